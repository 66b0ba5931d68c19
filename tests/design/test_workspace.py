"""Workspaces against arcs of circles in closed form, and against random points judged by plain
vectors.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from discs import area_of_rings, turned
from scipy.optimize import brentq

import parakin
from parakin.errors import InputError
from parakin.solving.solver import Solver

ROOT = Path(__file__).parents[2]
CATALOGUE = Path(parakin.__file__).parent / "catalogue"
RIG = ROOT / "examples" / "rig.toml"
XY = ["platform.x", "platform.y"]


def limited(folder: Path, name: str, limits: str, **options: Any) -> Solver:
    """A mechanism of the catalogue with limits of its own."""
    path = folder / f"{name}.toml"
    path.write_text((CATALOGUE / f"{name}.toml").read_text("utf-8") + "\n[limits]\n" + limits)
    return parakin.compile(path, **options)


def three_rpr(folder: Path, strokes: Sequence[tuple[float, float]], **options: Any) -> Solver:
    rows = [f"P{k} = [{low}, {high}]" for k, (low, high) in enumerate(strokes, start=1)]
    return limited(folder, "3-rpr", "\n".join(rows), **options)


# The planar 3-RPR: each leg keeps the platform's point in a ring.

ANGLES = np.radians([-150.0, -30.0, 90.0])


def rings(
    strokes: Sequence[tuple[float, float]], yaw: float = 0.0
) -> list[tuple[np.ndarray, float, float]]:
    centres = 0.5 * turned(ANGLES) - 0.15 * turned(ANGLES + np.radians(30.0) + yaw)
    return [(centre, *ends) for centre, ends in zip(centres, strokes, strict=True)]


def test_the_area_of_rings_is_right_where_it_is_known() -> None:
    ring = (np.array([1.0, 2.0]), 0.5, 1.0)
    assert area_of_rings([ring]) == pytest.approx(np.pi * 0.75, rel=1e-14)
    lens = [(np.zeros(2), 0.0, 1.0), (np.array([1.2, 0.0]), 0.0, 1.0)]
    assert area_of_rings(lens) == pytest.approx(2.0 * np.arccos(0.6) - 0.96, rel=1e-14)


STROKES = [(0.1, 0.55), (0.15, 0.6), (0.12, 0.58)]


@pytest.mark.parametrize("yaw", [0.0, 0.3])
@pytest.mark.parametrize("machine_code", [None, False])
def test_the_area_of_a_3_rpr(tmp_path: Path, machine_code: bool | None, yaw: float) -> None:
    solver = three_rpr(tmp_path, STROKES, machine_code=machine_code)
    found = parakin.workspace(solver, {"platform.yaw": yaw}, points=101)
    exact = area_of_rings(rings(STROKES, yaw))
    assert float(found["size"]) == pytest.approx(exact, rel=3e-4)
    assert abs(float(found["size"]) - exact) <= float(found["size_uncertainty"])
    assert found.sizes["island"] == 0
    finer = parakin.workspace(solver, {"platform.yaw": yaw}, points=301)
    assert abs(float(finer["size"]) - exact) < 0.2 * abs(float(found["size"]) - exact)


def test_arrays_and_machine_code_agree(tmp_path: Path) -> None:
    arrays, code = (
        parakin.workspace(three_rpr(tmp_path, STROKES, machine_code=machine_code), points=41)
        for machine_code in (False, None)
    )
    assert np.array_equal(arrays["inside"], code["inside"])
    assert arrays["boundary"].values == pytest.approx(code["boundary"].values, abs=1e-10)
    assert float(arrays["size"]) == pytest.approx(float(code["size"]), rel=1e-9)


def test_the_boundary_is_located_exactly_and_says_what_stops_it(tmp_path: Path) -> None:
    found = parakin.workspace(three_rpr(tmp_path, STROKES), points=41)
    corners = found["boundary"].values.reshape(-1, 2)
    words = found["stop"].values[found["boundary_stopped_by"].values.ravel()]
    for point, word in zip(corners, words, strict=True):
        leg, sign, end, _ = word.split()
        centre, low, high = rings(STROKES)[int(leg[1]) - 1]
        assert float(end) == {"<": low, ">": high}[sign]
        assert np.linalg.norm(point - centre) == pytest.approx(float(end), abs=5e-11)


def test_holes_are_found(tmp_path: Path) -> None:
    found = parakin.workspace(three_rpr(tmp_path, [(0.1, 0.9)] * 3))
    assert found["holes"].values == pytest.approx([0.01 * np.pi] * 3, rel=2e-3)
    exact = area_of_rings(rings([(0.1, 0.9)] * 3))
    assert float(found["size"]) == pytest.approx(exact, rel=1e-4)


def test_an_island_beyond_a_gap_is_told_apart(tmp_path: Path) -> None:
    """Two thin rings meet twice, in mirror images; the third leg goes everywhere."""
    strokes = [(0.36, 0.40), (0.36, 0.40), (0.01, 3.0)]
    solver = three_rpr(tmp_path, strokes)
    look = {"platform.x": (-0.5, 0.5), "platform.y": (-0.8, 0.4)}
    found = parakin.workspace(solver, within=look, points=401)
    half = 0.5 * area_of_rings(rings(strokes))
    assert float(found["size"]) == pytest.approx(half, rel=1e-3)
    assert found["islands"].values == pytest.approx([half], rel=1e-3)
    middle = 0.5 * (rings(strokes)[0][0] + rings(strokes)[1][0])
    beyond = {"x": 2.0 * middle[0], "y": 2.0 * middle[1]}  # home, mirrored
    there = {f"platform.{name}": value for name, value in beyond.items()}
    node = found.sel(there, method="nearest")
    assert bool(node["inside"])
    assert not bool(node["connected"])
    alone = parakin.workspace(solver, points=401)  # which looks no farther than home's own part
    assert float(alone["size"]) == pytest.approx(half, rel=1e-4)
    other = parakin.workspace(solver, there, within=look, points=401)
    assert float(other["size"]) == pytest.approx(half, rel=1e-3)


def test_reachable_and_dexterous(tmp_path: Path) -> None:
    solver = three_rpr(tmp_path, STROKES)
    yaws = (0.0, 0.5)
    turns = [{"platform.yaw": yaw} for yaw in yaws]
    each = [area_of_rings(rings(STROKES, yaw)) for yaw in yaws]
    both = area_of_rings([ring for yaw in yaws for ring in rings(STROKES, yaw)])
    found = {
        kind: parakin.workspace(solver, kind=kind, orientations=turns)
        for kind in ("reachable", "dexterous")
    }
    size = {kind: float(ds["size"]) + ds["islands"].values.sum() for kind, ds in found.items()}
    assert size["dexterous"] == pytest.approx(both, rel=2e-4)
    assert size["reachable"] == pytest.approx(sum(each) - both, rel=2e-4)


def test_the_largest_circle_and_box(tmp_path: Path) -> None:
    found = parakin.workspace(three_rpr(tmp_path, STROKES), points=201)
    distance = [(np.linalg.norm(c), low, high) for c, low, high in rings(STROKES)]
    least = min(min(high - d, d - low) for d, low, high in distance)
    assert float(found["radius"]) == pytest.approx(least, rel=1e-4)
    wide = parakin.workspace(
        three_rpr(tmp_path, STROKES), proportions={"platform.x": 2.0, "platform.y": 1.0}
    )["half_width"].values

    def room(h: float) -> float:
        t = np.linspace(-1.0, 1.0, 2001)
        one = np.ones_like(t)
        sides = np.concatenate(
            [np.stack(p, -1) for p in ((t, one), (t, -one), (one, t), (-one, t))]
        )
        return min(
            float(min(high - d.max(), d.min() - low))
            for c, low, high in rings(STROKES)
            for d in [np.linalg.norm(sides * (2.0 * h, h) - c, axis=1)]
        )

    assert wide == pytest.approx(np.array([2.0, 1.0]) * brentq(room, 1e-3, 1.0), rel=1e-3)


def test_how_much_is_left(tmp_path: Path) -> None:
    found = parakin.workspace(three_rpr(tmp_path, STROKES), points=41)
    node = found.sel({"platform.x": 0.05, "platform.y": 0.03}, method="nearest")
    point = np.array([float(node["platform.x"]), float(node["platform.y"])])
    left = min(
        min(high - d, d - low) / (high - low)
        for c, low, high in rings(STROKES)
        for d in [np.linalg.norm(point - c)]
    )
    assert float(node["stroke_left"]) == pytest.approx(left, abs=1e-13)
    at_home = found.sel({"platform.x": 0.0, "platform.y": 0.0}, method="nearest")
    assert float(at_home["conditioning"]) == pytest.approx(1.0, abs=1e-12)
    assert np.isnan(found["stroke_left"].values[~found["inside"].values]).all()


def test_a_singularity_bounds_where_conditioning_is_asked_for(tmp_path: Path) -> None:
    """The legs' lines of a 3-RPR all meet, or are parallel, where the determinant of their unit
    vectors and moments vanishes; its sign is the same all over what is kept.
    """
    solver = three_rpr(tmp_path, [(0.01, 2.0)] * 3)
    pose = {"platform.yaw": 0.6}

    def determinant(points: np.ndarray) -> np.ndarray:
        at = 0.15 * turned(ANGLES + np.radians(30.0) + 0.6)
        ways = points[:, None] + at - 0.5 * turned(ANGLES)
        ways /= np.linalg.norm(ways, axis=-1, keepdims=True)
        moment = at[:, 0] * ways[..., 1] - at[:, 1] * ways[..., 0]
        return np.asarray(np.linalg.det(np.concatenate([ways, moment[..., None]], axis=-1)))

    found = parakin.workspace(solver, pose, least_conditioning=0.05, points=81)
    inside = found["inside"].values
    points = np.stack(np.meshgrid(*(found[name].values for name in XY), indexing="ij"), axis=-1)
    values = determinant(points[inside]) * np.sign(determinant(np.zeros((1, 2))))
    assert (values > 0.0).all()
    assert "conditioning < 0.05" in found["stop"].values
    least = found["conditioning"].values[inside].min()
    assert least >= 0.05


# In space.


def random_points(low: np.ndarray, high: np.ndarray, count: int) -> np.ndarray:
    part: np.ndarray = np.random.default_rng(16).random((count, 3))
    return np.asarray(low + part * (high - low))


def agrees_with(
    found: Any, kept: Callable[[np.ndarray], np.ndarray], low: np.ndarray, high: np.ndarray
) -> None:
    """Volumes against the share of random points that are kept, within four standard errors."""
    points = random_points(low, high, 400_000)
    share = float(kept(points).mean())
    box = float(np.prod(high - low))
    error = box * np.sqrt(share * (1.0 - share) / len(points))
    total = float(found["size"]) + float(found["islands"].sum())
    assert abs(total - box * share) < 4.0 * error + float(found["size_uncertainty"])
    assert error < 1e-2 * total


@cache
def rig() -> Solver:
    return parakin.compile(RIG)


def rig_keeps(points: np.ndarray) -> np.ndarray:
    """Strokes and cones of the rig, level: legs between points on two circles."""

    def circle(r: float, apart: float, first: float) -> np.ndarray:
        middle = first + 120.0 * np.repeat(np.arange(3), 2)
        angle = np.radians(middle + np.tile([-0.5, 0.5], 3) * apart)
        return r * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)

    base, top = circle(0.82, 14.0, 0.0), np.roll(circle(0.61, 18.0, -60.0), -1, axis=0)
    flat = np.linalg.norm((top - base)[0])
    home = top - base + [0.0, 0.0, np.sqrt(1.06**2 - flat**2)]
    legs = points[:, None] + top - base
    lengths = np.linalg.norm(legs, axis=-1)
    cosine = (legs * home).sum(axis=-1) / lengths / 1.06
    kept = (lengths >= 0.86) & (lengths <= 1.26) & (cosine >= np.cos(np.radians(35.0)))
    return np.asarray(kept.all(axis=1))


def test_the_volume_of_the_rig() -> None:
    found = parakin.workspace(rig())
    ends = found["extent"].values
    agrees_with(found, rig_keeps, ends[:, 0] - 0.01, ends[:, 1] + 0.01)


def test_the_extent_of_a_slice_is_the_range() -> None:
    found = parakin.workspace(rig(), over=["platform.x", "platform.y"])
    alone = parakin.range(rig())["travel"].sel(driven="platform.x").values
    along = found["boundary"].values[np.abs(found["boundary"].values[..., 1]) < 1e-12]
    assert along[:, 0].min() == pytest.approx(alone[0], abs=1e-10)
    assert along[:, 0].max() == pytest.approx(alone[1], abs=1e-10)


def test_nodes_are_what_single_poses_are() -> None:
    found = parakin.workspace(rig(), over=["platform.x", "platform.z"], points=41)
    xs, zs = (found[name].values for name in ("platform.x", "platform.z"))
    for i, k in np.random.default_rng(3).integers(0, (len(xs), len(zs)), (100, 2)).tolist():
        tick = rig().at([xs[i], 0.0, zs[k], 0.0, 0.0, 0.0])
        assert bool(found["inside"].values[i, k]) == (tick.status == 0)


def test_a_cavity_is_found(tmp_path: Path) -> None:
    """A translational 3-UPU: each leg keeps the platform's point between two spheres."""
    limits = "P1 = [0.2, 1.0]\nP2 = [0.01, 1.0]\nP3 = [0.01, 1.0]"
    found = parakin.workspace(limited(tmp_path, "3-upu", limits), points=61)
    centres = np.pad(0.3 * turned(np.radians([90.0, 210.0, 330.0])), [(0, 0), (0, 1)])

    def kept(points: np.ndarray) -> np.ndarray:
        lengths = np.linalg.norm(points[:, None] - centres, axis=-1)
        return np.asarray((lengths <= 1.0).all(axis=1) & (lengths[:, 0] >= 0.2))

    agrees_with(found, kept, np.full(3, -1.0), np.ones(3))
    assert found["holes"].values == pytest.approx([4.0 / 3.0 * np.pi * 0.2**3], rel=1e-2)
    home = np.linalg.norm([0.0, 0.3, 0.7])
    assert float(found["radius"]) == pytest.approx(1.0 - home, rel=5e-3)


# What is refused.


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"kind": "dextrous"}, "kind"),
        ({"over": ["platform.x"]}, "two or three"),
        ({"over": ["platform.x", "platform.x"]}, "twice"),
        (
            {"over": ["platform.x", "platform.roll"], "kind": "constant-orientation"},
            "'platform.roll' in a workspace of kind constant-orientation; expected slides alone",
        ),
        ({"over": XY, "kind": "mixed"}, "slides alone in a workspace of kind mixed"),
        ({"kind": "mixed"}, "over: found 6 driven coordinates of the platform; expected two or"),
        ({"over": ["platform.x", "platform.q"]}, "not driven"),
        ({"kind": "orientation", "over": XY}, "angles alone"),
        ({"kind": "reachable"}, "orientations"),
        ({"orientations": [{"platform.yaw": 0.1}]}, "orientations"),
        ({"kind": "dexterous", "orientations": [{"platform.x": 0.1}]}, "a slide"),
        ({"kind": "dexterous", "orientations": [{"platform.yaw": np.nan}]}, "finite"),
        ({"pose": {"platform.x": np.inf}}, "finite"),
        ({"points": 3}, "points"),
        ({"within": {"platform.x": (0.1, 0.2)}}, "both sides"),
        ({"within": {"platform.yaw": (-1.0, 1.0)}}, "not moved"),
        ({"least_conditioning": np.nan}, "between 0 and 1"),
        ({"proportions": {"platform.x": 1.0}}, "proportions"),
        ({"over": XY, "proportions": dict.fromkeys(XY, 0.0)}, "above zero"),
        ({"pose": [1, 2]}, "pose: found \\[1, 2\\]; expected values by the names"),
        ({"over": XY, "within": 5}, "within: found 5; expected values by the names"),
        ({"over": XY, "within": {"platform.x": 1}}, "within of platform.x: found 1; expected two"),
        ({"over": XY, "proportions": [1]}, "proportions: found \\[1\\]; expected values by"),
        (
            {"over": XY, "kind": "reachable", "orientations": 5},
            "orientations: found 5; expected a list",
        ),
        ({"over": "platform.x"}, "over: found one coordinate alone; expected two or three"),
    ],
)
def test_bad_input_is_named(options: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        parakin.workspace(rig(), **options)


def test_a_pose_beyond_a_limit_is_told() -> None:
    found = parakin.workspace(rig(), {"platform.z": 1.3})
    assert found.attrs["stopped"].endswith(" > 1.26 m")
    assert "size" not in found


def test_a_solver_of_jerks_has_the_same_workspace() -> None:
    found = parakin.workspace(rig(), over=XY, least_conditioning=0.5, points=21)
    jerky = parakin.compile(RIG, derivatives=3)
    same = parakin.workspace(jerky, over=XY, least_conditioning=0.5, points=21)
    assert float(same["size"]) == float(found["size"])
