"""What has to be kept throughout a box of poses, and whether it is proved of one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from parakin.arrays import BoolArray, FloatArray
from parakin.design.bounds import Bounds, speed_bounds
from parakin.design.enclosing import Enclosed, Enclosing, least_firmness
from parakin.design.strength import Firmness
from parakin.errors import InputError
from parakin.solving.charts import Chart
from parakin.solving.solver import Solver
from parakin.solving.status import SINGULAR


class Positions(NamedTuple):
    """Limits on positions, by row: names, whether a cone angle, whose cosine is enclosed, and what
    it has to be between (m,), and the numbers of the stops.
    """

    names: tuple[str, ...]
    cone: BoolArray
    low: FloatArray
    high: FloatArray
    numbers: tuple[int, ...]

    def angles(self, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
        """What encloses each row (m,), with the angles of cosines."""
        with np.errstate(invalid="ignore"):  # what is not known stays so
            least, most = (np.arccos(np.clip(end, -1.0, 1.0)) for end in (high, low))
        return np.where(self.cone, least, low), np.where(self.cone, most, high)


@dataclass(frozen=True)
class Requirement:
    """Rows of `enclosing` are those of the positions, then of the actuators, if they have to be
    held, then of what is limited in its velocity, at `speeds` (k,). least: of conditioning.
    """

    solver: Solver
    enclosing: Enclosing
    positions: Positions
    firmness: Firmness
    fast: Bounds
    speeds: FloatArray
    least: float

    def kept(self, found: Enclosed) -> BoolArray:
        """What is proved of n boxes (rows, n): limits, conditioning, limits of velocities. What is
        not known is not proved.
        """
        m, held = len(self.positions.names), len(self.firmness.actuated)
        within = found.low[:m] >= self.positions.low[:, None]
        within &= found.high[:m] <= self.positions.high[:, None]
        regular = self.firmness.chart.relative_regularity
        firm = regular * np.sqrt(np.where(found.least > 0.0, found.least, 0.0))
        if held:
            rates = (found.rate_low[m : m + held], found.rate_high[m : m + held])
            firm = np.minimum(
                firm, least_firmness(*map(self.firmness.scaled, rates)) / abs(self.firmness.home)
            )
        most = self._fast(found.steepest)
        slow = (most <= self.fast.high[:, None]) & (-most >= self.fast.low[:, None])
        return np.concatenate([within, (firm >= self.least)[None], slow])

    def too_fast(self, found: Enclosed) -> tuple[str, int] | None:
        """A limit of velocities that no pose of a box keeps, and the number of that; None if there
        is none.
        """
        least = self._fast(found.gentlest)
        above, below = least > self.fast.high[:, None], -least < self.fast.low[:, None]
        broken = above | below
        if not broken.any():
            return None
        row, box = np.argwhere(broken)[0].tolist()
        return self.fast.words(row, upper=bool(above[row, box])), box

    def _fast(self, rates: FloatArray) -> FloatArray:
        """Of what is limited in its velocity, by rates of all rows either way (rows, n)."""
        first = len(self.positions.names) + len(self.firmness.actuated)
        return np.asarray((rates[first:] * self.speeds[:, None]).sum(axis=1), dtype=float)

    def spread(self, found: Enclosed, kept: BoolArray, radius: FloatArray) -> FloatArray:
        """How much each driven coordinate's half a side, (k, n), moves what is not proved of n
        boxes, at most, as a part of what it may move by (k, n). NaN where rates are not known.
        """
        m = len(self.positions.names)
        room = self.positions.high - self.positions.low
        room = np.where(np.isfinite(room), room, 1.0)
        moved = found.steepest[:m] / room[:, None, None] * radius
        moved = np.where(kept[:m, None], 0.0, moved)
        return np.asarray(np.max(moved, axis=0, initial=0.0), dtype=float)

    def reason(self, found: Enclosed, kept: BoolArray, box: int) -> str:
        """What is not proved of a box, of several the first: "P6 > 1.26 m"."""
        row, m = int(np.argmin(kept[:, box])), len(self.positions.names)
        if row == m:
            return f"conditioning < {self.least:g}"
        if row > m:
            fast = row - m - 1
            within = self._fast(found.steepest)[fast, box] <= self.fast.high[fast]
            return self.fast.words(fast, upper=not within)
        beyond = not found.high[row, box] <= self.positions.high[row]
        upper = beyond ^ bool(self.positions.cone[row])
        return self.solver.stops.limit_words(self.positions.numbers[row], upper=upper)


def requirement_of(solver: Solver, least: float | None, speeds: FloatArray | None) -> Requirement:
    """Of a solver's limits. speeds: of driven coordinates (k,), if limits of velocities count.

    Raises InputError where loops are solved by iteration, or home is singular.
    """
    plan, firmness = solver.plan, Firmness(solver).check(solver)
    if plan.iterated:
        names = ", ".join(plan.graph.coordinates[k].name for k in plan.iterated)
        where, found = solver.mechanism.where, f"{names}, found by iteration"
        raise InputError(where, found, "loops with closed forms, which alone are enclosed")
    rows, limits = _positions(solver, firmness.chart)
    fast = speed_bounds(solver.graph)
    if speeds is None:
        fast = Bounds((), np.empty(0), np.empty(0), fast.stops)
    enclosing = Enclosing(plan, (*rows, *firmness.actuated, *fast.coordinates))
    speeds = np.zeros(len(plan.driven)) if speeds is None else speeds
    least = SINGULAR if least is None else least
    return Requirement(solver, enclosing, limits, firmness, fast, speeds, least)


def _positions(solver: Solver, chart: Chart) -> tuple[list[int | str], Positions]:
    """What is limited: its rows, and what they have to be between, but for rounding."""
    coordinates, limits = chart.outputs.coordinates, chart.limits
    rows: list[int | str] = []
    found: list[tuple[bool, float, float, int]] = []
    for number, row, low, high, slack in zip(
        *(limits.numbers.tolist(), limits.rows.tolist(), limits.low, limits.high, limits.slack),
        strict=True,
    ):
        if row >= len(coordinates):  # a limit on a rate
            continue
        rows.append(coordinates[row])
        least, most = float(low - slack), float(high + slack)
        cone = isinstance(coordinates[row], str)
        if cone:  # of cosines, which fall as the angle grows
            least, most = (
                -np.inf if most >= np.pi else float(np.cos(most)),
                np.inf if least <= 0.0 else float(np.cos(least)),
            )
        found.append((cone, least, most, number))
    cones, least_of, most_of, numbers = zip(*found, strict=True) if found else ((),) * 4
    names = tuple(solver.stops.names[number] for number in numbers)
    ends = np.array(least_of, dtype=float), np.array(most_of, dtype=float)
    return rows, Positions(names, np.array(cones, dtype=bool), *ends, tuple(numbers))
