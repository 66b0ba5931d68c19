"""Chains: the linear algebra of closure rows loop by loop, for mechanisms of very many loops.

Each row knows the coordinates of its own loop alone. What follows from that in time that grows with
the number of loops, and not with its cube, is only taken where ranks are beyond doubt. None is
given where they are not, and where there is little to gain: dense matrices must decide then.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from parakin.arrays import FloatArray, IndexArray

_MANY = 40  # coordinates: fewer are as quickly dealt with together
_GROUP = 6  # rows at a time: as many as a joint has at most
_NONE, _SOME = 1e-12, 1e-6  # of the largest entry: singular values that are zero, that are not
_LARGE = 1e4  # times the gaps: a step for which some direction must be all but undetermined
_LEFT = 1e-9  # of the gaps, after a step that should close them to first order


def kernel(J: FloatArray) -> FloatArray | None:
    """Orthonormal columns that span what rows J (rows, n) map to zero."""
    n = J.shape[1]
    if n < _MANY:
        return None
    scale = float(np.abs(J).max(initial=0.0))
    basis = np.zeros((n, 0))
    seen = np.zeros(n, dtype=bool)
    for rows, columns in _groups(J):
        new = columns[~seen[columns]]
        seen[new] = True
        units = np.zeros((n, len(new)))
        units[new, range(len(new))] = 1.0
        basis = np.hstack([basis, units])
        moved = rows[:, columns] @ basis[columns]
        active = np.flatnonzero(np.abs(moved).max(axis=0) > 0.0)
        _, sizes, right = np.linalg.svd(moved[:, active])
        rank = _rank(sizes, scale)
        if rank is None:
            return None
        kept = basis[:, active] @ right[rank:].T
        basis = np.hstack([np.delete(basis, active, axis=1), kept])
    return np.hstack([basis, np.eye(n)[:, ~seen]])


def least_step(J: FloatArray, gaps: FloatArray) -> FloatArray | None:
    """The shortest x of those for which J x is nearest to the gaps."""
    n = J.shape[1]
    if n < _MANY or not (np.isfinite(J).all() and np.isfinite(gaps).all()):
        return None
    from scipy.sparse import block_array, csr_array, eye_array
    from scipy.sparse.linalg import splu

    scale = float(np.abs(J).max(initial=0.0))
    slopes, sides, at = [], [], 0
    for rows, columns in _groups(J):
        left, sizes, right = np.linalg.svd(rows[:, columns], full_matrices=False)
        rank = _rank(sizes, scale)
        if rank is None:
            return None
        independent = np.zeros((rank, n))
        independent[:, columns] = sizes[:rank, None] * right[:rank]
        slopes.append(independent)
        sides.append(left[:, :rank].T @ gaps[at : at + len(rows)])
        at += len(rows)
    A, b = csr_array(np.vstack(slopes)), np.concatenate(sides)
    system = block_array([[eye_array(n), A.T], [A, None]], format="csc")
    try:
        x: FloatArray = splu(system).solve(np.concatenate([np.zeros(n), b]))[:n]
    except RuntimeError:  # singular: some loops say what others say already
        return None
    size = float(np.linalg.norm(b))
    good = np.linalg.norm(x) <= _LARGE * size and np.linalg.norm(A @ x - b) <= _LEFT * size
    return x if good else None


def _groups(J: FloatArray) -> Iterator[tuple[FloatArray, IndexArray]]:
    """A few rows at a time, and the columns where they are not zero."""
    for start in range(0, len(J), _GROUP):
        rows = J[start : start + _GROUP]
        yield rows, np.flatnonzero(np.abs(rows).max(axis=0) > 0.0)


def _rank(sizes: FloatArray, scale: float) -> int | None:
    """How many singular values are not zero; None if that is in doubt."""
    rank = int((sizes > _SOME * scale).sum())
    return rank if (sizes[rank:] <= _NONE * scale).all() else None
