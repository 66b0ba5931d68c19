"""Quantities and expressions as text ("850 mm", "d2 + d3 + d4"), evaluated safely to SI.

A number followed by a unit is a quantity; every other name is a parameter, so a parameter may be
called `h` or `m`. The text is parsed by Python's own grammar and walked over a short list of
permitted nodes: nothing in it can be called, indexed or imported. Units are looked up with pint.

Dimensions are checked as exponents of length, time and angle. A bare number fits any dimension
and is taken as SI (metre, radian, second).
"""

from __future__ import annotations

import ast
import functools
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from parakin.errors import InputError, nearest

if TYPE_CHECKING:
    import pint

Value = float | int | str
Dimension = tuple[float, float, float]

BARE: Dimension = (0.0, 0.0, 0.0)
LENGTH: Dimension = (1.0, 0.0, 0.0)
TIME: Dimension = (0.0, 1.0, 0.0)
ANGLE: Dimension = (0.0, 0.0, 1.0)
FREQUENCY: Dimension = (0.0, -1.0, 0.0)

MAX_CHARACTERS = 500
_NAMES = {BARE: "a number", LENGTH: "a length", ANGLE: "an angle", TIME: "a time"} | {
    FREQUENCY: "a frequency"
}
_QUANTITY = re.compile(
    r"(?<![\w.])((?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*"
    r"((?:[^\W\d_]|°)+(?:/s(?:\^2|\*\*2|²)?)?)(?![\w.(])"
)
_SI = {"meter": 0, "second": 1, "radian": 2}


@dataclass(frozen=True)
class _Quantity:
    value: float
    dimension: Dimension


# The units of most files, so that these need not wait for the import of pint (0.2 s).
_COMMON = {
    "m": _Quantity(1.0, LENGTH),
    "mm": _Quantity(1e-3, LENGTH),
    "rad": _Quantity(1.0, ANGLE),
    "deg": _Quantity(math.pi / 180, ANGLE),
    "s": _Quantity(1.0, TIME),
    "Hz": _Quantity(1.0, FREQUENCY),
}


@functools.cache
def _registry() -> pint.UnitRegistry[Any]:
    import pint

    return pint.UnitRegistry(cache_folder=None)


@functools.cache
def _unit(name: str) -> _Quantity:
    if name in _COMMON:
        return _COMMON[name]
    try:
        base = _registry().Quantity(1.0, name.replace("²", "**2")).to_base_units()
    except Exception as error:  # pint raises many kinds, some of them not its own
        raise ValueError(f"{name!r} is not a unit") from error
    exponents = [0.0, 0.0, 0.0]
    for unit, power in base.unit_items():
        if unit not in _SI:
            raise ValueError(f"{name!r} is not a unit of length, angle or time")
        exponents[_SI[unit]] = float(power)
    return _Quantity(float(base.magnitude), (exponents[0], exponents[1], exponents[2]))


def _describe(dimension: Dimension) -> str:
    if dimension in _NAMES:
        return _NAMES[dimension]
    parts = zip(("m", "s", "rad"), dimension, strict=True)
    return "a quantity in " + " ".join(f"{unit}^{power:g}" for unit, power in parts if power)


def _same(a: _Quantity, b: _Quantity) -> Dimension:
    if a.dimension == b.dimension or b.dimension == BARE:
        return a.dimension
    if a.dimension == BARE:
        return b.dimension
    raise ValueError(f"{_describe(a.dimension)} and {_describe(b.dimension)} do not add up")


def _scaled(dimension: Dimension, factor: float) -> Dimension:
    return (dimension[0] * factor, dimension[1] * factor, dimension[2] * factor)


def _combined(a: Dimension, b: Dimension, sign: float) -> Dimension:
    return (a[0] + sign * b[0], a[1] + sign * b[1], a[2] + sign * b[2])


def _trigonometric(function: Callable[[float], float]) -> Callable[[_Quantity], _Quantity]:
    def apply(x: _Quantity) -> _Quantity:
        if x.dimension not in (ANGLE, BARE):
            raise ValueError(f"{function.__name__} takes an angle, not {_describe(x.dimension)}")
        return _Quantity(function(x.value), BARE)

    return apply


def _inverse(function: Callable[[float], float]) -> Callable[[_Quantity], _Quantity]:
    def apply(x: _Quantity) -> _Quantity:
        if x.dimension != BARE:
            raise ValueError(f"{function.__name__} takes a ratio, not {_describe(x.dimension)}")
        return _Quantity(function(x.value), ANGLE)

    return apply


_FUNCTIONS: dict[str, tuple[int, Callable[..., _Quantity]]] = {
    "sin": (1, _trigonometric(math.sin)),
    "cos": (1, _trigonometric(math.cos)),
    "tan": (1, _trigonometric(math.tan)),
    "asin": (1, _inverse(math.asin)),
    "acos": (1, _inverse(math.acos)),
    "atan": (1, _inverse(math.atan)),
    "atan2": (2, lambda y, x: (_same(y, x), _Quantity(math.atan2(y.value, x.value), ANGLE))[1]),
    "sqrt": (1, lambda x: _Quantity(math.sqrt(x.value), _scaled(x.dimension, 0.5))),
    "abs": (1, lambda x: _Quantity(abs(x.value), x.dimension)),
    "hypot": (2, lambda x, y: _Quantity(math.hypot(x.value, y.value), _same(x, y))),
}


def _binary(node: ast.BinOp, a: _Quantity, b: _Quantity) -> _Quantity:
    match node.op:
        case ast.Add():
            return _Quantity(a.value + b.value, _same(a, b))
        case ast.Sub():
            return _Quantity(a.value - b.value, _same(a, b))
        case ast.Mult():
            return _Quantity(a.value * b.value, _combined(a.dimension, b.dimension, 1.0))
        case ast.Div():
            return _Quantity(a.value / b.value, _combined(a.dimension, b.dimension, -1.0))
        case ast.Pow():
            if b.dimension != BARE:
                raise ValueError("an exponent must be a plain number")
            power = math.pow(a.value, b.value)
            return _Quantity(power, _scaled(a.dimension, b.value))
    raise ValueError("only + - * / ** may combine values")


def _walk(node: ast.AST, look_up: Callable[[str], _Quantity]) -> _Quantity:
    match node:
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            return _Quantity(float(number), BARE)
        case ast.Name(id=name):
            return look_up(name)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            x = _walk(operand, look_up)
            return _Quantity(-x.value, x.dimension)
        case ast.UnaryOp(op=ast.UAdd(), operand=operand):
            return _walk(operand, look_up)
        case ast.BinOp(left=left, right=right):
            return _binary(node, _walk(left, look_up), _walk(right, look_up))
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in _FUNCTIONS:
            arity, function = _FUNCTIONS[name]
            if len(args) != arity:
                raise ValueError(f"{name} takes {arity} argument(s), not {len(args)}")
            return function(*(_walk(arg, look_up) for arg in args))
        case ast.Call(func=ast.Name(id=name)):
            raise ValueError(f"{name!r} is not a function here; {nearest(name, _FUNCTIONS)}")
    raise ValueError("only numbers, units, parameters, + - * / ** and functions may stand here")


class Parameters:
    """Named values, each a number or an expression in the others, evaluated on demand."""

    def __init__(self, expressions: Mapping[str, Value], owner: str = "") -> None:
        self._prefix = f"{owner}: " if owner else ""
        self._expressions = dict(expressions)
        self._values: dict[str, _Quantity] = {"pi": _Quantity(math.pi, BARE)}
        self._pending: list[str] = []

    def evaluate(self, text: Value, dimension: Dimension, place: str) -> float:
        """The value of `text` in SI.

        Raises InputError, naming `place`, where it cannot be parsed or evaluated, is not finite,
        or is not of `dimension` (a bare number always is).
        """
        quantity = self._quantity(text, place)
        if quantity.dimension not in (dimension, BARE):
            raise InputError(
                place, f"{text!r}, {_describe(quantity.dimension)}", _describe(dimension)
            )
        return quantity.value

    def all(self) -> dict[str, float]:
        """Every parameter in SI, in the order given."""
        return {name: self._look_up(name).value for name in self._expressions}

    def _quantity(self, text: Value, place: str) -> _Quantity:
        if isinstance(text, str):
            quantity = self._parse(text, place)
        elif isinstance(text, bool):
            raise InputError(place, repr(text), "a number or an expression")
        else:
            try:
                quantity = _Quantity(float(text), BARE)
            except OverflowError:
                raise InputError(place, "a number beyond range", "a finite number") from None
        if not math.isfinite(quantity.value):
            raise InputError(place, f"{text!r}, which is {quantity.value}", "a finite number")
        return quantity

    def _parse(self, text: str, place: str) -> _Quantity:
        if len(text) > MAX_CHARACTERS:
            raise InputError(
                place, f"{len(text)} characters", f"an expression of at most {MAX_CHARACTERS}"
            )
        units: list[str] = []

        def mark(match: re.Match[str]) -> str:
            units.append(match[2])
            return f"({match[1]}*_unit{len(units) - 1})"

        def look_up(name: str) -> _Quantity:
            if name.startswith("_unit") and name[5:].isdigit() and int(name[5:]) < len(units):
                return _unit(units[int(name[5:])])
            return self._look_up(name)

        try:
            tree = ast.parse(_QUANTITY.sub(mark, text).strip(), mode="eval")
            return _walk(tree.body, look_up)
        except InputError:  # of a parameter it stands on: that is the place to mend
            raise
        except SyntaxError:
            reason = "it cannot be parsed"
        except ZeroDivisionError:
            reason = "it divides by zero"
        except OverflowError:
            reason = "it overflows"
        except (RecursionError, MemoryError):
            reason = "it is nested too deeply"
        except ValueError as error:
            reason = str(error)
        raise InputError(
            place, f"{text!r}: {reason}", "a number, a quantity like '850 mm' or an expression"
        )

    def _look_up(self, name: str) -> _Quantity:
        if name in self._values:
            return self._values[name]
        if name not in self._expressions:
            raise ValueError(f"unknown parameter {name!r}; {nearest(name, self._expressions)}")
        if name in self._pending:
            cycle = " -> ".join([*self._pending[self._pending.index(name) :], name])
            raise InputError(f"{self._prefix}parameters", f"the cycle {cycle}", "expressions without a cycle")
        self._pending.append(name)
        try:
            self._values[name] = self._quantity(
                self._expressions[name], f"{self._prefix}parameters.{name}"
            )
        finally:
            self._pending.pop()
        return self._values[name]
