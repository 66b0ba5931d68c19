"""Many starts are brought near to where rows vanish."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from parakin.algebra.spatial import Scalar, as_array
from parakin.planning.plan import Block
from parakin.solving.descent import descent


def test_all_four_crossings_of_a_circle_and_a_hyperbola_are_found() -> None:
    """x² + y² = 5, x y = 2: at (1, 2), (2, 1) and their opposites."""

    def equations(values: Sequence[Scalar]) -> tuple[list[Scalar], list[list[Scalar]]]:
        x, y = (as_array(value) for value in values)
        return [x * x + y * y - 5, x * y - 2], [[2 * x, 2 * y], [y, x]]

    rng = np.random.default_rng(0)
    starts: list[Scalar] = list(rng.uniform(-10, 10, (2, 400)))
    block = Block((0, 1), ())
    found = np.array(descent(np.ones(2))(block, equations, starts), dtype=float)
    exact = np.array([[1, 2], [2, 1], [-1, -2], [-2, -1]])
    apart = np.abs(found.T[:, None] - exact).max(axis=2)
    arrived = apart.min(axis=1) < 1e-6
    assert arrived.mean() > 0.9
    assert set(apart[arrived].argmin(axis=1).tolist()) == {0, 1, 2, 3}


def test_scales_do_not_change_where_it_leads() -> None:
    def equations(values: Sequence[Scalar]) -> tuple[list[Scalar], list[list[Scalar]]]:
        (x,) = (as_array(value) for value in values)
        return [x - 3e-3], [[np.ones_like(x)]]

    found = descent(np.array([1e-3]))(Block((0,), ()), equations, [np.array([5.0, -2.0])])
    np.testing.assert_allclose(as_array(found), 3e-3, rtol=1e-9)
