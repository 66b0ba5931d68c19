"""The units that coordinates are shown in: millimetres and degrees."""

from __future__ import annotations

import math
from typing import NamedTuple


class Unit(NamedTuple):
    """A unit: its name in plain text, its symbol as it follows a number, and how many make one SI
    unit.
    """

    name: str
    symbol: str
    per_si: float

    def plain(self, value: float, form: str = ".4f", per: str = "") -> str:
        """A value in SI, in this unit, for a terminal."""
        return f"{self.per_si * value:z{form}} {self.name}{per}"

    def typeset(self, value: float, form: str = ".3f", per: str = "") -> str:
        """A value in SI, in this unit, for a page or figure."""
        return f"{self.per_si * value:z{form}}{self.symbol}{per}"


MILLIMETRES = Unit("mm", " mm", 1e3)
DEGREES = Unit("deg", "°", math.degrees(1.0))


def unit_of(angle: bool) -> Unit:
    """The unit of an angle or a length."""
    return DEGREES if angle else MILLIMETRES
