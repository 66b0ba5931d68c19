"""Rays on one chart: stepping on, locating what is met, and ending where no step leads on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from parakin.arrays import BoolArray, FloatArray, IndexArray
from parakin.design.ends import Ends, judged
from parakin.solving.charts import Chart
from parakin.solving.continuity import ASIDE, follows, missing_turns, stays_clear
from parakin.solving.status import SINGULAR, Layout, Status, classify
from parakin.solving.walking import Ways

_FIRST, _STRIDE = 0.1, 0.5  # units: the first step of a ray, and the longest
_NEAR = 1e-3  # units: from how near the end of reach is located by halving a bracket
FLOOR = 1e-13  # units: the shortest step
_POOR = 0.1  # a figure of conditioning that may be about to vanish
_ATTEMPTS = 2000  # steps of all sizes on one ray before giving up
_LOCATED = 1e-14  # units: a step by which nothing moves any more
_SAME = 1e-12  # units: limits met no farther apart are met at once
_NEWTON = 80  # steps in a bracket; bisection alone needs 52
_AHEAD = 1e-9  # units: where, beyond the end of reach, it is asked which loops are open
_ROOT = 0.75  # figures falling by a lower power are those of a square root: nothing is left
_FORETELL = 40  # repeats, each of which halves what is wrong or better
_BACK = 1e-5  # units: from where it is foretold how a figure of conditioning vanishes


class Node(NamedTuple):
    """A place on a ray: its part, the chart that followed it there, and its outputs (rows,)."""

    part: float
    chart: Chart
    out: FloatArray


def ends_of(chart: Chart) -> Ends:
    """The limits of a chart, made once."""
    return chart.kept(("ends",), lambda: Ends.of(chart))


def outputs_at(
    ways: Ways,
    rays: IndexArray,
    target: FloatArray,
    known: tuple[FloatArray, FloatArray],
    *,
    straight: bool = False,
) -> FloatArray:
    """Outputs at parts (n,) of rays, from parts known and outputs there; angles by full turns as
    they go on from those.

    straight: as slopes near the end of reach foretell nothing, begin from where it was.
    """
    (part, before), layout = known, ways.chart.layout
    h = target - part
    found = ways.at(target, _guess(layout, before, h * (not straight)), rays)
    watched = layout.watched
    if watched.turning.any():
        a, b = _orders(layout, before, watched.rows), _orders(layout, found, watched.rows)
        if straight:
            a, b = (np.array([x[0], 0.0 * x[0], 0.0 * x[0]]) for x in (a, b))
        turns = np.nan_to_num(missing_turns(h, a, b, watched.turning))
        found[watched.rows] += 2.0 * np.pi * turns
    return found


def _guess(layout: Layout, out: FloatArray, h: FloatArray | float = 0.0) -> FloatArray:
    """Iterated coordinates (m, n) a little farther on."""
    x, v, a = (out[layout.iterated[order]] for order in range(3))
    farther: FloatArray = x + h * (v + 0.5 * h * a) if np.any(h) else x
    return farther


def _orders(layout: Layout, out: FloatArray, rows: IndexArray) -> FloatArray:
    """Position, velocity and acceleration (3, m, n)."""
    return np.array([out[layout.outputs.derivative(rows, order)] for order in range(3)])


class March:
    """Rays on one chart, n of them, and where each has come to. Arrays are changed in place.

    part, out: of the last place that is kept; stuck: where no step leads on; passed_on: to another
    chart; number, upper, status: as of `Met`.
    """

    def __init__(self, chart: Chart, ways: Ways, start: Node) -> None:
        n = len(ways.all)
        self.chart, self.ways, self.ends = chart, ways, ends_of(chart)
        self.layout, self.outputs = chart.layout, chart.outputs
        self.part = np.full(n, start.part)
        self.out = ways.at(
            self.part, _guess(self.layout, start.out[:, None].repeat(n, 1)), ways.all
        )
        held = self.layout.watched.rows  # full turns as they were counted before
        self.out[held] = start.out[held, None]
        self.size = _FIRST / ways.pace
        self.stuck, self.passed_on, self.upper = (np.zeros(n, dtype=bool) for _ in range(3))
        self.number = np.zeros(n, dtype=np.intp)
        self.status = np.zeros(n, dtype=np.int8)
        self.stuck_at = self.part, self.out
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
        self.note(rays[on])
        self.size[rays] = np.where(on, np.minimum(2.0 * size, _STRIDE / pace), 0.5 * h)
        poor = (status != 0) | (before[self.outputs.conditioning] < _POOR)
        near = tiny if patient else tiny | (poor & (h * pace <= _NEAR))
        stuck = ~good & near
        self.stuck[rays[stuck]] = True
        self.status[rays[stuck]] = np.where(status[stuck] == 0, Status.NOT_SMOOTH, status[stuck])
        # What is neither kept nor met at the shortest step is undefined there.
        lost = good & tiny & ~on & ~crossing
        self.stuck[rays[lost]], self.status[rays[lost]] = True, Status.ANGLES_UNDEFINED
        done: BoolArray = crossing | stuck | lost | (on & (target == 1.0))
        return done

    def finish(self) -> None:
        """Go on to where those that are stuck end, halving a bracket or in ever shorter steps."""
        rays = np.flatnonzero(self.stuck)
        self.stuck_at = self.part.copy(), self.out.copy()
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
        self.note(rays)
        self.stuck[:] = False
        if len(again) and not self.layout.unsigned:
            self._patiently(again)

    def told(self, rays: IndexArray) -> tuple[IndexArray, FloatArray]:
        """Of rays that ended at a singularity, those (numbers) beyond which loops are open, with
        the outputs there (rows, n). Those that merely pass one are put right where it is: with a
        figure of conditioning that falls as a power of what is left of the way.
        """
        part, before = self.part[rays], self.out[:, rays]
        pace = self.ways.pace[rays]
        found = self._at(part + _AHEAD / pace, part, before, rays, straight=True)
        open_ = classify(found.copy(), self.layout) == Status.OUT_OF_REACH
        passing = np.flatnonzero(~open_ & (self.status[rays] != Status.ANGLES_UNDEFINED))
        figures = [np.abs(before[self.outputs.conditioning])]
        for times in (1.0, 2.0):
            at = part - times * _BACK / pace
            back = self._at(
                at, self.stuck_at[0][rays], self.stuck_at[1][:, rays], rays, straight=True
            )
            closed = classify(back.copy(), self.layout) == Status.CONVERGED
            figures.append(np.where(closed, np.abs(back[self.outputs.conditioning]), np.nan))
        left = np.nan_to_num(_left(*figures)) / pace
        self.part[rays[passing]] += left[passing]
        return rays[open_], found[:, open_]

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
        return outputs_at(self.ways, rays, target, (part, before), straight=straight)

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
        states = _orders(layout, before, layout.unknowns), _orders(layout, found, layout.unknowns)
        digits = self.chart.digits_factor * found[self.outputs.conditioning]
        pace, bulk = self.ways.pace[rays], self.ways.bulk[rays]
        smooth: BoolArray = np.logical_and.reduce(
            follows(h, *states, pace, layout.units, digits, bulk)
        )
        if layout.unsigned:
            figure, aside = self.outputs.unsigned, ASIDE * h
            ahead, behind = (
                self.ways.at(at + on, _guess(layout, out, on), rays)[figure]
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
        self.note(rays[crossing])

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

    def note(self, rays: IndexArray) -> None:
        """Add where these rays are to their traces, if these are kept."""
        if self.traces is not None:
            for ray in rays.tolist():
                node = Node(float(self.part[ray]), self.chart, self.out[:, ray].copy())
                self.traces[ray].append(node)


def _left(last: FloatArray, one: FloatArray, two: FloatArray) -> FloatArray:
    """What is left of ways (n,) [units] to where a figure vanishes, from its values at the last
    place and one and two times `_BACK` before: k (left + back)ᵖ at all three.
    """
    left = np.zeros(len(last))
    for _ in range(_FORETELL):
        power = np.log(two / one) / np.log((left + 2.0 * _BACK) / (left + _BACK))
        ratio = (last / one) ** (1.0 / power)
        left = np.clip(_BACK * ratio / (1.0 - ratio), 0.0, _BACK)
    return np.where(power > _ROOT, left, 0.0)
