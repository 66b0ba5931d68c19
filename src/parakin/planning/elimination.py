"""Elimination: unknowns and rows in blocks, the smallest systems that can be solved one by one."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

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
    match = None if len(members) == 1 else _matched(square)
    if match is None:
        return [(members.tolist(), list(chosen))]
    needs = square[:, match]  # row i solves unknown match[i]; needs[i, j]: it needs that of row j
    return [
        (members[match[group]].tolist(), [chosen[i] for i in group]) for group in _components(needs)
    ]


def _matched(square: BoolArray) -> IndexArray | None:
    """For each row a column of its own where it is true; None where there is no such choice.

    After Hopcroft and Karp: as long as rows are left over, they take columns along the shortest
    paths on which rows pass theirs on. (SciPy has this, but takes longer to import than most
    mechanisms to plan, and tells that its choice may change from version to version.)
    """
    near = [np.flatnonzero(row).tolist() for row in square]
    of_row, of_column = ([-1] * len(square) for _ in range(2))

    def steps() -> tuple[dict[int, int], float]:
        level = {row: 0 for row, column in enumerate(of_row) if column < 0}
        queue, last = list(level), math.inf
        for row in queue:
            for holder in (of_column[column] for column in near[row] if level[row] < last):
                if holder < 0:
                    last = level[row] + 1
                elif holder not in level:
                    level[holder] = level[row] + 1
                    queue.append(holder)
        return level, last

    def passed_on(row: int, level: dict[int, int], last: float) -> bool:
        step = level.pop(row) + 1  # on one path only
        holders = [(of_column[column], column) for column in near[row]]
        free = [column for holder, column in holders if holder < 0 and step == last]
        further = (c for holder, c in reversed(holders) if level.get(holder) == step)
        for column in free[:1] or further:
            if of_column[column] < 0 or passed_on(of_column[column], level, last):
                of_row[row], of_column[column] = column, row
                return True
        return False

    while -1 in of_row:
        level, last = steps()
        if last == math.inf:
            return None
        for row in [row for row, column in enumerate(of_row) if column < 0]:
            passed_on(row, level, last)
    return np.array(of_row)


def _components(needs: BoolArray) -> list[list[int]]:
    """Rows that need each other, directly or not, together; after those that they need."""
    n = len(needs)
    reach = needs | np.eye(n, dtype=bool)
    for _ in range(n.bit_length()):
        reach = reach @ reach
    together = reach & reach.T
    finished: dict[int, int] = {}
    left = set(range(n))

    def visit(row: int) -> None:
        left.discard(row)
        for other in np.flatnonzero(needs[row]).tolist():
            if other in left:
                visit(other)
        finished[row] = len(finished)

    for row in range(n):
        if row in left:
            visit(row)
    groups = {tuple(np.flatnonzero(row).tolist()) for row in together}
    return [list(g) for g in sorted(groups, key=lambda g: max(finished[k] for k in g))]
