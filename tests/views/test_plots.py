"""Figures of results: what is on their axes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pendulum
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


def test_effort_and_power_of_actuators_where_the_result_has_them() -> None:
    swing = parakin.compile(pendulum.pendulum(), machine_code=False).solve("swing", forces=True)
    figure = plots.histories(swing)
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels[3:] == ["effort [N m]", "power [W]"]
    for axes, values in zip(figure.axes[3:], pendulum.efforts(swing["time"].values), strict=False):
        at_speed = np.abs(swing["velocity"].values[:, 0]) > 0.1  # friction is not in doubt
        np.testing.assert_allclose(curve(axes, "A")[1][at_speed], values[at_speed], rtol=1e-9)
    assert len(plots.histories(swing, orders=["position"]).axes) == 1


def test_the_band_of_friction_at_rest_is_shaded() -> None:
    rest = parakin.compile(pendulum.pendulum(), machine_code=False).solve("rest", forces=True)
    effort = plots.histories(rest).axes[3]
    (band,) = effort.collections
    weight = pendulum.MASS * pendulum.GRAVITY * pendulum.RADIUS
    heights = np.asarray(band.get_paths()[0].vertices)[:, 1]
    assert (heights.min(), heights.max()) == pytest.approx(
        (weight - pendulum.COULOMB, weight + pendulum.COULOMB)
    )


def test_columns_without_actuators_have_no_forces() -> None:
    mechanism = parakin.load("slider-crank")
    heavy = [body.model_copy(update={"mass": "1 kg"}) for body in mechanism.bodies]
    solver = parakin.compile(
        mechanism.model_copy(update={"bodies": tuple(heavy)}),
        coordinates="all",
        machine_code=False,
    )
    result = solver.solve(next(iter(mechanism.motions)), forces=True)
    passive = result["coordinate"].values[~result["actuated"].values].tolist()
    figure = plots.histories(result, passive)
    assert not any("effort" in axes.get_ylabel() for axes in figure.axes)
    assert any("effort" in axes.get_ylabel() for axes in plots.histories(result).axes)
