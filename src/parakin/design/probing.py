"""Whether poses keep everything, what does not let them, and how much is left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from parakin.arrays import BoolArray, FloatArray, IndexArray
from parakin.design.march import ends_of
from parakin.design.stopping import reason
from parakin.design.strength import Efforts, Firmness
from parakin.model.graph import Graph
from parakin.solving.charts import Chart
from parakin.solving.locks import begun_at, locks_of
from parakin.solving.solver import Solver
from parakin.solving.status import Status, are, converged
from parakin.solving.tick import Tick

_TOGETHER = 4096  # poses: as many as stay near the processor
_KEEPS = (Status.CONVERGED, Status.ANGLES_UNDEFINED)
# What may be wrong besides a stop; a status, or the number of a bound of efforts, less from it.
_EDGE, _POOR, _UNSURE, _STATUS, _EFFORT = -1, -2, -3, -100, -1000
_ALIKE = 1e-6  # of the most a drive gives: efforts that differ by less come to their bounds at once

EDGE_WORDS = "edge of what was looked at"


class Left(NamedTuple):
    """How firmly points are held (n,), home being 1; what is left of strokes (n,): of each the part
    of its length to its nearer end, and of these the least; and the greatest effort at rest (n,),
    as a part of the most that the drive gives.
    """

    conditioning: FloatArray
    stroke: FloatArray
    effort: FloatArray


@dataclass(frozen=True)
class Probe:
    """What is asked of points: the driven coordinates `over` (by number) are moved, the others held
    as in each of the poses (k, m). every: with all these poses, or with any. low, high (d,): what
    is looked at. least: of conditioning, as `firmness` tells it. efforts: at rest, where they are
    known; bounded: which points then have to keep within their bounds.
    """

    solver: Solver
    over: tuple[int, ...]
    poses: FloatArray
    every: bool
    low: FloatArray
    high: FloatArray
    firmness: Firmness
    least: float | None
    efforts: Efforts | None
    bounded: bool

    def driven(self, points: FloatArray, pose: int) -> FloatArray:
        """Driven values (k, n) at points (n, d), otherwise as in one of the poses."""
        y = self.poses[:, pose, None].repeat(len(points), axis=1)
        y[list(self.over)] = points.T
        return y

    def keeps(self, points: FloatArray) -> BoolArray:
        """Which points (n, d) keep everything."""
        return self._wrong(points)[1]

    def wrong(self, points: FloatArray) -> IndexArray:
        """What is wrong with points (n, d) in a code of its own, see `words`; 0 for nothing. Of
        several poses the first that is wrong tells.
        """
        codes, kept = self._wrong(points)
        first = np.argmax(codes != 0, axis=0)
        found: IndexArray = np.where(kept, 0, codes[first, np.arange(len(points))])
        return found

    def stops_next(self, inside: FloatArray, outside: FloatArray) -> IndexArray:
        """The same of points that are next to others, inside (both (n, d)): of the first pose that
        is kept there and not here.
        """
        codes = self._wrong(outside)[0]
        for pose in np.arange(len(codes)).tolist():
            self._name_first(codes[pose], outside, pose)
        first: IndexArray = np.zeros(len(outside), dtype=np.intp)
        if len(codes) > 1:
            first = np.argmax((self._wrong(inside)[0] == 0) & (codes != 0), axis=0)
        found: IndexArray = codes[first, np.arange(len(outside))]
        return found

    def _wrong(self, points: FloatArray) -> tuple[IndexArray, BoolArray]:
        """Codes (m, n) pose by pose, and which points keep everything."""
        codes = np.full((self.poses.shape[1], len(points)), _EDGE, dtype=np.intp)
        looked = ((points >= self.low) & (points <= self.high)).all(axis=1)
        at = np.flatnonzero(looked)
        for pose in np.arange(len(codes)).tolist():
            for k in np.arange(0, len(at), _TOGETHER).tolist():
                some = at[k : k + _TOGETHER]
                codes[pose, some] = self._codes(self.driven(points[some], pose))
        kept = codes == 0
        return codes, kept.all(axis=0) if self.every else kept.any(axis=0)

    def _name_first(self, codes: IndexArray, points: FloatArray, pose: int) -> None:
        """Of limits that are met at once, as by symmetry, the first of the file is named; in the
        codes (n,) of points (n, d) next to where they are met.
        """
        units = np.array([bool(unit) for unit in self.solver.stops.units])
        some = np.flatnonzero((codes > 0) & units[np.maximum(codes, 0) // 2])
        for k in np.arange(0, len(some), _TOGETHER).tolist():
            mine = some[k : k + _TOGETHER]
            y = self.driven(points[mine], pose)
            chart, out = self._outputs(y, self.solver.at(y))
            ends = ends_of(chart)
            met = (ends.beyond(out)[0] > -ends.slack[:, None]) & converged(out, chart.layout)
            first = np.argmax(met, axis=0)
            named = 2 * ends.numbers[first] + ends.upper[first]
            codes[mine] = np.where(met.any(axis=0), named, codes[mine])

    def _codes(self, y: FloatArray) -> IndexArray:
        tick = self.solver.at(y)
        status, number = np.asarray(tick.status), np.asarray(tick.stopped_by)
        upper = np.asarray(tick.excess) > 0.0
        codes = np.where(number > 0, 2 * number + upper, _STATUS - status.astype(np.intp))
        good = are(_KEEPS, status)
        codes[good] = 0
        if (self.least is not None or self.bounded) and good.any():
            codes[good] = self._demanded(y[:, good], _chosen(tick, good))
        return codes

    def _demanded(self, y: FloatArray, tick: Tick) -> IndexArray:
        """The same (n,) of poses that keep their limits: whether they are firm, and held."""
        chart, out = self._outputs(y, tick)
        codes = np.zeros(y.shape[1], dtype=np.intp)
        if self.least is not None:
            codes[~(self.firmness.of(chart, out, y) >= self.least)] = _POOR
        if self.bounded and self.efforts is not None:
            share = self.efforts.shares(chart, out, y)
            worst = np.abs(share).max(axis=0)
            first = np.argmax(np.abs(share) >= worst - _ALIKE, axis=0)
            upper = share[first, np.arange(len(first))] > 0.0
            bound = np.where(np.isfinite(worst), _EFFORT - first - len(share) * upper, _UNSURE)
            codes = np.where(worst <= 1.0, codes, bound)
        return codes

    def _outputs(self, y: FloatArray, tick: Tick) -> tuple[Chart, FloatArray]:
        """All that a chart knows of poses that are solved; NaN where it is singular itself."""
        solver, chart = self.solver, self.solver.atlas.followed
        known = begun_at(locks_of(solver.plan), solver.layout, tick)
        return chart, chart.at_rest(y, known)

    @staticmethod
    def is_singular(codes: IndexArray) -> BoolArray:
        """Which codes (n,) tell a singularity, as there is at an end of reach too."""
        return np.asarray(codes == _STATUS - Status.SINGULAR, dtype=bool)

    def words(self, code: int) -> str:
        """What a code says: "P6 > 1.26 m", "limb A1, B1 cannot reach", "singular"."""
        if code == 0:
            return ""
        if code == _EDGE:
            return EDGE_WORDS
        if code == _POOR:
            return f"conditioning < {self.least:g}"
        if code == _UNSURE:
            return "efforts not known"
        if code <= _EFFORT and self.efforts is not None:
            return self.efforts.words(_EFFORT - code)
        if code > 0:
            number, upper = divmod(code, 2)
            return reason(self.solver, number, Status.LIMIT_EXCEEDED, upper=bool(upper))
        return reason(self.solver, 0, Status(_STATUS - code), upper=False)

    def left(self, points: FloatArray) -> Left:
        """How much is left at points (n, d) that keep everything: the least of all poses, or the
        most of any.
        """
        best = np.full((3, len(points)), np.inf if self.every else np.nan)
        pick = np.minimum if self.every else np.fmax
        for pose in np.arange(self.poses.shape[1]).tolist():
            for k in np.arange(0, len(points), _TOGETHER).tolist():
                some = slice(k, k + _TOGETHER)
                best[:, some] = pick(best[:, some], self._left(self.driven(points[some], pose)))
        return Left(best[0], best[1], -best[2])

    def _left(self, y: FloatArray) -> FloatArray:
        """Conditioning, stroke and effort (3, n), this with a minus, so that more is better."""
        tick = self.solver.at(y)
        good = np.flatnonzero(are(_KEEPS, np.asarray(tick.status)))
        found = np.full((3, y.shape[1]), np.nan)
        if not len(good):
            return found
        chart, out = self._outputs(y[:, good], _chosen(tick, good))
        sure = converged(out, chart.layout)
        good, out = good[sure], out[:, sure]
        found[0, good] = self.firmness.of(chart, out, y[:, good])
        rows, low, high = _strokes(self.solver.graph, chart)
        share = np.minimum(out[rows] - low, high - out[rows]) / (high - low)
        found[1, good] = share.min(axis=0) if len(rows) else np.nan
        if self.efforts is not None:
            found[2, good] = -np.abs(self.efforts.shares(chart, out, y[:, good])).max(axis=0)
        return found


def _strokes(graph: Graph, chart: Chart) -> tuple[list[int], FloatArray, FloatArray]:
    """Rows of a chart's slides that both ends are given of, and these ends (m, 1)."""
    found = []
    for limit in graph.limited:
        if limit.order or not np.isfinite(limit.ends).all() or graph.is_angle(limit.coordinate):
            continue
        if limit.coordinate.startswith("platform."):
            continue
        row = chart.places.get(graph.index(limit.coordinate, "limits"))
        if row is not None and limit.high > limit.low:
            found.append((row, *limit.ends))
    rows, low, high = np.array(found).reshape(-1, 3).T
    return rows.astype(int).tolist(), low[:, None], high[:, None]


def _chosen(tick: Tick, some: BoolArray | IndexArray) -> Tick:
    """Some poses of a batch, as far as what is iterated goes."""
    return tick._replace(position=tick.position[:, some], iterated=tick.iterated[:, some])
