"""Intervals hold what they are to enclose: exact fractions, and roots and arcs of points inside."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from parakin.algebra.intervals import Interval, centred_functions, ends, parts, spanning

NUMBERS = st.floats(-1e3, 1e3, allow_subnormal=False)
PAIRS = st.tuples(NUMBERS, NUMBERS).map(sorted)
PARTS = st.floats(0.0, 1.0)
FUNCTIONS = centred_functions()


def inside(pair: list[float], part: float) -> float:
    """A point of an interval, by which part of it is below."""
    return min(max(pair[0] + part * (pair[1] - pair[0]), pair[0]), pair[1])


def interval(pair: list[float]) -> Interval:
    return Interval(np.array(pair[:1]), np.array(pair[1:]))


def holds(found: Any, exact: Fraction) -> bool:
    low, high = (Fraction(float(np.ravel(end)[0])) for end in ends(found))
    return low <= exact <= high


@given(PAIRS, PAIRS, PARTS, PARTS)
def test_sums_and_products_enclose_exact_ones(
    first: list[float], second: list[float], part: float, other: float
) -> None:
    a, b = interval(first), interval(second)
    x, y = inside(first, part), inside(second, other)
    p, q = Fraction(x), Fraction(y)
    assert holds(a + b, p + q)
    assert holds(a - b, p - q)
    assert holds(a * b, p * q)
    assert holds(a * a, p * p)
    assert holds(-a, -p)
    assert holds(2.5 * a - y, Fraction(5, 2) * p - q)
    quotient = a / b
    if second[0] <= 0.0 <= second[1]:
        assert np.isnan(quotient.low).all()
        assert np.isnan(quotient.high).all()
    else:
        assert holds(quotient, p / q)
        assert holds(3.0 / b, 3 / q)


def test_squares_are_not_below_zero_and_tiny_ones_are_enclosed() -> None:
    square = interval([-2.0, 3.0]) * interval([-2.0, 3.0])
    assert square.low == pytest.approx(-6.0)  # two things that may differ
    same = interval([-2.0, 3.0])
    assert (same * same).low == 0.0
    tiny = interval([1e-200, 1e-200])
    assert holds(tiny * tiny, Fraction(1e-200) ** 2)
    assert holds(tiny * interval([-1e-200, -1e-200]), -(Fraction(1e-200) ** 2))


def spanned(*pairs: list[float]) -> list[Any]:
    """What spans one box."""
    low, high = np.array(pairs).T[:, :, None]
    middle = 0.5 * (low + high)
    return spanning(middle, np.nextafter(np.maximum(high - middle, middle - low), np.inf))


def rounding(pair: list[float]) -> float:
    """What a box may be wider than it is said to be."""
    return 1e-15 * max(abs(pair[0]), abs(pair[1])) + 1e-300


ONE: list[tuple[Callable[[Any], Any], Callable[[float], float], float, float]] = [
    (FUNCTIONS.sin, math.sin, -20.0, 20.0),
    (FUNCTIONS.cos, math.cos, -20.0, 20.0),
    (FUNCTIONS.sqrt, math.sqrt, 0.0, 20.0),
]


@pytest.mark.parametrize(("function", "plain", "low", "high"), ONE)
@given(st.data())
def test_functions_enclose_points_and_their_rates(
    function: Callable[[Any], Any],
    plain: Callable[[float], float],
    low: float,
    high: float,
    data: st.DataObject,
) -> None:
    numbers = st.floats(low, high, allow_subnormal=False)
    pair = sorted(data.draw(st.tuples(numbers, numbers)))
    x = inside(pair, data.draw(PARTS))
    (a,) = spanned(pair)
    found = function(a)
    value, rate = parts(found)
    if plain is math.sqrt and np.isnan(value.low).all():
        assert pair[0] <= rounding(pair)  # its box goes below zero by rounding
        return
    assert value.low <= plain(x) <= value.high
    if plain is math.sin:
        assert rate.low.item() <= math.cos(x) <= rate.high.item()
    elif plain is math.cos:
        assert rate.low.item() <= -math.sin(x) <= rate.high.item()
    elif x > 0.0:
        known = rate.low.item() <= 0.5 / math.sqrt(x) <= rate.high.item()
        assert known or np.isnan(rate.low.item())


@given(PAIRS, PAIRS, PARTS, PARTS)
def test_arcs_enclose_points_or_are_not_known(
    first: list[float], second: list[float], part: float, other: float
) -> None:
    y, x = spanned(first, second)
    value, _ = parts(FUNCTIONS.atan2(y, x))
    if np.isnan(value.low).all():  # the origin, or the cut, is in the box
        assert second[0] <= rounding(second)
        assert first[0] <= rounding(first)
        assert first[1] >= -rounding(first)
        return
    assert value.low <= math.atan2(inside(first, part), inside(second, other)) <= value.high


@given(PAIRS, PAIRS, PARTS, PARTS)
def test_the_lesser_is_enclosed_and_a_sign_that_is_not_known_tells_nothing(
    first: list[float], second: list[float], part: float, other: float
) -> None:
    a, b = spanned(first, second)
    p, q = inside(first, part), inside(second, other)
    value, _ = parts(FUNCTIONS.minimum(a, b))
    assert value.low <= min(p, q) <= value.high
    value, _ = parts(FUNCTIONS.copysign(2.0, a))
    if np.isnan(value.low).all():
        assert first[0] <= rounding(first)
        assert first[1] >= -rounding(first)
    else:
        assert value.low <= math.copysign(2.0, p) <= value.high


@given(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(0.0, 0.5), PARTS, PARTS)
def test_what_is_computed_of_several_is_enclosed(
    x: float, y: float, radius: float, part: float, other: float
) -> None:
    """A leg's length, an angle of it, and the rates of both, by closed forms."""
    pairs = [[x - radius, x + radius], [y - radius, y + radius]]
    a, b = spanned(*pairs)
    p, q = (inside(pair, k) for pair, k in zip(pairs, (part, other), strict=True))
    reach = 3.0 + FUNCTIONS.sin(a) * b
    length = FUNCTIONS.sqrt(reach * reach + b * b)
    angle = FUNCTIONS.atan2(reach, length) / (2.0 - 0.25 * a)
    plain = 3.0 + math.sin(p) * q
    hypot = math.hypot(plain, q)
    slack = 4e-15  # of the numbers that they are compared with, which are rounded too
    value, rate = parts(length)
    assert value.low - slack <= hypot <= value.high + slack
    slope = (plain * math.sin(p) + q) / hypot
    assert rate.low[1, 0] - slack <= slope <= rate.high[1, 0] + slack
    value, _ = parts(angle)
    exact = math.atan2(plain, hypot) / (2.0 - 0.25 * p)
    assert value.low - slack <= exact <= value.high + slack


def test_what_is_left_over_falls_with_the_square_of_a_box() -> None:
    widths = []
    for radius in (0.1, 0.01, 0.001):
        a, b = spanned([0.4 - radius, 0.4 + radius], [0.7 - radius, 0.7 + radius])
        value, _ = parts((a - b) * (a + b) - a * a + b * b)  # zero, written so that it is not seen
        widths.append((value.high - value.low).item())
    assert widths[1] < 0.011 * widths[0]
    assert widths[2] < 0.011 * widths[1]


def test_numbers_among_them_stay_numbers() -> None:
    assert FUNCTIONS.sin(0.5) == math.sin(0.5)
    assert FUNCTIONS.cos(0.5) == math.cos(0.5)
    assert FUNCTIONS.sqrt(2.0) == math.sqrt(2.0)
    assert FUNCTIONS.atan2(1.0, -1.0) == math.atan2(1.0, -1.0)
    assert FUNCTIONS.minimum(1.0, 2.0) == 1.0
    assert FUNCTIONS.copysign(1.0, -2.0) == -1.0


def test_nan_is_never_known() -> None:
    (a,) = spanned([math.nan, math.nan])
    (b,) = spanned([1.0, 2.0])
    for found in (a + b, a * b, b / a, FUNCTIONS.sin(a), FUNCTIONS.minimum(a, b)):
        value, _ = parts(found)
        assert np.isnan(value.low).all()
        assert np.isnan(value.high).all()
