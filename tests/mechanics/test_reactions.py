"""Which reactions can be known: counted by hand for planar loops, and known for others."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin.kinematics.assembly import assembled
from parakin.kinematics.configuration import configure
from parakin.mechanics.reactions import indeterminate, joint_wrenches, joints_at, self_stresses
from parakin.model.evaluation import graph_of

# Redundant rows and indeterminate components: of a planar loop three of six equations say nothing
# new, and in each of its hinges the force across the plane and two moments are not known.
COUNTS = {
    "gough-stewart": (0, 0),
    "delta": (0, 0),
    "3-prs": (0, 0),
    "flight-simulator": (6, 24),
    "four-bar": (3, 12),
    "slider-crank": (3, 12),
    "bennett": (3, 20),
    "bricard": (1, 30),
    "3-rrr": (6, 27),
    "agile-eye": (6, 27),
}


@pytest.mark.parametrize("name", COUNTS)
def test_counts(name: str) -> None:
    graph = graph_of(parakin.load(name))
    tree, joints = graph.tree(), [joint for joint in graph.joints if joint.name != "platform"]
    at = configure(graph, tree, assembled(graph).q)
    redundant, unknown = COUNTS[name]
    assert self_stresses(graph, tree, at).shape[1] == redundant
    assert indeterminate(graph, tree, joints_at(graph, joints), [at]).sum() == unknown


def test_a_self_stress_balances_every_body() -> None:
    graph = graph_of(parakin.load("flight-simulator"))
    tree = graph.tree()
    at = configure(graph, tree, assembled(graph).q)
    from parakin.kinematics.closure import all_rows

    rows = all_rows(graph, tree)
    for stress in self_stresses(graph, tree, at).T:
        on = joint_wrenches(at, tree, dict(zip(rows, stress.tolist(), strict=True)))
        for body in range(1, len(graph.bodies)):
            total = np.zeros(6)
            for k, wrench in on.items():
                joint = graph.joints[k]
                side = (joint.child == body) - (joint.parent == body)
                total += side * np.array([*wrench.force, *wrench.moment], dtype=float)
            assert total == pytest.approx(0.0, abs=1e-9)
