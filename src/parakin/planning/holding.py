"""Holding: closure rows that hold those coordinates which a plan need not solve for.

Such a coordinate is affine in the driven ones, so that no row is spent on it; but what holds it
there exerts forces, and these act through rows.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from parakin.arrays import FloatArray
from parakin.kinematics.closure import Row
from parakin.kinematics.configuration import (
    Configuration,
    closure_system,
    configure,
    coordinate_scales,
    loop_signs,
    row_wrench,
)
from parakin.planning.plan import Plan


def holding_rows(plan: Plan, samples: Sequence[Configuration]) -> tuple[Row, ...]:
    """As many canonical rows as there are unsolved coordinates, that hold these firmly in all of
    some closed configurations of the plan's graph.
    """
    if not plan.unsolved:
        return ()
    from scipy.linalg import qr  # here, as it takes long to import

    held = [_held(plan, configure(plan.graph, plan.tree, at.q)) for at in samples]
    rows = closure_system(plan.graph, plan.tree, samples[0], loop_signs(plan.graph, plan.tree))[2]
    count = len(plan.unsolved)
    choices = [qr(slopes.T, mode="r", pivoting=True)[1][:count] for slopes in held]

    def firmness(choice: FloatArray) -> float:
        return min(float(np.linalg.svd(slopes[choice])[1][-1]) for slopes in held)

    best = max(choices, key=firmness)
    return tuple(rows[k] for k in sorted(best))


def _held(plan: Plan, at: Configuration) -> FloatArray:
    """How all canonical rows change where unsolved coordinates move alone, and those solved for
    follow: (rows, unsolved).
    """
    graph, scales = plan.graph, coordinate_scales(plan.graph)
    signs = loop_signs(graph, plan.tree)
    slopes = closure_system(graph, plan.tree, at, signs)[1] * scales
    solved = [
        (row_wrench(at, row) @ at.screws) * signs[row.cut] * scales
        for block in plan.blocks
        for row in block.rows
    ]
    motions = np.zeros((len(graph.coordinates), len(plan.unsolved)))
    motions[list(plan.unsolved), range(len(plan.unsolved))] = 1.0
    if solved:
        matrix = np.array(solved)
        following = np.linalg.lstsq(matrix[:, plan.unknowns], -matrix @ motions, rcond=None)[0]
        motions[plan.unknowns] = following
    found: FloatArray = slopes @ motions
    return found
