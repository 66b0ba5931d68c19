"""What `at` is given: driven values with their rates, and guesses; their shapes and soundness."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from parakin.algebra.angles import nearest_angle
from parakin.arrays import BoolArray, FloatArray, IndexArray
from parakin.caching import cached_property
from parakin.errors import InputError
from parakin.kernel.outputs import Outputs
from parakin.solving.status import TURNS, Layout, Status
from parakin.solving.tick import Tick

WILD = 1e100  # numbers beyond this may overflow on the way to accelerations


class Start(NamedTuple):
    """A guess: positions as reported, iterated coordinates, and, if they are known, angles that are
    limited and not reported.
    """

    position: FloatArray
    iterated: FloatArray
    turned: FloatArray | None = None


def turning_rows(
    layout: Layout, outputs: Outputs, reported: int, known: Collection[int | str]
) -> IndexArray:
    """Rows of angles that are not reported, but known, by their full turns."""
    rows = layout.angles.tolist()
    found = [row for row in rows if row >= reported and outputs.coordinates[row] in known]
    return np.array(found, dtype=np.intp)


def refuse_lean(outputs: Outputs) -> None:
    """Raises InputError on a solver that cannot follow motions."""
    if outputs.derivatives < 2 or not outputs.checks:
        found = "one compiled without accelerations or checks"
        raise InputError("solver", found, "one with derivatives=2 and checks=True; or use `at`")


def stacked(
    count: int, derivatives: int, y: ArrayLike, rates: Sequence[ArrayLike | None]
) -> FloatArray:
    """Values of `count` driven coordinates and as many `derivatives`, one below the other, zero
    where not given. Raises InputError on arrays of the wrong shape.
    """
    short = _stacked_alone(count, (y, *rates[:derivatives]))
    if short is not None:
        return short
    first = _numbers(y, "y")
    if first.ndim not in (1, 2) or first.shape[0] != count:
        raise InputError(
            "y", f"shape {first.shape}", f"({count},) or ({count}, n): one row per driven"
        )
    parts = [first]
    names = ("yd", "ydd", "yddd")
    for name, given in zip(names[:derivatives], rates, strict=False):
        part = np.zeros_like(first) if given is None else _numbers(given, name)
        if part.shape != first.shape:
            raise InputError(name, f"shape {part.shape}", f"{first.shape}, that of y")
        parts.append(part)
    return np.ascontiguousarray(np.concatenate(parts) if len(parts) > 1 else first)


def _stacked_alone(count: int, parts: Sequence[object]) -> FloatArray | None:
    """The same of arrays for one pose, as a control loop has them, for which all else would take as
    long as the kernel; None of anything else.
    """
    for part in parts:
        if type(part) is not np.ndarray or part.shape != (count,):
            return None
    whole: FloatArray = np.concatenate(parts)  # type: ignore[arg-type]
    return whole if whole.dtype == np.float64 else None


def all_bounded(*numbers: FloatArray) -> bool:
    """Whether all are numbers, and none so large that accelerations might overflow."""
    if numbers[0].ndim == 1:
        for some in numbers:  # noqa: SIM110  # a generator would take as long as the rest
            if not math.hypot(*some.tolist()) < WILD:  # true of NaN
                return False
        return True
    with np.errstate(over="ignore", invalid="ignore"):
        for some in numbers:
            flat = some.ravel()
            # Not by BLAS: its threads hold a lock that would hang a process forked meanwhile.
            if not np.einsum("i,i->", flat, flat) < WILD * WILD:
                return False
    return True


def _numbers(values: ArrayLike, name: str) -> FloatArray:
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(name, str(error), "numbers") from None


def _distance(one: FloatArray, other: FloatArray) -> float:
    return math.dist(one.tolist(), other.tolist())


@dataclass(frozen=True)
class Guesses:
    """How a solver reads guesses. home: positions of reported coordinates there. iterated: names of
    those that need a guess; hidden: which of them are not reported. turning: rows of angles
    that are limited or have springs, and are not reported.
    """

    layout: Layout
    home: FloatArray
    iterated: tuple[str, ...]
    hidden: tuple[str, ...]
    turning: IndexArray

    def start_of(self, guess: ArrayLike | Tick, shape: tuple[int, ...]) -> Start:
        """A guess in parts. Raises InputError where it does not fit poses of this shape."""
        tick = guess if isinstance(guess, Tick) else None
        n = self.layout.reported
        if type(guess) is np.ndarray and guess.shape == (n, *shape) and not self.hidden:
            return Start(guess, guess[self.layout.iterated[0]] if self.iterated else guess[:0])
        position = _numbers(guess, "guess") if tick is None else self._defined(tick)  # type: ignore[arg-type]
        if position.shape not in ((n,), (n, *shape)):
            each = f" or ({n}, {shape[0]})" if shape else ""
            expected = f"({n},){each}: one row per coordinate"
            raise InputError("guess", f"shape {position.shape}", expected)
        if self.hidden and tick is None:
            names = ", ".join(self.hidden)
            expected = f"a Tick, since {names} are iterated and not among the coordinates"
            raise InputError("guess", "positions alone", expected)
        turned = None
        if tick is not None and len(self.turning) and len(tick.turned) == len(self.turning):
            turned = tick.turned
        if not self.iterated:
            return Start(position, position[:0], turned)
        if tick is None or not (self.hidden or len(tick.iterated)):
            return Start(position, position[self.layout.iterated[0]], turned)
        if tick.iterated.shape != (len(self.iterated), *position.shape[1:]):
            raise InputError("guess", "a Tick of another solver", "one of this solver's own")
        return Start(position, tick.iterated, turned)

    def _defined(self, tick: Tick) -> FloatArray:
        """Positions of a tick, those angles at home that are not defined there."""
        if type(tick.status) is int and tick.status != Status.ANGLES_UNDEFINED:
            return tick.position
        undefined = np.asarray(tick.status) == Status.ANGLES_UNDEFINED
        if not undefined.any():
            return tick.position
        home = self.home if tick.position.ndim == 1 else self.home[:, None]
        return np.where(undefined & np.isnan(tick.position), home, tick.position)

    def turned_to(self, out: FloatArray, start: Start) -> bool:
        """Turn angles to within half a turn of the guess. Returns whether all guesses are sound,
        as far as a glance shows.
        """
        rows, guess, alone = self._angles, start.position, out.ndim == 1
        if start.turned is not None:
            near = start.turned[:, None] if start.turned.ndim < out.ndim else start.turned
            out[self.turning] = nearest_angle(out[self.turning], to=near)
        if alone and not self.hidden and _distance(guess, out[: len(guess)]) <= 3.0:
            return True  # which is false of NaN
        if len(rows):
            near = guess[:, None] if guess.ndim < out.ndim else guess
            if not np.abs(near[rows] - out[rows]).max(initial=0.0) <= np.pi:  # true of NaN too
                out[rows] = nearest_angle(out[rows], to=near[rows])
                return False
        return all_bounded(guess, start.iterated) if self.hidden else all_bounded(guess)

    def sound(self, inputs: FloatArray, start: Start | None) -> BoolArray:
        """Which columns are numbers, and in a guess have not lost the digits of their turns."""
        finite: BoolArray = np.logical_and.reduce(np.isfinite(inputs.reshape(len(inputs), -1)))
        if start is None:
            return finite
        guess, found = (a if a.ndim == 2 else a[:, None] for a in start[:2])
        numbers = np.concatenate([guess, found])
        angles = np.abs(guess[self._angles])
        sound: BoolArray = np.isfinite(numbers).all(axis=0)
        return finite & sound & (angles < 2 * np.pi * TURNS).all(axis=0)

    @cached_property
    def _angles(self) -> IndexArray:
        rows: IndexArray = self.layout.angles[self.layout.angles < self.layout.reported]
        return rows
