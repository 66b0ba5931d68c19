"""Rays: straight ways of the driven coordinates from one pose, each followed to the first limit.

All rays are followed at once, each in its own steps, which obey the rule of continuity
(`parakin.solving.continuity`), so that none jumps to another assembly. A step that may have left a
limit and come back is halved (`parakin.design.ends`). What is met within a step is located by
Newton's steps in a bracket, with the kernel's own rates.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from parakin.arrays import BoolArray, FloatArray, IndexArray, StatusArray
from parakin.design.ends import Ends, judged
from parakin.solving.atlas import Atlas
from parakin.solving.charts import Chart
from parakin.solving.continuity import ASIDE, follows, missing_turns, stays_clear
from parakin.solving.status import SINGULAR, Status, classify
from parakin.solving.tracking import POORER
from parakin.solving.walking import REGULAR, State, Ways, carried_over

_FIRST, _STRIDE = 0.1, 0.5  # units: the first step of a ray, and the longest
_NEAR = 1e-3  # units: from how near the end of reach is located by halving a bracket
FLOOR = 1e-13  # units: the shortest step
_POOR = 0.1  # a figure of conditioning that may be about to vanish
_ATTEMPTS = 2000  # steps of all sizes on one ray before giving up
_LOCATED = 1e-14  # units: a step by which nothing moves any more
_SAME = 1e-12  # units: limits met no farther apart are met at once
_NEWTON = 80  # steps in a bracket; bisection alone needs 52


class Met(NamedTuple):
    """How far each of n rays goes, as a part of its way, 1 if to its end; the number of the limit
    that is met there, 0 for none, and whether its upper end; else the status that tells why it
    ends; and what is reported there (coordinates, n).
    """

    part: FloatArray
    number: IndexArray
    upper: BoolArray
    status: StatusArray
    position: FloatArray


class Node(NamedTuple):
    """A place on a ray: its part, the chart that followed it there, and its outputs (rows,)."""

    part: float
    chart: Chart
    out: FloatArray


def no_limit(atlas: Atlas, node: Node, n: int) -> Met:
    """Of n rays that have not set off from a node."""
    return Met(
        np.full(n, node.part),
        np.zeros(n, dtype=np.intp),
        np.zeros(n, dtype=bool),
        np.zeros(n, dtype=np.int8),
        _reported(atlas, node.chart, node.out[:, None]).repeat(n, axis=1),
    )


def follow(
    atlas: Atlas,
    start: Node,
    origin: FloatArray,
    goal: FloatArray,
    traces: list[list[Node]] | None = None,
) -> Met:
    """Follow rays from `origin` (k,) to `goal` (k, n), as far as no limit is met.

    start: the pose at the origin, which keeps all limits. traces: by ray, where its nodes are
    added.
    """
    with np.errstate(all="ignore"):  # goals that overflow end like any out of reach
        met = no_limit(atlas, start, goal.shape[1])
        rays = np.arange(goal.shape[1])
        _follow(atlas, start, origin, goal, rays, met, traces)
    return met


def _follow(
    atlas: Atlas,
    start: Node,
    origin: FloatArray,
    goal: FloatArray,
    rays: IndexArray,
    met: Met,
    traces: list[list[Node]] | None,
) -> None:
    """The same from any node on these rays, written to `met`; on other charts where need be."""
    chart = start.chart
    at_rest = State(np.array([origin]), np.empty((1, 0)))
    march = _March(chart, Ways(chart, at_rest, goal[:, rays], atlas.units), start)
    if traces is not None:
        march.traces = [traces[ray] for ray in rays.tolist()]
    march.run(patient=chart.layout.unsigned)
    for k in np.flatnonzero(march.stuck):
        node = Node(float(march.part[k]), chart, march.out[:, k])
        other = _other_chart(atlas, node, origin, goal[:, rays[k]])
        if other is not None:
            march.stuck[k] = False
            _follow(atlas, other, origin, goal, rays[k : k + 1], met, traces)
            march.passed_on[k] = True
    march.finish()
    mine = ~march.passed_on
    ray = rays[mine]
    met.part[ray], met.number[ray] = march.part[mine], march.number[mine]
    met.upper[ray], met.status[ray] = march.upper[mine], march.status[mine]
    met.position[:, ray] = _reported(atlas, chart, march.out[:, mine])


def _reported(atlas: Atlas, chart: Chart, out: FloatArray) -> FloatArray:
    """Positions of what the solver reports, (coordinates, n)."""
    return out[[chart.places[c] for c in atlas.outputs.coordinates]]


def _other_chart(atlas: Atlas, node: Node, origin: FloatArray, goal: FloatArray) -> Node | None:
    """The same place on another chart, if it is only the plan that ends here."""
    chart, figure = node.chart, float(node.out[node.chart.outputs.conditioning])
    if not abs(figure) < _POOR:
        return None
    driven = np.zeros((len(chart.layout.iterated), len(origin), 1))
    driven[0, :, 0] = origin + node.part * (goal - origin)
    driven[1, :, 0] = goal - origin
    at = chart.configuration(driven[0, :, 0], node.out)
    if not chart.regularity(at) > max(REGULAR, POORER * abs(figure)):
        return None
    for other in atlas.others(chart, at, at):
        found = carried_over(other, driven, at)
        if found is not None:
            return Node(node.part, other, found[:, 0])
    return None


def ends_of(chart: Chart) -> Ends:
    """The limits of a chart, made once."""
    return chart.kept(("ends",), lambda: Ends.of(chart))


class _March:
    """Rays on one chart, n of them, and where each has come to. Arrays are changed in place.

    part, out: of the last place that is kept; stuck: where no step leads on; passed_on: to another
    chart; number, upper, status: as of `Met`.
    """

    def __init__(self, chart: Chart, ways: Ways, start: Node) -> None:
        n = len(ways.all)
        self.chart, self.ways, self.ends = chart, ways, ends_of(chart)
        self.layout, self.outputs = chart.layout, chart.outputs
        self.part = np.full(n, start.part)
        self.out = ways.at(self.part, self._guess(start.out[:, None].repeat(n, 1)), ways.all)
        held = self.layout.watched.rows  # full turns as they were counted before
        self.out[held] = start.out[held, None]
        self.size = _FIRST / ways.pace
        self.stuck, self.passed_on, self.upper = (np.zeros(n, dtype=bool) for _ in range(3))
        self.number = np.zeros(n, dtype=np.intp)
        self.status = np.zeros(n, dtype=np.int8)
        self.traces: list[list[Node]] | None = None

    def run(self, patient: bool) -> None:
        """Step on until each ray has arrived, met a limit, or is stuck; patient: in ever shorter
        steps up to a singularity.
        """
        going = self.ways.all
        for _ in range(_ATTEMPTS):
            going = going[~self._stepped(going, patient)]
            if not len(going):
                return
        self.stuck[going], self.status[going] = True, Status.NOT_REACHED

    def _stepped(self, rays: IndexArray, patient: bool) -> BoolArray:
        """Try one step of these rays. Returns which are done."""
        part, size = self.part[rays], self.size[rays]
        target = np.minimum(part + size, 1.0)
        h, pace = target - part, self.ways.pace[rays]
        before = self.out[:, rays]
        found = self._at(target, part, before, rays)
        status = classify(found, self.layout)
        good = (status == Status.CONVERGED) & self._smooth(rays, part, target, before, found)
        beyond = self.ends.beyond(before), self.ends.beyond(found)
        kept, met = judged(h, *beyond, self.ends.slack)
        tiny = h * pace <= FLOOR
        last = beyond[1][0]  # at the shortest step, ends decide
        kept |= tiny & (last <= self.ends.slack[:, None])
        met |= tiny & (last > self.ends.slack[:, None])
        on = good & kept.all(axis=0)
        crossing = good & (kept | met).all(axis=0) & ~on
        self._locate(rays, crossing, met, target, before)
        self.part[rays[on]], self.out[:, rays[on]] = target[on], found[:, on]
        self._note(rays[on])
        self.size[rays] = np.where(on, np.minimum(2.0 * size, _STRIDE / pace), 0.5 * h)
        poor = (status != 0) | (before[self.outputs.conditioning] < _POOR)
        near = tiny if patient else tiny | (poor & (h * pace <= _NEAR))
        stuck = ~good & near
        self.stuck[rays[stuck]] = True
        self.status[rays[stuck]] = np.where(status[stuck] == 0, Status.NOT_SMOOTH, status[stuck])
        # What is neither kept nor met at the shortest step is undefined there.
        lost = good & tiny & ~on & ~crossing
        self.stuck[rays[lost]], self.status[rays[lost]] = True, Status.ANGLES_UNDEFINED
        return crossing | stuck | lost | (on & (target == 1.0))

    def finish(self) -> None:
        """Go on to where those that are stuck end, by halving a bracket or in ever shorter steps."""
        rays = np.flatnonzero(self.stuck)
        if not len(rays):
            return
        reach = np.minimum(self.part[rays] + 8.0 * _NEAR / self.ways.pace[rays], 1.0)
        low, high = self.part[rays], reach.copy()
        before = self.out[:, rays]
        there = self._good(rays, reach, low, before)[0]
        slow = there | self.layout.unsigned | (self.status[rays] == Status.ANGLES_UNDEFINED)
        again, rays, low, high = rays[slow], rays[~slow], low[~slow], high[~slow]
        before, begun, last = before[:, ~slow], low.copy(), before[:, ~slow].copy()
        while len(rays) and ((high - low) * self.ways.pace[rays] > FLOOR).any():
            middle = 0.5 * (low + high)
            if not ((middle > low) & (middle < high)).any():
                break
            good, found = self._good(rays, middle, begun, before)
            status = classify(found.copy(), self.layout)
            low, high = np.where(good, middle, low), np.where(good, high, middle)
            last[:, good] = found[:, good]
            self.status[rays[~good]] = np.maximum(status[~good], 1)
        self.out[:, rays], self.part[rays] = last, low
        self._beyond_at_end(rays, begun, before)
        self._note(rays)
        self.stuck[:] = False
        if len(again) and not self.layout.unsigned:
            self._patiently(again)

    def _beyond_at_end(self, rays: IndexArray, begun: FloatArray, before: FloatArray) -> None:
        """Limits that were met on the last bit of the way."""
        beyond = self.ends.beyond(self.out[:, rays])[0] > self.ends.slack[:, None]
        crossing, end = beyond.any(axis=0), self.part[rays]
        self.part[rays[crossing]] = begun[crossing]
        self._locate(rays, crossing, beyond, end, before)

    def _patiently(self, rays: IndexArray) -> None:
        done = ~np.isin(self.ways.all, rays)
        self.size[rays] = _NEAR / self.ways.pace[rays]
        going = self.ways.all[~done]
        self.status[going] = 0
        for _ in range(_ATTEMPTS):
            going = going[~self._stepped(going, True)]
            if not len(going):
                return
        self.status[going] = Status.NOT_REACHED

    def _good(
        self, rays: IndexArray, target: FloatArray, part: FloatArray, before: FloatArray
    ) -> tuple[BoolArray, FloatArray]:
        """Which poses are closed on the same branch, and their outputs."""
        found = self._at(target, part, before, rays, straight=True)
        status = classify(found.copy(), self.layout)
        good: BoolArray = status == Status.CONVERGED
        return good & (found[self.outputs.conditioning] >= SINGULAR), found

    def _at(
        self,
        target: FloatArray,
        part: FloatArray,
        before: FloatArray,
        rays: IndexArray,
        *,
        straight: bool = False,
    ) -> FloatArray:
        """Outputs at parts, from those before, angles by full turns as they go on from there.

        straight: as slopes near the end of reach foretell nothing, begin from where it was.
        """
        h = target - part
        guess = self._guess(before, h * (not straight))
        found = self.ways.at(target, guess, rays)
        watched = self.layout.watched
        if watched.turning.any():
            a, b = self._orders(before, watched.rows), self._orders(found, watched.rows)
            if straight:
                a, b = (np.array([x[0], 0.0 * x[0], 0.0 * x[0]]) for x in (a, b))
            turns = np.nan_to_num(missing_turns(h, a, b, watched.turning))
            found[watched.rows] += 2.0 * np.pi * turns
        return found

    def _guess(self, out: FloatArray, h: FloatArray | float = 0.0) -> FloatArray:
        """Iterated coordinates (m, n) a little farther on."""
        x, v, a = (out[self.layout.iterated[order]] for order in range(3))
        if not np.any(h):
            return x
        return np.asarray(x + h * (v + 0.5 * h * a))

    def _orders(self, out: FloatArray, rows: IndexArray) -> FloatArray:
        return np.array([out[self.outputs.derivative(rows, order)] for order in range(3)])

    def _smooth(
        self,
        rays: IndexArray,
        part: FloatArray,
        target: FloatArray,
        before: FloatArray,
        found: FloatArray,
    ) -> BoolArray:
        """Which steps one smooth motion leads over."""
        layout, h = self.layout, target - part
        states = self._orders(before, layout.unknowns), self._orders(found, layout.unknowns)
        digits = self.chart.digits_factor * found[self.outputs.conditioning]
        pace, bulk = self.ways.pace[rays], self.ways.bulk[rays]
        smooth: BoolArray = np.logical_and.reduce(
            follows(h, *states, pace, layout.units, digits, bulk)
        )
        if layout.unsigned:
            figure, aside = self.outputs.unsigned, ASIDE * h
            ahead, behind = (
                self.ways.at(at + on, self._guess(out, on), rays)[figure]
                for at, out, on in ((part, before, aside), (target, found, -aside))
            )
            smooth &= stays_clear(h, before[figure], found[figure], ahead, behind)
        return smooth

    def _locate(
        self,
        rays: IndexArray,
        crossing: BoolArray,
        met: BoolArray,
        target: FloatArray,
        before: FloatArray,
    ) -> None:
        """Put rays that meet limits in this step where they meet the first."""
        ends, columns = np.nonzero(met & crossing)
        if not len(columns):
            return
        part = self.part[rays]
        at, out = self._roots(rays, columns, ends, part, target, before)
        for column in np.flatnonzero(crossing).tolist():
            mine = np.flatnonzero(columns == column)
            same = at[mine] <= at[mine].min() + _SAME / self.ways.pace[rays[column]]
            first = int(mine[np.argmax(same)])  # in the order of the file
            ray, end = rays[column], ends[first]
            self.part[ray], self.out[:, ray] = at[first], out[:, first]
            self.number[ray], self.upper[ray] = self.ends.numbers[end], self.ends.upper[end]
        self._note(rays[crossing])

    def _roots(
        self,
        rays: IndexArray,
        columns: IndexArray,
        ends: IndexArray,
        part: FloatArray,
        target: FloatArray,
        before: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        """The parts at which ends are met on rays (by column), and outputs there: Newton's steps,
        halving the bracket where one leaves it.
        """
        each, start, begun = rays[columns], part[columns], before[:, columns]
        low, high = start.copy(), target[columns].copy()
        which = np.arange(len(ends))
        g = self.ends.beyond(begun)[0, ends, which]
        at = np.where(g >= 0.0, low, 0.5 * (low + high))
        out = begun
        for _ in range(_NEWTON):
            out = self._at(at, start, begun, each)
            g, dg, _ = self.ends.beyond(out)[:, ends, which]
            inside = g <= 0.0
            low, high = np.where(inside, at, low), np.where(inside, high, at)
            step = -g / dg
            found = np.minimum(np.abs(step), high - low) * self.ways.pace[each] <= _LOCATED
            if found.all():
                break
            fine = (at + step > low) & (at + step < high)
            at = np.where(found, at, np.where(fine, at + step, 0.5 * (low + high)))
        return at, out

    def _note(self, rays: IndexArray) -> None:
        if self.traces is not None:
            for ray in rays.tolist():
                node = Node(float(self.part[ray]), self.chart, self.out[:, ray].copy())
                self.traces[ray].append(node)
