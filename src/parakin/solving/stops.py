"""What stops a mechanism: limits that its file declares, and loops that cannot be closed.

Stops have numbers: 0 is none, then come the limits, then the loops of a plan's blocks. Results
carry the number for every sample, and by how much a limit is exceeded.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from parakin.arrays import PER_TIME, BoolArray, FloatArray, IndexArray
from parakin.caching import cached_property
from parakin.kernel.outputs import Outputs
from parakin.kinematics.loops import sides
from parakin.kinematics.recursion import Circuits
from parakin.model.graph import Graph
from parakin.model.limits import Limit
from parakin.planning.plan import Block, Plan

_ROUNDING = 1e-12  # of a limit, and of its unit: beyond it by less is rounding


@dataclass(frozen=True)
class Stops:
    """By number, what can stop a mechanism.

    names: "", "P1", "P1.velocity", "B.cone", ..., "limb A1, B1, C1", ... units: of limits, in SI;
    low, high: the limits, NaN for what is none. joints: the names of those concerned. blocks: by
    block of the plan, the number of its loops.
    """

    names: tuple[str, ...] = ("",)
    units: tuple[str, ...] = ("",)
    low: tuple[float, ...] = (math.nan,)
    high: tuple[float, ...] = (math.nan,)
    joints: tuple[tuple[str, ...], ...] = ((),)
    blocks: tuple[int, ...] = ()

    def most_like(self, joints: tuple[str, ...]) -> int:
        """The number of the loops that share most joints with these; 0 if none shares any."""
        shared = {number: len({*joints} & {*self.joints[number]}) for number in self.blocks}
        best = max(shared, key=lambda number: shared[number], default=0)
        return best if shared.get(best) else 0

    def limit_words(self, number: int, *, upper: bool) -> str:
        """An end of a limit that was met, "P6 > 1.260 m", or a loop, "limb A1, B1, C1"."""
        name, unit = self.names[number], self.units[number]
        if not unit:
            return name
        per_si, shown = 1.0, f" {unit}"
        if unit.startswith("rad"):
            per_si, shown = math.degrees(1.0), unit.replace("rad", "°")
        end = per_si * (self.high if upper else self.low)[number]
        return f"{name} {'>' if upper else '<'} {end:z.6g}{shown}"

    def words(self, number: int, excess: float) -> str:
        """For example "P6 at 1.262 m, limit 1.260 m" or "limb A1, B1, C1 cannot reach"; "" for
        none.
        """
        name, unit = self.names[number], self.units[number]
        if not unit:
            return name and f"{name} cannot {'reach' if name.startswith(_LIMB) else 'close'}"
        per_si, shown = 1.0, f" {unit}"
        if unit.startswith("rad"):
            per_si, shown = math.degrees(1.0), unit.replace("rad", "°")
        end = per_si * (self.high if excess > 0.0 else self.low)[number]
        by = per_si * excess
        # As many digits as tell the two apart.
        digits = min(max(3, -math.floor(math.log10(abs(by)))), 15) if by else 3
        return f"{name} at {end + by:z.{digits}f}{shown}, limit {end:z.{digits}f}{shown}"


_LIMB, _LOOP = "limb", "loop"


def stops_of(plan: Plan) -> Stops:
    """The limits of a plan's mechanism, and the loops of each of its blocks."""
    graph = plan.graph.plain
    rows: list[tuple[str, str, float, float, tuple[str, ...]]] = [("", "", math.nan, math.nan, ())]
    for limit in graph.limited:
        joint = graph.joints[graph.holder(limit.coordinate)].name
        rows.append((limit.name, _unit(graph, limit), limit.low, limit.high, (joint,)))
    blocks: list[int] = []
    for block in plan.blocks:
        joints = _joints(plan, block)
        named = tuple(graph.joints[k].name for k in joints if k != graph.platform)
        kind = _LIMB if graph.platform in joints else _LOOP
        several = "s" if len({row.cut for row in block.rows}) > 1 else ""
        row = (f"{kind}{several} {', '.join(named)}", "", math.nan, math.nan, named)
        if row[0] not in (known[0] for known in rows):
            rows.append(row)
        blocks.append([known[0] for known in rows].index(row[0]))
    names, units, low, high, concerned = zip(*rows, strict=True)
    return Stops(names, units, low, high, concerned, tuple(blocks))


def _joints(plan: Plan, block: Block) -> list[int]:
    """The joints of a block's loops, those cut among them, in the order of the file."""
    graph, circuits = plan.graph, Circuits(plan.graph, plan.tree)
    cuts = {row.cut for row in block.rows}
    along = {graph.coordinates[k].joint for cut in cuts for k in sides(circuits, cut)}
    return [k for k in sorted(cuts | along) if k < len(graph.plain.joints)]


def beyond_limits(graph: Graph, positions: Mapping[str, float]) -> tuple[str, ...]:
    """The names of the limits on positions and cone angles that these exceed; NaN does."""
    return tuple(limit.name for limit in exceeded(graph, positions))


def exceeded(graph: Graph, positions: Mapping[str, float]) -> list[Limit]:
    """These limits themselves."""
    return [
        limit
        for limit in graph.limited
        if limit.order == 0 and not keeps(graph, limit, positions[limit.coordinate])
    ]


def beyond_words(graph: Graph, positions: Mapping[str, float]) -> list[str]:
    """Each of these limits in words: "P6 at 1.262 m, limit 1.260 m"."""
    words = []
    for limit in exceeded(graph, positions):
        value, unit = positions[limit.coordinate], _unit(graph, limit)
        excess = value - (limit.high if value > limit.high else limit.low)
        one = Stops(("", limit.name), ("", unit), (math.nan, limit.low), (math.nan, limit.high))
        words.append(one.words(1, excess))
    return words


def _unit(graph: Graph, limit: Limit) -> str:
    return ("rad" if graph.is_angle(limit.coordinate) else "m") + PER_TIME[limit.order]


def keeps(graph: Graph, limit: Limit, value: float) -> bool:
    """Whether a value keeps a limit, but for rounding; NaN does not."""
    return limit.excess(value) <= _slack_of(graph, limit)


def _slack_of(graph: Graph, limit: Limit) -> float:
    """What of going beyond a limit is rounding."""
    unit = 1.0 if graph.is_angle(limit.coordinate) else graph.length
    return _ROUNDING * (unit + max(abs(end) for end in limit.ends if math.isfinite(end)))


@dataclass(frozen=True)
class LimitRows:
    """Rows of a kernel's outputs that are limited, with their limits (L,), or (L, n) of n samples
    that have limits of their own, and what of going beyond them is rounding; numbers: of the stops.
    """

    numbers: IndexArray
    rows: IndexArray
    low: FloatArray
    high: FloatArray
    slack: FloatArray

    @staticmethod
    def of(graph: Graph, outputs: Outputs) -> LimitRows:
        """All limits of what is known: positions, and as many derivatives as there are."""
        place = {c: row for row, c in enumerate(outputs.coordinates)}
        numbers = {c.name: k for k, c in enumerate(graph.plain.coordinates)}
        found = []
        for number, limit in enumerate(graph.limited, start=1):
            coordinate: int | str = numbers.get(limit.coordinate, limit.coordinate)
            if coordinate not in place or limit.order > outputs.derivatives:
                continue
            row = outputs.derivative(place[coordinate], limit.order)
            found.append((number, row, *limit.ends, _slack_of(graph, limit)))
        chosen, rows, low, high, slack = np.array(found, dtype=float).reshape(-1, 5).T
        return LimitRows(chosen.astype(np.intp), rows.astype(np.intp), low, high, slack)

    def kept(self, out: FloatArray) -> bool:
        """Whether outputs (rows,) of one pose are within all limits; NaN is not."""
        if not len(self.rows):
            return True
        low, high = self._ends
        values = out[self.rows].tolist()
        return all(a <= x <= b for a, x, b in zip(low, values, high, strict=True))

    @cached_property
    def _ends(self) -> tuple[list[float], list[float]]:
        return (self.low - self.slack).tolist(), (self.high + self.slack).tolist()

    def beyond(self, out: FloatArray) -> tuple[BoolArray, BoolArray]:
        """Which limits (L, n) outputs (rows, n) are below, and above; the undefined are neither."""
        values, slack = out[self.rows], self.slack[:, None]
        low, high = self._columns
        below: BoolArray = values < low - slack
        above: BoolArray = values > high + slack
        return below, above

    @cached_property
    def _columns(self) -> tuple[FloatArray, FloatArray]:
        """Limits (L, 1) or (L, n)."""
        if self.low.ndim == 2:
            return self.low, self.high
        return self.low[:, None], self.high[:, None]

    def stopped(self, out: FloatArray) -> Stopped:
        """The limit that each sample (rows, n) exceeds, by the greatest part of its range."""
        found = Stopped.by_nothing(out.shape[1])
        if not len(self.rows):
            return found
        beyond = np.logical_or(*self.beyond(out))
        samples = np.flatnonzero(beyond.any(axis=0))
        if len(samples):
            values = out[np.ix_(self.rows, samples)]
            low, high = (a if a.shape[1] == 1 else a[:, samples] for a in self._columns)
            with np.errstate(invalid="ignore"):  # infinity, beyond no open end
                excess = np.where(values < low, values - low, values - high)
            excess[~beyond[:, samples]] = 0.0
            span = high - low
            parts = np.abs(excess) / np.where(np.isfinite(span) & (span > 0.0), span, 1.0)
            worst = np.argmax(parts, axis=0)
            found.number[samples] = self.numbers[worst]
            found.excess[samples] = excess[worst, np.arange(len(samples))]
        return found


class Stopped(NamedTuple):
    """What stops each of n samples, by number, and the excess: how far above its upper limit or,
    if negative, below its lower one something is [SI]; NaN where no limit stops the sample.
    """

    number: IndexArray
    excess: FloatArray

    @staticmethod
    def by_nothing(n: int) -> Stopped:
        return Stopped(np.zeros(n, dtype=np.intp), np.full(n, np.nan))
