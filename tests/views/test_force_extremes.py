"""Extremes of forces, against closed forms of a driven pendulum."""

from __future__ import annotations

import numpy as np
import pendulum
import pytest
import xarray as xr

import parakin
from parakin.views.extremes import extremes
from parakin.views.force_extremes import ForceExtremes, force_extremes, uses


@pytest.fixture(scope="module")
def solver() -> parakin.Solver:
    return parakin.compile(pendulum.pendulum(), machine_code=False)


@pytest.fixture(scope="module")
def swing(solver: parakin.Solver) -> xr.Dataset:
    return solver.solve("swing", forces=True, reactions=True)


def summed(ds: xr.Dataset, size: int = 5000) -> ForceExtremes:
    found: ForceExtremes | None = None
    for start in range(0, ds.sizes["time"], size):
        found = force_extremes(ds.isel(time=slice(start, start + size)), found)
    assert found is not None
    return found


def test_peaks_and_rms_are_those_of_the_closed_form(swing: xr.Dataset) -> None:
    found = summed(swing)
    time = np.linspace(0.0, 2.0, 200_001)
    effort, power, torque = pendulum.efforts(time)
    peak, at = found.peak("effort", 0)
    assert peak == pytest.approx(effort.max(), rel=1e-5)
    assert at % 1.0 == pytest.approx(0.751, abs=2e-3)
    assert found.rms("effort", 0) == pytest.approx(np.sqrt((effort[:-1] ** 2).mean()), rel=1e-4)
    assert found.rms("motor_torque", 0) == pytest.approx(
        np.sqrt((torque[:-1] ** 2).mean()), rel=1e-3
    )
    low, high = (float(end[0]) for end in found.ranges["power"][:2])
    assert (low, high) == pytest.approx((power.min(), power.max()), rel=1e-4)
    given, taken = found.work
    assert given == pytest.approx(2.0 * np.maximum(power[:-1], 0).mean(), rel=1e-4)
    # Over whole periods only friction takes work: 4 amplitudes a period.
    lost = 2 * 4 * pendulum.AMPLITUDE * pendulum.COULOMB
    assert given - taken == pytest.approx(lost, rel=1e-3)


def test_the_reaction_is_weight_and_inertia(swing: xr.Dataset) -> None:
    found = summed(swing).reactions
    assert found is not None
    q = pendulum.AMPLITUDE * np.sin(pendulum.RATE * swing["time"].values)
    qd = pendulum.AMPLITUDE * pendulum.RATE * np.cos(pendulum.RATE * swing["time"].values)
    turn = np.exp(1j * q)
    moved = pendulum.RADIUS * turn * (-1j * pendulum.RATE**2 * q - 0 - qd**2)
    force = pendulum.MASS * np.abs(moved + 1j * pendulum.GRAVITY)
    assert float(found.force.high[0]) == pytest.approx(force.max(), rel=1e-9)
    assert found.force_known.all()


def test_windows_sum_up_to_the_whole(swing: xr.Dataset) -> None:
    whole, parts = summed(swing), summed(swing, 137)
    assert parts.rms("effort", 0) == pytest.approx(whole.rms("effort", 0), rel=1e-12)
    assert parts.work == pytest.approx(whole.work, rel=1e-12)
    for name, range_ in whole.ranges.items():
        np.testing.assert_array_equal(parts.ranges[name], range_)


def test_uses_of_limits(solver: parakin.Solver, swing: xr.Dataset) -> None:
    effort, _, torque = pendulum.efforts(np.linspace(0.0, 2.0, 20_001))
    found = {use.what: use for use in uses(summed(swing), solver.graph)}
    assert set(found) == {"effort", "torque"}
    assert found["effort"].part == pytest.approx(effort.max() / 30.0, rel=1e-4)
    assert found["torque"].part == pytest.approx(np.abs(torque).max() / 0.2, rel=1e-4)
    assert (found["effort"].unit, found["torque"].unit) == ("N m", "N m")


def test_one_sample_has_its_own_value_as_rms(swing: xr.Dataset) -> None:
    found = summed(swing.isel(time=[0]))
    rest = pendulum.MASS * pendulum.GRAVITY * pendulum.RADIUS + pendulum.COULOMB
    assert found.rms("effort", 0) == pytest.approx(rest)
    assert found.work == (0.0, 0.0)


def test_samples_without_forces_are_left_out(swing: xr.Dataset) -> None:
    broken = swing.copy(deep=True)
    broken["effort"][500:1001] = np.nan  # from the middle to the end of the first period
    found = summed(broken)
    effort = swing["effort"].values[:, 0]
    kept = np.concatenate([effort[:500], effort[1001:]])
    assert found.rms("effort", 0) == pytest.approx(np.sqrt((kept**2).mean()), rel=1e-2)


def test_a_result_without_forces_has_none(swing: xr.Dataset) -> None:
    assert force_extremes(swing.drop_vars("effort")) is None
    assert extremes(swing).forces is not None


def test_conditioning_that_changes_sign(swing: xr.Dataset) -> None:
    crossed = swing.copy(deep=True)
    crossed["effort_conditioning"][:] = np.linspace(0.5, -0.2, swing.sizes["time"])
    found = summed(crossed)
    assert found.changes_sign
    assert found.least_conditioning()[0] == 0.0
