"""Ranges against plain vectors: a rig given by its numbers, a crank, a five-bar, and poses drawn at
random.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import parakin
from parakin.errors import InputError
from parakin.solving.solver import Solver

RIG = Path(__file__).parents[2] / "examples" / "rig.toml"
DRIVEN = [f"platform.{name}" for name in ("x", "y", "z", "roll", "pitch", "yaw")]
SHORTEST, LONGEST, SPEED = 0.86, 1.26, 0.6


@cache
def rig(*, machine_code: bool | None = None) -> Solver:
    return parakin.compile(RIG, machine_code=machine_code)


def pairs_at(radius: float, apart: float, first: float) -> np.ndarray:
    """Six points on a circle, in three pairs so many degrees apart, the first at an angle."""
    middle = first + 120.0 * np.repeat(np.arange(3), 2)
    angle = np.radians(middle + np.tile([-0.5, 0.5], 3) * apart)
    return radius * np.array([np.cos(angle), np.sin(angle), 0.0 * angle])


def legs(pose: np.ndarray) -> np.ndarray:
    """Lengths of the six legs: plain vectors, angles about moving axes x, y, z. The platform's
    pairs lie between the base's, so that each pair of the base's shares its legs out to two.
    """
    base = pairs_at(0.82, 14.0, 0.0)
    top = np.roll(pairs_at(0.61, 18.0, -60.0), -1, axis=1)
    turned = Rotation.from_euler("XYZ", pose[3:]).as_matrix() @ top
    return np.asarray(np.linalg.norm(pose[:3, None] + turned - base, axis=0))


def height() -> float:
    """Of the platform with all legs half way out."""
    middle = 0.5 * (SHORTEST + LONGEST)
    return float(
        brentq(lambda z: legs(np.array([0, 0, z, 0, 0, 0]))[0] - middle, 0.5, 1.2, xtol=1e-15)
    )


def home() -> np.ndarray:
    return np.array([0.0, 0.0, height(), 0.0, 0.0, 0.0])


def way_left(pose: np.ndarray, way: np.ndarray) -> float:
    """How far a leg's stroke lets it go along a way: sampled finely, then Brent's method."""

    def beyond(s: float) -> float:
        lengths = legs(pose + s * way)
        return float(max(lengths.max() - LONGEST, SHORTEST - lengths.min()))

    samples = np.linspace(0.0, 1.5, 3001)
    first = next(k for k, s in enumerate(samples) if beyond(s) > 0.0)
    return float(brentq(beyond, samples[first - 1], samples[first], xtol=1e-15, rtol=1e-15))


def rates(pose: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Of the legs, along a way: a complex step would need another norm, so central differences."""
    h = 1e-6
    difference: np.ndarray = legs(pose + h * way) - legs(pose - h * way)
    return difference / (2 * h)


def test_the_rig_is_at_home_at_mid_stroke() -> None:
    assert rig().home["platform.z"] == pytest.approx(height(), abs=1e-12)
    assert 1e3 * height() == pytest.approx(893.716, abs=5e-4)


@pytest.mark.parametrize("machine_code", [None, False])
def test_the_rig_goes_as_far_as_plain_vectors_say(machine_code: bool | None) -> None:
    found = parakin.range(rig(machine_code=machine_code))
    for name, way in zip(DRIVEN, np.eye(6), strict=True):
        down, up = found["travel"].sel(driven=name).values
        assert up == pytest.approx(way_left(home(), way), abs=1e-11)
        assert down == pytest.approx(-way_left(home(), -way), abs=1e-11)


def test_the_rig_goes_as_far_as_it_was_told() -> None:
    found = parakin.range(rig())["travel"].values
    told = {
        0: (-375.54, 329.63),
        1: (-322.01, 322.01),
        2: (-249.72, 230.00),
    }
    for row, ends in told.items():
        assert 1e3 * found[row] == pytest.approx(ends, abs=6e-3)
    assert np.degrees(found[3:]) == pytest.approx(
        np.array([[-22.907, 22.907], [-23.799, 22.810], [-31.195, 31.195]]), abs=6e-4
    )


def test_the_limit_that_is_named_is_met_where_it_is_told() -> None:
    found = parakin.range(rig())
    for row, way in enumerate(np.eye(6)):
        for side in (0, 1):
            words = str(found["stopped_by"].values[row, side])
            leg, sign, end = int(words[1]) - 1, words.split()[1], float(words.split()[2])
            length = legs(home() + found["travel"].values[row, side] * way)[leg]
            assert length == pytest.approx(end, abs=1e-11)
            assert (sign, end) in ((">", LONGEST), ("<", SHORTEST))


def test_all_that_is_reported_is_told_at_the_ends() -> None:
    found = parakin.range(rig())
    there = found["position"].sel(driven="platform.x", end="up")
    pose = home() + np.eye(6)[0] * float(found["travel"].sel(driven="platform.x", end="up"))
    assert there.sel(coordinate=DRIVEN).values == pytest.approx(pose, abs=1e-12)
    lengths = there.sel(coordinate=[f"P{k}" for k in range(1, 7)]).values
    assert lengths == pytest.approx(legs(pose), abs=1e-11)


def test_heave_is_counted_from_ten_degrees_of_pitch() -> None:
    tilted = home() + np.radians([0, 0, 0, 0, 10, 0])
    found = parakin.range(rig(), offsets={"platform.pitch": np.radians(10)})
    down, up = found["travel"].sel(driven="platform.z").values
    assert up == pytest.approx(way_left(tilted, np.eye(6)[2]), abs=1e-11)
    assert down == pytest.approx(-way_left(tilted, -np.eye(6)[2]), abs=1e-11)
    assert 1e3 * np.array([down, up]) == pytest.approx([-186.99, 126.22], abs=6e-3)
    same = parakin.range(rig(), {"platform.pitch": np.radians(10)})
    assert same["travel"].values == pytest.approx(found["travel"].values, abs=1e-12)


def test_velocities_at_home_are_those_of_the_slowest_leg() -> None:
    found = parakin.range(rig())["max_velocity"].values
    for row, way in enumerate(np.eye(6)):
        most = SPEED / np.abs(rates(home(), way)).max()
        assert found[row] == pytest.approx([-most, most], rel=1e-8)
    assert found[:3, 1] == pytest.approx([1.180, 1.137, 0.712], abs=5e-4)
    assert np.degrees(found[3:, 1]) == pytest.approx([71.6, 67.7, 104.9], abs=0.05)


@pytest.mark.parametrize("name", ["platform.x", "platform.z", "platform.pitch"])
def test_a_sine_reaches_but_keeps_the_speed_limits(name: str) -> None:
    frequency = 1.0
    found = parakin.range(rig(), frequency=frequency)
    amplitude = float(found["amplitude"].sel(driven=name))
    way = np.eye(6)[DRIVEN.index(name)]

    def fastest(amplitude: float) -> float:
        phase = 2 * np.pi * np.arange(2000) / 2000
        poses = [home() + amplitude * np.sin(at) * way for at in phase]
        by = np.array([rates(pose, way) for pose in poses]).T
        return float(np.abs(by * amplitude * 2 * np.pi * frequency * np.cos(phase)).max())

    assert fastest(amplitude) == pytest.approx(SPEED, rel=3e-6)  # as finely as is sampled
    assert "velocity" in str(found["amplitude_limited_by"].sel(driven=name).values)


def test_a_slow_sine_goes_to_the_nearer_end() -> None:
    found = parakin.range(rig(), frequency=1e-3)
    nearer = np.abs(found["travel"].values).min(axis=1)
    assert found["amplitude"].values == pytest.approx(nearer, rel=1e-13)


def test_boundaries_of_pairs_are_where_plain_vectors_say() -> None:
    found = parakin.range(rig(), pairs=True, rays=24)
    assert found["boundary"].shape == (15, 24, 2)
    strokes = np.char.startswith(found["boundary_stopped_by"].values, "P")
    for pair, ray in np.argwhere(strokes)[::7]:
        place = np.zeros(6)
        names = [str(found[key].values[pair]) for key in ("first", "second")]
        place[[DRIVEN.index(name) for name in names]] = found["boundary"].values[pair, ray]
        assert way_left(home(), place) == pytest.approx(1.0, abs=1e-10)


def test_boundaries_meet_the_ranges_alone() -> None:
    found = parakin.range(rig(), pairs=True, rays=8)
    both = found["boundary"].values[0]
    assert both[[0, 4], 0] == pytest.approx(found["travel"].values[0][::-1], abs=1e-11)
    assert both[[2, 6], 1] == pytest.approx(found["travel"].values[1][::-1], abs=1e-11)


def test_offsets_that_cannot_be_gone_are_told() -> None:
    found = parakin.range(rig(), offsets={"platform.pitch": np.radians(40)})
    most = way_left(home(), np.eye(6)[4])
    assert found.attrs["reached"] == pytest.approx(most / np.radians(40), abs=1e-11)
    assert found.attrs["stopped"] == "P4 > 1.26 m"
    assert np.isnan(found["travel"].values).all()


def test_a_pose_beyond_a_limit_is_told() -> None:
    found = parakin.range(rig(), {"platform.x": 0.34})
    assert "limit 1.26" in found.attrs["stopped"]
    assert found.attrs["reached"] == 0.0
    assert np.isnan(found["travel"].values).all()


def test_from_an_end_there_is_nothing_left_that_way_and_all_the_other() -> None:
    first = parakin.range(rig())["travel"].sel(driven="platform.x").values
    found = parakin.range(rig(), {"platform.x": float(first[1])})
    down, up = found["travel"].sel(driven="platform.x").values
    assert up == pytest.approx(0.0, abs=1e-11)
    assert down == pytest.approx(first[0] - first[1], abs=1e-11)


SMALL = st.floats(-1.0, 1.0)


@settings(max_examples=10, deadline=None)
@given(st.lists(SMALL, min_size=6, max_size=6), st.integers(0, 5))
def test_ends_from_random_poses_are_those_of_plain_vectors(part: list[float], row: int) -> None:
    pose = home() + np.array(part) * [0.05, 0.05, 0.05, 0.06, 0.06, 0.08]
    found = parakin.range(rig(), dict(zip(DRIVEN, pose, strict=True)))
    for side, sign in enumerate((-1.0, 1.0)):
        words = str(found["stopped_by"].values[row, side])
        if words.startswith("P"):
            away = float(found["travel"].values[row, side])
            assert sign * away == pytest.approx(way_left(pose, sign * np.eye(6)[row]), abs=1e-9)


@settings(max_examples=8, deadline=None)
@given(st.lists(SMALL, min_size=6, max_size=6))
def test_just_inside_all_is_kept_and_just_outside_it_is_not(part: list[float]) -> None:
    pose = home() + np.array(part) * [0.05, 0.05, 0.05, 0.06, 0.06, 0.08]
    found = parakin.range(rig(), dict(zip(DRIVEN, pose, strict=True)))
    ends = found["travel"].values
    for times, kept in ((1.0 - 1e-7, True), (1.0 + 1e-7, False)):
        for side in (0, 1):
            y = pose[:, None] + np.diag(times * ends[:, side])
            assert set(np.ravel(rig().at(y).stopped_by) == 0) == {kept}


def crank(**limits: tuple[float, float]) -> Solver:
    given = parakin.load("slider-crank").model_dump(exclude_unset=True)
    return parakin.compile(parakin.Mechanism(**given | {"limits": limits}))


CRANK, ROD, OFFSET = 0.04, 0.12, -0.02  # of the slider-crank in the catalogue
FARTHEST = float(np.sqrt((CRANK + ROD) ** 2 - OFFSET**2))  # with crank and rod in line
IN_LINE = float(np.arcsin(OFFSET / (CRANK + ROD)))


def slide(angle: float) -> float:
    """Where the slider is on its line."""
    across = CRANK * np.sin(angle) - OFFSET
    return float(CRANK * np.cos(angle) + np.sqrt(ROD**2 - across**2))


@pytest.mark.parametrize("over", [1e-3, 1e-6, 1e-9])
def test_a_short_excursion_beyond_a_limit_is_seen(over: float) -> None:
    limit = FARTHEST - over  # the slider turns back at its farthest, barely beyond
    found = parakin.range(crank(D=(0.0, limit)))
    before, after = (
        brentq(lambda a: slide(a) - limit, IN_LINE, IN_LINE + aside, xtol=1e-15)
        for aside in (-0.8, 0.8)
    )
    down, up = np.radians(60) + found["travel"].values[0]
    slope = np.sqrt(2 * over / 0.05)  # near the top, where curvature is 1/(50 mm) or so
    tolerance = 1e-12 + 1e-15 / slope  # a position rounded to 1e-16 m tells an angle no better
    assert down == pytest.approx(after, abs=tolerance)
    assert up == pytest.approx(2 * np.pi + before, abs=tolerance)
    assert str(found["stopped_by"].values[0, 0]).startswith("D > 0.15")


def test_a_limit_that_is_not_quite_met_stops_nothing() -> None:
    found = parakin.range(crank(D=(0.0, FARTHEST + 1e-9)))
    assert np.isinf(found["travel"].values).all()
    assert (found["stopped_by"].values == "").all()


def test_limits_of_angles_count_by_full_turns() -> None:
    found = parakin.range(crank(A=(-10.0, 7.0)))
    assert found["travel"].values[0] == pytest.approx([-10 - np.pi / 3, 7 - np.pi / 3], abs=1e-12)
    assert found["stopped_by"].values[0].tolist() == ["A < -572.958°", "A > 401.07°"]


def test_a_five_bar_goes_as_far_as_its_arms_reach() -> None:
    found = parakin.range(parakin.compile("five-bar"))
    out, base, y = 0.15 + 0.22, 0.1, 0.26  # stretched arms, from motors at x = -base and base
    x_most, y_most = np.sqrt(out**2 - y**2) - base, np.sqrt(out**2 - base**2)
    assert found["travel"].values[0] == pytest.approx([-x_most, x_most], abs=1e-11)
    assert found["travel"].values[1] == pytest.approx([-y_most - y, y_most - y], abs=1e-11)
    assert str(found["stopped_by"].sel(driven="platform.x", end="up").values) == (
        "limb A1, B1 cannot reach"
    )


def test_singularities_that_are_passed_are_located() -> None:
    eye = parakin.range(parakin.compile("agile-eye"))  # 90° in each angle
    assert np.abs(eye["travel"].values) == pytest.approx(0.5 * np.pi, abs=1e-9)
    assert (eye["stopped_by"].values == "singular").all()
    tricept = parakin.range(parakin.compile("tricept"))["travel"]  # down into the base's plane
    home_z = parakin.compile("tricept").home["platform.z"]
    assert float(tricept.sel(driven="platform.z", end="down")) == pytest.approx(-home_z, abs=1e-9)


def test_legs_that_drive_end_alike_by_symmetry_where_the_platform_is_singular() -> None:
    hexapod = parakin.compile("gough-stewart", [f"P{k}" for k in range(1, 7)])
    travel = parakin.range(hexapod)["travel"].values
    assert travel == pytest.approx(np.tile(travel[0], (6, 1)), abs=1e-8)


def test_limits_of_what_is_not_reported_count() -> None:
    solver = parakin.compile(RIG, coordinates=["platform.x"])
    found = parakin.range(solver)
    assert found["travel"].values == pytest.approx(parakin.range(rig())["travel"].values, abs=1e-12)


def test_bad_input_is_refused() -> None:
    for bad, place in (
        ({"pose": {"platform.w": 1.0}}, "pose"),
        ({"offsets": {"P1": 1.0}}, "offsets"),
        ({"pose": {"platform.x": np.nan}}, "pose of platform.x"),
        ({"frequency": 0.0}, "frequency"),
        ({"frequency": np.nan}, "frequency"),
        ({"rays": 3}, "rays"),
        ({"least_conditioning": 1.5}, "least_conditioning"),
    ):
        with pytest.raises(InputError, match=place):
            parakin.range(rig(), **bad)
    with pytest.raises(InputError, match="nothing that makes forces"):
        parakin.range(rig(), forces=True)
    with pytest.raises(InputError, match="accelerations"):
        parakin.range(parakin.compile(RIG, derivatives=1))


@pytest.mark.parametrize("name", ["delta", "6-rus", "3-rrr", "linear-delta", "seat-3dof", "3-prs"])
def test_poses_are_solved_up_to_the_ends_and_not_beyond(name: str) -> None:
    solver = parakin.compile(name)
    found = parakin.range(solver)
    home = np.array([solver.home[each] for each in solver.driven])
    for row, ends in enumerate(found["travel"].values):
        for end in ends[np.isfinite(ends)]:
            way = np.eye(len(home))[row] * np.sign(end)
            inside = solver.at(home + (abs(end) - 1e-8) * way)
            beyond = solver.at(home + (abs(end) + 1e-8) * way)
            assert inside.status == parakin.Status.CONVERGED
            assert beyond.status != parakin.Status.CONVERGED


def test_one_coordinate_has_no_pairs() -> None:
    assert "boundary" not in parakin.range(crank(), pairs=True)


def test_a_range_is_asked_of_where_home_s_plan_is_singular_and_the_mechanism_is_not() -> None:
    hexapod = parakin.compile("gough-stewart")
    found = parakin.range(hexapod, {"platform.pitch": np.pi / 2}, frequency=0.5)
    assert found.attrs["stopped"] == ""
    assert np.isfinite(found["amplitude"].values).all()


def test_cones_of_35_degrees_end_no_coordinate_alone() -> None:
    wide = parakin.compile(RIG, parameters={"cone": "179 deg"})
    found = parakin.range(wide)["travel"].values
    assert found == pytest.approx(parakin.range(rig())["travel"].values, abs=1e-13)


def cylinders(pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Orientations of the cylinders (6, 3, 3): columns along the leg, the second pin, which is
    square to it and to the first, and to both; and the first pins, tangents of the base's circle.
    The platform does not turn.
    """
    base, top = pairs_at(0.82, 14.0, 0.0), np.roll(pairs_at(0.61, 18.0, -60.0), -1, axis=1)
    pins = np.array([-base[1], base[0], base[2]]).T / 0.82
    legs = (pose[:3, None] + top - base).T
    legs = legs / np.linalg.norm(legs, axis=1, keepdims=True)
    second = np.cross(pins, legs)
    second = second / np.linalg.norm(second, axis=1, keepdims=True)
    return np.stack([legs, second, np.cross(legs, second)], axis=2), pins


def tilted(pose: np.ndarray) -> float:
    """The most that a leg has tilted since home, or what was square to both of its pins there."""
    (before, pins), (after, _) = cylinders(home()), cylinders(pose)
    legs = (before[:, :, 0] * after[:, :, 0]).sum(axis=1)
    normals = np.cross(pins, before[:, :, 1])
    turned = np.einsum("nij,nkj,nk->ni", after, before, normals)
    return float(np.arccos(min(legs.min(), (normals * turned).sum(axis=1).min())))


@pytest.mark.parametrize("row", [0, 1, 2])
def test_narrow_cones_end_translations_where_a_leg_has_tilted_as_far(row: int) -> None:
    narrow = parakin.compile(RIG, parameters={"cone": "8 deg"})
    found = parakin.range(narrow)
    for side, sign in enumerate((-1.0, 1.0)):
        way, end = sign * np.eye(6)[row], np.radians(8)
        where = brentq(lambda s, way=way, end=end: tilted(home() + s * way) - end, 0.0, 0.5)
        where = min(where, way_left(home(), way))
        assert sign * found["travel"].values[row, side] == pytest.approx(where, abs=1e-11)
    assert ".cone > 8°" in str(found["stopped_by"].values[0, 1])


def gantry(**limits: tuple[float, float]) -> Solver:
    """Two slides at right angles, the second on the first; the platform is what it carries."""
    table = {
        "name": "gantry",
        "bodies": [{"name": "base"}, {"name": "bridge"}, {"name": "tool"}],
        "joints": [
            {
                "name": "X",
                "kind": "prismatic",
                "parent": "base",
                "child": "bridge",
                "on_parent": {"axis": [1, 0, 0]},
                "on_child": {"axis": [1, 0, 0]},
            },
            {
                "name": "Z",
                "kind": "prismatic",
                "parent": "bridge",
                "child": "tool",
                "on_parent": {"at": [0.05, 0, 0]},
            },
        ],
        "driven": ["X", "Z"],
        "limits": {name.replace("_", "."): list(ends) for name, ends in limits.items()},
    }
    return parakin.compile(parakin.Mechanism(**table), machine_code=False)


@pytest.mark.parametrize("long", [2.0, 20.0])
def test_rays_of_a_pair_go_as_far_as_either_is_looked_at(long: float) -> None:
    found = parakin.range(gantry(X=(-long, long), Z=(-0.3, 0.3)), pairs=True, rays=16)
    x, z = found.boundary.sel(pair=found.pair[0]).values.T
    assert np.isfinite(x).all()
    assert np.isfinite(z).all()
    off = np.maximum(np.abs(x) / long, np.abs(z) / 0.3)
    np.testing.assert_allclose(off, 1.0, atol=1e-9)


def test_a_speed_limit_of_zero_one_way_leaves_the_others_as_they_are() -> None:
    limits = {"X": (-1.0, 1.0), "Z": (-1.0, 1.0), "Z_velocity": (-0.3, np.inf)}
    table = gantry(**limits, X_velocity=(0.0, 0.5))
    found = parakin.range(table, frequency=1.0)
    np.testing.assert_allclose(found.amplitude, [0.0, 0.3 / (2.0 * np.pi)], atol=1e-12)
    assert found.amplitude_limited_by.values.tolist() == [
        "X.velocity < 0 m/s",
        "Z.velocity < -0.3 m/s",
    ]


@pytest.mark.parametrize("derivatives", [2, 3])
def test_a_solver_of_jerks_has_the_same_range(derivatives: int) -> None:
    solver = parakin.compile("delta", derivatives=derivatives, machine_code=False)
    found = parakin.range(solver, forces=True, least_conditioning=0.2)
    same = parakin.range(
        parakin.compile("delta", machine_code=False), forces=True, least_conditioning=0.2
    )
    np.testing.assert_allclose(found.travel, same.travel, atol=1e-9)


@pytest.mark.parametrize("pose", [[1, 2], "home", np.zeros(2)])
def test_poses_and_offsets_are_by_name(pose: object) -> None:
    with pytest.raises(InputError, match="values by the names of driven coordinates"):
        parakin.range(gantry(), pose)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="values by the names of driven coordinates"):
        parakin.range(gantry(), offsets=pose)  # type: ignore[arg-type]
