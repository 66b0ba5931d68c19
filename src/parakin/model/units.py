"""Units and dimensions: what a unit is in SI, and what kind of quantity it measures.

Dimensions are exponents of length, time, angle, mass and current.
"""

from __future__ import annotations

import functools
import math
import re
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NamedTuple

from parakin.errors import nearest

if TYPE_CHECKING:
    import pint


class Dimension(NamedTuple):
    """Exponents of length, time, angle, mass and current."""

    length: float = 0.0
    time: float = 0.0
    angle: float = 0.0
    mass: float = 0.0
    current: float = 0.0

    def scaled(self, factor: float) -> Dimension:
        """Of a power of the quantity."""
        return Dimension(*(factor * exponent for exponent in self))

    def times(self, other: Dimension, power: float = 1.0) -> Dimension:
        """Of the product with another quantity's power."""
        return Dimension(*(a + power * b for a, b in zip(self, other, strict=True)))


BARE = Dimension()
LENGTH = Dimension(length=1)
TIME = Dimension(time=1)
ANGLE = Dimension(angle=1)
MASS = Dimension(mass=1)
CURRENT = Dimension(current=1)
FREQUENCY = Dimension(time=-1)
VELOCITY = Dimension(length=1, time=-1)
ANGULAR_VELOCITY = Dimension(time=-1, angle=1)
ACCELERATION = Dimension(length=1, time=-2)
ANGULAR_ACCELERATION = Dimension(time=-2, angle=1)
FORCE = Dimension(length=1, time=-2, mass=1)
TORQUE = Dimension(length=2, time=-2, mass=1)
POWER = Dimension(length=2, time=-3, mass=1)
INERTIA = Dimension(length=2, mass=1)
DENSITY = Dimension(length=-3, mass=1)

_NAMES = {
    BARE: "a number",
    LENGTH: "a length",
    ANGLE: "an angle",
    TIME: "a time",
    MASS: "a mass",
    CURRENT: "a current",
    FREQUENCY: "a frequency",
    VELOCITY: "a velocity",
    ANGULAR_VELOCITY: "an angular velocity",
    ACCELERATION: "an acceleration",
    ANGULAR_ACCELERATION: "an angular acceleration",
    FORCE: "a force",
    TORQUE: "a torque",
    POWER: "a power",
    INERTIA: "a moment of inertia",
    DENSITY: "a density",
    Dimension(time=-2, mass=1): "a stiffness, such as N/m",
    Dimension(time=-1, mass=1): "a damping, such as N s/m",
    Dimension(length=-1, time=1): "a dissipation, such as s/m",
    Dimension(time=1, angle=-1): "a dissipation, such as s/rad",
}


def describe(dimension: Dimension) -> str:
    """In words: "a length", "a quantity in kg^1 s^-1"."""
    if dimension in _NAMES:
        return _NAMES[dimension]
    parts = zip(("m", "s", "rad", "kg", "A"), dimension, strict=True)
    return "a quantity in " + " ".join(f"{unit}^{power:g}" for unit, power in parts if power)


class Unit(NamedTuple):
    """How many of the SI unit it is, exactly where that is rational, and of what."""

    value: Fraction | float
    dimension: Dimension


class UnknownUnitError(Exception):
    """Why a text is no unit, and what was expected instead."""

    def __init__(self, reason: str, expected: str) -> None:
        super().__init__(reason)
        self.expected = expected


# The units in most files, which need not wait for the import of pint (0.2 s).
_COMMON: dict[str, Unit] = {
    "m": Unit(Fraction(1), LENGTH),
    "mm": Unit(Fraction(1, 1000), LENGTH),
    "cm": Unit(Fraction(1, 100), LENGTH),
    "rad": Unit(Fraction(1), ANGLE),
    "deg": Unit(math.pi / 180, ANGLE),
    "s": Unit(Fraction(1), TIME),
    "Hz": Unit(Fraction(1), FREQUENCY),
    "kg": Unit(Fraction(1), MASS),
    "g": Unit(Fraction(1, 1000), MASS),
    "N": Unit(Fraction(1), FORCE),
    "kN": Unit(Fraction(1000), FORCE),
    "Nm": Unit(Fraction(1), TORQUE),  # to pint a count of textile threads
    "W": Unit(Fraction(1), POWER),
    "kW": Unit(Fraction(1000), POWER),
    "A": Unit(Fraction(1), CURRENT),
}

# Listed in messages; any other unit that pint knows is accepted too.
_USUAL = (
    *("m", "mm", "cm", "um", "in", "ft", "rad", "mrad", "deg", "s", "ms", "min", "Hz", "rpm"),
    *("kg", "g", "t", "lb", "N", "kN", "lbf", "Nm", "W", "kW", "A", "mA"),
)
_BASE = {"meter": 0, "second": 1, "radian": 2, "kilogram": 3, "ampere": 4}

ATOM = r"(?:[^\W\d_]|°)+(?:\^-?\d|[²³])?"  # mm, s^2, m³
_PARTS = re.compile(rf"\s*([*/·]?)\s*({ATOM})")
_POWERS = {"²": 2, "³": 3}


@functools.cache
def _registry() -> pint.UnitRegistry[Any]:
    import pint

    return pint.UnitRegistry(cache_folder=None)


@functools.cache
def _named(name: str) -> Unit:
    """A unit without powers, by its name."""
    if name in _COMMON:
        return _COMMON[name]
    try:
        base = _registry().Quantity(1.0, name).to_base_units()
        twice = _registry().Quantity(2.0, name).to_base_units()
        linear = abs(twice.magnitude - 2 * base.magnitude) <= 1e-12 * abs(twice.magnitude)
        if not linear:  # degC, dBm
            raise ValueError
    except Exception:  # pint raises many kinds, some of them not its own
        raise UnknownUnitError(f"{name!r} is not a unit", nearest(name, _USUAL)) from None
    exponents = [0.0] * 5
    powers: dict[str, Any] = dict(base.unit_items())
    for unit, power in powers.items():
        if unit not in _BASE:
            what = "length, time, angle, mass or current"
            raise UnknownUnitError(f"{name!r} is not a unit of {what}", nearest(name, _USUAL))
        exponents[_BASE[unit]] = float(power)
    magnitude: Any = base.magnitude
    return Unit(float(magnitude), Dimension(*exponents))


def atom(text: str) -> Unit:
    """A unit, to a power or not: "mm", "s^2", "m³". Raises UnknownUnitError."""
    power = 1
    if text[-1] in _POWERS:
        text, power = text[:-1], _POWERS[text[-1]]
    elif "^" in text:
        text, _, exponent = text.partition("^")
        power = int(exponent)
    unit = _named(text)
    return Unit(unit.value**power, unit.dimension.scaled(power))


def is_unit(text: str) -> bool:
    """Whether there is such a unit."""
    try:
        atom(text)
    except UnknownUnitError:
        return False
    return True


def compound(text: str, stop: frozenset[str]) -> tuple[Unit, int]:
    """Units multiplied and divided, "kg m^2", "N*s/m", and how many characters of the text they
    are: a product or quotient with one of the names `stop` or with what is no unit is not theirs.
    Raises UnknownUnitError on a first word that is none, and on others that stand beside it.
    """
    value: Fraction | float = Fraction(1)
    dimension, end = BARE, 0
    for match in _PARTS.finditer(text):
        operator, name = match.groups()
        of_time = operator == "/" and name[0] == "s" and not name[1:].isalpha()
        if operator and not of_time and (name in stop or not is_unit(name)):
            break
        unit, power = atom(name), -1 if operator == "/" else 1
        value = value * unit.value**power
        dimension, end = dimension.times(unit.dimension, power), match.end()
    return Unit(value, dimension), end
