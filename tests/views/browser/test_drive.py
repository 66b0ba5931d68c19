"""Driving by hand: it follows, and stops where geometry says it must."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import parakin
from parakin.solving.status import Status
from parakin.views.browser.drive import Drive, choices, driven_by


def _drive(name: str, *driven: str) -> Drive:
    return driven_by(parakin.load(name), driven)


def test_a_platform_stops_where_an_arm_is_stretched() -> None:
    drive = _drive("five-bar", "platform.x", "platform.y")
    p = drive.solver.graph.parameters
    reach, shoulder = p["proximal"] + p["distal"], p["base"] / 2
    stop = drive.to([drive.y[0], 10.0])
    assert stop is not None
    assert drive.tick.status == Status.CONVERGED
    x, y = drive.y
    far = max(math.hypot(x - shoulder, y), math.hypot(x + shoulder, y))
    assert far == pytest.approx(reach, abs=1e-5)
    assert far < reach
    blamed = {drive.solver.graph.joints[k].name for k in stop.joints}
    assert blamed & {"A1", "A2", "B1", "B2"}
    limb, _, singularity = stop.words.partition(" cannot reach: ")
    assert limb in ("limb P, A2, B2", "limb A1, B1")
    assert singularity == "a type 1 singularity, where A1 and A2 move while the platform rests"


def test_actuators_stop_where_the_forearms_are_in_line() -> None:
    drive = _drive("five-bar", "A1", "A2")
    p = drive.solver.graph.parameters
    stop = drive.to([drive.y[0] + 10.0, drive.y[1]])
    assert stop is not None
    assert stop.words.startswith("a type 2 singularity, where the platform moves along direction")
    assert stop.words.endswith("with the actuators locked (A1 and A2)")
    x = np.array([-1.0, 1.0]) * p["base"] / 2 + p["proximal"] * np.cos(drive.y)
    elbows = math.hypot(x[1] - x[0], p["proximal"] * float(np.diff(np.sin(drive.y))[0]))
    assert elbows == pytest.approx(2 * p["distal"], abs=1e-5)
    assert elbows < 2 * p["distal"]


def test_a_rocker_stops_where_crank_and_coupler_are_in_line() -> None:
    drive = _drive("four-bar", "D")
    p = drive.solver.graph.parameters
    a, b, c, d = (p[k] for k in "abcd")

    def rocker(diagonal: float) -> float:
        """The angle at the rocker's pivot, from the base, to a coupler's end so far from A."""
        return math.acos((c * c + d * d - diagonal**2) / (2 * c * d))

    ends = {round(math.pi - rocker(s), 3) for s in (b + a, b - a)}
    found = set()
    for way in (-10.0, 10.0):
        drive.home()
        stop = drive.to(drive.y + way)
        assert stop is not None
        found.add(round(float(drive.y[0]) % (2 * math.pi), 3))
    assert found == {round(e % (2 * math.pi), 3) for e in ends}


def test_a_flat_parallelogram_lets_the_platform_turn_whatever_is_driven() -> None:
    drive = _drive("delta", "A1", "A2", "A3")
    stop = drive.to([drive.y[0] + 10.0, *drive.y[1:]])
    assert stop is not None
    assert stop.words.startswith("a constraint singularity, where the platform turns")
    assert stop.words.endswith("whatever is driven")


def test_a_limit_stops_it_at_the_limit() -> None:
    drive = _drive("seat-2dof", "A1", "A2")
    assert drive.beyond_limits == {}
    _, high = drive.solver.graph.limits("A1")
    stop = drive.to([9.0, 0.0])
    assert stop is not None
    assert stop.status == Status.LIMIT_EXCEEDED
    assert [drive.solver.graph.joints[k].name for k in stop.joints] == ["A1"]
    assert high - 1e-4 < drive.y[0] <= high
    assert drive.to([0.0, 0.0]) is None  # and back


def test_values_that_are_no_numbers_are_refused() -> None:
    drive = _drive("four-bar", "A")
    for bad in (math.nan, math.inf):
        stop = drive.to([bad])
        assert stop is not None
        assert stop.status == Status.OUT_OF_REACH
    assert drive.tick.status == Status.CONVERGED


@settings(deadline=None)
@given(st.lists(st.floats(-3, 3), min_size=6, max_size=6))
def test_wherever_it_is_sent_it_stands_closed(goal: list[float]) -> None:
    drive = _cached("gough-stewart")
    drive.home()
    stop = drive.to(goal)
    assert drive.tick.status == Status.CONVERGED
    assert drive.tick.residual < 1e-12 * max(1.0, drive.solver.graph.length)
    assert stop is not None or np.array_equal(drive.y, goal)


_kept: dict[str, Drive] = {}


def _cached(name: str) -> Drive:
    if name not in _kept:
        solver = parakin.compile(name, coordinates="all")
        _kept[name] = Drive(solver)
    return _kept[name]


@pytest.mark.parametrize("name", ["gough-stewart", "flight-simulator", "agile-eye"])
def test_driven_to_a_pose_it_takes_that_pose(name: str) -> None:
    """There and back: where it stands leads to the same driven values."""
    drive = _cached(name)
    drive.home()
    goal = drive.y + 0.05 * np.array([1.0, -1.0, 0.5, 0.3, -0.7, 0.9])[: len(drive.y)]
    assert drive.to(goal) is None
    there = drive.platform()
    assert there is not None
    drive.home()
    np.testing.assert_allclose(drive.values_for_pose(*there), goal, atol=1e-12)


def test_forward_takes_over_the_pose_that_inverse_left() -> None:
    mechanism = parakin.load("flight-simulator")
    inverse = driven_by(mechanism, mechanism.driven)
    assert inverse.to([1.9, 1.2, 0.1]) is None
    forward = _drive("flight-simulator", "A2", "B3", "C3")
    assert forward.start_from(inverse.values)
    for name, value in inverse.values.items():
        assert forward.values[name] == pytest.approx(value, abs=1e-9)
    assert not forward.start_from(dict.fromkeys(inverse.values, 1.0))


def test_it_knows_in_which_assembly_it_stands() -> None:
    drive = _drive("five-bar", "platform.x", "platform.y")
    search = parakin.modes(drive.solver)
    poses = [branch.coordinates for branch in search.modes]
    assert drive.nearest(poses, search.distinguished_by) == 0
    for k, pose in enumerate(poses):
        other = driven_by(drive.solver.mechanism, drive.solver.driven, pose)
        assert other.nearest(poses, search.distinguished_by) == k
    assert drive.to(drive.y + 0.02) is None
    assert drive.nearest(poses, search.distinguished_by) is None


def test_a_pose_beyond_limits_tells_them() -> None:
    drive = _drive("seat-2dof", "A1", "A2")
    _, high = drive.solver.graph.limits("A1")
    drive.y = np.array([high + 0.1, 0.0])
    drive.tick = drive.solver.at(drive.y, guess=drive.tick.position)
    assert drive.beyond_limits == {"A1": drive.solver.graph.holder("A1")}
    assert drive.to([high + 0.2, 0.0]) is not None  # no further
    assert drive.to([high - 0.1, 0.0]) is None  # but back


def test_what_can_be_driven() -> None:
    sets = {
        name: choices(parakin.compile(name, coordinates="all"))
        for name in ("flight-simulator", "four-bar", "hexapod-on-3rps", "bennett")
    }
    pose = ("platform.x", "platform.y", "platform.phi")
    assert sets["flight-simulator"] == {"inverse": pose, "forward": ("A2", "B3", "C3")}
    assert sets["four-bar"] == {"inverse": ("D",), "forward": ("A",)}
    assert sets["hexapod-on-3rps"]["forward"] == (
        *(f"L{i}" for i in range(1, 4)),
        *(f"P{i}" for i in range(1, 7)),
    )
    assert sets["bennett"]["forward"] == ("A",)


@pytest.mark.parametrize("name", [n for n in parakin.catalogue() if n != "flight-simulator-upu"])
def test_one_of_the_choices_is_the_files_own_and_all_can_be_compiled(name: str) -> None:
    solver = parakin.compile(name, coordinates="all")
    found = choices(solver)
    assert solver.driven in found.values()
    for driven in found.values():
        drive = driven_by(solver.mechanism, driven)
        assert drive.tick.status == Status.CONVERGED
        for k, coordinate in enumerate(driven):
            low, high = drive.span(coordinate)
            assert low <= drive.y[k] <= high


def test_what_is_left_is_told_where_positions_are_limited() -> None:
    seat = _drive("seat-3dof", "platform.z", "platform.pitch", "platform.roll")
    before = seat.left()
    assert before is not None
    assert seat.to(seat.y + np.array([0.02, 0.0, 0.0])) is None
    after = seat.left()
    assert after is not None
    heave = {"driven": "platform.z"}
    moved = before["travel"].sel(heave) - after["travel"].sel(heave)
    assert moved.values == pytest.approx([0.02, 0.02], abs=1e-9)
    assert _drive("five-bar", "platform.x", "platform.y").left() is None
