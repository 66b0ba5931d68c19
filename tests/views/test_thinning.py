"""Thinning: what is left out is not missed."""

from __future__ import annotations

import numpy as np

from parakin.labelled import Labelled, Variable, joined
from parakin.views.thinning import every, thinned


def test_a_thinned_curve_keeps_its_extremes_and_gaps() -> None:
    random = np.random.default_rng(4)
    values = random.normal(size=(3, 100_000))
    values[0, 500:40_000] = np.nan
    rows = thinned(values, 100)
    assert len(rows) <= 2 * 3 * 100 + 2
    np.testing.assert_array_equal(np.nanmax(values[:, rows], axis=1), np.nanmax(values, axis=1))
    np.testing.assert_array_equal(np.nanmin(values[:, rows], axis=1), np.nanmin(values, axis=1))
    assert np.isnan(values[0, rows]).any()
    assert (rows[0], rows[-1]) == (0, 99_999)
    assert (np.diff(rows) > 0).all()
    np.testing.assert_array_equal(thinned(values[:, :100], 100), np.arange(100))


def test_a_single_peak_between_evenly_spaced_samples_is_kept() -> None:
    values = np.zeros((1, 100_001))
    values[0, 33_333] = 1.0
    assert 33_333 in thinned(values, 50)


def test_samples_are_evenly_spaced_across_windows() -> None:
    whole = Labelled({"q": Variable.of("time", np.arange(1000.0))}, ())
    starts = (0, 130, 131, 500)
    ends = (130, 131, 500, 1000)
    windows = [whole.isel(time=slice(a, b)) for a, b in zip(starts, ends, strict=True)]
    parts = [every(7, w, start) for w, start in zip(windows, starts, strict=True)]
    np.testing.assert_array_equal(joined(parts)["q"].values, np.arange(0.0, 1000.0, 7.0))
