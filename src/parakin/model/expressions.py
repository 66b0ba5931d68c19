"""Quantities and expressions as text ("850 mm", "d2 + d3 + d4"), evaluated safely to SI.

A number followed by a unit is a quantity; every other name is a parameter, so a parameter may be
called `h` or `m`. The text is parsed by Python's own parser, and only a short list of nodes is
evaluated: nothing in it can be called, indexed or imported. Units are looked up with pint.

Dimensions are checked as exponents of length, time and angle. A bare number fits any dimension
and is taken as SI (metre, radian, second).
"""

from __future__ import annotations

import ast
import keyword
import math
import re
import unicodedata
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from parakin.algebra import varied
from parakin.algebra.varied import Varied, as_number, must_be_finite, nominal
from parakin.errors import InputError, nearest
from parakin.model.units import (
    ANGLE,
    ATOM,
    BARE,
    Dimension,
    UnknownUnitError,
    compound,
    describe,
    is_unit,
)

Value = float | int | str

MAX_CHARACTERS = 500
_QUANTITY = re.compile(  # the whole number: 1e-3 is not one e (electron charge) minus 3
    rf"(?<![\w.])((?>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?))\s*"
    rf"({ATOM}(?:\s*/\s*s\*\*[23]|(?:\s*[*/·]\s*|\s+){ATOM})*)(?![\w.(])"
)


class Bare(NamedTuple):
    """A number without a unit where one with a unit may stand, taken as SI."""

    place: str
    value: float
    dimension: Dimension


@dataclass(frozen=True)
class _Quantity:
    value: float
    dimension: Dimension


class _Refusal(Exception):  # noqa: N818
    """Why an expression has no value, and what was expected instead."""

    def __init__(self, reason: str, expected: str = "") -> None:
        super().__init__(reason)
        self.expected = expected or "a number, a quantity like '850 mm' or an expression"


def _same(a: _Quantity, b: _Quantity) -> Dimension:
    if b.dimension in (a.dimension, BARE):
        return a.dimension
    if a.dimension == BARE:
        return b.dimension
    raise _Refusal(
        f"{describe(a.dimension)} and {describe(b.dimension)} do not go together",
        "values of one dimension",
    )


def _trigonometric(function: Callable[[float], float]) -> Callable[[_Quantity], _Quantity]:
    def apply(x: _Quantity) -> _Quantity:
        if x.dimension not in (ANGLE, BARE):
            raise _Refusal(f"{function.__name__} of {describe(x.dimension)}", "an angle there")
        return _Quantity(function(x.value), BARE)

    return apply


def _inverse(function: Callable[[float], float]) -> Callable[[_Quantity], _Quantity]:
    def apply(x: _Quantity) -> _Quantity:
        if x.dimension != BARE:
            found = f"{function.__name__} of {describe(x.dimension)}"
            raise _Refusal(found, "a plain number there")
        return _Quantity(function(x.value), ANGLE)

    return apply


_FUNCTIONS: dict[str, tuple[int, Callable[..., _Quantity]]] = {
    "sin": (1, _trigonometric(varied.sin)),
    "cos": (1, _trigonometric(varied.cos)),
    "tan": (1, _trigonometric(varied.tan)),
    "asin": (1, _inverse(varied.asin)),
    "acos": (1, _inverse(varied.acos)),
    "atan": (1, _inverse(varied.atan)),
    "atan2": (2, lambda y, x: (_same(y, x), _Quantity(varied.atan2(y.value, x.value), ANGLE))[1]),
    "sqrt": (1, lambda x: _Quantity(varied.sqrt(x.value), x.dimension.scaled(0.5))),
    "abs": (1, lambda x: _Quantity(abs(x.value), x.dimension)),
    "hypot": (2, lambda x, y: _Quantity(varied.hypot(x.value, y.value), _same(x, y))),
}


def _binary(node: ast.BinOp, a: _Quantity, b: _Quantity) -> _Quantity:
    match node.op:
        case ast.Add():
            return _Quantity(a.value + b.value, _same(a, b))
        case ast.Sub():
            return _Quantity(a.value - b.value, _same(a, b))
        case ast.Mult():
            return _Quantity(a.value * b.value, a.dimension.times(b.dimension))
        case ast.Div():
            return _Quantity(a.value / b.value, a.dimension.times(b.dimension, -1.0))
        case ast.Pow():
            if b.dimension != BARE:
                raise _Refusal("an exponent with a dimension", "a plain number there")
            if isinstance(b.value, Varied):
                raise _Refusal("an exponent that depends on a parameter left open", "a number")
            power = a.value**b.value if isinstance(a.value, Varied) else math.pow(a.value, b.value)
            return _Quantity(power, a.dimension.scaled(b.value))
    raise _Refusal("an operator other than + - * / **", "one of these")


def _walk(node: ast.AST, look_up: Callable[[str], _Quantity]) -> _Quantity:
    quantity = _value(node, look_up)
    if not math.isfinite(nominal(quantity.value)):  # checked for every part: 1/1e999 would hide it
        raise OverflowError
    if isinstance(node, ast.BinOp) and isinstance(node.op, (ast.Div, ast.Pow)):
        must_be_finite(quantity.value)
    return quantity


def _value(node: ast.AST, look_up: Callable[[str], _Quantity]) -> _Quantity:
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
                raise _Refusal(f"{name} of {len(args)} values", f"{arity} there")
            return function(*(_walk(arg, look_up) for arg in args))
        case ast.Call(func=ast.Name(id=name)) if name not in _FUNCTIONS:
            raise _Refusal(f"unknown function {name!r}", nearest(name, _FUNCTIONS))
    raise _Refusal(
        "it is more than arithmetic", "only numbers, units, parameters, + - * / ** and functions"
    )


def is_parameter_name(name: str) -> bool:
    """Whether `name` can be used in expressions: pi, functions and Python keywords cannot."""
    taken = name == "pi" or name in _FUNCTIONS or keyword.iskeyword(name)
    return name.isidentifier() and not taken


class Parameters:
    """Named values, each a number or an expression in the others, evaluated on demand to SI.

    owner: prefix of the places in messages, such as a file. bare: a list that takes note of
    numbers without a unit; those in which pi occurs are sure to be radians. free: by name, numbers
    in SI that stand instead of what is given here; those that vary make whatever depends on them
    vary too.
    """

    def __init__(
        self,
        expressions: Mapping[str, Value],
        owner: str = "",
        bare: list[Bare] | None = None,
        free: Mapping[str, Any] | None = None,
    ) -> None:
        self._bare = bare
        self._free = free or {}
        self._prefix = f"{owner}: " if owner else ""
        self._expressions = dict(expressions)
        self._values: dict[str, _Quantity] = {"pi": _Quantity(math.pi, BARE)}
        self._pending: list[str] = []

    def evaluate(self, text: Value, dimension: Dimension, place: str) -> float:
        """The value of `text` in SI.

        Raises InputError, naming `place`, if it cannot be parsed or evaluated, is not finite, or
        is not of `dimension` (a bare number always is). What is per angle may be given as if
        radians were none: a stiffness in N m/rad or in N m.
        """
        quantity = self._quantity(text, place)
        fitting = {dimension, BARE}
        if dimension.angle == -1:
            fitting.add(dimension._replace(angle=0.0))
        if quantity.dimension not in fitting:
            raise InputError(
                place, f"{text!r}, {describe(quantity.dimension)}", describe(dimension)
            )
        if self._bare is not None and quantity.dimension == BARE and "pi" not in str(text):
            self._bare.append(Bare(place, quantity.value, dimension))
        return quantity.value

    def all(self) -> dict[str, float]:
        """All parameters in SI, in the order given. Raises InputError."""
        return {name: self._look_up(name).value for name in self._expressions}

    def value(self, name: str) -> float:
        """A parameter in SI. Raises InputError."""
        return self._look_up(name).value

    def dimension(self, name: str) -> Dimension:
        """The dimension of a parameter; BARE for a number without a unit. Raises InputError."""
        return self._look_up(name).dimension

    def _quantity(self, text: Value, place: str) -> _Quantity:
        if isinstance(text, str):
            return self._parse(text, place)
        try:
            if isinstance(text, bool):
                raise TypeError
            value = float(text)
        except (TypeError, ValueError):
            raise InputError(place, repr(text), "a number or an expression") from None
        except OverflowError:
            raise InputError(place, "a number out of range", "a finite number") from None
        if not math.isfinite(value):
            raise InputError(place, f"{value}", "a finite number")
        return _Quantity(value, BARE)

    def _parse(self, text: str, place: str) -> _Quantity:
        if len(text) > MAX_CHARACTERS:
            raise InputError(
                place, f"{len(text)} characters", f"an expression of at most {MAX_CHARACTERS}"
            )
        units: list[_Quantity] = []
        marker = "_unit"  # stands for a unit, with a name that the text does not use
        while marker in unicodedata.normalize("NFKC", text):
            marker = f"_{marker}"

        own = frozenset((*self._expressions, "pi"))

        def mark(match: re.Match[str]) -> str:
            words = match[2].replace("**", "^")  # m/s**2
            if words in own and not is_unit(words):
                raise _Refusal(
                    f"{words!r} is a parameter, not a unit", f"{match[1]}*{words} for that"
                )
            unit, end = compound(words, own)
            rest = match[2][end:] if end < len(words) else ""
            by, factor, dimension = "*", float(unit.value), unit.dimension
            parts = round(1 / factor) if 0 < factor < 1 else 0
            if parts and 1 / parts == factor:  # 950 mm are 0.95 to the last bit
                by, factor, dimension = "/", float(parts), dimension.scaled(-1.0)
            units.append(_Quantity(factor, dimension))
            return f"({match[1]}{by}{marker}{len(units) - 1}){rest}"

        def look_up(name: str) -> _Quantity:
            if name.startswith(marker):
                return units[int(name.removeprefix(marker))]
            return self._look_up(name)

        expected = "a finite number"
        try:
            if "#" in text:
                raise _Refusal("it contains a #, which would hide the rest")
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # Python's own, about text that is refused below
                tree = ast.parse(_QUANTITY.sub(mark, text).strip(), mode="eval")
            return _walk(tree.body, look_up)
        except InputError:  # in a parameter it depends on, which is what has to be corrected
            raise
        except (_Refusal, UnknownUnitError) as refusal:
            reason, expected = str(refusal), refusal.expected
        except SyntaxError:
            reason = "it cannot be parsed"
            expected = "a number, a quantity like '850 mm' or an expression like '2*d1 + d2'"
        except ZeroDivisionError:
            reason = "it divides by zero"
        except OverflowError:
            reason = "it overflows"
        except (RecursionError, MemoryError):
            reason, expected = "it is nested too deeply", "a simpler expression"
        except ValueError:  # from a function of math, or a null character
            reason = "it has no real value"
        raise InputError(place, f"{text!r}: {reason}", expected)

    def _look_up(self, name: str) -> _Quantity:
        if name in self._values:
            return self._values[name]
        if name not in self._expressions:
            raise _Refusal(f"unknown parameter {name!r}", nearest(name, self._expressions))
        if name in self._pending:
            cycle = " -> ".join([*self._pending[self._pending.index(name) :], name])
            raise InputError(
                f"{self._prefix}parameters.{name}",
                f"the cycle {cycle}",
                "expressions without a cycle",
            )
        self._pending.append(name)
        try:
            found = self._quantity(self._expressions[name], f"{self._prefix}parameters.{name}")
            if name in self._free:
                found = _Quantity(as_number(self._free[name]), found.dimension)
            self._values[name] = found
        finally:
            self._pending.pop()
        return self._values[name]
