"""Elimination: unknowns and rows in blocks, the smallest systems that can be solved one by one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

from parakin.arrays import BoolArray, FloatArray, IndexArray

_ZERO = 1e-9  # a derivative this small, in scaled units, is none

Members = tuple[list[int], list[int]]  # unknowns, rows


def eliminated(scaled: FloatArray, pattern: BoolArray) -> list[Members] | None:
    """Unknowns and rows in blocks, the smallest systems that can be solved first.

    A set of unknowns can be solved when rows that know nothing else (but what is solved already)
    have full rank in it. The sets tried are those that rows know, then unions of two of them.
    None where the rows leave something undetermined.
    """
    left = np.ones(pattern.shape[1], dtype=bool)
    blocks: list[Members] = []
    while left.any():
        found, known = None, np.zeros((0, int(left.sum())), dtype=bool)
        for sets in _known(pattern[:, left]):
            found = _smallest(scaled[:, left], pattern[:, left], sets)
            if found is not None:
                break
            known = np.vstack([known, sets])
        if found is None and len(known) > 1:
            i, j = np.triu_indices(len(known), 1)
            unions = np.unique(known[i] | known[j], axis=0)
            unions = unions[np.argsort(unions.sum(axis=1), kind="stable")]
            found = _smallest(scaled[:, left], pattern[:, left], unions)
        if found is None:
            found = _smallest(scaled[:, left], pattern[:, left], np.ones((1, left.sum()), bool))
        if found is None:
            return None
        members, chosen = found
        numbers = np.flatnonzero(left)[members]
        blocks += _sorted(pattern, numbers, chosen)
        left[numbers] = False
    return blocks


def _known(pattern: BoolArray) -> Iterator[BoolArray]:
    """The sets that rows know, the smallest first: one size after the other, since it is mostly
    among the first that something is found.
    """
    sizes = pattern.sum(axis=1)
    for size in np.unique(sizes[sizes > 0]):
        yield np.unique(pattern[sizes == size], axis=0)


def _smallest(scaled: FloatArray, pattern: BoolArray, sets: BoolArray) -> Members | None:
    """The first of the sets that rows knowing only it determine, and such rows."""
    for chosen_set in sets:
        rows = np.flatnonzero(pattern.any(axis=1) & ~(pattern & ~chosen_set).any(axis=1))
        members = np.flatnonzero(chosen_set)
        if len(rows) < len(members):
            continue
        picked = _independent(scaled[np.ix_(rows, members)], pattern[rows].sum(axis=1))
        if len(picked) == len(members):
            return members.tolist(), rows[picked].tolist()
    return None


def _independent(jacobian: FloatArray, counts: IndexArray) -> list[int]:
    """Rows that span all, those with the fewest unknowns first, the largest of equals."""
    chosen: list[int] = []
    basis = np.zeros((0, jacobian.shape[1]))
    usable = np.linalg.norm(jacobian, axis=1) > _ZERO
    for threshold in (0.05, 1e-5):  # well-conditioned choices first
        for count in sorted(set(counts[usable].tolist())):
            waiting = [i for i in np.flatnonzero((counts == count) & usable) if i not in chosen]
            while waiting and len(chosen) < jacobian.shape[1]:
                left = jacobian[waiting] - (jacobian[waiting] @ basis.T) @ basis
                left -= (left @ basis.T) @ basis
                norms = np.linalg.norm(left, axis=1)
                top = int(np.argmax(norms > 0.98 * norms.max()))  # the first of near equals
                if norms[top] < threshold:
                    break
                chosen.append(int(waiting[top]))
                basis = np.vstack([basis, left[top] / norms[top]])
                del waiting[top]
    return chosen


def _sorted(pattern: BoolArray, members: IndexArray, chosen: Sequence[int]) -> list[Members]:
    """One system's rows matched with its unknowns: its strongly connected components, in order."""
    square = pattern[np.array(chosen)][:, members]
    match = maximum_bipartite_matching(csr_array(square), perm_type="column")
    if len(members) == 1 or (match < 0).any():
        return [(members.tolist(), list(chosen))]
    needs = square[:, match]  # row i solves unknown match[i]; needs[i, j]: it needs that of row j
    _, labels = connected_components(csr_array(needs), directed=True, connection="strong")
    groups = [np.flatnonzero(labels == g).tolist() for g in sorted(set(labels.tolist()))]
    done: set[int] = set()
    blocks: list[Members] = []
    while len(done) < len(members):
        for group in groups:
            wanted = set(np.flatnonzero(needs[group].any(axis=0)).tolist()) - set(group)
            if group[0] not in done and wanted <= done:
                blocks.append((members[match[group]].tolist(), [chosen[i] for i in group]))
                done |= set(group)
    return blocks
