"""Energies of a double pendulum, by hand."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import parakin

TEXT = """
name = "double"
up = "y"
gravity = 10
driven = ["A", "B"]
[bodies]
upper = { mass = 2, com = [0.5, 0, 0], inertia = [0.1, 0.1, 0.1] }
lower = { mass = 1, com = [1, 0, 0], points = { tip = [1, 0, 0] } }
[joints.A]
kind = "revolute"
parent = "base"
child = "upper"
actuated = true
[joints.B]
kind = "revolute"
parent = "upper"
child = "lower"
actuated = true
armature = 0.2
[joints.A.spring]
stiffness = 8
zero = 0.1
[joints.A.damper]
damping = 3
[joints.B.on_parent]
at = [1, 0, 0]
[forces]
push = { kind = "wrench", at = "lower.tip", force = [4, 0, 0] }
"""


def test_energies_and_powers(tmp_path: Path) -> None:
    (tmp_path / "double.toml").write_text(TEXT)
    solver = parakin.compile(tmp_path / "double.toml")
    a, b, u, v = 0.3, 0.5, 1.5, -0.4
    forces = solver.at([a, b], [u, v], [0.7, 0.2], energies=True).forces
    assert forces is not None
    w = u + v
    tip = (
        -u * math.sin(a) - w * math.sin(a + b),
        u * math.cos(a) + w * math.cos(a + b),
    )
    kinetic = 0.5 * 2 * (0.5 * u) ** 2 + 0.5 * 0.1 * u**2
    kinetic += 0.5 * (tip[0] ** 2 + tip[1] ** 2) + 0.5 * 0.2 * v**2
    height = math.sin(a) + math.sin(a + b)
    potential = 2 * 10 * 0.5 * math.sin(a) + 10 * height + 0.5 * 8 * (a - 0.1) ** 2
    assert forces.kinetic == pytest.approx(kinetic)
    assert forces.potential == pytest.approx(potential)
    assert forces.lost == pytest.approx(3 * u * u)
    assert forces.applied == pytest.approx(4 * tip[0])
