"""The angle of a point, without a branch, for machine code that works on many at once."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

# (atan t / t - 1) / t² as a polynomial in t², up to t = tan(π/8): interpolated at Chebyshev nodes
# in 60 digits, off by 5e-18 of the arc. (Its first coefficients are those of the series.)
_SERIES = (
    -0.3333333333333333,
    0.19999999999995438,
    -0.1428571428464918,
    0.1111111101386139,
    -0.09090904521500148,
    0.07692181876696624,
    -0.06664492955081326,
    0.058579884306572266,
    -0.05084610777582189,
    0.0392074453205456,
    -0.01914726376323698,
)
_FLAT = math.tan(math.pi / 8.0)
_LEAST = 5e-324  # what keeps the origin from being 0 / 0


def atan2(
    y: Any, x: Any, select: Callable[[Any, Any, Any], Any], less: Callable[[Any, Any], Any]
) -> Any:
    """The angle of a point (x, y) from the x axis, in (-π, π], within 2.5 units in the last place.

    select: of a condition, what holds where it is true, and where not; less: whether one is below
    another. Zeros have no sign: at y = 0, x < 0 it is π, at the origin 0. Where a coordinate is
    infinite it is the limit if there is one, else NaN. Coordinates beyond 8e307 are too large.
    """
    left, below = less(x, 0.0), less(y, 0.0)
    wide, high = select(left, -x, x), select(below, -y, y)
    steep = less(wide, high)
    short, long = select(steep, wide, high), select(steep, high, wide)
    turned = less(_FLAT * long, short)  # by an eighth of a turn, to be within π/8
    over, under = select(turned, short - long, short), select(turned, short + long, long)
    t = over / (under + _LEAST)
    square = t * t
    series = _SERIES[-1] * square + _SERIES[-2]
    for coefficient in _SERIES[-3::-1]:
        series = series * square + coefficient
    arc = t + t * (square * series)
    arc = select(turned, arc + math.pi / 4.0, arc)
    arc = select(steep, math.pi / 2.0 - arc, arc)
    arc = select(left, math.pi - arc, arc)
    return select(below, -arc, arc)
