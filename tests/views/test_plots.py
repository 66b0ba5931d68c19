"""Figures of results: what is on their axes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes

import parakin
from parakin.views import plots

pytest.importorskip("matplotlib")


@pytest.fixture(scope="module")
def solver() -> parakin.Solver:
    return parakin.compile("slider-crank", derivatives=3, machine_code=False)


@pytest.fixture(scope="module")
def result(solver: parakin.Solver) -> xr.Dataset:
    motion = next(iter(solver.mechanism.motions))
    return solver.solve(motion)


def curve(axes: Axes, label: str) -> tuple[np.ndarray, np.ndarray]:
    (line,) = (line for line in axes.lines if line.get_label() == label)
    return np.asarray(line.get_xdata()), np.asarray(line.get_ydata())


def test_lengths_in_metres_and_angles_in_degrees(result: xr.Dataset) -> None:
    units = dict(zip(result["coordinate"].values, result["unit"].values, strict=True))
    length = next(name for name, unit in units.items() if unit == "m")
    angle = next(name for name, unit in units.items() if unit == "rad")
    figure = plots.histories(result, [length, angle])
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == [
        *("position [m]", "position [deg]", "velocity [m/s]", "velocity [deg/s]"),
        *("acceleration [m/s²]", "acceleration [deg/s²]", "jerk [m/s³]", "jerk [deg/s³]"),
    ]
    time, position = curve(figure.axes[1], angle)
    np.testing.assert_array_equal(time, result["time"])
    radians = result["position"].sel(coordinate=angle).values
    np.testing.assert_allclose(position, radians * 180 / np.pi, rtol=1e-12)


def test_some_orders_alone(result: xr.Dataset) -> None:
    name = str(result["coordinate"].values[0])
    figure = plots.histories(result, [name], orders=["velocity"])
    (axes,) = figure.axes
    assert axes.get_ylabel().startswith("velocity")


def test_a_peak_of_a_long_result_is_drawn(result: xr.Dataset) -> None:
    name = str(result["coordinate"].values[0])
    count = 100_001
    one = result.isel(time=np.zeros(count, int)).assign_coords(time=np.arange(float(count)))
    one["position"].values[33_333, 0] = 99.0
    figure = plots.histories(one, [name], orders=["position"])
    time, position = curve(figure.axes[0], name)
    scale = 180 / np.pi if result["unit"].values[0] == "rad" else 1.0
    assert len(time) <= 20_002
    assert position.max() == pytest.approx(99.0 * scale)
    assert time[position.argmax()] == 33_333


def test_flagged_samples_are_shaded(result: xr.Dataset) -> None:
    bad = result.copy(deep=True)
    bad["status"].values[10:20] = parakin.Status.LIMIT_EXCEEDED
    axes = plots.histories(bad).axes[0]
    (patch,) = axes.patches
    shaded = patch.get_extents().transformed(axes.transData.inverted())
    assert shaded.x0 == pytest.approx(float(result["time"][10]))
    assert shaded.x1 == pytest.approx(float(result["time"][19]))
    assert not plots.histories(result).axes[0].patches


def test_symbols_that_do_not_parse_are_refused(result: xr.Dataset, tmp_path: Path) -> None:
    name = str(result["coordinate"].values[0])
    figure = plots.histories(result, [name], {name: r"\nonsense"})
    with pytest.raises(parakin.InputError, match="symbols in mathtext"):
        plots.save(figure, tmp_path / "a.svg")
    assert not list(tmp_path.iterdir())
