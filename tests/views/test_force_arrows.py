"""Arrows of efforts: on the joint, along its axis, in proportion."""

from __future__ import annotations

import numpy as np
import pendulum
import pytest
from scipy.spatial.transform import Rotation

import parakin
from parakin.model.evaluation import graph_of
from parakin.views.force_arrows import LONGEST, ForceArrows, largest_of


def test_the_largest_of_those_with_the_same_unit() -> None:
    efforts = np.array([[1.0, -5.0, np.nan], [2.0, 3.0, 0.25]])
    assert largest_of(efforts, ("N", "N", "N m")).tolist() == [5.0, 5.0, 0.25]


def test_a_moment_is_along_its_axis() -> None:
    arrows = ForceArrows(graph_of(pendulum.pendulum()), ("A",), 2.0)
    R, p = np.repeat(np.eye(3)[None], 2, axis=0), np.zeros((2, 3))
    (arrow,) = arrows.at(R, p, np.array([-5.0]), np.array([10.0]))
    np.testing.assert_allclose(arrow, np.array([[0, 0, 0], [0, 0, -0.5 * LONGEST * 2.0]]))
    (unknown,) = arrows.at(R, p, np.array([np.nan]), np.array([10.0]))
    np.testing.assert_array_equal(unknown, np.zeros((2, 3)))


def test_the_forces_of_legs_are_along_them() -> None:
    """A leg of a Gough platform pushes from its joint on the base to that on the platform."""
    solver = parakin.compile("gough-stewart", coordinates="all", machine_code=False)
    graph = solver.graph
    result = solver.solve("tour", bodies=True)
    legs = tuple(f"P{k}" for k in range(1, 7))
    arrows = ForceArrows(graph, legs, graph.length)
    assert arrows.shown == tuple(range(6))
    for i in (0, 1234):
        position = result["body_position"].values[i]
        turned = Rotation.from_quat(result["body_orientation"].values[i], scalar_first=True)
        R = np.concatenate([np.eye(3)[None], turned.as_matrix()])
        p = np.concatenate([np.zeros((1, 3)), position])
        found = arrows.at(R, p, np.ones(6), np.ones(6))
        for k, (start, end) in enumerate(found, start=1):
            lower, upper = (
                next(j for j in graph.joints if j.name == f"{kind}{k}") for kind in "US"
            )
            foot = p[lower.parent] + R[lower.parent] @ np.array(lower.F.p)
            ball = p[upper.child] + R[upper.child] @ np.array(upper.M.p)
            leg = (ball - foot) / np.linalg.norm(ball - foot)
            np.testing.assert_allclose(end - start, LONGEST * graph.length * leg, atol=1e-12)
            assert np.linalg.norm(np.cross(start - foot, leg)) < 1e-9


def test_the_axis_of_a_pair_between_others_is_not_known() -> None:
    graph = graph_of(parakin.load("gough-stewart"))
    arrows = ForceArrows(graph, ("platform.x", "platform.y", "platform.yaw"), 1.0)
    assert arrows.shown == (0, 2)
    assert pytest.approx(1.0) == float(np.linalg.norm(arrows._axes[1]))
