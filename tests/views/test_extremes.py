"""Extremes: those of a window at a time are those of the whole."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import parakin
from parakin import Status
from parakin.views.extremes import extremes


def window(time: np.ndarray, rows: np.ndarray) -> xr.Dataset:
    over = ("time", "coordinate")
    orders = dict.fromkeys(("position", "velocity", "acceleration"), (over, rows))
    figures = {name: ("time", time / len(time)) for name in ("residual", "conditioning")}
    lost = np.isnan(rows[:, 0])
    status = {
        "status": ("time", np.where(lost, 2, 0).astype(np.int8)),
        "stopped_by": ("time", np.where(lost, 1, 0).astype(np.int16)),
        "excess": ("time", np.full(len(time), np.nan)),
        "first_at": ("time", np.where(lost, 149.5, np.nan)),
        "limit_low": ("stop", [np.nan, np.nan]),
        "limit_high": ("stop", [np.nan, np.nan]),
    }
    stops = {"stop": ["", "limb A"], "stop_unit": ("stop", ["", ""])}
    coordinates = {"time": time, "coordinate": ["a", "b"]} | stops
    met = "limb A at t = 149.5 s" if time[-1] > 149 else ""
    return xr.Dataset(orders | figures | status, coordinates, {"stops_met": met})


def test_extremes_of_windows_are_those_of_the_whole() -> None:
    random = np.random.default_rng(3)
    time, rows = np.arange(1000.0), random.normal(size=(1000, 2))
    rows[150:200] = np.nan
    rows[:, 1] = np.nan
    found = None
    for start in range(0, 1000, 100):
        part = slice(start, start + 100)
        found = extremes(window(time[part], rows[part]), found)
    assert found is not None
    assert found.high[0, 0] == np.nanmax(rows[:, 0])
    assert found.low_time[2, 0] == np.nanargmin(rows[:, 0])
    peak = int(np.nanargmax(np.abs(rows[:, 0])))
    assert found.peak(1, 0) == (abs(float(rows[peak, 0])), float(peak))
    assert np.isnan(found.high[:, 1]).all()
    assert found.samples == 1000
    words = "out of reach: limb A cannot reach, first at t = 149.5 s"
    assert found.first_flag == (150, 150.0, Status.OUT_OF_REACH, words)
    assert found.met == "limb A at t = 149.5 s"
    assert found.counts[Status.OUT_OF_REACH] == 50


def test_a_crank_that_turns_evenly_peaks_where_its_law_says() -> None:
    """The cosine law's angle is pi (1 - cos(pi t)) for one turn in one second."""
    solver = parakin.compile("four-bar", machine_code=False, derivatives=3)
    law = {"law": "cosine", "by": 2 * np.pi}
    table = {"duration": 1.0, "rate": 1000, "laws": {"A": law}}
    mechanism = solver.mechanism.model_copy(update={"motions": {"once": table}})
    solver = parakin.compile(mechanism, machine_code=False, derivatives=3)
    found = extremes(solver.solve("once"))
    k = list(found.coordinates).index("A")
    assert found.peak(1, k) == pytest.approx((np.pi**2, 0.5), rel=1e-9)
    assert found.peak(2, k)[0] == pytest.approx(np.pi**3, rel=1e-9)
    assert found.peak(3, k)[0] == pytest.approx(np.pi**4, rel=1e-9)
    assert found.high[0, k] - found.low[0, k] == pytest.approx(2 * np.pi, rel=1e-12)
