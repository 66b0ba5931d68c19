"""Small systems against LAPACK's."""

from __future__ import annotations

import numpy as np
import pytest

from parakin.algebra.linear import solve, squared_volume
from parakin.algebra.spatial import ARRAYS, FLOATS, as_array


@pytest.mark.parametrize("n", range(1, 9))
def test_square_systems(n: int) -> None:
    rng = np.random.default_rng(n)
    for _ in range(20):
        a, b = rng.normal(size=(n, n)), rng.normal(size=(2, n))
        found = solve(a.tolist(), b.tolist(), FLOATS)
        np.testing.assert_allclose(as_array(found.solutions), np.linalg.solve(a, b.T).T, rtol=1e-9)
        lengths = np.linalg.norm(a, axis=1).prod() if n > 1 else 1.0
        np.testing.assert_allclose(
            as_array(found.conditioning), np.linalg.det(a) / lengths, rtol=1e-9
        )


@pytest.mark.parametrize(("m", "n"), [(2, 1), (5, 1), (3, 2), (6, 4), (9, 6)])
def test_more_rows_than_unknowns_are_solved_by_least_squares(m: int, n: int) -> None:
    rng = np.random.default_rng(10 * m + n)
    a, b = rng.normal(size=(m, n)), rng.normal(size=m)
    found = solve(a.tolist(), [b.tolist()], FLOATS)
    np.testing.assert_allclose(
        as_array(found.solutions[0]), np.linalg.lstsq(a, b, rcond=None)[0], rtol=1e-10
    )
    volume = np.sqrt(np.linalg.det(a.T @ a))
    np.testing.assert_allclose(as_array(found.conditioning), volume, rtol=1e-10)


def test_a_batch_gives_what_single_systems_give() -> None:
    rng = np.random.default_rng(5)
    a, b = rng.normal(size=(5, 5, 40)), rng.normal(size=(5, 40))
    batch = solve([list(row) for row in a], [list(b)], ARRAYS)
    for k in range(40):
        alone = solve(a[:, :, k].tolist(), [b[:, k].tolist()], FLOATS)
        single = [as_array(x)[k] for x in batch.solutions[0]]
        np.testing.assert_allclose(single, as_array(alone.solutions[0]), rtol=1e-13)


def test_rows_that_vanish_as_a_whole_show_in_the_conditioning() -> None:
    def figure(scale: float, typical: tuple[float, ...]) -> float:
        rows = [[3.0, 1.0], [scale * 1.0, scale * 2.0]]
        return float(as_array(solve(rows, [[1.0, 1.0]], FLOATS, typical).conditioning))

    assert figure(1e-9, ()) == pytest.approx(figure(1.0, ()))
    assert figure(1e-9, (10**0.5, 5**0.5)) < 1e-8


def test_a_matrix_without_an_inverse_has_conditioning_zero() -> None:
    for n in (2, 3, 5):
        singular = np.ones((n, n)) + np.eye(n)
        singular[-1] = singular[0]
        with np.errstate(all="ignore"):
            rows = [list(np.array(row)[:, None]) for row in singular]
            found = solve(rows, [[np.ones(1)] * n], ARRAYS)
        assert abs(float(as_array(found.conditioning)[0])) < 1e-15


@pytest.mark.parametrize("n", range(1, 6))
def test_the_volume_of_columns(n: int) -> None:
    columns = np.random.default_rng(n).normal(size=(n, 7))
    gram = np.linalg.det(columns @ columns.T)
    assert float(as_array(squared_volume(columns.tolist(), FLOATS))) == pytest.approx(gram)
