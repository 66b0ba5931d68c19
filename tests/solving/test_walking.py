"""Sums on which a walk sets off: right, and rounded alike in any batch."""

from __future__ import annotations

import numpy as np
import pytest

from parakin.solving.walking import _weighted


@pytest.mark.parametrize(("m", "k"), [(1, 1), (3, 9), (6, 21), (12, 78)])
def test_a_column_is_summed_alike_in_any_batch(m: int, k: int) -> None:
    rng = np.random.default_rng(m)
    weights, columns = rng.normal(size=(m, k)), rng.normal(size=(k, 203))
    whole = _weighted(weights, columns)
    np.testing.assert_allclose(whole, weights @ columns, rtol=0, atol=1e-12)
    for n in (1, 2, 3, 7, 8, 9, 31, 64, 200):
        for start in (0, 3):
            part = _weighted(weights, columns[:, start : start + n])
            np.testing.assert_array_equal(part, whole[:, start : start + n])
