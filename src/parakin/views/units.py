"""The units that coordinates are shown in: millimetres and degrees."""

from __future__ import annotations

import math
from typing import NamedTuple

PER_TIME = ("", "/s", "/s²", "/s³")  # what an order of derivative adds to a unit


class Unit(NamedTuple):
    """A unit by its names in plain and in set text, and how many of it make one SI unit."""

    plain: str
    set: str
    per_si: float

    def written(self, value: float, digits: int = 4) -> str:
        """A value in SI with this unit, in plain text."""
        return f"{self.per_si * value:z.{digits}f} {self.plain}"


MILLIMETRES = Unit("mm", " mm", 1e3)
DEGREES = Unit("deg", "°", math.degrees(1.0))


def unit_of(angle: bool) -> Unit:
    """The unit of a length or an angle."""
    return DEGREES if angle else MILLIMETRES
