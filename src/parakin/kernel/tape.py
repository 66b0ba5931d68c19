"""A kernel traced once into a list of operations, and played back on NumPy arrays.

What is computed twice is recorded once, what no result needs not at all, and each operation writes
into an array that is used again: so the same kernel runs several times as fast as the recursion
itself on arrays. A pose alone is played on plain numbers, with the same results to the last bit.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from parakin.algebra.spatial import FLOATS, Functions, Scalar, as_float
from parakin.arrays import FloatArray
from parakin.caching import cached_property

_TOGETHER = 1000  # columns: as many as keep what is used again near the processor


def _divided(a: float, b: float) -> float:
    return a / b if b != 0.0 else float(np.divide(a, b))


def _root(a: float) -> float:
    return math.sqrt(a) if a >= 0.0 else math.nan


def _lesser(a: float, b: float) -> float:
    if a < b:
        return a
    return b if b <= a else math.nan


# What an operation on arrays does to plain numbers; NumPy itself where rounding might differ.
_ON_NUMBERS: dict[Any, Callable[..., float]] = {
    np.add: operator.add,
    np.subtract: operator.sub,
    np.multiply: operator.mul,
    np.divide: _divided,
    np.negative: operator.neg,
    np.copysign: math.copysign,
    np.sqrt: _root,
    np.minimum: _lesser,
    np.sin: lambda a: float(np.sin(a)),
    np.cos: lambda a: float(np.cos(a)),
    np.arctan2: lambda y, x: float(np.arctan2(y, x)),
    np.power: lambda a, b: float(np.power(a, b)),
}


class Term:
    """A scalar whose arithmetic is recorded: a place on a tape."""

    __slots__ = ("place", "tape")
    __array_ufunc__ = None  # a NumPy number leaves sums and products with it to us

    def __init__(self, tape: Tape, place: int) -> None:
        self.tape, self.place = tape, place

    def __neg__(self) -> Term:
        return self.tape.let(np.negative, self)

    def __add__(self, other: Any) -> Any:
        return self._with(np.add, self, other)

    def __radd__(self, other: Any) -> Any:
        return self._with(np.add, other, self)

    def __sub__(self, other: Any) -> Any:
        return self._with(np.subtract, self, other)

    def __rsub__(self, other: Any) -> Any:
        return self._with(np.subtract, other, self)

    def __mul__(self, other: Any) -> Any:
        return self._with(np.multiply, self, other)

    def __rmul__(self, other: Any) -> Any:
        return self._with(np.multiply, other, self)

    def __truediv__(self, other: Any) -> Any:
        return self._with(np.divide, self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return self._with(np.divide, other, self)

    def __pow__(self, exponent: float) -> Term:
        return self.tape.let(np.power, self, exponent)

    def _with(self, does: Any, a: Any, b: Any) -> Any:
        if all(isinstance(x, (Term, int, float, np.number)) for x in (a, b)):
            return self.tape.let(does, a, b)
        return NotImplemented  # dual numbers know what to do with it


class Tape:
    """Operations in traced order: places of inputs come first, then those of constants and of
    results as they arise.
    """

    def __init__(self, inputs: int) -> None:
        self.inputs = [Term(self, place) for place in range(inputs)]
        self.count = inputs
        self.constants: dict[int, float] = {}
        self.operations: list[tuple[Any, tuple[int, ...], int]] = []
        self._known: dict[Any, Term] = {}

    def let(self, does: Any, *arguments: Scalar) -> Term:
        """What an operation gives."""
        key = (does, *(self.place_of(a) for a in arguments))
        if key not in self._known:
            self.operations.append((does, key[1:], self.count))
            self._known[key] = Term(self, self.count)
            self.count += 1
        return self._known[key]

    def place_of(self, a: Scalar) -> int:
        if isinstance(a, Term):
            return a.place
        value = as_float(a)
        key = (value, math.copysign(1.0, value))
        if key not in self._known:
            self.constants[self.count] = value
            self._known[key] = Term(self, self.count)
            self.count += 1
        return self._known[key].place

    def functions(self) -> Functions:
        """The elementary functions, those of constants being worked out at once."""

        def recorded(does: Any, plain: Any) -> Callable[..., Any]:
            def function(*arguments: Scalar) -> Any:
                if not any(isinstance(a, Term) for a in arguments):
                    return plain(*arguments)
                return self.let(does, *arguments)

            return function

        def atan2(y: Scalar, x: Scalar) -> Any:  # no zero is negative, as of all scalars
            return recorded(np.arctan2, FLOATS.atan2)(y + 0.0, x + 0.0)

        return Functions(
            recorded(np.sin, FLOATS.sin),
            recorded(np.cos, FLOATS.cos),
            recorded(np.sqrt, FLOATS.sqrt),
            atan2,
            recorded(np.minimum, FLOATS.minimum),
            recorded(np.copysign, FLOATS.copysign),
            lambda a: 1.0 / a,
        )


@dataclass(frozen=True)
class Program:
    """A tape cut down to what results need: operations on registers, which are used again.

    inputs: each that is needed, and its register. constants: alike. operations: what is done, to
    which registers (the second -1 if there is but one), and where the result goes. results: the
    register of each.
    """

    registers: int
    inputs: list[tuple[int, int]]
    constants: list[tuple[int, float]]
    operations: list[tuple[Any, int, int, int]]
    results: list[int]

    def play(self, inputs: FloatArray, out: FloatArray) -> None:
        """Outputs (rows, n) of inputs (k, n)."""
        with np.errstate(all="ignore"):  # what cannot be reached is NaN, and flagged as such
            for start in range(0, inputs.shape[1], _TOGETHER):
                some = slice(start, start + _TOGETHER)
                self._play(inputs[:, some], out[:, some])

    def _play(self, inputs: FloatArray, out: FloatArray) -> None:
        held: list[Any] = list(np.empty((self.registers, inputs.shape[1])))
        for row, register in self.inputs:
            held[register][:] = inputs[row]
        for register, value in self.constants:
            held[register] = np.array(value)
        for does, a, b, to in self.operations:
            if b < 0:
                does(held[a], out=held[to])
            else:
                does(held[a], held[b], out=held[to])
        for row, register in enumerate(self.results):
            out[row] = held[register]

    def play_alone(self, inputs: FloatArray, out: FloatArray) -> None:
        """Outputs (rows,) of inputs (k,), on plain numbers."""
        held = [0.0] * self.registers
        given = inputs.tolist()
        for row, register in self.inputs:
            held[register] = given[row]
        for register, value in self.constants:
            held[register] = value
        with np.errstate(all="ignore"):
            for does, a, b, to in self._on_numbers:
                held[to] = does(held[a]) if b < 0 else does(held[a], held[b])
        out[:] = [held[register] for register in self.results]

    @cached_property
    def _on_numbers(self) -> list[tuple[Callable[..., float], int, int, int]]:
        return [(_ON_NUMBERS[does], a, b, to) for does, a, b, to in self.operations]


def program(tape: Tape, results: Sequence[Scalar]) -> Program:
    """What a tape has to do for results."""
    wanted = [tape.place_of(a) for a in results]
    needed = set(wanted)
    operations = []
    for operation in reversed(tape.operations):
        if operation[2] in needed:
            operations.append(operation)
            needed.update(operation[1])
    operations.reverse()
    last = {place: k for k, (_, places, _) in enumerate(operations) for place in places}
    last |= dict.fromkeys([*wanted, *tape.constants], len(operations))  # kept to the end
    registers = _Registers({}, [])
    given = [(place, registers.take(place)) for place in range(len(tape.inputs)) if place in needed]
    constants = [
        (registers.take(place), value) for place, value in tape.constants.items() if place in needed
    ]
    made = []
    for k, (does, places, to) in enumerate(operations):
        held = [registers.of[place] for place in places]
        registers.free.extend({registers.of[place] for place in places if last[place] == k})
        made.append((does, held[0], held[1] if len(held) > 1 else -1, registers.take(to)))
    return Program(
        registers.count, given, constants, made, [registers.of[place] for place in wanted]
    )


@dataclass
class _Registers:
    """Registers by place, and those that are free again."""

    of: dict[int, int]
    free: list[int]
    count: int = 0

    def take(self, place: int) -> int:
        if self.free:
            self.of[place] = self.free.pop()
        else:
            self.of[place] = self.count
            self.count += 1
        return self.of[place]
