"""Rows that hold what a plan need not solve for."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin.kinematics.assembly import neighbours
from parakin.kinematics.configuration import configure
from parakin.kinematics.free_motions import free_motions
from parakin.planning.holding import holding_rows

NAMES = ["3-rrr", "flight-simulator", "delta", "agile-eye", "bricard", "seat-3dof", "gough-stewart"]


@pytest.mark.parametrize("name", NAMES)
def test_with_the_blocks_rows_they_leave_only_the_driven_freedoms(name: str) -> None:
    plan = parakin.compile(name, machine_code=False).plan
    graph = plan.graph
    home = configure(graph, graph.posed_tree(), configure(graph, plan.tree, plan.home).q)
    samples = [home, *neighbours(graph, graph.posed_tree(), home, 3)]
    rows = holding_rows(plan, [configure(graph, plan.tree, at.q) for at in samples])
    assert len(rows) == len(plan.unsolved)
    from parakin.kinematics.configuration import loop_signs, row_wrench

    signs, at = loop_signs(graph, plan.tree), configure(graph, plan.tree, plan.home)
    every = [*rows, *(row for block in plan.blocks for row in block.rows)]
    slopes = np.array([(row_wrench(at, row) @ at.screws) * signs[row.cut] for row in every])
    inside = graph.tree_coordinates(plan.tree)
    freedoms = len(inside) - np.linalg.matrix_rank(slopes[:, inside], tol=1e-8)
    assert freedoms == free_motions(graph, plan.tree, at).shape[1]
