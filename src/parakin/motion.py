"""Motions: what drives a mechanism over time, as position, velocity and acceleration.

A motion is made from laws of time, whose derivatives are exact, or from samples, whose
derivatives are given with them or follow from a quintic spline. SI: seconds, metres, radians.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from parakin.errors import InputError, nearest
from parakin.expressions import ANGLE, FREQUENCY, TIME, Dimension, Parameters, Value
from parakin.validation import Table, validated

FloatArray = NDArray[np.float64]
Law = Callable[[FloatArray], tuple[FloatArray, FloatArray, FloatArray]]
"""Times (n,) [s] to position, velocity and acceleration (n,), exact derivatives of each other."""

MAX_SAMPLES = 10**9
_QUANTITIES = ("position", "velocity", "acceleration")
_SLACK = 1e-9  # relative; ends computed from decimal times miss each other by rounding


class Samples(NamedTuple):
    """Consecutive samples; each array is C-contiguous and the caller's own."""

    time: FloatArray  # (n,) [s]
    position: FloatArray  # (k, n) [m or rad], a row per driven coordinate
    velocity: FloatArray  # (k, n) [per s]
    acceleration: FloatArray  # (k, n) [per s²]


@dataclass(frozen=True)
class Motion:
    """`count` samples of the driven `coordinates`.

    `window(start, stop)` gives some of them, chosen as a slice would; they are computed when
    asked for, so a long motion takes no memory. `derivatives` says how velocity and
    acceleration came about.
    """

    name: str
    coordinates: tuple[str, ...]
    count: int
    window: Callable[[int, int], Samples]
    derivatives: str

    def samples(self) -> Samples:
        """All samples at once."""
        return self.window(0, self.count)

    def reordered(self, coordinates: Sequence[str]) -> Motion:
        """The same motion, its rows in the order of `coordinates`.

        Raises InputError unless these are the motion's own, each once.
        """
        place = f"motion {self.name!r}"
        for name in coordinates:
            if name not in self.coordinates:
                raise InputError(place, f"no {name!r}", nearest(name, self.coordinates))
        for name in self.coordinates:
            if name not in coordinates:
                raise InputError(place, f"{name!r}, not driven", nearest(name, coordinates))
        _refuse_repeated(coordinates, place)
        rows = [self.coordinates.index(name) for name in coordinates]

        def window(start: int, stop: int) -> Samples:
            time, *arrays = self.window(start, stop)
            return Samples(time, *(array[rows] for array in arrays))

        return replace(self, coordinates=tuple(coordinates), window=window)


# ---- laws of time


def constant(value: float) -> Law:
    """At rest."""
    return lambda t: (np.full_like(t, value), np.zeros_like(t), np.zeros_like(t))


def cosine(start: float, by: float, duration: float, begin: float = 0.0) -> Law:
    """Rest to rest by start + by/2 (1 - cos(π (t - begin)/duration)), constant outside.

    Equation (6) of the paper, where `by` is twice x*. Its acceleration jumps at both ends; there
    it is that of the moving side.
    """

    def shape(u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        half = np.pi / 2  # sin² instead of 1 - cos, which cancels near the start
        return np.sin(half * u) ** 2, half * np.sin(np.pi * u), half * np.pi * np.cos(np.pi * u)

    return _rest_to_rest(shape, start, by, duration, begin)


def polynomial345(start: float, by: float, duration: float, begin: float = 0.0) -> Law:
    """From rest to rest with zero acceleration at both ends, constant outside."""
    return _rest_to_rest(_polynomial(0, 0, 0, 10, -15, 6), start, by, duration, begin)


def polynomial4567(start: float, by: float, duration: float, begin: float = 0.0) -> Law:
    """From rest to rest with zero acceleration and jerk at both ends, constant outside."""
    return _rest_to_rest(_polynomial(0, 0, 0, 0, 35, -84, 70, -20), start, by, duration, begin)


def _polynomial(*coefficients: float) -> Law:
    p = np.polynomial.Polynomial(coefficients)
    return lambda u: (p(u), p.deriv()(u), p.deriv(2)(u))


def _rest_to_rest(shape: Law, start: float, by: float, duration: float, begin: float) -> Law:
    """`shape`, which goes from 0 to 1 while its argument does, scaled and shifted."""
    _refuse_unless_positive(duration, "duration")

    def law(t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        u = (t - begin) / duration
        moving = by * (np.abs(u - 0.5) <= 0.5 + _SLACK)
        s, ds, dds = shape(np.clip(u, 0.0, 1.0))
        return start + by * s, moving / duration * ds, moving / duration**2 * dds

    return law


def sine(center: float, amplitude: float, frequency: float, phase: float = 0.0) -> Law:
    """The sine center + amplitude sin(2π frequency t + phase); frequency [Hz], phase [rad]."""
    return sines(center, [(amplitude, frequency, phase)])


def sines(center: float, terms: Sequence[tuple[float, float, float]]) -> Law:
    """The sum of `center` and a sine for each (amplitude, frequency [Hz], phase [rad])."""

    def law(t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        position, velocity, acceleration = constant(center)(t)
        for amplitude, frequency, phase in terms:
            omega = 2 * np.pi * frequency
            s, c = np.sin(omega * t + phase), np.cos(omega * t + phase)
            position += amplitude * s
            velocity += amplitude * omega * c
            acceleration -= amplitude * omega**2 * s
        return position, velocity, acceleration

    return law


def chirp(
    center: float, amplitude: float, f0: float, f1: float, duration: float, phase: float = 0.0
) -> Law:
    """A sine whose frequency changes linearly from f0 [Hz] at t = 0 to f1 at t = duration."""
    _refuse_unless_positive(duration, "duration")

    def law(t: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        growth = 2 * np.pi * (f1 - f0) / duration
        omega = 2 * np.pi * f0 + growth * t
        angle = (2 * np.pi * f0 + growth / 2 * t) * t + phase
        s, c = amplitude * np.sin(angle), amplitude * np.cos(angle)
        return center + s, omega * c, growth * c - omega**2 * s

    return law


def waypoints(times: ArrayLike, values: ArrayLike) -> Law:
    """The quintic spline through `values` (m,) at increasing `times` (m,), constant outside.

    Velocity and acceleration vanish at both ends; between them the fourth derivative is
    continuous. Like any interpolation it may overshoot between values.
    """
    t = _array(times, "times", (-1,))
    x = _array(values, "values", t.shape)
    if len(t) < 2 or not np.isfinite(t).all() or not (np.diff(t) > 0).all():
        raise InputError("times", f"{t.tolist()}", "two or more, increasing")
    if not np.isfinite(x).all():
        raise InputError("values", f"{x.tolist()}", "finite numbers")
    rest = [(1, 0.0), (2, 0.0)]
    spline = _spline(t, x, "times", (rest, rest))

    def law(time: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        moving = (t[0] < time) & (time < t[-1])
        u = np.clip(time, t[0], t[-1])
        return spline(u), moving * spline(u, 1), moving * spline(u, 2)

    return law


def from_laws(name: str, laws: Mapping[str, Law], duration: float, rate: float) -> Motion:
    """Samples at t = 0, 1/rate, 2/rate, ... up to `duration` [s], rounded to whole steps.

    Raises InputError where there is no law, or not between 1 and 10⁹ steps; the window raises it
    where a value is not finite.
    """
    place = f"motion {name!r}"
    _refuse_unless_positive(duration, f"{place}, duration")
    _refuse_unless_positive(rate, f"{place}, rate")
    steps = duration * rate
    if not 0.5 < steps < MAX_SAMPLES:
        found = f"{steps:g} steps ({duration:g} s at {rate:g} samples per second)"
        raise InputError(place, found, f"at least 1 and fewer than {MAX_SAMPLES:g}")
    if not laws:
        raise InputError(place, "no laws", "one for every driven coordinate")
    count = round(steps) + 1

    def window(start: int, stop: int) -> Samples:
        chosen = range(count)[start:stop]
        time = np.arange(chosen.start, chosen.stop) / rate
        rows = np.empty((3, len(laws), len(time)))
        with np.errstate(over="ignore", invalid="ignore"):  # refused below
            for row, law in enumerate(laws.values()):
                rows[0, row], rows[1, row], rows[2, row] = law(time)
        _refuse_non_finite(time, rows, list(laws), place)
        return Samples(time, *rows)

    return Motion(name, tuple(laws), count, window, "exact")


# ---- samples


def from_arrays(
    name: str,
    coordinates: Sequence[str],
    time: ArrayLike,
    position: ArrayLike,
    velocity: ArrayLike | None = None,
    acceleration: ArrayLike | None = None,
    smoothing: float | Mapping[str, float] | None = None,
    max_gap: float | None = None,
) -> Motion:
    """A motion through samples at increasing times (n,) [s], evenly spaced or not.

    `position` and, both or neither, `velocity` and `acceleration` are (k, n), a row per
    coordinate. Where the latter are not given they are the derivatives of the quintic spline
    through the positions (n >= 6). `smoothing` is the standard deviation of the noise in the
    positions, in their SI unit, one for all or by coordinate: then position, velocity and
    acceleration are those of a smoother spline (n >= 24; see `_smoothed`).

    A sample that repeats the one before it, time included, is dropped. `max_gap` [s] is the
    longest step allowed, unless given 10 times the median step. Raises InputError on whatever
    else is no motion, and where velocity or acceleration are plainly not the derivatives of
    what they are given with (see `_refuse_contradiction`).
    """
    place = f"motion {name!r}"
    _refuse_repeated(coordinates, place)
    noise = _noise(smoothing, coordinates, place)
    if (velocity is None) != (acceleration is None):
        lone = "velocity" if acceleration is None else "acceleration"
        raise InputError(place, f"{lone} alone", "both velocity and acceleration, or neither")
    if noise and velocity is not None:
        raise InputError(place, "velocity and smoothing", "positions alone to be smoothed")

    t = _array(time, f"{place}, time", (-1,))
    given = [array for array in (position, velocity, acceleration) if array is not None]
    rows = np.empty((len(given), len(coordinates), len(t)))
    for order, array in enumerate(given):
        rows[order] = _array(array, f"{place}, {_QUANTITIES[order]}", rows.shape[1:])
    _refuse_non_finite(t, rows, coordinates, place)
    kept = _increasing(t, rows, place)
    t, rows = t[kept], rows[:, :, kept]
    needed = 24 if noise else 6 if velocity is None else 2
    if len(t) < needed:
        raise InputError(place, f"{len(t)} samples", f"at least {needed}")
    _refuse_gaps(t, max_gap, place)

    if velocity is None:
        rows = _differentiated(t, rows[0], coordinates, noise, place)
        told = ", ".join(f"{key} {deviation:g}" for key, deviation in noise.items())
        derivatives = f"smoothed quintic spline (noise {told})" if noise else "quintic spline"
    else:
        derivatives = "given"
        for row, coordinate in enumerate(coordinates):
            for order in (1, 2):
                where = f"{place}, {_QUANTITIES[order]} of {coordinate!r}"
                _refuse_contradiction(t, rows[order - 1, row], rows[order, row], where)
    if not kept.all():
        derivatives += f"; repeated samples dropped: {np.sum(~kept)}"

    def window(start: int, stop: int) -> Samples:
        return Samples(t[start:stop].copy(), *(row[:, start:stop].copy() for row in rows))

    return Motion(name, tuple(coordinates), len(t), window, derivatives)


def _noise(
    smoothing: float | Mapping[str, float] | None, coordinates: Sequence[str], place: str
) -> dict[str, float]:
    """The standard deviation of each coordinate that is to be smoothed."""
    if smoothing is None:
        return {}
    if not isinstance(smoothing, Mapping):
        smoothing = dict.fromkeys(coordinates, smoothing)
    for coordinate, deviation in smoothing.items():
        where = f"{place}, smoothing"
        if coordinate not in coordinates:
            raise InputError(where, f"{coordinate!r}", nearest(coordinate, coordinates))
        _refuse_unless_positive(deviation, where)
    return dict(smoothing)


def _differentiated(
    t: FloatArray,
    position: FloatArray,
    coordinates: Sequence[str],
    noise: Mapping[str, float],
    place: str,
) -> FloatArray:
    """Position, velocity and acceleration (3, k, n) of the splines for positions (k, n)."""
    u = t - t[0]  # counted from long ago, the times would cost the spline digits
    rows = np.repeat(position[np.newaxis], 3, axis=0)
    for row, coordinate in enumerate(coordinates):
        where = f"{place}, {coordinate!r}"
        if coordinate in noise:
            spline = _smoothed(u, position[row], noise[coordinate], where)
            rows[0, row] = spline(u)
        else:
            spline = _spline(u, position[row], where)
        rows[1, row], rows[2, row] = spline(u, 1), spline(u, 2)
    _refuse_non_finite(t, rows, coordinates, place)
    return rows


def _spline(t: FloatArray, x: FloatArray, place: str, ends: Any = None) -> Any:
    """The quintic spline (scipy's BSpline) through x (n,) at t (n,)."""
    from scipy.interpolate import make_interp_spline  # here, as it takes long to import

    step = np.diff(t)
    if not step.max() <= 1e4 * step.min():  # beyond, it may swing wildly between the samples
        found = f"steps from {step.min():g} s to {step.max():g} s"
        raise InputError(place, found, "steps within a factor of 10,000, for a spline")
    return make_interp_spline(t, x, k=5, bc_type=ends)


def _smoothed(t: FloatArray, x: FloatArray, deviation: float, place: str) -> Any:
    """The stiffest quintic spline (scipy's BSpline) that leaves no more than the noise.

    Splines are fitted by least squares, each with twice as many intervals as the last, of
    equally many samples; the first is taken whose residual variance is deviation² or above it
    by less than three standard errors. (FITPACK's smoothing, its sum of squares set to
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


def _increasing(t: FloatArray, rows: FloatArray, place: str) -> NDArray[np.bool_]:
    """Which samples to keep: all but repeats. Refuses times that do not increase."""
    step = np.diff(t)
    repeats = (step == 0) & (rows[:, :, 1:] == rows[:, :, :-1]).all(axis=(0, 1))
    wrong = np.flatnonzero((step <= 0) & ~repeats)
    if len(wrong):
        i = int(wrong[0]) + 1
        found = f"{t[i]:.9g} s after {t[i - 1]:.9g} s"
        expected = "a later time, or all values the same as before"
        raise InputError(f"{place}, time of sample {i}", found, expected)
    kept = np.ones(len(t), dtype=np.bool_)
    kept[1:] = ~repeats
    return kept


def _refuse_gaps(t: FloatArray, max_gap: float | None, place: str) -> None:
    step = np.diff(t)
    longest = int(np.argmax(step))
    if max_gap is None:
        limit, of = 10 * float(np.median(step)), "10 times the median"
    else:
        _refuse_unless_positive(max_gap, f"{place}, max_gap")
        limit, of = max_gap, "max_gap"
    if step[longest] > limit * (1 + _SLACK):
        found = f"a step of {step[longest]:g} s after sample {longest} (t = {t[longest]:.9g} s)"
        raise InputError(place, found, f"at most {limit:g} s ({of}); a larger max_gap allows it")


def _refuse_contradiction(t: FloatArray, x: FloatArray, v: FloatArray, place: str) -> None:
    """Refuse v (n,) as the derivative of x (n,) if it is off by a factor of two, or in sign.

    The integral of v by the trapezoidal rule may stray from x over half of the range that either
    covers, plus a micrometre or microradian (per second), plus what noise may build up. That is
    judged by the third differences of what v leaves over: noise changes from step to step, a
    wrong unit does not where there are a dozen samples or more in a cycle.
    """
    step = np.diff(t)
    covered = step * (v[1:] + v[:-1]) / 2
    left = np.diff(x) - covered
    with np.errstate(over="ignore", invalid="ignore"):
        noise = 3 * np.linalg.norm(step[3:] * np.diff(left / step, 3))

    def reach(steps: FloatArray) -> float:
        return float(np.ptp(np.append(0.0, np.cumsum(steps))))

    if reach(left) > max(reach(np.diff(x)), reach(covered)) / 2 + noise + 1e-6:
        found = f"an integral off by {reach(left):.3g} from values ranging over {np.ptp(x):.3g}"
        expected = "the derivative, in SI or the unit stated; or only positions"
        raise InputError(place, found, expected)


def _array(values: ArrayLike, place: str, shape: tuple[int, ...]) -> FloatArray:
    """A copy of `values`, of `shape` (-1: any length)."""
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(place, str(error), "numbers") from None
    if array.ndim != len(shape) or shape not in (array.shape, (-1,)):
        raise InputError(place, f"an array of shape {array.shape}", f"{shape}".replace("-1", "n"))
    return array


def _refuse_non_finite(
    t: FloatArray, rows: FloatArray, coordinates: Sequence[str], place: str
) -> None:
    """Refuse times (n,) or rows (quantities, k, n) that hold NaN or infinity."""
    if not np.isfinite(t).all():
        i = int(np.argmin(np.isfinite(t)))
        raise InputError(f"{place}, time of sample {i}", f"{t[i]}", "a finite number")
    if not np.isfinite(rows).all():
        quantity, row, i = np.argwhere(~np.isfinite(rows))[0]
        where = f"{place}, {_QUANTITIES[quantity]} of {coordinates[row]!r}"
        found = f"{rows[quantity, row, i]} at t = {t[i]:.9g} s (sample {i})"
        raise InputError(where, found, "a finite number")


def _refuse_repeated(coordinates: Sequence[str], place: str) -> None:
    if not coordinates or len(set(coordinates)) < len(coordinates):
        raise InputError(place, f"coordinates {list(coordinates)}", "one or more, each once")


def _refuse_unless_positive(value: float, place: str) -> None:
    if not 0 < value < np.inf:
        raise InputError(place, f"{value:g}", "a positive number")


# ---- tables


class _Constant(Table):
    law: Literal["constant"]
    value: Value


class _RestToRest(Table):
    law: Literal["cosine", "poly345", "poly4567"]
    by: Value | None = None
    to: Value | None = None
    from_: Value | None = Field(None, alias="from")
    begin: Value = 0.0
    duration: Value | None = None


class _Term(Table):
    amplitude: Value
    frequency: Value
    phase: Value = 0.0


class _Sine(_Term):
    law: Literal["sine"]
    center: Value | None = None


class _Sines(Table):
    law: Literal["sines"]
    terms: Annotated[list[_Term], Field(min_length=1)]
    center: Value | None = None


class _Chirp(Table):
    law: Literal["chirp"]
    amplitude: Value
    from_frequency: Value
    to_frequency: Value
    phase: Value = 0.0
    center: Value | None = None


class _Waypoints(Table):
    law: Literal["waypoints"]
    times: list[Value]
    values: list[Value]


_LawTable = Annotated[
    _Constant | _RestToRest | _Sine | _Sines | _Chirp | _Waypoints, Field(discriminator="law")
]


class _MotionTable(Table):
    duration: Value
    rate: Value = 1000.0  # samples per second
    title: str = ""
    laws: dict[str, _LawTable] = Field(default_factory=dict)


def flatten(table: Mapping[str, Any], place: str) -> dict[str, Any]:
    """Law tables by coordinate, `platform.x` being x inside platform where TOML nests them.

    A table of nothing but tables is a part of a name. Raises InputError on a name given twice.
    """
    flat: dict[str, Any] = {}
    for key, entry in table.items():
        laws = {key: entry}
        inner = list(entry.values()) if isinstance(entry, Mapping) else []
        if inner and all(isinstance(value, Mapping) for value in inner):
            below = flatten(entry, f"{place}.{key}")
            laws = {f"{key}.{name}": law for name, law in below.items()}
        for name in laws.keys() & flat.keys():
            raise InputError(f"{place}.{name}", "two laws", "one")
        flat |= laws
    return flat


def from_table(
    table: Mapping[str, Any],
    name: str,
    parameters: Parameters,
    home: Mapping[str, float],
    dimensions: Mapping[str, Dimension],
    place: str,
    rate: float | None = None,
) -> Motion:
    """The motion that a TOML table says: duration, rate, and laws by driven coordinate.

    `dimensions` names the driven coordinates, LENGTH or ANGLE each, and `home` has their values
    [SI]: where laws start or oscillate unless they say otherwise, and where a coordinate without
    a law rests. `rate` [samples per second] replaces the table's. Laws must begin and end within
    the motion. Raises InputError, its place below `place`.
    """
    table = dict(table)
    if isinstance(table.get("laws"), Mapping):
        table["laws"] = flatten(table["laws"], f"{place}.laws")
    checked = validated(_MotionTable, table, place)
    span = parameters.evaluate(checked.duration, TIME, f"{place}.duration")
    _refuse_unless_positive(span, f"{place}.duration")
    if rate is None:
        rate = parameters.evaluate(checked.rate, FREQUENCY, f"{place}.rate")
        _refuse_unless_positive(rate, f"{place}.rate")
    for coordinate in checked.laws:
        if coordinate not in dimensions:
            found = f"{coordinate!r}, not driven"
            raise InputError(f"{place}.laws", found, nearest(coordinate, dimensions))
    laws = {coordinate: constant(home[coordinate]) for coordinate in dimensions}
    for coordinate, law in checked.laws.items():
        try:
            laws[coordinate] = _law(
                law, parameters.evaluate, dimensions[coordinate], home[coordinate], span
            )
        except InputError as error:
            inner = f"{place}.laws.{coordinate}.{error.place}"
            raise InputError(inner, error.found, error.expected) from None
    return from_laws(name, laws, span, rate)


def _law(
    table: _LawTable,
    value: Callable[[Value, Dimension, str], float],
    dimension: Dimension,
    home: float,
    span: float,
) -> Law:
    """The law that `table` says for a motion of `span` seconds; errors name its keys."""

    def center(text: Value | None, key: str = "center") -> float:
        return home if text is None else value(text, dimension, key)

    def term(table: _Term, key: str = "") -> tuple[float, float, float]:
        return (
            value(table.amplitude, dimension, f"{key}amplitude"),
            value(table.frequency, FREQUENCY, f"{key}frequency"),
            value(table.phase, ANGLE, f"{key}phase"),
        )

    match table:
        case _Constant():
            return constant(value(table.value, dimension, "value"))
        case _Sine():
            return sine(center(table.center), *term(table))
        case _Sines():
            terms = [term(inner, f"terms[{i}].") for i, inner in enumerate(table.terms)]
            return sines(center(table.center), terms)
        case _Chirp():
            return chirp(
                center(table.center),
                value(table.amplitude, dimension, "amplitude"),
                value(table.from_frequency, FREQUENCY, "from_frequency"),
                value(table.to_frequency, FREQUENCY, "to_frequency"),
                span,
                value(table.phase, ANGLE, "phase"),
            )
        case _Waypoints():
            times = [value(text, TIME, f"times[{i}]") for i, text in enumerate(table.times)]
            values = [value(text, dimension, f"values[{i}]") for i, text in enumerate(table.values)]
            _refuse_outside(min(times, default=0.0), max(times, default=0.0), span, "times")
            return waypoints(times, values)
        case _RestToRest():
            start = center(table.from_, "from")
            if (table.by is None) == (table.to is None):
                found = "neither" if table.by is None else "both"
                raise InputError("by and to", found, "one of them")
            by = center(table.to, "to") - start
            if table.by is not None:
                by = value(table.by, dimension, "by")
            begin = value(table.begin, TIME, "begin")
            duration = span - begin
            if table.duration is not None:
                duration = value(table.duration, TIME, "duration")
            _refuse_outside(begin, begin + duration, span, "begin")
            make = {"cosine": cosine, "poly345": polynomial345, "poly4567": polynomial4567}
            return make[table.law](start, by, duration, begin)


def _refuse_outside(begin: float, end: float, span: float, place: str) -> None:
    if not 0 <= begin <= end <= span * (1 + _SLACK):
        found = f"a law from {begin:g} s to {end:g} s"
        raise InputError(place, found, f"one within the motion, 0 s to {span:g} s")
