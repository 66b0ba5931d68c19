"""Instantaneous motions in words."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import parakin
from parakin.analysis.twists import moving, names, platform_axes, platform_motion
from parakin.model.graph import Graph


@pytest.fixture(scope="module")
def graph() -> Graph:
    return parakin.compile("gough-stewart", machine_code=False).graph


def test_names_are_listed_as_in_a_sentence(graph: Graph) -> None:
    legs = [graph.index(f"P{i}", "test") for i in (1, 2, 3)]
    assert names(graph, legs[:1]) == "P1"
    assert names(graph, legs[:2]) == "P1 and P2"
    assert names(graph, legs) == "P1, P2 and P3"


def test_what_moves_most_is_named_first_and_what_hardly_moves_not_at_all(graph: Graph) -> None:
    legs = [graph.index(f"P{i}", "test") for i in (1, 2, 3)]
    rates = np.zeros(len(graph.coordinates))
    rates[legs] = [0.5, -1.0, 0.1]
    assert moving(graph, rates, legs) == "P2 and P1 move"
    assert moving(graph, rates, legs[2:]) == "P3 moves"


def test_the_axes_of_three_angles_are_those_of_the_rotation(graph: Graph) -> None:
    """Roll, pitch and yaw about moving axes: R = Rx Ry Rz, each axis carried by those before."""
    pose = graph.joints[graph.platform or 0]
    q = np.zeros((len(graph.coordinates), 1))
    q[list(pose.coordinates[3:]), 0] = 0.3, -0.5, 0.8
    sequence = "".join("XYZ"[pair.axis] for pair in pose.pairs[3:])
    (axes,), (R,) = platform_axes(graph, q)
    angles = q[list(pose.coordinates[3:]), 0]
    np.testing.assert_allclose(R, Rotation.from_euler(sequence, angles).as_matrix(), atol=1e-15)
    h = 1e-6
    for k in range(3):
        ahead, behind = (
            Rotation.from_euler(sequence, angles + step * np.eye(3)[k]) for step in (h, -h)
        )
        np.testing.assert_allclose(
            axes[:, k], (ahead * behind.inv()).as_rotvec() / (2 * h), atol=1e-9
        )


@pytest.mark.parametrize(
    ("rates", "said"),
    [
        ([0, 0, 1, 0, 0, 0], "the platform slides along its own z"),
        ([0, 0, 0, 0, 0, 1], "the platform turns about its own z"),
    ],
)
def test_the_platforms_motion_in_words(graph: Graph, rates: list[float], said: str) -> None:
    pose = graph.joints[graph.platform or 0]
    whole = np.zeros(len(graph.coordinates))
    whole[list(pose.coordinates)] = rates
    q = np.zeros(len(graph.coordinates))
    assert platform_motion(graph, whole, q, list(pose.coordinates)) == said
    cannot = platform_motion(graph, whole, q, list(pose.coordinates), "cannot")
    assert cannot.startswith("the platform cannot")


def test_no_platform_no_words() -> None:
    four_bar = parakin.compile("four-bar", machine_code=False).graph
    assert platform_motion(four_bar, np.ones(4), np.zeros(4), [3]) == ""
