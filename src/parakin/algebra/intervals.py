"""Intervals: the kernel run on these encloses all that it could return over boxes of poses.

Every bound is rounded outwards, so that what it encloses is proved, but for what NumPy's elementary
functions are off, for which more than they claim is allowed. An interval of which nothing is known
(a root of what may be negative, a quotient by what may be zero, an angle across its cut) is NaN,
and so is all that comes of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from parakin.algebra.spatial import Functions, add, mul, sub
from parakin.arrays import BoolArray, FloatArray

_OFF = 2.0**-49  # of a sine, a cosine or an arc: eight units in the last place


class Interval:
    """From `low` to `high`, arrays of any one shape."""

    __slots__ = ("high", "low")
    __array_ufunc__ = None  # an array leaves sums and products with an interval to the latter

    def __init__(self, low: FloatArray, high: FloatArray) -> None:
        self.low, self.high = low, high

    def __neg__(self) -> Interval:
        return Interval(-self.high, -self.low)

    def __add__(self, other: Any) -> Any:
        low, high = ends(other)
        return Interval(_down_sum(self.low + low), _up_sum(self.high + high))

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        low, high = ends(other)
        return Interval(_down_sum(self.low - high), _up_sum(self.high - low))

    def __rsub__(self, other: Any) -> Any:
        return (-self) + other

    def __mul__(self, other: Any) -> Any:
        if other is self:
            return self._square()
        if isinstance(other, (int, float)):
            products = (other * self.low, other * self.high)
            return _outward(np.minimum(*products), np.maximum(*products))
        low, high = ends(other)
        first, second = self.low * low, self.low * high
        third, fourth = self.high * low, self.high * high
        return _outward(
            np.minimum(np.minimum(first, second), np.minimum(third, fourth)),
            np.maximum(np.maximum(first, second), np.maximum(third, fourth)),
        )

    __rmul__ = __mul__

    def _square(self) -> Interval:
        first, second = self.low * self.low, self.high * self.high
        inside = (self.low <= 0.0) & (self.high >= 0.0)
        found = _outward(np.minimum(first, second), np.maximum(first, second))
        return Interval(np.where(inside, 0.0, np.maximum(found.low, 0.0)), found.high)

    def __truediv__(self, other: Any) -> Any:
        return self * inverse(other)

    def __rtruediv__(self, other: Any) -> Any:
        return other * inverse(self)


def inverse(a: Any) -> Interval:
    """1 / a; NaN where a may be zero."""
    low, high = ends(a)
    known = (low > 0.0) | (high < 0.0)
    with np.errstate(divide="ignore", over="ignore"):
        found = _outward(1.0 / np.asarray(high), 1.0 / np.asarray(low))
    return _where(known, found)


def ends(a: Any) -> tuple[Any, Any]:
    """Both ends of an interval, or of a number."""
    return (a.low, a.high) if isinstance(a, Interval) else (a, a)


class Centred:
    """What is enclosed over boxes: its value (n,), its rates by what spans the boxes (k, n), and
    its value in their middles (n,); radius (k, n): how far the boxes go from there.

    By the mean value theorem a value is that in the middle and what the rates add to it, at most.
    Whatever is computed is enclosed that way too: what is left over then falls with the square of
    the size of a box. Rates that are not known count for nothing; a value that is not is NaN.
    """

    __slots__ = ("middle", "radius", "rate", "value")
    __array_ufunc__ = None

    def __init__(self, value: Any, rate: Any, middle: Any, radius: FloatArray) -> None:
        self.value, self.rate, self.middle, self.radius = value, rate, middle, radius
        rate_low, rate_high = ends(rate)
        steepest = np.maximum(np.abs(rate_low), np.abs(rate_high))
        away = _up((_up(steepest * radius)).sum(axis=0) * (1.0 + 1e-14))
        (low, high), (middle_low, middle_high) = ends(value), ends(middle)
        least, most = _down(middle_low - away), _up(middle_high + away)
        known = ~np.isnan(least + most)
        self.value = Interval(
            np.where(known, np.maximum(low, least), low),
            np.where(known, np.minimum(high, most), high),
        )

    def _like(self, value: Any, rate: Any, middle: Any) -> Centred:
        return Centred(value, rate, middle, self.radius)

    def __neg__(self) -> Centred:
        return self._like(-self.value, sub(0.0, self.rate), -self.middle)

    def __add__(self, other: Any) -> Any:
        value, rate, middle = _parts(other)
        return self._like(self.value + value, add(self.rate, rate), self.middle + middle)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        value, rate, middle = _parts(other)
        return self._like(self.value - value, sub(self.rate, rate), self.middle - middle)

    def __rsub__(self, other: Any) -> Any:
        return (-self) + other

    def __mul__(self, other: Any) -> Any:
        value, rate, middle = _parts(other)
        rates = add(mul(self.rate, value), mul(rate, self.value))
        return self._like(self.value * value, rates, self.middle * middle)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        return self * (1.0 / other)

    def __rtruediv__(self, other: Any) -> Any:
        inverted = inverse(self.value)
        slope = -(inverted * inverted)
        return other * self._like(inverted, mul(self.rate, slope), inverse(self.middle))


def spanning(middle: FloatArray, radius: FloatArray) -> list[Centred]:
    """The coordinates that span boxes about points, both (k, n)."""
    low, high = _down(middle - radius), _up(middle + radius)
    away = _up(np.maximum(high - middle, middle - low))
    unit = np.eye(len(middle))[:, :, None].repeat(middle.shape[1], axis=2)
    return [
        Centred(Interval(low[k], high[k]), Interval(u, u), Interval(m, m), away)
        for k, (u, m) in enumerate(zip(unit, middle, strict=True))
    ]


def centred_functions() -> Functions:
    """The elementary functions of what is enclosed, and of numbers among it."""
    return Functions(_sin, _cos, _sqrt, _atan2, _minimum, _copysign, lambda a: 1.0 / a)


def _parts(a: Any) -> tuple[Any, Any, Any]:
    """Value, rate and value in the middle."""
    return (a.value, a.rate, a.middle) if isinstance(a, Centred) else (a, 0.0, a)


def parts(a: Any) -> tuple[Any, Any]:
    """Value and rates."""
    return _parts(a)[:2]


def _down(a: FloatArray) -> FloatArray:
    return np.nextafter(a, -np.inf)


def _up(a: FloatArray) -> FloatArray:
    return np.nextafter(a, np.inf)


def _down_sum(a: FloatArray) -> FloatArray:
    """A sum that comes out as zero is exact, so that sums of squares stay above it."""
    return np.where(a == 0.0, a, np.nextafter(a, -np.inf))


def _up_sum(a: FloatArray) -> FloatArray:
    return np.where(a == 0.0, a, np.nextafter(a, np.inf))


def _outward(low: FloatArray, high: FloatArray) -> Interval:
    return Interval(_down(low), _up(high))


def _where(known: BoolArray, a: Interval) -> Interval:
    return Interval(np.where(known, a.low, np.nan), np.where(known, a.high, np.nan))


def _sin(a: Any) -> Any:
    if not isinstance(a, Centred):
        return math.sin(a)
    sine, cosine = _wave(np.sin, 0.5, a.value), _wave(np.cos, 0.0, a.value)
    return a._like(sine, mul(a.rate, cosine), _wave(np.sin, 0.5, a.middle))


def _cos(a: Any) -> Any:
    if not isinstance(a, Centred):
        return math.cos(a)
    sine, cosine = _wave(np.sin, 0.5, a.value), _wave(np.cos, 0.0, a.value)
    return a._like(cosine, mul(a.rate, -sine), _wave(np.cos, 0.0, a.middle))


def _sqrt(a: Any) -> Any:
    if not isinstance(a, Centred):
        return math.sqrt(a)
    root = _root(a.value)
    return a._like(root, mul(a.rate, 0.5 * inverse(root)), _root(a.middle))


def _atan2(y: Any, x: Any) -> Any:
    if not isinstance(y, Centred) and not isinstance(x, Centred):
        return math.atan2(y, x)
    (a, a_rate, a_middle), (b, b_rate, b_middle) = _parts(y), _parts(x)
    known: Centred = y if isinstance(y, Centred) else x
    turning = sub(mul(a_rate, b), mul(b_rate, a))
    rates = mul(turning, inverse(add(mul(a, a), mul(b, b))))
    return known._like(_arc(a, b), rates, _arc(a_middle, b_middle))


def _minimum(a: Any, b: Any) -> Any:
    if not isinstance(a, Centred) and not isinstance(b, Centred):
        return min(a, b)
    (x, x_rate, x_middle), (y, y_rate, y_middle) = _parts(a), _parts(b)
    (x_low, x_high), (y_low, y_high) = ends(x), ends(y)
    (u_low, u_high), (v_low, v_high) = ends(x_rate), ends(y_rate)
    first, second = x_high < y_low, y_high < x_low
    rates = Interval(
        np.where(first, u_low, np.where(second, v_low, np.minimum(u_low, v_low))),
        np.where(first, u_high, np.where(second, v_high, np.maximum(u_high, v_high))),
    )
    known: Centred = a if isinstance(a, Centred) else b
    return known._like(_least(x, y), rates, _least(x_middle, y_middle))


def _copysign(size: Any, sign: Any) -> Any:
    """Not known where the sign is not: what is known only but for its sign jumps."""
    if not isinstance(size, Centred) and not isinstance(sign, Centred):
        return math.copysign(size, sign)
    low, high = ends(_parts(sign)[0])
    side = np.where(np.asarray(low) > 0.0, 1.0, np.where(np.asarray(high) < 0.0, -1.0, np.nan))
    known: Centred = size if isinstance(size, Centred) else sign
    one = known._like(Interval(side, side), 0.0, Interval(side, side))
    return mul(one, size)


def _wave(function: Callable[[FloatArray], FloatArray], peak: float, a: Interval) -> Interval:
    """A sine or cosine, with a peak so many half turns from zero."""
    low, high = a.low, a.high
    slack = _OFF * (1.0 + np.maximum(np.abs(low), np.abs(high)))
    # Half turns from a peak on, between both ends: the even ones are peaks, the odd ones troughs.
    first = np.ceil((low - slack) / np.pi - peak)
    last = np.floor((high + slack) / np.pi - peak)
    peaks = 2.0 * np.ceil(0.5 * first) <= last
    troughs = 2.0 * np.ceil(0.5 * (first - 1.0)) + 1.0 <= last
    at_low, at_high = function(low), function(high)
    least = np.maximum(np.minimum(at_low, at_high) - _OFF, -1.0)
    most = np.minimum(np.maximum(at_low, at_high) + _OFF, 1.0)
    found = Interval(np.where(troughs, -1.0, least), np.where(peaks, 1.0, most))
    return _where(np.isfinite(low) & np.isfinite(high), found)


def _root(a: Interval) -> Interval:
    known = a.low >= 0.0
    low, high = np.sqrt(np.where(known, a.low, 0.0)), np.sqrt(np.where(known, a.high, 0.0))
    return _where(known, Interval(np.maximum(_down(low), 0.0), _up(high)))


def _arc(y: Any, x: Any) -> Interval:
    """Of what neither surrounds the origin nor meets the cut the extremes are at corners."""
    (y_low, y_high), (x_low, x_high) = ends(y), ends(x)
    known = (x_low > 0.0) | (y_low > 0.0) | (y_high < 0.0)
    corners = [np.arctan2(b, a) for b in (y_low, y_high) for a in (x_low, x_high)]
    low, high = np.minimum.reduce(corners), np.maximum.reduce(corners)
    whole = np.asarray(known & ~np.isnan(low + high))
    return _where(whole, Interval(low - _OFF * np.abs(low), high + _OFF * np.abs(high)))


def _least(a: Any, b: Any) -> Interval:
    (a_low, a_high), (b_low, b_high) = ends(a), ends(b)
    return Interval(np.minimum(a_low, b_low), np.minimum(a_high, b_high))
