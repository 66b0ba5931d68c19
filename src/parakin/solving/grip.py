"""How firmly a plan's rows hold a mechanism, all together and block by block."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from parakin.kinematics.closure import Row
from parakin.kinematics.configuration import (
    Configuration,
    closure_system,
    configure,
    coordinate_scales,
    full_screws,
    loop_signs,
    row_wrench,
)
from parakin.planning.plan import Block, Plan

_WEAK = 0.2  # of what rows determined at home: with less, others are looked for


def weak_rows(plan: Plan, at: Configuration) -> set[Row]:
    """Rows of blocks that have lost their grip since home, at a configuration in the plan's tree: a
    distance, say, that has shrunk to nothing.
    """
    home = configure(plan.graph, plan.tree, plan.home)
    signs, scales = loop_signs(plan.graph, plan.tree), coordinate_scales(plan.graph)

    def grip(block: Block, there: Configuration) -> float:
        rows = [(row_wrench(there, row) @ there.screws) * signs[row.cut] for row in block.rows]
        matrix = (np.array(rows) * scales)[:, list(block.unknowns)]
        return float(np.linalg.svd(matrix, compute_uv=False)[-1])

    weak = [block for block in plan.blocks if not grip(block, at) > _WEAK * grip(block, home)]
    return {row for block in weak for row in block.rows}


def least_singular_value(plan: Plan, at: Configuration) -> float:
    """The least singular value of all closure rows by all coordinates that are not driven.

    `at` is a configuration in the plan's tree. Joints of three turns count by three axes at right
    angles, whatever their angles.
    """
    graph, tree = plan.graph, plan.tree
    held = {*plan.driven, *plan.idle}
    free = [k for k in graph.tree_coordinates(tree) if k not in held]
    if not free:
        return 1.0
    at = replace(at, screws=full_screws(graph, at, held))
    _, jacobian, _ = closure_system(graph, tree, at, loop_signs(graph, tree))
    matrix = jacobian[:, free] * coordinate_scales(graph)[free]
    values = np.linalg.svd(matrix, compute_uv=False)
    return float(values[-1]) if len(matrix) >= len(free) else 0.0
