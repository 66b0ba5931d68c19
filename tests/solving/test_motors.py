"""What motors need behind a screw, driven and driven back."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import parakin

TEXT = """
name = "lift"
driven = ["S"]
gravity = 10
bodies.table = { mass = 120 }
[joints.S]
kind = "prismatic"
parent = "base"
child = "table"
actuated = true
[joints.S.drive]
lead = "10 mm"
efficiency = 0.8
back_efficiency = 0.5
rotor = "1e-3 kg m^2"
torque_constant = "0.5 N m/A"
"""
RATIO = 2 * math.pi / 0.01


@pytest.fixture
def lift(tmp_path: Path) -> parakin.Solver:
    (tmp_path / "lift.toml").write_text(TEXT)
    return parakin.compile(tmp_path / "lift.toml")


@pytest.mark.parametrize(("speed", "through"), [(0.2, 1 / 0.8), (-0.2, 0.5)])
def test_a_screw_takes_more_upwards_and_less_downwards(
    lift: parakin.Solver, speed: float, through: float
) -> None:
    forces = lift.at([0.0], [speed], [0.3], forces=True).forces
    assert forces is not None
    effort = 120 * 10.3
    assert forces.effort == pytest.approx([effort])
    torque = effort / RATIO * through + 1e-3 * RATIO * 0.3
    assert forces.motor_torque == pytest.approx([torque])
    assert forces.motor_speed == pytest.approx([RATIO * speed])
    assert forces.motor_power == pytest.approx([torque * RATIO * speed])
    assert forces.current == pytest.approx([torque / 0.5])
    assert forces.motor_band == pytest.approx([0.0])


def test_at_rest_the_screws_friction_is_a_band(lift: parakin.Solver) -> None:
    forces = lift.at([0.0], forces=True).forces
    assert forces is not None
    ideal = 1200 / RATIO
    assert forces.motor_torque == pytest.approx([ideal])
    assert forces.motor_band == pytest.approx([0.5 * ideal])  # it holds by itself with half


def test_at_rest_the_band_of_a_motor_reaches_as_far_as_both_frictions(tmp_path: Path) -> None:
    friction = TEXT.replace("actuated = true", "actuated = true\nfriction = { coulomb = 300 }")
    (tmp_path / "lift.toml").write_text(friction)
    forces = parakin.compile(tmp_path / "lift.toml").at([0.0], forces=True).forces
    assert forces is not None
    assert forces.band == pytest.approx([300.0])
    assert forces.motor_torque == pytest.approx([1200 / RATIO])
    lowest, highest = 900 / RATIO * 0.5, 1500 / RATIO / 0.8
    farthest = max(1200 / RATIO - lowest, highest - 1200 / RATIO)
    assert forces.motor_band == pytest.approx([farthest])
