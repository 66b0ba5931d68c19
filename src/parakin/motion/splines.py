"""Quintic splines through samples, and smoother ones that leave out their noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from parakin.arrays import FloatArray
from parakin.errors import InputError
from parakin.motion.checks import refuse_non_finite


def quintic(t: FloatArray, x: FloatArray, place: str, ends: Any = None) -> Any:
    """The quintic spline (scipy's BSpline) through x (n,) at t (n,).

    ends: scipy's `bc_type`. Raises InputError where the steps differ too much.
    """
    from scipy.interpolate import make_interp_spline  # here, as it takes long to import

    step = np.diff(t)
    if not step.max() <= 1e4 * step.min():  # beyond, it may swing wildly between the samples
        found = f"steps from {step.min():g} s to {step.max():g} s"
        raise InputError(place, found, "steps within a factor of 10,000, for a spline")
    return make_interp_spline(t, x, k=5, bc_type=ends)


def differentiated(
    t: FloatArray,
    position: FloatArray,
    coordinates: Sequence[str],
    noise: Mapping[str, float],
    place: str,
) -> FloatArray:
    """Position, velocity, acceleration and jerk (4, k, n) of splines for positions (k, n)."""
    u = t - t[0]  # counted from long ago, the times would cost the spline digits
    rows = np.repeat(position[np.newaxis], 4, axis=0)
    for row, coordinate in enumerate(coordinates):
        where = f"{place}, {coordinate!r}"
        if coordinate in noise:
            spline = _smoothed(u, position[row], noise[coordinate], where)
            rows[0, row] = spline(u)
        else:
            spline = quintic(u, position[row], where)
        for order in (1, 2, 3):
            rows[order, row] = spline(u, order)
    refuse_non_finite(t, rows, coordinates, place)
    return rows


def _smoothed(t: FloatArray, x: FloatArray, deviation: float, place: str) -> Any:
    """The smoothest quintic spline (scipy's BSpline) with residuals no larger than the noise.

    Splines are fitted by least squares, each with twice as many intervals as the last, with
    equally many samples in each; the result is the first with a residual variance less than
    three standard errors above deviation². (FITPACK's smoothing, with a sum of squares of
    n deviation², follows the noise once `deviation` is a little too small.)
    """
    from scipy.interpolate import BSpline, splrep

    intervals, variance = 1, 0.0
    while 4 * (intervals + 5) <= len(t):  # four samples per coefficient tell noise from motion
        inner = t[np.arange(1, intervals) * (len(t) - 1) // intervals]
        # FITPACK's own least squares: make_lsq_spline's time grows with samples times intervals.
        spline = BSpline(*splrep(t, x, k=5, t=inner, task=-1))
        freedom = len(t) - intervals - 5
        variance = np.sum((spline(t) - x) ** 2) / freedom
        if variance <= deviation**2 * (1 + 3 * np.sqrt(2 / freedom)):
            return spline
        intervals *= 2
    found = f"smoothing {deviation:g} where the noise is about {np.sqrt(variance):.2g}"
    raise InputError(place, found, "the noise's standard deviation, or more samples")
