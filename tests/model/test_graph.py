"""Spanning trees, joints split into single ones, and twins, of the whole catalogue."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import parakin
from parakin import InputError
from parakin.algebra.spatial import IDENTITY
from parakin.model.evaluation import graph_of
from parakin.model.graph import Graph, Tree
from parakin.model.joints import GraphJoint, Pair

NAMES = parakin.catalogue()


def assert_spans(graph: Graph, tree: Tree) -> None:
    """Every body is reached once, each step starts where a step before it has led, and by
    Euler's formula as many joints are cut as there are independent loops.
    """
    reached = [0]
    for k, backwards in tree.steps:
        joint = graph.joints[k]
        near, far = (joint.child, joint.parent) if backwards else (joint.parent, joint.child)
        assert near in reached
        assert far not in reached
        reached.append(far)
    assert sorted(reached) == list(range(len(graph.bodies)))
    assert len(tree.cuts) == len(graph.joints) - len(graph.bodies) + 1
    assert sorted([*tree.cuts, *(k for k, _ in tree.steps)]) == list(range(len(graph.joints)))


@pytest.mark.parametrize("name", NAMES)
def test_trees_span_and_keep_what_they_are_asked_to(name: str) -> None:
    graph = graph_of(parakin.load(name))
    assert_spans(graph, graph.tree())
    assert_spans(graph, graph.posed_tree())
    steps = [k for k, _ in graph.posed_tree().steps]
    assert graph.platform is None or graph.platform in steps
    for k, joint in enumerate(graph.joints):
        if joint.kind != "rod":
            tree = graph.tree(first=[k])
            assert_spans(graph, tree)
            assert k in [step for step, _ in tree.steps]


@pytest.mark.parametrize("name", ["gough-stewart", "flight-simulator", "delta"])
def test_no_joint_of_a_tree_could_be_exchanged_for_a_cut_one_of_fewer_freedoms(name: str) -> None:
    """A tree of least freedoms: along the loop of each cut joint no joint has more."""
    graph = graph_of(parakin.load(name))
    tree = graph.tree()
    for cut in tree.cuts:
        if graph.joints[cut].kind == "rod":  # which no tree may contain
            continue
        for k, _ in tree.steps:
            exchanged = [cut, *(j for j, _ in tree.steps if j != k)]
            if spans(graph, exchanged):
                assert len(graph.joints[k].pairs) <= len(graph.joints[cut].pairs)


def spans(graph: Graph, joints: list[int]) -> bool:
    group = list(range(len(graph.bodies)))
    for k in joints:
        a, b = group[graph.joints[k].parent], group[graph.joints[k].child]
        group = [a if g == b else g for g in group]
    return len(set(group)) == 1


def passed(joint: GraphJoint, q: np.ndarray) -> np.ndarray:
    """From the parent's frame to the child's, in homogeneous coordinates."""
    matrix: np.ndarray = frame(joint.F.R, joint.F.p)
    for pair, value in zip(joint.pairs, q, strict=True):
        matrix = matrix @ moved(pair, float(value))
    child: np.ndarray = np.linalg.inv(frame(joint.M.R, joint.M.p))
    passed: np.ndarray = matrix @ frame(joint.tail) @ child
    return passed


def frame(R: Any, p: Any = (0.0, 0.0, 0.0)) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = R, p
    return matrix


def moved(pair: Pair, value: float) -> np.ndarray:
    axis = np.eye(3)[pair.axis]
    if pair.slides:
        return frame(np.eye(3), value * axis)
    return frame(Rotation.from_rotvec(value * axis).as_matrix(), pair.pitch * value * axis)


@pytest.mark.parametrize("name", ["flight-simulator", "gough-stewart", "tricept", "rssr"])
def test_a_joint_split_into_single_ones_moves_alike(name: str) -> None:
    graph = graph_of(parakin.load(name))
    rng = np.random.default_rng(0)
    for k, joint in enumerate(graph.joints):
        if len(joint.pairs) < 2:
            continue
        split = graph.split(k)
        q = rng.uniform(-3, 3, len(split.coordinates))
        chain = [split.joints[split.coordinates[n].joint] for n in joint.coordinates]
        product = np.eye(4)
        for single in chain:
            product = product @ passed(single, q[list(single.coordinates)])
        assert_allclose(product, passed(joint, q[list(joint.coordinates)]), atol=1e-13)
        assert [c.name for c in split.coordinates] == [c.name for c in graph.coordinates]
        assert (chain[0].parent, chain[-1].child) == (joint.parent, joint.child)
        assert {len(single.pairs) for single in chain} == {1}


def test_a_twin_has_angles_that_vanish_at_its_orientation() -> None:
    graph = graph_of(parakin.load("gough-stewart"))
    number = graph.platform
    assert number is not None
    R = Rotation.from_euler("XYZ", [0.3, np.pi / 2, -0.2]).as_matrix()  # where the platform's lock
    rows = tuple(tuple(row) for row in R.tolist())
    twinned = graph.recentred(number, rows)  # type: ignore[arg-type]
    twin = twinned.joints[twinned.twins[number]]
    assert_allclose(passed(twin, np.zeros(6))[:3, :3], R, atol=1e-15)
    assert twinned.plain == graph
    assert list(twin.coordinates) == list(range(len(graph.coordinates), len(twinned.coordinates)))


def test_unknown_names_are_refused_with_the_nearest() -> None:
    graph = graph_of(parakin.load("four-bar"))
    assert graph.coordinates[graph.index("B", "here")].name == "B"
    for look_up in (lambda: graph.index("b", "here"), lambda: graph.limits("b")):
        with pytest.raises(InputError, match=r"unknown coordinate 'b'; .*did you mean 'B'"):
            look_up()
    assert graph.joints[0].tail == IDENTITY
