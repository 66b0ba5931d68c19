"""Certificates against plain vectors: what is proved holds at every pose."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import parakin
from parakin.design.choice import driven_for
from parakin.design.enclosing import least_firmness
from parakin.design.requirement import requirement_of
from parakin.errors import InputError
from parakin.solving.solver import Solver

RIG = Path(__file__).parents[2] / "examples" / "rig.toml"
SHORTEST, LONGEST = 0.86, 1.26


@cache
def rig(cone: str = "35 deg") -> Solver:
    return parakin.compile(parakin.load(RIG, {"cone": cone}))


def pairs_at(radius: float, apart: float, first: float) -> np.ndarray:
    middle = first + 120.0 * np.repeat(np.arange(3), 2)
    angle = np.radians(middle + np.tile([-0.5, 0.5], 3) * apart)
    return radius * np.array([np.cos(angle), np.sin(angle), 0.0 * angle])


BASE = pairs_at(0.82, 14.0, 0.0)
TOP = np.roll(pairs_at(0.61, 18.0, -60.0), -1, axis=1)


def legs(poses: np.ndarray) -> np.ndarray:
    """Vectors along the six legs (n, 3, 6) of poses (n, 6), angles about moving axes x, y, z."""
    turned = Rotation.from_euler("XYZ", poses[:, 3:]).as_matrix() @ TOP
    return np.asarray(poses[:, :3, None] + turned - BASE)


def box(solver: Solver, **half: float) -> dict[str, tuple[float, float]]:
    """About home, so far either way."""
    names = {f"platform.{name}": size for name, size in half.items()}
    return {n: (solver.home[n] - size, solver.home[n] + size) for n, size in names.items()}


def extremes(half: float, z: float) -> tuple[np.ndarray, np.ndarray]:
    """The shortest and the longest that each leg is in a cube about home, the platform level: from
    a joint of the base to the nearest and to the farthest point of the cube.
    """
    middle = (np.array([0.0, 0.0, z])[:, None] + TOP - BASE).T
    away = np.abs(middle)
    nearest = np.linalg.norm(np.maximum(away - half, 0.0), axis=1)
    return nearest, np.linalg.norm(away + half, axis=1)


def test_strokes_in_a_cube_are_enclosed_closely() -> None:
    half, solver = 0.08, rig()
    found = parakin.certify(solver, box(solver, x=half, y=half, z=half))
    assert found.attrs["outcome"] == "proved"
    assert float(found["proved"]) == 1.0
    shortest, longest = extremes(half, solver.home["platform.z"])
    legs_of = found.sel(coordinate=[f"P{k}" for k in range(1, 7)])
    assert (legs_of["low"] <= shortest + 1e-14).all()
    assert (legs_of["high"] >= longest - 1e-14).all()
    assert legs_of["low"].values == pytest.approx(shortest, abs=0.03 * half)
    assert legs_of["high"].values == pytest.approx(longest, abs=0.03 * half)


@pytest.mark.parametrize("part", [0.999, 1.001])
def test_the_largest_cube_is_found_from_both_sides(part: float) -> None:
    """Of strokes alone, which farthest and nearest points of a cube bound."""
    solver = rig("80 deg")
    z = solver.home["platform.z"]

    def kept(half: float) -> bool:
        shortest, longest = extremes(half, z)
        return bool((shortest >= SHORTEST).all() and (longest <= LONGEST).all())

    low, high = 0.05, 0.25
    for _ in range(50):
        low, high = (
            (0.5 * (low + high), high) if kept(0.5 * (low + high)) else (low, 0.5 * (low + high))
        )
    found = parakin.certify(solver, box(solver, x=part * low, y=part * low, z=part * low))
    assert found.attrs["outcome"] == ("proved" if part < 1.0 else "refuted")
    if part > 1.0:
        pose = found["where"].values[None]
        length = np.linalg.norm(legs(pose)[0], axis=0)
        assert length.min() < SHORTEST or length.max() > LONGEST
        assert found.attrs["reason"][:2] in {f"P{k}" for k in range(1, 7)}


def test_in_all_six_freedoms_random_poses_keep_what_is_proved() -> None:
    solver = rig()
    turn = np.radians(2.5)
    within = box(solver, x=0.04, y=0.04, z=0.04, roll=turn, pitch=turn, yaw=turn)
    found = parakin.certify(solver, within, velocities={"platform.z": 0.2, "platform.x": 0.1})
    assert found.attrs["outcome"] == "proved"
    low, high = np.array(list(within.values())).T
    poses = np.random.default_rng(7).uniform(low, high, (20000, 6))
    vectors = legs(poses)
    length = np.linalg.norm(vectors, axis=1)
    of_legs = found.sel(coordinate=[f"P{k}" for k in range(1, 7)])
    assert (length.min(axis=0) >= of_legs["low"].values).all()
    assert (length.max(axis=0) <= of_legs["high"].values).all()
    assert length.min() >= SHORTEST
    assert length.max() <= LONGEST
    speed = 0.2 * np.abs(vectors[:, 2] / length) + 0.1 * np.abs(vectors[:, 0] / length)
    assert speed.max() < 0.6


def test_speeds_are_proved_up_to_what_the_legs_give_and_refuted_beyond() -> None:
    """At one pose: a leg's rate is that of the platform along it."""
    solver = rig()
    home = np.array([[0.0, 0.0, solver.home["platform.z"], 0.0, 0.0, 0.0]])
    along = legs(home)[0] / np.linalg.norm(legs(home)[0], axis=0)
    most = float((0.6 / (np.abs(along[2]) + 0.5 * np.abs(along[0]))).min())
    within = box(solver, z=0.0)
    for part, outcome in ((1.0 - 1e-9, "proved"), (1.0 + 1e-9, "refuted")):
        speeds = {"platform.z": part * most, "platform.x": 0.5 * part * most}
        found = parakin.certify(solver, within, velocities=speeds)
        assert found.attrs["outcome"] == outcome
    assert "velocity > 0.6 m/s" in found.attrs["reason"]


def test_a_singularity_of_the_actuators_in_the_box_is_never_proved_away() -> None:
    """A planar 3-RPR with concentric triangles is singular where these are aligned: its legs meet
    in the middle then. At home they are 30 degrees apart.
    """
    solver = parakin.compile("3-rpr")
    turn = np.radians
    kept = parakin.certify(solver, {"platform.yaw": (turn(-29.0), turn(29.0))})
    assert kept.attrs["outcome"] == "proved"
    found = parakin.certify(solver, {"platform.yaw": (turn(-31.0), turn(5.0))})
    assert found.attrs["outcome"] == "refuted"  # by a pose on its other side
    assert found.attrs["reason"] == "conditioning < 1e-06"
    assert np.degrees(float(found["where"].sel(driven="platform.yaw"))) <= -30.0
    found = parakin.certify(solver, {"platform.yaw": (turn(-30.0) + 1e-9, turn(5.0))}, boxes=500)
    assert found.attrs["outcome"] in ("undecided", "refuted")
    assert float(found["proved"]) < 1.0


def test_how_firmly_it_is_held_is_proved_and_refuted() -> None:
    """The determinant of its legs' rates falls with the sine of the angle between the triangles."""
    solver = parakin.compile("3-rpr")
    within = {"platform.yaw": (np.radians(-20.0), np.radians(20.0))}
    least = np.sin(np.radians(10.0)) / np.sin(np.radians(30.0))
    assert parakin.certify(solver, within, least_conditioning=0.5 * least).outcome == "proved"
    found = parakin.certify(solver, within, least_conditioning=0.999)
    assert found.attrs["outcome"] == "refuted"
    assert found.attrs["reason"] == "conditioning < 0.999"


def test_the_least_singular_value_of_any_matrix_between_two_is_bounded() -> None:
    draw = np.random.default_rng(5)
    middle = draw.uniform(-1.0, 1.0, (5, 3, 50)) + np.eye(5, 3)[:, :, None]
    off = draw.uniform(0.0, 0.03, middle.shape)
    least = least_firmness(middle - off, middle + off)
    for _ in range(200):
        one = middle + draw.uniform(-1.0, 1.0, middle.shape) * off
        values = np.linalg.svd(np.moveaxis(one, 2, 0), compute_uv=False)[:, -1]
        assert (values >= least).all()
    assert (least > 0.0).mean() > 0.9
    exact = np.linalg.svd(np.moveaxis(middle, 2, 0), compute_uv=False)[:, -1]
    assert least_firmness(middle, middle) == pytest.approx(exact, rel=1e-9)
    unknown = np.where(np.arange(50) == 3, np.nan, middle)
    assert least_firmness(unknown, middle)[3] == 0.0
    singular = np.zeros((3, 3, 1))
    assert least_firmness(singular, singular) == 0.0


@pytest.mark.parametrize("name", sorted(parakin.catalogue()))
def test_what_kernels_find_in_a_box_is_enclosed(name: str) -> None:
    mechanism = parakin.load(name)
    try:
        solver = parakin.compile(mechanism, driven_for(mechanism), machine_code=False)
        requirement = requirement_of(solver, None, None)
    except parakin.ParakinError as error:
        assert "found by iteration" in str(error) or "can move independently" in str(error)
        return
    draw = np.random.default_rng(3)
    y, scale = np.array([[solver.home[n], 1.0] for n in solver.driven]).T
    scale[[not solver.graph.is_angle(n) for n in solver.driven]] = solver.graph.length
    n = 8
    middle = y[:, None] + scale[:, None] * draw.uniform(-0.02, 0.02, (len(y), n))
    radius = np.repeat(0.004 * scale[:, None], n, axis=1)
    found = requirement.enclosing.over(middle, radius)
    chart = solver.atlas.followed
    known = 0
    for _ in range(20):
        poses = middle + draw.uniform(-1.0, 1.0, middle.shape) * radius
        out = chart.at_rest(poses, np.zeros((0, n)))
        for row, what in enumerate(requirement.enclosing.rows):
            value = out[chart.places[what]]
            value = np.cos(value) if isinstance(what, str) else value
            slack = 1e-13 * max(1.0, solver.graph.length)  # what the kernel itself is off
            beyond = (value < found.low[row] - slack) | (value > found.high[row] + slack)
            assert not beyond.any(), what
            known += int(np.isfinite(found.low[row]).sum())
        figure = np.sqrt(np.maximum(found.least, 0.0))
        assert not (out[chart.outputs.conditioning] < figure - 1e-12).any()
    assert known > 0


def test_what_takes_too_many_parts_is_undecided() -> None:
    solver = rig()
    turn = np.radians(2.5)
    within = box(solver, x=0.04, y=0.04, z=0.04, roll=turn, pitch=turn, yaw=turn)
    found = parakin.certify(solver, within, boxes=40)
    assert found.attrs["outcome"] == "undecided"
    assert int(found["boxes"]) <= 40
    assert 0.0 <= float(found["proved"]) < 1.0
    assert ">" in found.attrs["reason"]
    assert np.isfinite(found["where"]).all()


def test_a_pose_that_keeps_not_all_refutes_at_once() -> None:
    solver = rig()
    found = parakin.certify(solver, {"platform.x": (0.9, 1.1)}, {"platform.x": 1.0})
    assert found.attrs["outcome"] == "refuted"
    assert np.isnan(found["low"]).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"within": {}}, "within: found no coordinate"),
        ({"within": {"platform.q": (0.0, 1.0)}}, "found 'platform.q', which is not driven"),
        ({"within": {"platform.x": (0.0, np.nan)}}, "expected a finite number"),
        ({"within": {"platform.x": (0.1, -0.1)}}, "expected the lower end first"),
        ({"within": {"platform.x": (0.1, 0.2)}}, "expected the pose, at 0, in between"),
        ({"within": {"platform.x": 0.1}}, "expected two finite numbers"),
        ({"within": {"platform.x": (0.0, [1.0, 2.0])}}, "expected a finite number"),
        ({"within": {"platform.x": (-1e308, 1e308)}}, "expected ends below 1e"),
        ({"within": [1]}, "expected values by the names"),
        ({"within": {"platform.x": (0.0, "1 deg")}}, "found '1 deg', an angle"),
        ({"velocities": {"platform.x": "1 m"}}, "found '1 m', a length"),
        ({"velocities": {"platform.x": -1.0}}, "expected how fast, either way"),
        ({"velocities": {"platform.x": np.inf}}, "expected a finite number"),
        ({"boxes": 0}, "boxes: found 0"),
        ({"boxes": 2.5}, "boxes: found 2.5"),
        ({"least_conditioning": 1.5}, "least_conditioning: found 1.5"),
    ],
)
def test_bad_input_is_refused(options: dict, message: str) -> None:  # type: ignore[type-arg]
    asked = {"within": {"platform.x": (-0.1, 0.1)}, **options}
    with pytest.raises(InputError, match=message):
        parakin.certify(rig(), **asked)


def test_loops_found_by_iteration_are_refused() -> None:
    solver = parakin.compile("3-rps", driven_for(parakin.load("3-rps")), machine_code=False)
    with pytest.raises(InputError, match="found by iteration"):
        parakin.certify(solver, {"platform.z": (0.5, 0.7)})


def test_text_with_units_and_other_designs() -> None:
    solver, half = rig(), 0.08
    found = parakin.certify(
        solver,
        {"platform.x": ("-80 mm", "8 cm")},
        velocities={"platform.z": "100 mm/s"},
        parameters={"leg_max": 1.3},
    )
    same = parakin.compile(parakin.load(RIG, {"leg_max": "1.3"}))
    other = parakin.certify(same, {"platform.x": (-half, half)}, velocities={"platform.z": 0.1})
    assert found.attrs["outcome"] == "proved"
    assert np.array_equal(found["high"], other["high"])
    assert float(found["limit_high"].sel(coordinate="P1")) == 1.3


def homothetic(yaw: float, folder: Path) -> Solver:
    """A planar 3-RPR whose triangles are alike: singular where they are aligned, at yaw = 0."""
    text = (Path(parakin.__file__).parent / "catalogue" / "3-rpr.toml").read_text("utf-8")
    text = text.replace("platform = { x = 0, y = 0, yaw = 0 }", f"platform.yaw = {yaw}")
    path = folder / "homothetic.toml"
    path.write_text(text.replace('twist = "30 deg"', 'twist = "0 deg"'), "utf-8")
    return parakin.compile(path, machine_code=False)


def test_a_home_that_is_singular_measures_nothing(tmp_path: Path) -> None:
    solver = homothetic(0.0, tmp_path)
    within = {"platform.yaw": (-0.5, -0.1)}
    with pytest.raises(InputError, match="home at which the actuators are singular"):
        parakin.certify(solver, within, {"platform.yaw": -0.3})
    with pytest.raises(InputError, match="home at which the actuators are singular"):
        parakin.range(solver, {"platform.yaw": -0.3}, least_conditioning=0.3)
    space = parakin.workspace(
        solver, over=["platform.x", "platform.y"], pose={"platform.yaw": -0.3}, points=9
    )
    assert np.isnan(space["conditioning"]).all()
    other = homothetic(-0.2, tmp_path)
    assert parakin.certify(other, within, {"platform.yaw": -0.3}).outcome == "proved"


SLIDE = """
[joints.A{k}]
kind = "prismatic"
parent = "{parent}"
child = "b{k}"
actuated = true
"""


def slides(count: int, limits: str, folder: Path) -> Solver:
    """A chain of slides."""
    joints = "".join(SLIDE.format(k=k, parent=f"b{k - 1}" if k else "base") for k in range(count))
    bodies = "".join(f"[bodies.b{k}]\n" for k in range(count))
    driven = ", ".join(f'"A{k}"' for k in range(count))
    path = folder / "slides.toml"
    text = f'name = "slides"\ndriven = [{driven}]\n{bodies}{joints}[limits]\n{limits}\n'
    path.write_text(text, "utf-8")
    return parakin.compile(path, machine_code=False)


@pytest.mark.parametrize(
    ("limits", "told"),
    [
        ('["-0.5 m/s", "2 m/s"]', "A0.velocity < -0.5 m/s"),
        ('["-0.5 m/s", "inf"]', "A0.velocity < -0.5 m/s"),
        ('["-2 m/s", "0.5 m/s"]', "A0.velocity > 0.5 m/s"),
    ],
)
def test_the_end_of_a_velocity_that_is_passed_is_named(
    limits: str, told: str, tmp_path: Path
) -> None:
    solver = slides(1, f'"A0.velocity" = {limits}', tmp_path)
    found = parakin.certify(solver, {"A0": (-1.0, 1.0)}, velocities={"A0": 1.0})
    assert (found.attrs["outcome"], found.attrs["reason"]) == ("refuted", told)


def test_corners_of_very_many_sides_are_not_all_looked_at(tmp_path: Path) -> None:
    names = [f"A{k}" for k in range(20)]
    solver = slides(20, "\n".join(f"{name} = [-1, 1]" for name in names), tmp_path)
    assert parakin.certify(solver, dict.fromkeys(names, (-0.5, 0.5))).outcome == "proved"
