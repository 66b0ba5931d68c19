"""Laws of time with exact derivatives, and motions made from them.

They are functions with their numbers bound, and not closures: motions can be pickled.

Positions are in metres or radians, times in seconds, frequencies in hertz, phases in radians.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from parakin.arrays import FloatArray
from parakin.errors import InputError
from parakin.motion.checks import (
    SLACK,
    checked_array,
    refuse_non_finite,
    refuse_unless_positive,
)
from parakin.motion.motion import MAX_SAMPLES, Motion, Samples
from parakin.motion.splines import quintic

Law = Callable[[FloatArray], tuple[FloatArray, ...]]
"""Times (n,) [s] to position and its exact derivatives (n,): velocity, acceleration and jerk.

The jerk may be left out; then the mechanism's is not available either.
"""

_FASTEST = 1e12  # [Hz]
BURST = 1 / 1000  # of a motion's duration


@dataclass(frozen=True)
class Paced:
    """A law with what is known of its changes: it is smooth between its `knots` [s], and changes
    in no less than `period` [s]. Any other law may change in `BURST` of the motion's duration.
    """

    law: Law
    knots: tuple[float, ...] = ()
    period: float = np.inf

    def __call__(self, t: FloatArray) -> tuple[FloatArray, ...]:
        return self.law(t)


def constant(value: float) -> Law:
    """At rest."""
    return Paced(partial(_constant, value))


def _constant(value: float, t: FloatArray) -> tuple[FloatArray, ...]:
    return np.full_like(t, value), *np.zeros((3, *t.shape))


def cosine(start: float, by: float, duration: float, begin: float = 0.0) -> Law:
    """Rest to rest by start + by/2 (1 - cos(π (t - begin)/duration)), constant outside.

    Equation (6) of the paper, where `by` is twice x*. Its acceleration jumps at both ends, where
    it has the value of the moving side. Raises InputError on a duration that is not positive.
    """
    return _rest_to_rest(_half_wave, start, by, duration, begin)


def _half_wave(u: FloatArray) -> tuple[FloatArray, ...]:
    half = np.pi / 2  # sin² of half the angle instead of 1 - cos, which cancels near the start
    s, c = np.sin(half * u), np.cos(half * u)
    sine, cosine = 2 * s * c, (c - s) * (c + s)
    return s * s, half * sine, half * np.pi * cosine, -half * np.pi**2 * sine


def polynomial345(start: float, by: float, duration: float, begin: float = 0.0) -> Law:
    """From rest to rest with zero acceleration at both ends, constant outside.

    Raises InputError on a duration that is not positive.
    """
    shape = partial(_polynomial, (0, 0, 0, 10, -15, 6))
    return _rest_to_rest(shape, start, by, duration, begin)


def polynomial4567(start: float, by: float, duration: float, begin: float = 0.0) -> Law:
    """From rest to rest with zero acceleration and jerk at both ends, constant outside.

    Raises InputError on a duration that is not positive.
    """
    shape = partial(_polynomial, (0, 0, 0, 0, 35, -84, 70, -20))
    return _rest_to_rest(shape, start, by, duration, begin)


def _polynomial(coefficients: Sequence[float], u: FloatArray) -> tuple[FloatArray, ...]:
    return tuple(_horner(each, u) for each in _with_derivatives(tuple(coefficients)))


@functools.cache
def _with_derivatives(coefficients: tuple[float, ...]) -> tuple[tuple[float, ...], ...]:
    p = np.polynomial.Polynomial(coefficients)
    return tuple(tuple((p.deriv(k) if k else p).coef.tolist()) for k in range(4))


def _horner(coefficients: tuple[float, ...], u: FloatArray) -> FloatArray:
    total = np.full_like(u, coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        total = coefficient + total * u
    return total


def _rest_to_rest(shape: Law, start: float, by: float, duration: float, begin: float) -> Law:
    """`shape`, which rises from 0 to 1 over the interval from 0 to 1, scaled and shifted."""
    refuse_unless_positive(duration, "duration")
    return Paced(partial(_scaled, shape, start, by, duration, begin), (begin, begin + duration))


def _scaled(
    shape: Law, start: float, by: float, duration: float, begin: float, t: FloatArray
) -> tuple[FloatArray, ...]:
    u = (t - begin) / duration
    moving = by * (np.abs(u - 0.5) <= 0.5 + SLACK)
    s, *rates = shape(np.minimum(np.maximum(u, 0.0), 1.0))
    scaled = (moving / duration**order * rate for order, rate in enumerate(rates, start=1))
    return start + by * s, *scaled


def sine(center: float, amplitude: float, frequency: float, phase: float = 0.0) -> Law:
    """The sine center + amplitude sin(2π frequency t + phase)."""
    return sines(center, [(amplitude, frequency, phase)])


def sines(center: float, terms: Sequence[tuple[float, float, float]]) -> Law:
    """The sum of `center` and a sine for each (amplitude, frequency, phase). Raises InputError on
    frequencies without derivatives.
    """
    fastest = max((abs(frequency) for _, frequency, _ in terms), default=0.0)
    _refuse_too_fast(fastest)
    law = partial(_sum_of_sines, center, tuple(terms))
    return Paced(law, period=1 / fastest if fastest else np.inf)


def _refuse_too_fast(frequency: float) -> None:
    if not frequency <= _FASTEST:
        raise InputError("frequency", f"{frequency:g} Hz", f"at most {_FASTEST:g} Hz")


def _sum_of_sines(
    center: float, terms: Sequence[tuple[float, float, float]], t: FloatArray
) -> tuple[FloatArray, ...]:
    position, velocity, acceleration, jerk = _constant(center, t)
    for amplitude, frequency, phase in terms:
        omega = 2 * np.pi * frequency
        s, c = np.sin(omega * t + phase), np.cos(omega * t + phase)
        position += amplitude * s
        velocity += amplitude * omega * c
        acceleration -= amplitude * omega**2 * s
        jerk -= amplitude * omega**3 * c
    return position, velocity, acceleration, jerk


def chirp(
    center: float, amplitude: float, f0: float, f1: float, duration: float, phase: float = 0.0
) -> Law:
    """A sine with a frequency that changes linearly from f0 at t = 0 to f1 at t = duration.

    Raises InputError on a duration that is not positive, and on frequencies without derivatives.
    """
    refuse_unless_positive(duration, "duration")
    fastest = max(abs(f0), abs(f1))
    _refuse_too_fast(fastest)
    law = partial(_chirped, center, amplitude, f0, f1, duration, phase)
    return Paced(law, period=1 / fastest if fastest else np.inf)


def _chirped(
    center: float,
    amplitude: float,
    f0: float,
    f1: float,
    duration: float,
    phase: float,
    t: FloatArray,
) -> tuple[FloatArray, ...]:
    growth = 2 * np.pi * (f1 - f0) / duration
    omega = 2 * np.pi * f0 + growth * t
    angle = (2 * np.pi * f0 + growth / 2 * t) * t + phase
    s, c = amplitude * np.sin(angle), amplitude * np.cos(angle)
    jerk = -3 * growth * omega * s - omega**3 * c
    return center + s, omega * c, growth * c - omega**2 * s, jerk


def waypoints(times: ArrayLike, values: ArrayLike) -> Law:
    """The quintic spline through `values` (m,) at increasing `times` (m,), constant outside.

    Velocity and acceleration vanish at both ends; between them the fourth derivative is
    continuous. Like any interpolation, it may overshoot between values. Raises InputError on
    times that do not increase and values that are not finite.
    """
    t = checked_array(times, "times", (-1,))
    x = checked_array(values, "values", t.shape)
    if len(t) < 2 or not np.isfinite(t).all() or not (np.diff(t) > 0).all():
        raise InputError("times", f"{t.tolist()}", "two or more, increasing")
    if not np.isfinite(x).all():
        raise InputError("values", f"{x.tolist()}", "finite numbers")
    rest = [(1, 0.0), (2, 0.0)]
    spline = quintic(t, x, "times", (rest, rest))
    knots = tuple(t.tolist())
    return Paced(partial(_splined, spline, knots[0], knots[-1]), knots)


def _splined(spline: Any, first: float, last: float, t: FloatArray) -> tuple[FloatArray, ...]:
    moving = (first < t) & (t < last)
    jerking = (first <= t) & (t <= last)  # at the ends, that of the moving side
    u = np.clip(t, first, last)
    return spline(u), moving * spline(u, 1), moving * spline(u, 2), jerking * spline(u, 3)


def from_laws(name: str, laws: Mapping[str, Law], duration: float, rate: float) -> Motion:
    """A motion sampled at t = 0, 1/rate, 2/rate, ... up to `duration`, rounded to whole steps.

    laws: by driven coordinate. duration: [s]. rate: samples per second. Raises InputError if
    there is no law, or not between 1 and 10⁹ steps; reading samples raises it if one is not
    finite.
    """
    place = f"motion {name!r}"
    refuse_unless_positive(duration, f"{place}, duration")
    refuse_unless_positive(rate, f"{place}, rate")
    steps = duration * rate
    if not 0.5 < steps < MAX_SAMPLES:
        found = f"{steps:g} steps ({duration:g} s at {rate:g} samples per second)"
        raise InputError(place, found, f"at least 1 and fewer than {MAX_SAMPLES:g}")
    if not laws:
        raise InputError(place, "no laws", "one for every driven coordinate")
    count = round(steps) + 1
    between = partial(_between, place, dict(laws))
    window = partial(_window, between, count, rate)
    end = (count - 1) / rate  # at most half a step from the duration
    known = [
        law if isinstance(law, Paced) else Paced(law, (), BURST * duration) for law in laws.values()
    ]
    knots = {0.0, duration, *(knot for law in known for knot in law.knots if 0 < knot < duration)}
    period = min(law.period for law in known)
    ordered = tuple(sorted(knots | {end} if end > duration else knots))
    return Motion(name, tuple(laws), count, window, "exact", between, ordered, period)


def _between(place: str, laws: Mapping[str, Law], time: FloatArray) -> Samples:
    """The samples at any times (n,) [s]. Raises InputError on laws that give none."""
    with np.errstate(over="ignore", invalid="ignore"):  # refused below
        values = {coordinate: law(time) for coordinate, law in laws.items()}
    for coordinate, orders in values.items():
        if len(orders) not in (3, 4):
            found = f"{len(orders)} arrays from the law of {coordinate!r}"
            raise InputError(place, found, "position, velocity, acceleration and jerk")
    known = min(len(orders) for orders in values.values())
    rows = np.empty((known, len(laws), len(time)))
    for row, orders in enumerate(values.values()):
        rows[:, row] = orders[:known]
    refuse_non_finite(time, rows, list(laws), place)
    return Samples(time, *rows)


def _window(
    between: Callable[[FloatArray], Samples], count: int, rate: float, start: int, stop: int
) -> Samples:
    chosen = range(count)[start:stop]
    return between(np.arange(chosen.start, chosen.stop) / rate)
