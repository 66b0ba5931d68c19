"""Charts thin a long motion without losing its peaks."""

from __future__ import annotations

import numpy as np

from parakin.charts import telling


def test_no_peak_is_lost_and_order_is_kept() -> None:
    t = np.linspace(0, 600, 36_000)
    values = np.array([np.sin(7 * t), np.exp(-((t - 123.4) ** 2)), 0.001 * t])
    rows = telling(values)
    assert (np.diff(rows) > 0).all()
    assert len(rows) <= 2 * 120 * 3 + 2
    np.testing.assert_array_equal(values[:, rows].max(axis=1), values.max(axis=1))
    np.testing.assert_array_equal(values[:, rows].min(axis=1), values.min(axis=1))
    assert (rows[0], rows[-1]) == (0, len(t) - 1)


def test_a_short_motion_is_shown_whole() -> None:
    np.testing.assert_array_equal(telling(np.ones((2, 100))), np.arange(100))
