"""The smallest systems that can be solved one after the other."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

from parakin.planning.elimination import _components, _matched, eliminated


def blocks(matrix: list[list[float]]) -> list[tuple[list[int], list[int]]] | None:
    a = np.array(matrix)
    return eliminated(a / np.linalg.norm(a, axis=1, keepdims=True), a != 0.0)


def test_a_triangle_falls_into_single_unknowns() -> None:
    found = blocks([[1, 0, 0], [2, 1, 0], [1, 1, 3]])
    assert found == [([0], [0]), ([1], [1]), ([2], [2])]


def test_the_order_is_that_of_dependence_and_not_of_the_rows() -> None:
    found = blocks([[1, 1, 3], [0, 1, 2], [0, 0, 1]])
    assert found == [([2], [2]), ([1], [1]), ([0], [0])]


def test_what_depends_on_each_other_stays_together() -> None:
    found = blocks([[1, 2, 0], [3, 4, 0], [1, 1, 1]])
    assert found is not None
    assert [sorted(members) for members, _ in found] == [[0, 1], [2]]
    assert sorted(found[0][1]) == [0, 1]


def test_redundant_rows_are_left_out() -> None:
    found = blocks([[1, 0], [2, 0], [1, 1], [2, 2]])
    assert found is not None
    assert sum(len(rows) for _, rows in found) == 2
    chosen = [row for _, rows in found for row in rows]
    assert len({0, 1} & set(chosen)) == 1


@pytest.mark.parametrize("matrix", [[[1, 1], [2, 2]], [[1, 0], [3, 0]]])
def test_what_is_not_determined_is_not_solved(matrix: list[list[float]]) -> None:
    assert blocks(matrix) is None


@pytest.mark.parametrize("seed", range(10))
def test_any_solvable_system_is_solved_block_by_block(seed: int) -> None:
    """Back substitution through the blocks gives what LAPACK gives for the whole."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 8))
    a = rng.normal(size=(n, n)) * (rng.random((n, n)) < 0.4) + np.diag(rng.uniform(1, 2, n))
    a = a[rng.permutation(n)]
    b = rng.normal(size=n)
    found = blocks(a.tolist())
    assert found is not None
    x = np.full(n, np.nan)
    for members, rows in found:
        known = [k for k in range(n) if not np.isnan(x[k])]
        open_ = [k for k in range(n) if np.isnan(x[k]) and k not in members]
        assert not a[np.ix_(rows, open_)].any()
        side = b[rows] - a[np.ix_(rows, known)] @ x[known]
        x[members] = np.linalg.solve(a[np.ix_(rows, members)], side)
    np.testing.assert_allclose(x, np.linalg.solve(a, b), rtol=1e-8)


@pytest.mark.parametrize("seed", range(40))
def test_rows_are_matched_with_unknowns_where_scipy_finds_a_way(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 14))
    square = rng.random((n, n)) < rng.uniform(0.1, 0.7)
    theirs = maximum_bipartite_matching(csr_array(square), perm_type="column")
    ours = _matched(square)
    assert (ours is None) == bool((theirs < 0).any())
    if ours is not None:
        assert sorted(ours.tolist()) == list(range(n))
        assert square[np.arange(n), ours].all()


@pytest.mark.parametrize("seed", range(40))
def test_components_are_those_of_scipy_and_come_after_what_they_need(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 14))
    needs = rng.random((n, n)) < rng.uniform(0.02, 0.3)
    _, labels = connected_components(csr_array(needs), directed=True, connection="strong")
    found = _components(needs)
    assert {frozenset(g) for g in found} == {
        frozenset(np.flatnonzero(labels == k).tolist()) for k in labels
    }
    for place, group in enumerate(found):
        known = {k for earlier in found[: place + 1] for k in earlier}
        assert set(np.flatnonzero(needs[group].any(axis=0)).tolist()) <= known
