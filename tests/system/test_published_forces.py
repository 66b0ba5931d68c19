"""Forces that are published, or follow by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import parakin

# Andrews' squeezing mechanism (IFToMM benchmark A03; Hairer and Wanner, Solving Ordinary
# Differential Equations II; the test set for IVP solvers). K1 is driven by 0.033 N m from rest.
ANDREWS = """
name = "andrews"
up = "y"
driven = ["O"]
gravity = 0
home.O = -0.0617138900142764496
[guess]
F = 0
B = 0.455279819163070380
G = 0.222668390165885885
A5 = 0.487364979543842550
H = -0.222668390165885885
A7 = 1.23054744454982119
[bodies]
base = { points = { C = [0.014, 0.072, 0] } }
K1 = { mass = 0.04325, com = [92e-5, 0, 0], inertia = { xx = 2.194e-6, yy = 2.194e-6, zz = 2.194e-6 } }
K2 = { mass = 0.00365, com = [-0.0115, 0, 0], inertia = [4.410e-7, 4.410e-7, 4.410e-7] }
K3 = { mass = 0.02373, com = [0.01043, -0.01874, 0], inertia = [5.255e-6, 5.255e-6, 5.255e-6], points = { D = [0.02, -0.018, 0] } }
K4 = { mass = 0.00706, com = [0, -0.00579, 0], inertia = [5.667e-7, 5.667e-7, 5.667e-7] }
K5 = { mass = 0.07050, com = [0.02308, 0.00916, 0], inertia = [1.169e-5, 1.169e-5, 1.169e-5] }
K6 = { mass = 0.00706, com = [0.00579, 0, 0], inertia = [5.667e-7, 5.667e-7, 5.667e-7] }
K7 = { mass = 0.05498, com = [-0.00449, -0.01228, 0], inertia = [1.912e-5, 1.912e-5, 1.912e-5] }
[joints]
O = { kind = "revolute", parent = "base", child = "K1", actuated = true }
F = { kind = "revolute", parent = "K1", child = "K2", on_parent = { at = [0.007, 0, 0] } }
B = { kind = "revolute", parent = "base", child = "K3", on_parent = { at = [-0.03635, 0.03273, 0] } }
A5 = { kind = "revolute", parent = "base", child = "K5", on_parent = { at = [-0.06934, -0.00227, 0] } }
G = { kind = "revolute", parent = "K5", child = "K4", on_parent = { at = [0.04, 0, 0] } }
A7 = { kind = "revolute", parent = "base", child = "K7", on_parent = { at = [-0.06934, -0.00227, 0] } }
H = { kind = "revolute", parent = "K7", child = "K6", on_parent = { at = [0, -0.04, 0] } }
E3 = { kind = "revolute", parent = "K2", child = "K3", on_parent = { at = [-0.028, 0, 0] }, on_child = { at = [0, -0.035, 0] } }
E4 = { kind = "revolute", parent = "K2", child = "K4", on_parent = { at = [-0.028, 0, 0] }, on_child = { at = [0, -0.02, 0] } }
E6 = { kind = "revolute", parent = "K2", child = "K6", on_parent = { at = [-0.028, 0, 0] }, on_child = { at = [0.02, 0, 0] } }
[forces]
s = { kind = "spring", between = ["K3.D", "base.C"], stiffness = "4530 N/m", length = "0.07785 m" }
"""


@pytest.fixture
def andrews(tmp_path: Path) -> parakin.Solver:
    (tmp_path / "andrews.toml").write_text(ANDREWS)
    return parakin.compile(tmp_path / "andrews.toml", coordinates="all")


def test_andrews_starts_as_published(andrews: parakin.Solver) -> None:
    start = andrews.at([andrews.home["O"]], [0.0], [14222.4439199541138705911], forces=True)
    assert start.value("F", "acceleration") == pytest.approx(-10666.8329399655854029, rel=1e-12)
    # The torque is 0.033 N m, of which its digits are exact; the acceleration has 27.
    assert start.value("O", "effort") == pytest.approx(0.033, rel=1e-11)


def test_andrews_multipliers_are_the_published_ones(andrews: parakin.Solver) -> None:
    start = andrews.at(
        [andrews.home["O"]], [0.0], [14222.4439199541138705911], reactions=["E3", "E4", "E6"]
    )
    assert start.forces is not None
    force = start.forces.reaction_force
    # Published: of E as K3 has it, less E as K2 has it, along the base's axes. On K3 at home,
    # whose joint has the axes of K2.
    turn = start.value("O") + start.value("F")
    c, s = math.cos(turn), math.sin(turn)
    x, y = (c * force[:, 0] - s * force[:, 1], s * force[:, 0] + c * force[:, 1])
    assert abs(x[0]) == pytest.approx(98.5668703962410896, rel=1e-10)
    assert abs(y[0]) == pytest.approx(6.12268834425566265, rel=1e-9)
    assert x[1:] == pytest.approx(0.0, abs=1e-9)


def test_andrews_goes_on_as_published(andrews: parakin.Solver) -> None:
    """At 0.03 s: positions, rates and accelerations of the reference solution."""
    there = andrews.at(
        [15.81077119629904],
        [1139.920302151208],
        [-24631.76316945196],
        guess=_walked(andrews, 15.81077119629904),
        forces=True,
    )
    expected = {"F": 51850.37701610329, "B": 324102.5686413781, "H": -566749.3645176222}
    for name, value in expected.items():
        # The published position of K1 is right to 1e-9 rad, which is magnified a thousandfold.
        assert there.value(name, "acceleration") == pytest.approx(value, rel=2e-6)
    assert there.value("O", "effort") == pytest.approx(0.033, rel=1e-4)


def _walked(solver: parakin.Solver, angle: float) -> parakin.Tick:
    tick = solver.at([solver.home["O"]])
    for value in np.linspace(solver.home["O"], angle, 4000).tolist():
        tick = solver.at([value], guess=tick)
    return tick


# Uicker, Pennock and Shigley, Theory of Machines and Mechanisms, problem 11.2: a slider-crank with
# r = 75 mm, l = 350 mm, at 105°, with 900 N against the piston.
SLIDER_CRANK = """
name = "slider-crank"
up = "y"
driven = ["A"]
home.A = "105 deg"
gravity = 0
guess.B = "-117 deg"
guess.D = "0.32 m"
[bodies]
crank = {}
rod = {}
piston = {}
[joints]
A = { kind = "revolute", parent = "base", child = "crank", actuated = true }
B = { kind = "revolute", parent = "crank", child = "rod", on_parent = { at = ["75 mm", 0, 0] } }
C = { kind = "revolute", parent = "rod", child = "piston", on_parent = { at = ["350 mm", 0, 0] } }
D = { kind = "prismatic", parent = "base", child = "piston", on_parent = { axis = [1, 0, 0], x = [0, 1, 0] }, on_child = { axis = [1, 0, 0], x = [0, 1, 0] } }
[forces]
P = { kind = "wrench", at = "piston", force = ["-900 N", 0, 0] }
"""


def test_a_slider_crank_holds_as_in_the_textbook(tmp_path: Path) -> None:
    (tmp_path / "crank.toml").write_text(SLIDER_CRANK)
    solver = parakin.compile(tmp_path / "crank.toml", coordinates="all")
    tick = solver.at([math.radians(105)], reactions=["C", "D"])
    assert tick.status == 0
    forces = tick.forces
    assert forces is not None
    theta, r, rod, P = math.radians(105), 0.075, 0.35, 900.0
    phi = math.asin(r * math.sin(theta) / rod)
    assert math.degrees(phi) == pytest.approx(11.95, abs=0.005)
    assert np.linalg.norm(forces.reaction_force[0, :2]) == pytest.approx(920.0, abs=1.0)
    assert np.linalg.norm(forces.reaction_force[0, :2]) == pytest.approx(P / math.cos(phi))
    wall = abs(forces.reaction_force[1, 0])  # along its frame's x, the base's y
    assert np.isnan(forces.reaction_force[1, 1])  # across the plane: overconstrained in space
    assert wall == pytest.approx(190.0, abs=1.0)
    assert wall == pytest.approx(P * math.tan(phi))
    by_hand = P * r * math.sin(theta + phi) / math.cos(phi)  # virtual power
    assert by_hand == pytest.approx(61.5, abs=0.05)
    # The force pushes the piston towards the crank's axis, which turns it on; the motor holds it.
    assert abs(forces.effort[0]) == pytest.approx(by_hand, rel=1e-12)
    step = 1e-6
    slides = [solver.at([theta + way]).value("D") for way in (step, -step)]
    assert math.copysign(1.0, forces.effort[0]) == math.copysign(1.0, slides[0] - slides[1])
