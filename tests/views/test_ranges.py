"""Ranges of curves over windows."""

from __future__ import annotations

import numpy as np

from parakin.views.ranges import Range


def test_least_and_greatest_with_their_times() -> None:
    found = Range.of(2)
    found.widen(np.array([0.0, 1.0]), np.array([[1.0, np.nan], [3.0, np.nan]]))
    found.widen(np.array([2.0, 3.0]), np.array([[-4.0, np.nan], [2.0, np.inf]]))
    assert (found.low[0], found.low_time[0], found.high[0], found.high_time[0]) == (-4, 2, 3, 1)
    assert found.peak(0) == (-4.0, 2.0)
    assert np.isnan(found.peak(1)).all()
