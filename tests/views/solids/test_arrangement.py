"""Where joints are drawn: in planes, away from a common centre, over their stroke."""

from __future__ import annotations

import numpy as np
import pytest

from parakin.files.reading import catalogue, load
from parakin.model.evaluation import graph_of
from parakin.views.solids.arrangement import Arrangement, arrangement_of


def arranged(name: str) -> Arrangement:
    return arrangement_of(graph_of(load(name)))


@pytest.mark.parametrize("name", ["four-bar", "five-bar", "slider-crank", "3-rrr"])
def test_links_that_share_a_hinge_lie_in_different_planes(name: str) -> None:
    arrangement = arranged(name)
    assert arrangement.plane_axis is not None
    np.testing.assert_allclose(np.abs(arrangement.plane_axis).max(), 1, atol=1e-12)
    hinges = [joint for joint in arrangement.graph.joints if joint.kind == "revolute"]
    assert hinges
    for joint in hinges:
        assert arrangement.layers[joint.parent] != arrangement.layers[joint.child]
    assert arrangement.layers[0] == 0


@pytest.mark.parametrize("name", ["gough-stewart", "delta", "agile-eye"])
def test_a_spatial_mechanism_has_no_planes(name: str) -> None:
    arrangement = arranged(name)
    assert arrangement.plane_axis is None
    assert set(arrangement.layers) == {0}
    assert not arrangement.shift(1).any()


def test_hinges_of_a_spherical_mechanism_stand_around_its_centre() -> None:
    """All axes of an Agile Eye meet in one point, where its file puts every joint."""
    arrangement = arranged("agile-eye")
    for body in range(len(arrangement.poses)):
        for end in arrangement.ends(body):
            if arrangement.graph.joints[end.joint].kind == "revolute":
                away = np.linalg.norm(arrangement.world(body, end.point))
                assert away == pytest.approx(arrangement.concurrent)


def test_the_legs_of_a_hexapod_are_cylinders_as_long_as_from_joint_to_joint() -> None:
    arrangement = arranged("gough-stewart")
    graph = arrangement.graph
    legs = [k for k, joint in enumerate(graph.joints) if joint.kind == "prismatic"]
    assert len(legs) == 6
    for number in legs:
        joint = graph.joints[number]
        assert arrangement.is_cylinder(number)
        ends = []
        for body in (joint.parent, joint.child):
            (other,) = (end for end in arrangement.placed(body) if end.joint != number)
            ends.append(arrangement.world(body, other.point)[0])
        apart = np.linalg.norm(ends[1] - ends[0])
        assert abs(arrangement.length(number)) == pytest.approx(apart, rel=1e-9)
        low, high = arrangement.stroke(number)
        assert low < arrangement.travel(joint) < high


@pytest.mark.parametrize("name", catalogue())
def test_both_bodies_of_a_joint_meet_where_it_is(name: str) -> None:
    """A hinge, a universal and a spherical joint have one point, wherever they turn to."""
    arrangement = arranged(name)
    placed = [
        {e.joint: arrangement.world(b, e.point)[0] for e in arrangement.placed(b)}
        for b in range(len(arrangement.poses))
    ]
    for number, joint in enumerate(arrangement.graph.joints):
        if joint.kind in ("revolute", "universal", "spherical"):
            apart = placed[joint.parent][number] - placed[joint.child][number]
            assert np.abs(apart).max() < 1e-8 * arrangement.size
