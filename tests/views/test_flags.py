"""Runs of flagged samples, against those written by hand."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from parakin.views.flags import flagged_spans


@pytest.mark.parametrize(
    ("status", "spans"),
    [
        ([], []),
        ([0, 0, 0], []),
        ([5], [(0.0, 0.0)]),
        ([5, 5, 0, 0, 2, 6, 6], [(0.0, 1.0), (4.0, 6.0)]),
        ([0, 5, 0, 8, 5, 0], [(1.0, 1.0), (3.0, 4.0)]),
    ],
)
def test_each_run_is_a_span(status: list[int], spans: list[tuple[float, float]]) -> None:
    time = np.arange(len(status), dtype=float)
    ds = xr.Dataset({"status": ("time", np.array(status, dtype=np.int8))}, {"time": time})
    assert flagged_spans(ds) == spans
