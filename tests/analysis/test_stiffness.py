"""Stiffness and the largest wrench, against lines in space."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin import Body, InputError, Mechanism
from parakin.analysis.stiffness import Stiffness
from parakin.model.drives import Drive

STIFF = 2.0e7  # [N/m]
LIMIT = 5000.0  # [N]


def hexapod(**drive: float) -> Mechanism:
    """The catalogue's without its masses, every leg with this drive."""
    mechanism = parakin.load("gough-stewart")
    joints = [
        joint.model_copy(update={"drive": Drive(**drive)}) if joint.actuated else joint
        for joint in mechanism.joints
    ]
    bodies = tuple(Body(name=body.name, points=body.points) for body in mechanism.bodies)
    return mechanism.model_copy(update={"joints": tuple(joints), "bodies": bodies})


def legs() -> np.ndarray:
    """Plücker lines of the legs at home about the platform's origin, upwards, (6, legs)."""
    a, rb, rp, h = np.radians(20), 1.2, 0.7, 1.1
    base = np.radians([-10, 10, 110, 130, 230, 250])
    top = np.array([a / 2 - np.pi / 3, np.pi / 3 - a / 2, np.pi / 3 + a / 2])
    top = np.concatenate([top, [np.pi - a / 2, np.pi + a / 2, -np.pi / 3 - a / 2]])
    feet = np.stack([rb * np.cos(base), rb * np.sin(base), np.full(6, -h)])
    tips = np.stack([rp * np.cos(top), rp * np.sin(top), np.zeros(6)])
    along = (tips - feet) / np.linalg.norm(tips - feet, axis=0)
    return np.concatenate([along, np.cross(tips.T, along.T).T])


def at_home(mechanism: Mechanism) -> Stiffness:
    solver = parakin.compile(mechanism)
    return parakin.stiffness(solver, [solver.home[name] for name in solver.driven])


def test_a_hexapods_stiffness_is_that_of_its_lines() -> None:
    lines = legs()
    found = at_home(hexapod(stiffness=STIFF))
    expected = STIFF * lines @ lines.T
    assert found.stiffness == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())
    wrench = np.array([100.0, -200.0, 300.0, 10.0, 20.0, -30.0])
    assert found.deflection(wrench) == pytest.approx(np.linalg.solve(expected, wrench), rel=1e-9)


def test_efforts_hold_a_wrench_along_the_legs() -> None:
    lines = legs()
    found = at_home(hexapod())
    wrench = np.array([100.0, -200.0, 300.0, 10.0, 20.0, -30.0])
    assert found.effort_per_wrench @ wrench == pytest.approx(-np.linalg.solve(lines, wrench))
    assert found.compliance == pytest.approx(0.0)  # of rigid drives
    with pytest.raises(InputError, match="infinitely stiff"):
        _ = found.stiffness


def test_the_largest_wrench_is_where_the_first_leg_is_at_its_limit() -> None:
    lines = legs()
    found = at_home(hexapod(max_effort=LIMIT))
    direction = np.array([0.0, 1.0, 0.5, 0.1, 0.0, 0.0])
    efforts = np.linalg.solve(lines, direction)
    factor, actuator = found.largest(direction)
    assert factor == pytest.approx(LIMIT / np.abs(efforts).max())
    assert actuator == f"P{1 + np.argmax(np.abs(efforts))}"
    axes, directions = found.ellipsoid()
    shares = np.linalg.solve(lines, directions * axes) / LIMIT
    assert np.linalg.norm(shares, axis=0) == pytest.approx(1.0)
    assert (np.diff(axes) <= 0).all()


def test_own_weight_takes_its_share() -> None:
    mechanism = hexapod(max_effort=LIMIT)
    bodies = [
        body.model_copy(update={"mass": 250.0}) if body.name == "platform" else body
        for body in mechanism.bodies
    ]
    found = at_home(mechanism.model_copy(update={"bodies": tuple(bodies)}))
    lines = legs()
    weight = np.array([0.0, 0.0, 250.0 * 9.80665, 0.0, 0.0, 0.0])
    assert found.efforts == pytest.approx(np.linalg.solve(lines, weight))
    down = found.largest([0.0, 0.0, -1.0, 0.0, 0.0, 0.0]).factor
    up = found.largest([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]).factor
    assert up - down == pytest.approx(2 * 250.0 * 9.80665)


def test_what_nothing_holds_is_refused() -> None:
    four_bar = parakin.load("four-bar")
    solver = parakin.compile(four_bar)
    y = [solver.home["A"]]
    with pytest.raises(InputError, match="unknown body or point 'seat'"):
        parakin.stiffness(solver, y, at="seat")
    with pytest.raises(InputError, match="no max_effort"):
        parakin.stiffness(solver, y, at=four_bar.joints[1].child).ellipsoid()
    with pytest.raises(InputError, match="expected \\(6,\\), finite"):
        parakin.stiffness(solver, y, at=four_bar.joints[1].child).deflection([1.0])
