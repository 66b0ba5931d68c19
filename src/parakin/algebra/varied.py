"""Numbers that vary from design to design, so that dimensions can be left open.

What a mechanism's dimensions are worked out from may be left open: a parameter is then a scalar of
whatever kind the kernel computes with, together with its value in a few designs. By these values
decisions are taken (the first design is the file's own), and what comes out the same in all of them
is a plain float again, so that structural zeros survive and a parameter that merely happens to be
zero does not become one. Every decision is recorded, to be checked in every design that is asked
for.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from parakin.algebra.spatial import Functions, Scalar, add, mul, sub
from parakin.arrays import FloatArray

_SAME = 4e-16  # of what a number is made of: values that differ by no more are the same


class Condition(NamedTuple):
    """A decision: whether `margin` is above zero, or, not `strict`, at least zero; or, where
    `finite`, that it is a finite number, which it has to be in any design.
    """

    margin: Scalar
    strict: bool
    holds: bool
    finite: bool = False


@dataclass(frozen=True)
class Record:
    """The elementary functions of the scalars in use, and the decisions taken so far."""

    functions: Functions
    conditions: list[Condition] = field(default_factory=list)


class Varied:
    """A scalar and its values in a few designs (designs,), the first being the file's own."""

    __slots__ = ("record", "scalar", "values")
    __array_ufunc__ = None  # nothing of NumPy may take it for a number

    def __init__(self, values: FloatArray, scalar: Scalar, record: Record) -> None:
        self.values, self.scalar, self.record = values, scalar, record

    def __float__(self) -> float:
        raise TypeError("a number that is left open has no single value")

    def __add__(self, other: Any) -> Any:
        return self._with(other, np.add, add)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        return self._with(other, np.subtract, sub)

    def __rsub__(self, other: Any) -> Any:
        return (-self) + other

    def __neg__(self) -> Any:
        return varied(-self.values, sub(0.0, self.scalar), self.record)

    def __mul__(self, other: Any) -> Any:
        return self._with(other, np.multiply, mul)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        return self._with(other, np.divide, lambda a, b: a / b)

    def __rtruediv__(self, other: Any) -> Any:
        return self._with(other, lambda a, b: b / a, lambda a, b: b / a)

    def __pow__(self, exponent: float) -> Any:
        scalar: Any = self.scalar
        power = self.record.functions.sqrt(scalar) if exponent == 0.5 else scalar**exponent
        with np.errstate(all="ignore"):
            return varied(self.values**exponent, power, self.record)

    def __abs__(self) -> Any:
        side: Scalar = self.record.functions.copysign(1.0, self.scalar)
        return varied(np.abs(self.values), mul(side, self.scalar), self.record)

    def __lt__(self, other: Any) -> bool:
        return self._decided(other, below=True, strict=True)

    def __gt__(self, other: Any) -> bool:
        return self._decided(other, below=False, strict=True)

    def __le__(self, other: Any) -> bool:
        return self._decided(other, below=True, strict=False)

    def __ge__(self, other: Any) -> bool:
        return self._decided(other, below=False, strict=False)

    def _with(self, other: Any, values: Callable[..., Any], scalars: Callable[..., Any]) -> Any:
        if not isinstance(other, (Varied, float, int)):
            return NotImplemented
        with np.errstate(all="ignore"):  # what has no value in some design is NaN there
            found = values(self.values, values_of(other))
        of = np.maximum(np.abs(self.values), np.abs(values_of(other)))
        terms = float(np.nan_to_num(of).max()) if values in (np.add, np.subtract) else 0.0
        return varied(found, scalars(self.scalar, scalar_of(other)), self.record, terms)

    def _decided(self, other: Any, *, below: bool, strict: bool) -> bool:
        margin = sub(scalar_of(other), self.scalar) if below else sub(self.scalar, scalar_of(other))
        value = nominal(other) - nominal(self) if below else nominal(self) - nominal(other)
        holds = value > 0.0 if strict else value >= 0.0
        self.record.conditions.append(Condition(margin, strict, holds))
        return holds


def varied(values: FloatArray, scalar: Scalar, record: Record, terms: float = 0.0) -> Any:
    """A number that varies, or a float where it is the same in all designs. terms: the size of
    those that it is the sum of.
    """
    first = float(values[0])
    same = bool(np.abs(values - first).max() <= _SAME * max(terms, abs(first)))  # false of NaN
    return first if same else Varied(values, scalar, record)


def must_be_finite(a: Any) -> None:
    """Record that a number has to be finite, if it varies."""
    if isinstance(a, Varied):
        a.record.conditions.append(Condition(a.scalar, strict=False, holds=True, finite=True))


def values_of(a: Any) -> Any:
    """The values of a number in the designs, or the number itself."""
    return a.values if isinstance(a, Varied) else a


def scalar_of(a: Any) -> Any:
    """What a number is computed as."""
    return a.scalar if isinstance(a, Varied) else a


def nominal(a: Any) -> float:
    """A number in the file's own design."""
    return float(a.values[0]) if isinstance(a, Varied) else float(a)


def as_number(a: Any) -> Any:
    """A float, unless it varies."""
    return a if isinstance(a, Varied) else float(a)


def _tangent(functions: Functions, a: Scalar) -> Scalar:
    ratio: Scalar = functions.sin(a) / functions.cos(a)
    return ratio


def _across(functions: Functions, a: Scalar) -> Scalar:
    """The leg beside `a` in a right triangle whose hypotenuse is 1."""
    root: Scalar = functions.sqrt(mul(sub(1.0, a), add(1.0, a)))
    return root


# By the name of a function in `math`: the same on arrays, and on any scalar.
_LIFTED: dict[str, tuple[Callable[..., Any], Callable[..., Any]]] = {
    "sin": (np.sin, lambda f, a: f.sin(a)),
    "cos": (np.cos, lambda f, a: f.cos(a)),
    "tan": (np.tan, _tangent),
    "asin": (np.arcsin, lambda f, a: f.atan2(a, _across(f, a))),
    "acos": (np.arccos, lambda f, a: f.atan2(_across(f, a), a)),
    "atan": (np.arctan, lambda f, a: f.atan2(a, 1.0)),
    "atan2": (np.arctan2, lambda f, y, x: f.atan2(y, x)),
    "sqrt": (np.sqrt, lambda f, a: f.sqrt(a)),
}


def lifted(function: Callable[..., float]) -> Callable[..., Any]:
    """One of `math`'s functions, on numbers that vary too."""
    name = function.__name__
    on_values, on_scalars = _LIFTED[name]

    def applied(*numbers: Any) -> Any:
        record = next((a.record for a in numbers if isinstance(a, Varied)), None)
        if record is None:
            return function(*numbers)
        with np.errstate(all="ignore"):
            values = on_values(*map(values_of, numbers))
        return varied(values, on_scalars(record.functions, *map(scalar_of, numbers)), record)

    applied.__name__ = name
    return applied


sin, cos, tan = lifted(math.sin), lifted(math.cos), lifted(math.tan)
asin, acos, atan = lifted(math.asin), lifted(math.acos), lifted(math.atan)
atan2, sqrt = lifted(math.atan2), lifted(math.sqrt)


def hypot(*numbers: Any) -> Any:
    """As `math.hypot`, on numbers that vary too."""
    if not any(isinstance(a, Varied) for a in numbers):
        return math.hypot(*numbers)
    total: Any = 0.0
    for a in numbers:
        total = total + a * a
    return sqrt(total)
