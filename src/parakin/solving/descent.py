"""Descent: many starts brought near to where a block's rows vanish, before Newton's method."""

from __future__ import annotations

import numpy as np

from parakin.algebra.spatial import Scalar, as_array
from parakin.arrays import FloatArray
from parakin.kernel.motion import Equations, Refiner
from parakin.planning.plan import Block

_STEPS = 60  # damped, from a start


def descent(scales: FloatArray) -> Refiner:
    """Levenberg-Marquardt from every start: Newton's steps alone would throw most of them away."""

    def refine(block: Block, equations: Equations, values: list[Scalar]) -> list[Scalar]:
        unit = scales[list(block.unknowns)]
        n = as_array(values[0]).size

        def system(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
            gaps, rows = equations(list(x * unit[:, None]))
            g = np.array([np.broadcast_to(as_array(gap), n) for gap in gaps]).T
            J = np.array([[np.broadcast_to(as_array(entry), n) for entry in row] for row in rows])
            J = np.moveaxis(J, 2, 0) * unit
            return g, J, np.nan_to_num(np.einsum("ij,ij->i", g, g), nan=np.inf)

        x = np.array(values) / unit[:, None]
        g, J, cost = system(x)
        damping = np.full(n, 1e-2)
        eye = np.eye(len(unit))
        for _ in range(_STEPS):
            square = np.einsum("nij,nik->njk", J, J)
            size = np.einsum("njj->n", square) / len(unit)
            normal = square + (damping * size)[:, None, None] * eye + 1e-30 * eye
            slope = np.einsum("nij,ni->nj", J, g)
            step = np.linalg.solve(normal, slope[:, :, None])[:, :, 0].T
            there = system(x - step)
            better = there[2] < cost
            x = np.where(better, x - step, x)
            g = np.where(better[:, None], there[0], g)
            J = np.where(better[:, None, None], there[1], J)
            cost = np.where(better, there[2], cost)
            damping = np.clip(np.where(better, damping * 0.2, damping * 5.0), 1e-12, 1e12)
        return list(x * unit[:, None])

    return refine
