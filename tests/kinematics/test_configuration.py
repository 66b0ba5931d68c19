"""Configurations: screws and the closure's Jacobian against differences of what is closed."""

from __future__ import annotations

import numpy as np
import pytest
from loops_of_every_kind import KINDS, closed, loop_of
from scipy.spatial.transform import Rotation

import parakin
from parakin.algebra.spatial import as_array, as_float
from parakin.arrays import FloatArray
from parakin.kinematics.configuration import (
    Configuration,
    closure_system,
    configure,
    coordinate_scales,
    loop_rank,
    loop_signs,
)
from parakin.model.evaluation import graph_of
from parakin.model.graph import Graph, Tree


def standing(kind: str, seed: int = 0) -> tuple[Graph, Tree, Configuration]:
    circuits, _ = closed(kind, seed)
    graph, tree = circuits.graph, loop_of(kind)[1]
    q = np.zeros(len(graph.coordinates))
    for k, turn in circuits.turns.items():
        q[k] = as_float(turn.amount)
    return graph, tree, configure(graph, tree, q)


def twist_by_differences(graph: Graph, tree: Tree, q: FloatArray, k: int, body: int) -> FloatArray:
    """Angular velocity and velocity at the base's origin per unit of a coordinate."""
    h = 1e-6
    ahead, behind = (
        configure(graph, tree, q + step * np.eye(len(q))[k]).pose(body) for step in (h, -h)
    )
    turn = Rotation.from_matrix(as_array(ahead.R)) * Rotation.from_matrix(as_array(behind.R)).inv()
    w = turn.as_rotvec() / (2 * h)
    v = (as_array(ahead.p) - as_array(behind.p)) / (2 * h)
    middle = 0.5 * (as_array(ahead.p) + as_array(behind.p))
    return np.concatenate([w, v - np.cross(w, middle)])


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_a_screw_is_what_its_coordinate_moves_the_bodies_beyond_by(kind: str) -> None:
    graph, tree, at = standing(kind)
    for number, backwards in tree.steps:
        joint = graph.joints[number]
        assert not backwards
        for k in joint.coordinates:
            exact = twist_by_differences(graph, tree, at.q, k, joint.child)
            np.testing.assert_allclose(at.screws[:, k], exact, atol=1e-8)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_the_jacobian_is_that_of_the_gaps(kind: str, seed: int) -> None:
    """Of joints that slide too, whose gap is not zero where the loop is closed."""
    graph, tree, at = standing(kind, seed)
    signs = loop_signs(graph, tree)
    gaps, jacobian, rows = closure_system(graph, tree, at, signs)
    assert np.abs(gaps).max() < 1e-14
    assert jacobian.shape == (len(rows), len(graph.coordinates))
    h = 1e-6
    for k in graph.tree_coordinates(tree):
        ahead, behind = (
            closure_system(
                graph, tree, configure(graph, tree, at.q + step * np.eye(len(at.q))[k]), signs
            )[0]
            for step in (h, -h)
        )
        np.testing.assert_allclose(jacobian[:, k], (ahead - behind) / (2 * h), atol=1e-8)


@pytest.mark.parametrize(("name", "rank"), [("four-bar", 3), ("bennett", 3), ("bricard", 5)])
def test_the_rank_of_a_loop(name: str, rank: int) -> None:
    """Planar loops span 3; Bennett's has mobility 1 from four axes, Bricard's 1 from six."""
    graph = graph_of(parakin.load(name))
    solver = parakin.compile(name, machine_code=False)
    at = configure(graph, graph.posed_tree(), solver.plan.home)
    assert loop_rank(graph, at, range(len(graph.coordinates))) == rank


def test_slides_count_in_characteristic_lengths() -> None:
    graph = graph_of(parakin.load("slider-crank"))
    scales = coordinate_scales(graph)
    for coordinate, scale in zip(graph.coordinates, scales, strict=True):
        assert scale == (1.0 if coordinate.angle else graph.length)


def test_angles_of_cut_joints_stay_within_half_a_turn_of_what_is_given() -> None:
    graph = graph_of(parakin.load("four-bar"))
    tree = graph.posed_tree()
    home = parakin.compile("four-bar", machine_code=False).plan.home
    (cut,) = tree.cuts
    k = graph.joints[cut].first
    given = home.copy()
    given[k] += 4 * np.pi + 0.1
    assert configure(graph, tree, given).q[k] == pytest.approx(home[k] + 4 * np.pi, abs=1e-12)
