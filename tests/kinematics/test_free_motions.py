"""Free motions: how many, known from the literature, and that they keep the loops closed."""

from __future__ import annotations

import numpy as np
import pytest
from loops_of_every_kind import KINDS, closed, loop_of

import parakin
from parakin.algebra.spatial import as_float
from parakin.files.mechanism_toml import mechanism_from_table
from parakin.kinematics import loops
from parakin.kinematics.closure import canonical_rows
from parakin.kinematics.configuration import configure, coordinate_scales
from parakin.kinematics.free_motions import free_motions, holders, is_idle
from parakin.model.evaluation import graph_of

FREEDOMS = {
    "revolute": 1,
    "prismatic": 1,
    "cylindrical": 2,
    "universal": 2,
    "spherical": 3,
    "planar": 3,
    "fixed": 0,
    "rod": 5,
}
MOBILITY = {  # Merlet, Parallel Robots; Bennett and Bricard by their own theorems
    "four-bar": 1,
    "bennett": 1,
    "bricard": 1,
    "five-bar": 2,
    "delta": 3,
    "3-rrr": 3,
    "agile-eye": 3,
    "gough-stewart": 6,
    "flight-simulator": 3,
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_they_keep_the_loop_closed(kind: str, seed: int) -> None:
    """An arm of two freedoms and a joint: the plate has as many as both, or what a rod leaves."""
    circuits, cut = closed(kind, seed)
    graph, tree = circuits.graph, loop_of(kind)[1]
    q = np.zeros(len(graph.coordinates))
    for k, turn in circuits.turns.items():
        q[k] = as_float(turn.amount)
    at = configure(graph, tree, q)
    motions = free_motions(graph, tree, at)
    assert motions.shape == (len(q), 2 + FREEDOMS[kind])
    for motion in motions.T:
        moving = circuits.with_coordinates(
            rates={k: float(motion[k]) for k in graph.tree_coordinates(tree)}
        )
        end = loops.ends(moving, cut)
        for row in canonical_rows(graph.joints[cut], cut):
            assert abs(as_float(row.rate(moving, end))) < 1e-13, row


@pytest.mark.parametrize(("name", "mobility"), MOBILITY.items())
def test_their_number_is_the_mobility(name: str, mobility: int) -> None:
    solver = parakin.compile(name, machine_code=False)
    graph = graph_of(parakin.load(name))
    tree = graph.posed_tree()
    at = configure(graph, tree, solver.plan.home[: len(graph.coordinates)])
    assert free_motions(graph, tree, at).shape[1] == mobility


def test_the_spin_of_a_rod_between_balls_is_idle() -> None:
    """A leg between two spherical joints spins about itself and moves nothing else."""
    joints = {
        "A": {"kind": "revolute", "parent": "base", "child": "crank", "actuated": True},
        "B": {
            "kind": "spherical",
            "parent": "crank",
            "child": "leg",
            "on_parent": {"at": [0.3, 0, 0]},
        },
        "C": {
            "kind": "spherical",
            "parent": "rocker",
            "child": "leg",
            "on_parent": {"at": [0.5, 0, 0]},
            "on_child": {"at": [1, 0.2, 0]},
        },
        "D": {
            "kind": "revolute",
            "parent": "base",
            "child": "rocker",
            "on_parent": {"at": [1, 0, 0.2], "axis": [0, 1, 0]},
        },
    }
    bodies: dict[str, object] = {"crank": {}, "leg": {}, "rocker": {}}
    table = {"name": "spinning", "driven": ["A"], "bodies": bodies, "joints": joints}
    mechanism = mechanism_from_table(table, "spinning")
    solver = parakin.compile(mechanism, machine_code=False)
    graph = solver.graph
    tree = graph.posed_tree()
    at = configure(graph, tree, solver.plan.home[: len(graph.coordinates)])
    motions = free_motions(graph, tree, at) / coordinate_scales(graph)[:, None]
    assert motions.shape[1] == 2
    assert len(solver.plan.idle) == 1
    crank = graph.index("A", "test")
    weights = np.linalg.svd(motions[[crank]])[2]
    spin = motions @ weights[1:].T  # the mix in which the crank rests
    assert is_idle(at, spin)
    assert not is_idle(at, motions @ weights[:1].T)
    (held,) = holders(spin)
    assert graph.coordinates[held].name.split(".")[0] in ("B", "C")
