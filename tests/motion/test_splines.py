"""Derivatives of splines through samples, with and without noise."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from waves import uneven, wave

from parakin.errors import InputError
from parakin.motion.sampled import from_arrays

PATIENT = settings(deadline=None)  # the first spline imports scipy


def refusal(error: pytest.ExceptionInfo[InputError]) -> str:
    return str(error.value)


@pytest.mark.parametrize("origin", [0.0, 1.7e9])
def test_the_splines_derivatives_of_uneven_samples(origin: float) -> None:
    """Errors of h⁵x⁽⁶⁾ and h⁴x⁽⁶⁾ times constants below 1, here with h = 10 ms and 2π rad/s."""
    t = uneven(600)
    stamps = origin + t  # seconds since 1970 are rounded to 0.24 µs
    seen = stamps - origin
    drive = from_arrays("m", ["x", "y"], stamps, wave(seen)[0])
    assert drive.derivatives == "quintic spline"
    time, position, velocity, acceleration, jerk = drive.samples()
    _, v, a, j = wave(seen)
    assert_array_equal(time, stamps)
    assert_array_equal(position, wave(seen)[0])
    h, sixth = np.diff(seen).max(), (2 * np.pi) ** 6
    assert_allclose(velocity, v, rtol=0, atol=h**5 * sixth)
    assert_allclose(acceleration, a, rtol=0, atol=h**4 * sixth)
    assert jerk is not None
    assert_allclose(jerk, j, rtol=0, atol=h**3 * sixth)


@PATIENT
@given(
    st.lists(st.floats(-3, 3), min_size=6, max_size=6),
    st.lists(st.floats(0.2, 1), min_size=8, max_size=20),
)
def test_the_spline_reproduces_quintics(coefficients: list[float], steps: list[float]) -> None:
    t = np.cumsum(steps) / len(steps)
    p = np.polynomial.Polynomial(coefficients)
    _, position, velocity, acceleration, _ = from_arrays("m", ["x"], t, [p(t)]).samples()
    assert_array_equal(position[0], p(t))
    # Rounding, amplified by 1/h and 1/h² with h down to 0.01 s and by the splines' uneven knots.
    assert_allclose(velocity[0], p.deriv()(t), atol=1e-9, rtol=0)
    assert_allclose(acceleration[0], p.deriv(2)(t), atol=1e-7, rtol=0)


@pytest.mark.parametrize("n", [301, 3001, 30_001])
def test_smoothing_recovers_the_derivatives(n: int) -> None:
    """The spline is taken once its residual is the noise's but for 3√(2/n), one more of which may
    be luck; so it misses by b = σ√(6√(2/n) + c/n), c = 13 coefficients at least. What it misses
    swings within intervals of h = 3/8 s: a derivative brings a factor of order 10/h.
    """
    sigma, h = 1e-3, 3 / 8
    t = uneven(n, seed=2)
    p, v, a, _ = wave(t)
    noisy = p + sigma * np.random.default_rng(3).standard_normal(p.shape)
    drive = from_arrays("m", ["x", "y"], t, noisy, smoothing={"x": sigma, "y": sigma})
    assert drive.derivatives == "smoothed quintic spline (noise x 0.001, y 0.001)"
    _, position, velocity, acceleration, _ = drive.samples()
    b = sigma * np.sqrt(6 * np.sqrt(2 / n) + 13 / n)
    assert np.sqrt(np.mean((position - p) ** 2)) < b
    assert np.sqrt(np.mean((velocity - v) ** 2)) < 10 * b / h
    assert np.sqrt(np.mean((acceleration - a) ** 2)) < 100 * b / h**2
    # The spline through all samples is useless: its accelerations are wrong by about σ (n/3)².
    raw = from_arrays("m", ["x", "y"], t, noisy).samples()
    assert np.sqrt(np.mean((raw.acceleration - a) ** 2)) > sigma * (n / 3) ** 2
    assert 100 * b / h**2 < 0.03 * np.abs(a).max()


def test_smoothing_of_one_coordinate_leaves_the_other() -> None:
    t = uneven(300)
    p = wave(t)[0]
    noisy = p + 1e-3 * np.random.default_rng(5).standard_normal(p.shape)
    samples = from_arrays("m", ["x", "y"], t, noisy, smoothing={"y": 1e-3}).samples()
    assert_array_equal(samples.position[0], noisy[0])
    assert np.abs(samples.position[1] - noisy[1]).max() > 1e-3


def test_smoothing_says_when_the_noise_is_larger_than_said() -> None:
    t = uneven(3000)
    noisy = wave(t)[0] + 1e-3 * np.random.default_rng(6).standard_normal((2, 3000))
    with pytest.raises(InputError) as error:
        from_arrays("m", ["x", "y"], t, noisy, smoothing=5e-4)
    assert "motion 'm', 'x': found smoothing 0.0005 where the noise is about 0.00" in refusal(error)
    assert "the noise's standard deviation, or more samples" in refusal(error)
