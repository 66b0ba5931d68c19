"""Arrows of efforts in a scene: one node, to the scale of the largest."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pendulum
import pytest

import parakin
from parakin.model.evaluation import graph_of
from parakin.views.browser.efforts import Efforts, Reactions
from parakin.views.force_arrows import LONGEST


class Api:
    """Counts the arrows' nodes that are in a scene."""

    def __init__(self) -> None:
        self.nodes: list[Any] = []

    def add_arrows(self, name: str, points: np.ndarray, colors: np.ndarray, **_: Any) -> Any:
        node = SimpleNamespace(name=name, points=points, colors=colors)
        node.remove = lambda: self.nodes.remove(node)
        self.nodes.append(node)
        return node


def length(node: Any) -> float:
    return float(np.linalg.norm(node.points[0, 1] - node.points[0, 0]))


def test_arrows_follow_and_keep_their_scale() -> None:
    api = Api()
    efforts = Efforts(api, "/mechanism", graph_of(pendulum.pendulum()), 1.0)
    pose = np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]])
    efforts.scale_to(np.array([[4.0], [-20.0], [np.nan]]), ("N m",))
    efforts.show(*pose, ("A",), ("N m",), np.array([10.0]))
    (node,) = api.nodes
    assert length(node) == pytest.approx(0.5 * LONGEST)
    efforts.show(*pose, ("A",), ("N m",), np.array([-20.0]))
    assert api.nodes == [node]
    assert length(node) == pytest.approx(LONGEST)
    assert node.points[0, 1, 2] < 0.0
    efforts.show(*pose, ("A",), ("N m",), np.array([40.0]))
    assert length(node) == pytest.approx(LONGEST)
    efforts.show(*pose, ("A",), ("N m",), np.array([20.0]))
    assert length(node) == pytest.approx(0.5 * LONGEST)


def test_efforts_that_are_none_or_unknown_have_no_arrow() -> None:
    api = Api()
    efforts = Efforts(api, "/mechanism", graph_of(pendulum.pendulum()), 1.0)
    pose = np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]])
    for effort in (5.0, 0.0, 5.0, np.nan):
        efforts.show(*pose, ("A",), ("N m",), np.array([effort]))
        assert len(api.nodes) == int(effort > 0.0)
    efforts.hide()
    assert api.nodes == []


def test_forces_in_joints_are_along_the_joints_axes() -> None:
    """A pendulum at rest, carried by its pivot: an arrow upwards, to the scale of the largest."""
    api = Api()
    solver = parakin.compile(pendulum.pendulum())
    joints = tuple(solver.mechanics.joints.values())
    tick = solver.at([0.3], reactions=True)
    assert tick.forces is not None
    force = tick.forces.reaction_force
    reactions = Reactions(api, "/mechanism", 1.0)
    reactions.scale_to(2.0 * force[None])
    poses = solver.poses(np.array([0.3]), tick)
    reactions.show(*poses, joints, force)
    (node,) = api.nodes
    gravity = np.array(solver.graph.dynamics.gravity)
    up = -gravity / np.linalg.norm(gravity)
    arrow = node.points[0, 1] - node.points[0, 0]
    assert arrow == pytest.approx(0.5 * LONGEST * up, abs=1e-6)
    reactions.show(*poses, joints, np.full((1, 3), np.nan))
    assert api.nodes == []
    reactions.hide()
    assert len(reactions.points) == 0
