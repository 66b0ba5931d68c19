"""Declared limits in numbers: on the position, velocity or acceleration of a coordinate, or on a
cone angle.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import NamedTuple

from parakin.algebra.varied import nominal
from parakin.arrays import ORDERS
from parakin.errors import InputError, nearest
from parakin.model.expressions import Parameters
from parakin.model.fields import Quantity
from parakin.model.mechanism import Mechanism
from parakin.model.units import ANGLE, LENGTH, Dimension

UNLIMITED = (-math.inf, math.inf)
_LIMITED_ORDERS = ORDERS[:3]


class Limit(NamedTuple):
    """What a coordinate or cone angle (`order` 0), its velocity (1) or its acceleration (2) must
    keep within, in SI; infinite where one end is not limited.
    """

    coordinate: str
    order: int
    low: float
    high: float

    @property
    def ends(self) -> tuple[float, float]:
        """Both."""
        return self.low, self.high

    def excess(self, value: float) -> float:
        """How far a value is beyond the nearer end, negative within."""
        return max(self.low - value, value - self.high)

    @property
    def name(self) -> str:
        """`P1`, `P1.velocity`, `P1.acceleration`."""
        return f"{self.coordinate}.{ORDERS[self.order]}" if self.order else self.coordinate


def limits_of(
    mechanism: Mechanism,
    parameters: Parameters,
    angles: Mapping[str, bool],
    cones: Collection[str],
) -> tuple[Limit, ...]:
    """The mechanism's limits. angles: by coordinate, whether it is an angle; cones: cone angles.

    Raises InputError on names that do not exist, limits given twice, rates of cone angles (which
    have none where the angle is zero), values of the wrong dimension, and empty ranges.
    """
    found: dict[str, Limit] = {}
    for name, pair in mechanism.limits.items():
        place = f"{mechanism.where}: limits.{name}"
        coordinate, order = _meant(name, place, angles, cones)
        dimension = _dimension(coordinate in cones or angles[coordinate], order)
        low, high = (_end(end, parameters, dimension, place) for end in pair)
        if not low < high:
            raise InputError(place, f"[{low:g}, {high:g}]", "a lower limit below the upper one")
        if math.isinf(nominal(low)) and math.isinf(nominal(high)):
            raise InputError(place, f"[{low:g}, {high:g}]", "at least one end that is finite")
        limit = Limit(coordinate, order, low, high)
        if limit.name in found:
            raise InputError(place, "two limits", "one")
        found[limit.name] = limit
    return tuple(found.values())


def _meant(
    name: str, place: str, angles: Mapping[str, bool], cones: Collection[str]
) -> tuple[str, int]:
    """The coordinate or cone angle, and which of its derivatives is limited."""
    if name in angles or name in cones:
        return name, 0
    coordinate, _, order = name.rpartition(".")
    if order in _LIMITED_ORDERS and (coordinate in angles or coordinate in cones):
        if coordinate in cones and order != "position":
            raise InputError(place, f"a limit on the {order} of a cone angle", "one on the angle")
        return coordinate, _LIMITED_ORDERS.index(order)
    known = [*angles, *cones]
    if coordinate in angles:
        known = [f"{coordinate}.{each}" for each in _LIMITED_ORDERS]
    raise InputError(place, f"unknown coordinate {name!r}", nearest(name, known))


def _dimension(angle: bool, order: int) -> Dimension:
    return (ANGLE if angle else LENGTH)._replace(time=-float(order))


def _end(end: Quantity, parameters: Parameters, dimension: Dimension, place: str) -> float:
    """One end of a range; a bare infinity leaves it open."""
    if isinstance(end, str) and end.strip() in ("inf", "+inf", "-inf"):
        end = float(end)
    if isinstance(end, float) and math.isinf(end):
        return end
    return parameters.evaluate(end, dimension, place)
