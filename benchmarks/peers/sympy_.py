"""SymPy: closure and its derivatives as symbols, lambdified with common subexpressions shared.

Newton's iteration is the user's; written for NumPy's broadcasting it takes one pose or a thousand.
For one pose the same functions are lambdified for `math`, whose scalars are faster.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import sympy as sp

from benchmarks.baselines import D1, D2, D3, D4, D5, L1, L2, L3, L4, S_A, S_B, S_C, B, H
from benchmarks.peers.dimensions import AXES, FEET, STROKE_0, TOPS
from benchmarks.peers.ways import CLOSED, POSE, SLIDERS, VARIABLES, Both, Floats, Solve, Way, others


def flight_simulator() -> Both:
    q = sp.symbols(f"q:{len(VARIABLES)}")
    x, y, phi, a, la, a3, f, g, lb, i, j, lc, d, e, s = q
    rod = sp.Matrix([sp.cos(a - a3), sp.sin(a - a3)])
    arm = sp.Matrix([sp.sin(phi) * rod[1], -sp.sin(phi) * rod[0], sp.cos(phi)]) * B / 2
    side_b = sp.Matrix([-sp.sin(f) * sp.sin(g), sp.cos(f) * sp.sin(g), -sp.cos(g)])
    side_c = sp.Matrix([-sp.sin(i) * sp.sin(j), sp.cos(i) * sp.sin(j), sp.cos(j)])
    G, foot = sp.Matrix([x, y]), D2 + D3 + D4
    closure = sp.Matrix.vstack(
        (S_A + L1 + la) * sp.Matrix([sp.cos(a), sp.sin(a)]) + H * rod - G,
        sp.Matrix([foot - x, -y, D5]) + (S_B + L2 + lb) * side_b - arm,
        sp.Matrix([foot - x, -y, -D5]) + (S_C + L2 + lc) * side_c + arm,
        sp.Matrix([D2 + D3 + L3 * sp.cos(d), L3 * sp.sin(d)]) + (H - D1) * rod - G,
        sp.Matrix([D2 + L4 * sp.cos(e), L4 * sp.sin(e)]) + (H - D1 - s) * rod - G,
    )
    qd = sp.symbols(f"qd:{len(VARIABLES)}")
    jacobian = closure.jacobian(q)
    drift = (jacobian * sp.Matrix(qd)).jacobian(q) * sp.Matrix(qd)
    scalars, arrays = (
        (evaluated([closure, jacobian], q, module), evaluated([drift], (*q, *qd), module))
        for module in ("math", "numpy")
    )
    inverse, forward = (
        Way(solver(*scalars, driven), solver(*arrays, driven)) for driven in (POSE, SLIDERS)
    )
    return Both(inverse, forward)


def hexapod() -> Both:
    pose, strokes = sp.symbols("x y z roll pitch yaw"), sp.symbols("s:6")
    # SymPy's matrices turn the axes, not the vectors
    turn = sp.rot_axis1(-pose[3]) * sp.rot_axis2(-pose[4]) * sp.rot_axis3(-pose[5])
    joints, gaps = [], []
    for k in range(6):
        leg = sp.Matrix(pose[:3]) + turn * sp.Matrix(TOPS[k]) - sp.Matrix(FEET[k])
        leg = sp.Matrix(AXES[k].T) * leg
        length = sp.sqrt(leg.dot(leg))
        bend = sp.atan2(sp.sqrt(leg[0] ** 2 + leg[1] ** 2), leg[2])
        joints += [sp.atan2(leg[0], -leg[1]), bend, length - STROKE_0]
        gaps.append(length - STROKE_0 - strokes[k])
    closure = sp.Matrix(gaps)
    rows = [closure, closure.jacobian((*strokes, *pose))]

    def ways(module: str) -> tuple[Solve, Solve]:
        legs = evaluated([sp.Matrix(joints)], pose, module)
        forward = solver(evaluated(rows, (*strokes, *pose), module), None, range(6))

        def inverse(given: Floats, _: Floats) -> list[Floats]:
            return [legs(given[0])[0][..., 0].T]

        return inverse, forward

    (inverse, forward), (inverses, forwards) = ways("math"), ways("numpy")
    return Both(Way(inverse, inverses), Way(forward, forwards))


def evaluated(
    matrices: Sequence[Any], symbols: Sequence[Any], module: str
) -> Callable[[Floats], list[Floats]]:
    """A function of values (m,) or (m, n) that gives the matrices, or n of each."""
    entries = [(k, place) for k, matrix in enumerate(matrices) for place in matrix.todok()]
    values = [matrices[k][place] for k, place in entries]
    function = sp.lambdify([symbols], values, module, cse=True)

    def evaluate(at: Floats) -> list[Floats]:
        found = [np.zeros((*at.shape[1:], *matrix.shape)) for matrix in matrices]
        scalars = at.tolist() if at.ndim == 1 else at  # faster in Python's arithmetic
        for (k, (row, column)), value in zip(entries, function(scalars), strict=True):
            found[k][..., row, column] = value
        return found

    return evaluate


def solver(rows: Any, drift: Any, driven: Sequence[int]) -> Solve:
    """Newton's iteration on closure and Jacobian, and the rates if there is a `drift`."""

    def solve(given: Floats, guess: Floats) -> list[Floats]:
        rest = others(driven, len(given[0]) + len(guess))
        q = np.empty((len(driven) + len(guess), *guess.shape[1:]))
        q[driven], q[rest] = given[0], guess
        for _ in range(20):
            residual, jacobian = rows(q)
            if np.abs(residual).max() < CLOSED:
                break
            q[rest] -= np.linalg.solve(jacobian[..., rest], residual)[..., 0].T
        else:
            raise RuntimeError("Newton's iteration did not settle")
        if drift is None:
            return [q[rest]]
        by_rest, by_driven = jacobian[..., rest], jacobian[..., driven]
        qd, qdd = np.empty_like(q), np.empty_like(q)
        qd[driven], qdd[driven] = given[1], given[2]
        known = by_driven @ given[1].T[..., None]
        qd[rest] = -np.linalg.solve(by_rest, known)[..., 0].T
        known = by_driven @ given[2].T[..., None] + drift(np.concatenate((q, qd)))[0]
        qdd[rest] = -np.linalg.solve(by_rest, known)[..., 0].T
        return [q[rest], qd[rest], qdd[rest]]

    return solve
