"""Motions: what drives a mechanism over time, as position, velocity, acceleration and jerk.

A motion is made from laws of time, whose derivatives are exact, or from samples, whose
derivatives are given with them or follow from a quintic spline. SI: seconds, metres, radians.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from parakin.arrays import ORDERS, BoolArray, FloatArray
from parakin.errors import InputError, nearest

MAX_SAMPLES = 10**9
SLACK = 1e-9  # relative; ends computed from decimal times miss each other by rounding


class Samples(NamedTuple):
    """Consecutive samples; each array is C-contiguous and the caller's own."""

    time: FloatArray  # (n,) [s]
    position: FloatArray  # (k, n) [m or rad], a row per driven coordinate
    velocity: FloatArray  # (k, n) [per s]
    acceleration: FloatArray  # (k, n) [per s²]
    jerk: FloatArray | None = None  # (k, n) [per s³], where it is known

    @property
    def orders(self) -> tuple[FloatArray, ...]:
        """Position and the derivatives that are known."""
        known = (self.position, self.velocity, self.acceleration)
        return known if self.jerk is None else (*known, self.jerk)

    def cropped(self, start: int, stop: int) -> Samples:
        """Those from `start` to before `stop`, as views."""
        return Samples(self.time[start:stop], *(order[:, start:stop] for order in self.orders))


@dataclass(frozen=True)
class Motion:
    """`count` samples of the driven `coordinates`.

    `window(start, stop)` gives some of them, chosen as a slice would; they are computed when
    asked for, so a long motion takes no memory. `derivatives` says how velocity and
    acceleration came about. `between` gives the motion at any times (n,) [s], where it is known
    (else it is the quintic from sample to sample that keeps their derivatives): it is smooth
    between `knots` (from first to last moment), and changes in no less time than `period` [s].
    """

    name: str
    coordinates: tuple[str, ...]
    count: int
    window: Callable[[int, int], Samples]
    derivatives: str
    between: Callable[[FloatArray], Samples] | None = None
    knots: tuple[float, ...] = ()
    period: float = np.inf

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
        refuse_repeated(coordinates, place)
        rows = [self.coordinates.index(name) for name in coordinates]
        if rows == list(range(len(rows))):
            return self
        between = self.between

        def sorted_(samples: Samples) -> Samples:
            return Samples(samples.time, *(order[rows] for order in samples.orders))

        return replace(
            self,
            coordinates=tuple(coordinates),
            window=lambda start, stop: sorted_(self.window(start, stop)),
            between=None if between is None else lambda time: sorted_(between(time)),
        )


def quintic(t: FloatArray, x: FloatArray, place: str, ends: Any = None) -> Any:
    """The quintic spline (scipy's BSpline) through x (n,) at t (n,)."""
    from scipy.interpolate import make_interp_spline  # here, as it takes long to import

    step = np.diff(t)
    if not step.max() <= 1e4 * step.min():  # beyond, it may swing wildly between the samples
        found = f"steps from {step.min():g} s to {step.max():g} s"
        raise InputError(place, found, "steps within a factor of 10,000, for a spline")
    return make_interp_spline(t, x, k=5, bc_type=ends)


def increasing(t: FloatArray, rows: FloatArray, place: str) -> BoolArray:
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


def checked_array(values: ArrayLike, place: str, shape: tuple[int, ...]) -> FloatArray:
    """A copy of `values`, of `shape` (-1: any length)."""
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(place, str(error), "numbers") from None
    if array.ndim != len(shape) or shape not in (array.shape, (-1,)):
        raise InputError(place, f"an array of shape {array.shape}", f"{shape}".replace("-1", "n"))
    return array


def refuse_non_finite(
    t: FloatArray, rows: FloatArray, coordinates: Sequence[str], place: str
) -> None:
    """Refuse times (n,) or rows (quantities, k, n) that hold NaN or infinity."""
    if not np.isfinite(t).all():
        i = int(np.argmin(np.isfinite(t)))
        raise InputError(f"{place}, time of sample {i}", f"{t[i]}", "a finite number")
    if not np.isfinite(rows).all():
        quantity, row, i = np.argwhere(~np.isfinite(rows))[0]
        where = f"{place}, {ORDERS[quantity]} of {coordinates[row]!r}"
        found = f"{rows[quantity, row, i]} at t = {t[i]:.9g} s (sample {i})"
        raise InputError(where, found, "a finite number")


def refuse_repeated(coordinates: Sequence[str], place: str) -> None:
    if not coordinates or len(set(coordinates)) < len(coordinates):
        raise InputError(place, f"coordinates {list(coordinates)}", "one or more, each once")


def refuse_unless_positive(value: float, place: str) -> None:
    if not 0 < value < np.inf:
        raise InputError(place, f"{value:g}", "a positive number")
