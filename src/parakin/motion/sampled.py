"""Motions from samples, with derivatives that are given too or come from a quintic spline."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from parakin.arrays import ORDERS, FloatArray
from parakin.errors import InputError, nearest
from parakin.motion.checks import (
    SLACK,
    checked_array,
    increasing,
    refuse_non_finite,
    refuse_repeated,
    refuse_unless_positive,
)
from parakin.motion.motion import Motion, Samples
from parakin.motion.splines import differentiated

_JERKS = 24  # samples; with fewer, a jerk, which can jump, is too coarse to be checked


def from_arrays(
    name: str,
    coordinates: Sequence[str],
    time: ArrayLike,
    position: ArrayLike,
    velocity: ArrayLike | None = None,
    acceleration: ArrayLike | None = None,
    jerk: ArrayLike | None = None,
    *,
    smoothing: float | Mapping[str, float] | None = None,
    max_gap: float | None = None,
) -> Motion:
    """A motion through samples at increasing times (n,) [s], evenly spaced or not.

    position, velocity, acceleration, jerk: (k, n), a row per coordinate, SI. Velocity and
    acceleration are given both or not at all; jerk only with them. If not given, they are the
    derivatives of the quintic spline through the positions (n >= 6). smoothing: standard
    deviation of the noise in the positions [m or rad], one for all or by coordinate; then the
    positions, too, are those of a smoother spline (n >= 24; see `splines`). max_gap: longest
    step allowed [s], by default 10 times the median step.

    A sample that repeats the one before it, time included, is dropped. Raises InputError on
    anything else that is not a motion, and if velocity or acceleration is clearly not the
    derivative of what it is given with (see `_refuse_contradiction`).
    """
    place = f"motion {name!r}"
    refuse_repeated(coordinates, place)
    noise = _noise(smoothing, coordinates, place)
    given = _given([position, velocity, acceleration, jerk], bool(noise), place)
    t = checked_array(time, f"{place}, time", (-1,))
    rows = np.empty((len(given), len(coordinates), len(t)))
    for order, array in enumerate(given):
        rows[order] = checked_array(array, f"{place}, {ORDERS[order]}", rows.shape[1:])
    refuse_non_finite(t, rows, coordinates, place)
    kept = increasing(t, rows, place)
    t, rows = t[kept], rows[:, :, kept]
    needed = 24 if noise else 6 if velocity is None else 2
    if len(t) < needed:
        raise InputError(place, f"{len(t)} samples", f"at least {needed}")
    _refuse_gaps(t, max_gap, place)
    if velocity is None:
        rows = differentiated(t, rows[0], coordinates, noise, place)
        derivatives = _spline_name(noise)
    else:
        _refuse_contradictions(t, rows, coordinates, place)
        derivatives = "given"
    if not kept.all():
        derivatives += f"; repeated samples dropped: {np.sum(~kept)}"
    window = partial(_window, t, rows)
    return Motion(name, tuple(coordinates), len(t), window, derivatives)


def _window(t: FloatArray, rows: FloatArray, start: int, stop: int) -> Samples:
    return Samples(t[start:stop].copy(), *(row[:, start:stop].copy() for row in rows))


def _given(arrays: Sequence[ArrayLike | None], smoothed: bool, place: str) -> list[ArrayLike]:
    """The arrays that are given, of position and its three derivatives.

    Raises InputError on combinations that make no sense.
    """
    _, velocity, acceleration, jerk = arrays
    if (velocity is None) != (acceleration is None):
        lone = "velocity" if acceleration is None else "acceleration"
        raise InputError(place, f"{lone} alone", "both velocity and acceleration, or neither")
    if jerk is not None and velocity is None:
        raise InputError(place, "jerk alone", "velocity and acceleration with it")
    if smoothed and velocity is not None:
        raise InputError(place, "velocity and smoothing", "positions alone to be smoothed")
    return [array for array in arrays if array is not None]


def _noise(
    smoothing: float | Mapping[str, float] | None, coordinates: Sequence[str], place: str
) -> dict[str, float]:
    """The standard deviations by coordinate to be smoothed."""
    if smoothing is None:
        return {}
    if not isinstance(smoothing, Mapping):
        smoothing = dict.fromkeys(coordinates, smoothing)
    for coordinate, deviation in smoothing.items():
        where = f"{place}, smoothing"
        if coordinate not in coordinates:
            raise InputError(where, f"{coordinate!r}", nearest(coordinate, coordinates))
        refuse_unless_positive(deviation, where)
    return dict(smoothing)


def _spline_name(noise: Mapping[str, float]) -> str:
    if not noise:
        return "quintic spline"
    deviations = ", ".join(f"{key} {deviation:g}" for key, deviation in noise.items())
    return f"smoothed quintic spline (noise {deviations})"


def _refuse_gaps(t: FloatArray, max_gap: float | None, place: str) -> None:
    step = np.diff(t)
    longest = int(np.argmax(step))
    if max_gap is None:
        limit, of = 10 * float(np.median(step)), "10 times the median"
    else:
        refuse_unless_positive(max_gap, f"{place}, max_gap")
        limit, of = max_gap, "max_gap"
    if step[longest] > limit * (1 + SLACK):
        found = f"a step of {step[longest]:g} s after sample {longest} (t = {t[longest]:.9g} s)"
        raise InputError(place, found, f"at most {limit:g} s ({of}); a larger max_gap allows it")


def _refuse_contradictions(
    t: FloatArray, rows: FloatArray, coordinates: Sequence[str], place: str
) -> None:
    """Refuse rows (quantities, k, n) that are not each the derivative of the one before."""
    checked = len(rows) if len(t) >= _JERKS else min(len(rows), 3)
    for row, coordinate in enumerate(coordinates):
        for order in range(1, checked):
            where = f"{place}, {ORDERS[order]} of {coordinate!r}"
            _refuse_contradiction(t, rows[order - 1, row], rows[order, row], where)


def _refuse_contradiction(t: FloatArray, x: FloatArray, v: FloatArray, place: str) -> None:
    """Refuse v (n,) as the derivative of x (n,) if it is wrong by a factor of two, or in sign.

    The trapezoidal integral of v may differ from x by half the range of either, plus a
    micrometre or microradian (per second), plus what noise may add up to. Noise is estimated from
    the third differences of the remainder: it changes from step to step, unlike the effect of a
    wrong unit if there are a dozen samples or more in a cycle.
    """
    step = np.diff(t)
    covered = step * (v[1:] + v[:-1]) / 2
    left = np.diff(x) - covered
    with np.errstate(over="ignore", invalid="ignore"):
        rough = step[3:] * np.diff(left / step, 3)
        noise = 3 * np.sqrt(np.einsum("i,i->", rough, rough))  # not by BLAS, see `all_bounded`

    def reach(steps: FloatArray) -> float:
        return float(np.ptp(np.append(0.0, np.cumsum(steps))))

    if reach(left) > max(reach(np.diff(x)), reach(covered)) / 2 + noise + 1e-6:
        found = f"an integral off by {reach(left):.3g} from values ranging over {np.ptp(x):.3g}"
        expected = "the derivative, in SI or the unit stated; or only positions"
        raise InputError(place, found, expected)
