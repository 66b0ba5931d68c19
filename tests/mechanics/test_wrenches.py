"""What bodies need to move, and what springs and wrenches exert, by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import parakin
from parakin.algebra.spatial import ARRAYS, FLOATS, Vector, as_array
from parakin.kinematics.closure import Wrench
from parakin.kinematics.recursion import Circuits, slide, turn
from parakin.mechanics.wrenches import applied_wrench, inertial, pull, put, wrenches_needed
from parakin.model.evaluation import graph_of
from parakin.model.graph import Graph

# A cart on rails along x that carries an arm turning about y.
TEXT = """
name = "crane"
driven = ["S", "A"]
gravity = [0, 0, -10]
[bodies]
cart = { mass = 3 }
arm = { mass = 2, com = [0.5, 0, 0], inertia = [0.1, 0.2, 0.3], points = { tip = [1, 0, 0] } }
[joints.S]
kind = "prismatic"
parent = "base"
child = "cart"
on_parent = { axis = [1, 0, 0], x = [0, 0, -1] }
on_child = { axis = [1, 0, 0], x = [0, 0, -1] }
[joints.A]
kind = "revolute"
parent = "cart"
child = "arm"
on_parent = { axis = [0, 1, 0], x = [1, 0, 0] }
on_child = { axis = [0, 1, 0], x = [1, 0, 0] }
[forces]
s = { kind = "spring", between = ["base", "arm.tip"], stiffness = 100, damping = 7, length = 0.5 }
w = { kind = "wrench", at = "arm.tip", force = [0, 0, -4], moment = [0, 3, 0], axes = "body" }
"""
q, qd, qdd = (0.3, 0.7), (0.2, -1.1), (0.5, 2.0)  # of S and A


@pytest.fixture
def crane(tmp_path: Path) -> Graph:
    (tmp_path / "crane.toml").write_text(TEXT)
    return graph_of(parakin.load(tmp_path / "crane.toml"))


def moving(graph: Graph) -> Circuits:
    circuits = Circuits(graph, graph.tree())
    circuits.turns |= {0: slide(q[0]), 1: turn(q[1], FLOATS)}
    circuits.rates |= dict(enumerate(qd))
    circuits.second |= dict(enumerate(qdd))
    return circuits


def test_a_body_needs_newton_and_euler(crane: Graph) -> None:
    g = crane.dynamics.gravity
    found = inertial(moving(crane), 2, crane.dynamics.masses[2], g, 2.0, 1.0)
    c, s = math.cos(q[1]), math.sin(q[1])  # the arm points along (c, 0, -s)
    w, alpha = qd[1], qdd[1]
    r = 0.5 * np.array([c, 0.0, -s])
    across = 0.5 * np.array([-s, 0.0, -c])
    a = np.array([qdd[0], 0.0, 0.0]) + alpha * across - w * w * r
    force = 2.0 * (a + np.array([0.0, 0.0, 10.0]))
    centre = np.array([q[0], 0.0, 0.0]) + r
    moment = np.array([0.0, 0.2 * alpha, 0.0]) + np.cross(centre, force)
    assert as_array(found.force) == pytest.approx(force)
    assert as_array(found.moment) == pytest.approx(moment)


def test_a_spring_pulls_along_its_line(crane: Graph) -> None:
    (spring,) = crane.dynamics.springs
    found = pull(moving(crane), spring, FLOATS)
    tip = np.array([q[0] + math.cos(q[1]), 0.0, -math.sin(q[1])])
    v = np.array([qd[0] - qd[1] * math.sin(q[1]), 0.0, -qd[1] * math.cos(q[1])])
    length = np.linalg.norm(tip)
    rate = v @ tip / length
    tension = 100 * (length - 0.5) + 7 * rate
    assert found.length == pytest.approx(length)
    assert found.rate == pytest.approx(rate)
    assert as_array(found.wrench.force) == pytest.approx(tension * tip / length)
    assert as_array(found.wrench.moment) == pytest.approx(0.0)  # at the base's origin


@pytest.mark.parametrize(("length", "damping"), [(0.0, 0.0), (0.5, 0.0), (0.0, 7.0)])
def test_where_a_spring_s_ends_meet_it_has_a_direction_only_if_it_needs_none(
    crane: Graph, length: float, damping: float
) -> None:
    (spring,) = crane.dynamics.springs
    same = ((2, Vector((1.0, 0.0, 0.0))), (2, Vector((1.0, 0.0, 0.0))))
    spring = spring._replace(ends=same, length=length, damping=damping)
    circuits = Circuits(crane, crane.tree())
    circuits.turns |= {0: slide(np.array([q[0]])), 1: turn(np.array([q[1]]), ARRAYS)}
    circuits.rates |= {k: np.array([rate]) for k, rate in enumerate(qd)}
    with np.errstate(all="ignore"):
        x = as_array(pull(circuits, spring, ARRAYS).wrench.force[0])
    assert np.isnan(x).all() if length or damping else x == pytest.approx(0.0)


def test_a_wrench_turns_with_its_body_or_does_not(crane: Graph) -> None:
    (wrench,) = crane.dynamics.wrenches
    c, s = math.cos(q[1]), math.sin(q[1])
    tip = np.array([q[0] + c, 0.0, -s])
    turning = applied_wrench(moving(crane), wrench, ())
    force = -4 * np.array([s, 0.0, c])  # of the arm's z
    assert as_array(turning.force) == pytest.approx(force)
    assert as_array(turning.moment) == pytest.approx(np.cross(tip, force) + np.array([0, 3, 0]))
    fixed = applied_wrench(moving(crane), wrench._replace(turns=False), ())
    assert as_array(fixed.force) == pytest.approx([0.0, 0.0, -4.0])
    half = applied_wrench(moving(crane), wrench._replace(law={}, turns=False), [0.5])
    assert as_array(half.force) == pytest.approx([0.0, 0.0, -2.0])
    given = applied_wrench(
        moving(crane), wrench._replace(csv="f.csv", turns=False), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    )
    assert as_array(given.force) == pytest.approx([1.0, 2.0, 3.0])
    assert as_array(given.moment) == pytest.approx(np.cross(tip, [1, 2, 3]) + np.array([4, 5, 6]))


def test_what_acts_is_needed_less(crane: Graph) -> None:
    circuits, dynamics = moving(crane), crane.dynamics
    needed = wrenches_needed(circuits, dynamics, (), FLOATS)
    own = inertial(circuits, 2, dynamics.masses[2], dynamics.gravity, 2.0, 1.0)
    spring = pull(
        circuits, dynamics.springs[0], FLOATS
    ).wrench  # on the base; the arm's is opposite
    applied = applied_wrench(circuits, dynamics.wrenches[0], ())
    expected = own.plus(applied.times(-1.0)).plus(spring)
    assert as_array(needed[2].force) == pytest.approx(as_array(expected.force))
    assert as_array(needed[2].moment) == pytest.approx(as_array(expected.moment))
    assert 0 not in needed


def test_nothing_is_put_on_the_base(crane: Graph) -> None:
    on: dict[int, Wrench] = {}
    wrench = pull(moving(crane), crane.dynamics.springs[0], FLOATS).wrench
    put(on, 0, wrench)
    put(on, 1, wrench)
    put(on, 1, wrench)
    assert on.keys() == {1}
    assert isinstance(on[1].force, Vector)
    assert as_array(on[1].force) == pytest.approx(2 * as_array(wrench.force))
