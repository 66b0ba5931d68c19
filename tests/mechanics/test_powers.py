"""Wrenches carried to the base, against moments about the joints by hand."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import parakin
from parakin.algebra.spatial import FLOATS, ZERO, Vector
from parakin.kinematics.closure import Wrench
from parakin.kinematics.recursion import Circuits, turn
from parakin.mechanics.powers import carried, power_at_unit_rate
from parakin.model.evaluation import graph_of

# Two arms of one metre in a plane; the second joint is written from the outer arm to the inner one.
TEXT = """
name = "arms"
driven = ["A", "B"]
[bodies]
inner = {}
outer = {}
[joints.A]
kind = "revolute"
parent = "base"
child = "inner"
[joints.B]
kind = "revolute"
parent = "outer"
child = "inner"
on_child = { at = [1, 0, 0] }
"""


@pytest.fixture
def circuits(tmp_path: Path) -> Circuits:
    (tmp_path / "arms.toml").write_text(TEXT)
    graph = graph_of(parakin.load(tmp_path / "arms.toml"))
    found = Circuits(graph, graph.tree())
    found.turns |= {0: turn(0.4, FLOATS), 1: turn(-0.9, FLOATS)}  # the outer arm is turned by 1.3
    return found


def test_efforts_are_moments_about_the_joints(circuits: Circuits) -> None:
    elbow = (math.cos(0.4), math.sin(0.4))
    tip = (elbow[0] + math.cos(1.3), elbow[1] + math.sin(1.3))
    force = Vector((2.0, -5.0, 0.0))
    needed = {2: Wrench(Vector((0.0, 0.0, tip[0] * force[1] - tip[1] * force[0])), force)}
    found = carried(circuits, circuits.graph.tree(), needed)
    shoulder = tip[0] * force[1] - tip[1] * force[0]
    bend = (tip[0] - elbow[0]) * force[1] - (tip[1] - elbow[1]) * force[0]
    assert found.efforts[0] == pytest.approx(shoulder)
    assert found.efforts[1] == pytest.approx(-bend)  # B counts from the outer arm
    assert found.joints[0].force == pytest.approx(force)
    assert found.joints[1].force == pytest.approx(force * -1.0)  # on its child, the inner arm


def test_only_what_is_wanted_is_worked_out(circuits: Circuits) -> None:
    needed = {1: Wrench(Vector((0.0, 0.0, 3.0)), ZERO)}
    found = carried(circuits, circuits.graph.tree(), needed, wanted=[1])
    assert found.efforts == {}  # nothing hangs on B
    assert found.joints.keys() == {0}
    assert power_at_unit_rate(circuits, 1, 0, needed[1]) == 3.0
