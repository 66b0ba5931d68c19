"""Checks of motions: shapes of arrays, increasing times, finite numbers.

Each raises InputError, naming `place`, if it fails.
"""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike

from parakin.arrays import ORDERS, BoolArray, FloatArray
from parakin.errors import InputError

SLACK = 1e-9  # relative; ends computed from decimal times miss each other by rounding


def increasing(t: FloatArray, rows: FloatArray, place: str) -> BoolArray:
    """Which samples (n,) to keep: all but repeats. Refuses times that do not increase.

    t: (n,) [s]. rows: (quantities, k, n).
    """
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
    """A copy of `values` as an array of `shape` (-1: any length). Refuses other shapes."""
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
    """Refuse no coordinates, and any that are named twice."""
    if not coordinates or len(set(coordinates)) < len(coordinates):
        raise InputError(place, f"coordinates {list(coordinates)}", "one or more, each once")


def refuse_unless_positive(value: float, place: str) -> None:
    """Refuse anything but a positive, finite number."""
    if not (isinstance(value, Real) and 0 < value < np.inf):
        found = f"{value:g}" if isinstance(value, Real) else repr(value)
        raise InputError(place, found, "a positive number")
