"""A stretch of a motion on one chart: moments one after the other, held to the rule of continuity.

Where the rule does not hold from one to the next, what lies between is halved until it does or
nothing is left of it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from parakin.arrays import BoolArray, FloatArray, IndexArray
from parakin.motion.course import Course, hermite
from parakin.motion.motion import Samples
from parakin.solving.charts import Chart
from parakin.solving.continuity import (
    ASIDE,
    follows,
    magnitude_of,
    missing_turns,
    pace_of,
    shortest_interval,
    stays_clear,
)
from parakin.solving.status import Status, converged
from parakin.solving.walking import iterate

_HALVED = 32  # steps halved at once, counted from the first that does not hold
_READ_OFF = 2.0**-12  # of a step: as far as the turns of angles that are read off are looked into
_PARTS = 50_000  # moments; what needs more of them for a few hundred steps is too wild
_BLOCK = 256  # samples held to the rule at once, so that what is worked out stays in the cache
_SWING = 2.0  # times the velocity at a moment: the most an angle turns until the next
_MARGIN = 0.1  # rad from where an angle wraps
_SPEED_GROWTH = 5.0  # times what they were `LOOKBACK` moments ago: velocities at an end of reach
LOOKBACK = 100


class Nodes(NamedTuple):
    """Moments of a walk: time (n,), driven values (orders, k, n), all outputs (rows, n), and the
    width of the motion's own step that each lies in or ends (n,).
    """

    time: FloatArray
    driven: FloatArray
    out: FloatArray
    step: FloatArray

    def part(self, chosen: IndexArray | slice) -> Nodes:
        return Nodes(*(array[..., chosen] for array in self))


class Ending(NamedTuple):
    """The last moment that can be reached, and why it is the last."""

    time: float
    status: Status


class Stretch:
    """Where a motion goes on one chart.

    units (k,): of the driven coordinates, as `Layout` has those of the unknowns.
    """

    def __init__(self, chart: Chart, course: Course, units: FloatArray) -> None:
        self.chart, self._course, self._units = chart, course, units
        self._layout = layout = chart.layout
        self._watched = watched = layout.watched
        orders = [layout.outputs.derivative(watched.rows, order) for order in range(3)]
        self._rows = np.concatenate(orders)
        self._turns = bool(watched.turning.any())

    def evaluated(self, time: FloatArray, step: FloatArray, guess: FloatArray) -> Nodes:
        driven = self._course.at(time, len(self._layout.iterated))
        return Nodes(time, driven, self._solved_at(driven, guess), step)

    def _solved_at(
        self, driven: FloatArray, guess: FloatArray, *, parallel: bool = False
    ) -> FloatArray:
        inputs = driven.reshape(-1, driven.shape[2])
        if len(guess):
            return iterate(self.chart, inputs, guess, parallel=parallel)
        return self.chart.run(inputs, parallel=parallel)

    def walked(self, head: Nodes, ends: FloatArray) -> tuple[Nodes, Ending | None]:
        """With some moments, on from the last to the ends of steps, or as far as it goes."""
        steps = np.diff(ends, prepend=head.time[-1:])
        if len(self._layout.iterated[0]):
            return self._stepped(head, ends, steps)
        ahead = self.evaluated(ends, steps, np.empty((0, len(ends))))
        return self.certified(joined(head, ahead))

    def closer(self, nodes: Nodes, time: float) -> tuple[Nodes, Ending | None]:
        """Halve the interval in which a sample does not follow from the moment before it."""
        place = min(int(np.searchsorted(nodes.time, time, side="right")), len(nodes.time) - 1) - 1
        if place < 0:  # the motion's very first moment
            return nodes, Ending(-np.inf, Status.BRANCH_CHANGE)
        pair = nodes.part(slice(place, place + 2))
        if pair.time[1] - pair.time[0] <= shortest_interval(time):
            walked = nodes.part(slice(0, place + 1))
            return walked, self.ending_of(walked, pair)
        found, ending = self.certified(self.with_middles(pair, np.array([0])))
        rest = [] if ending else [nodes.part(slice(place + 2, None))]
        return joined(nodes.part(slice(0, place)), found, *rest), ending

    def _stepped(
        self, head: Nodes, ends: FloatArray, steps: FloatArray
    ) -> tuple[Nodes, Ending | None]:
        """Where a guess is needed: moment by moment, each foretold by the one before."""
        found = [head.part(slice(0, -1)), head.part(slice(-1, None))]
        pending = list(zip(ends.tolist(), steps.tolist(), strict=True))[::-1]
        while pending:
            time, step = pending[-1]
            here = found[-1]
            h = time - float(here.time[0])
            x, v, a = here.out[self._layout.iterated[:3]]
            guess = x + h * (v + 0.5 * h * a)
            ahead = self.evaluated(np.array([time]), np.array([step]), guess)
            pair = self._unwrapped(joined(here, ahead))
            smooth, read = self._judged(pair)
            narrow = h <= shortest_interval(time)
            if smooth[0] and (read[0] or h <= _READ_OFF * step):
                found.append(pair.part(slice(1, None)))
                pending.pop()
            elif len(found) > _PARTS:
                return joined(*found), Ending(float(here.time[0]), Status.NOT_SMOOTH)
            elif narrow and not smooth[0]:
                walked = joined(*found)
                return walked, self.ending_of(walked, pair)
            else:
                pending.append((time - 0.5 * h, step))
        return joined(*found), None

    def certified(self, nodes: Nodes) -> tuple[Nodes, Ending | None]:
        """Moments from the first of these, which holds, to the last, or as far as it goes."""
        while True:
            nodes = self._unwrapped(nodes)
            smooth, read = self._judged(nodes)
            h = nodes.time[1:] - nodes.time[:-1]
            open_ = ~(smooth & (read | (h <= _READ_OFF * nodes.step[1:])))
            if not open_.any():
                return nodes, None
            first = int(np.argmax(open_))
            time = float(nodes.time[first + 1])
            walked = nodes.part(slice(0, first + 1))
            if len(nodes.time) > _PARTS:
                return walked, Ending(float(walked.time[-1]), Status.NOT_SMOOTH)
            if not smooth[first] and h[first] <= shortest_interval(time):
                return walked, self.ending_of(walked, nodes.part(slice(first, first + 2)))
            places = first + np.flatnonzero(open_[first : first + _HALVED])
            places = places[h[places] > shortest_interval(time)]
            nodes = self.with_middles(nodes, places)

    def with_middles(self, nodes: Nodes, places: IndexArray) -> Nodes:
        """With a moment in the middle of each of these intervals, where it can be solved."""
        time = 0.5 * (nodes.time[places] + nodes.time[places + 1])
        guess = np.empty((0, len(time)))
        if len(self._layout.iterated[0]):
            guess = hermite(nodes.time, nodes.out[self._layout.iterated[:3]], time)
        middles = self.evaluated(time, nodes.step[places + 1], guess)
        return Nodes(
            *(
                np.insert(array, places + 1, new, axis=-1)
                for array, new in zip(nodes, middles, strict=True)
            )
        )

    def _orders_of(self, out: FloatArray) -> FloatArray:
        """Position, velocity and acceleration of what is watched, (3, m, n)."""
        orders: FloatArray = out[self._rows].reshape(3, -1, out.shape[1])
        return orders

    def _unwrapped(self, nodes: Nodes) -> Nodes:
        """Let angles run on past half a turn from home, from moment to moment."""
        if not self._turns or len(nodes.time) < 2:
            return nodes
        h, orders = nodes.time[1:] - nodes.time[:-1], self._orders_of(nodes.out)
        turns = missing_turns(h, orders[:, :, :-1], orders[:, :, 1:], self._watched.turning)
        if not turns.any():
            return nodes
        turns[~np.isfinite(turns)] = 0.0
        out = nodes.out.copy()
        out[self._watched.rows, 1:] += 2 * np.pi * np.cumsum(turns, axis=1)
        return nodes._replace(out=out)

    def _judged(self, nodes: Nodes) -> tuple[BoolArray, BoolArray]:
        """Of each interval, whether what is solved follows smoothly, and what is read off too."""
        h = nodes.time[1:] - nodes.time[:-1]
        orders, watched = self._orders_of(nodes.out), self._watched
        before, after = orders[:, :, :-1], orders[:, :, 1:]
        pace, digits = self._pace(nodes), self._digits(nodes.out)[1:]
        driven, bulk = (
            (nodes.driven[:3, :, :-1], nodes.driven[:3, :, 1:]),
            magnitude_of(nodes.driven[0], self._units)[1:],
        )
        noise = self._course.noise
        with np.errstate(all="ignore"):
            good = converged(nodes.out, self._layout)
            smooth = follows(h, before, after, pace, watched.units, digits, bulk, noise)
            smooth_driven = follows(h, *driven, pace, self._units, np.ones(1), bulk, noise).all(
                axis=0
            )
        solved = np.logical_and.reduce(smooth[watched.solved])
        solved &= smooth_driven & good[1:] & good[:-1]
        return self._clear(nodes, solved), np.logical_and.reduce(smooth)

    def _clear(self, nodes: Nodes, smooth: BoolArray) -> BoolArray:
        """Which of the intervals that are smooth do not pass a singularity in between."""
        near = np.flatnonzero(smooth)
        if not self._layout.unsigned or not len(near):
            return smooth
        row = self._layout.outputs.unsigned
        figure = nodes.out[row]
        h = (nodes.time[1:] - nodes.time[:-1])[near]
        sides = np.concatenate([near, near + 1])
        aside = ASIDE * np.concatenate([h, -h])
        driven = nodes.driven.take(sides, axis=2)
        driven[0] += aside * (driven[1] + 0.5 * aside * driven[2])
        for order in range(1, len(driven) - 1):
            driven[order] += aside * driven[order + 1]
        guess = np.empty((0, len(aside)))
        if len(self._layout.iterated[0]):
            x, v, a = nodes.out[self._layout.iterated[:3]][:, :, sides]
            guess = x + aside * (v + 0.5 * aside * a)
        aside_figure = self._solved_at(driven, guess)[row]
        ahead, behind = aside_figure[: len(near)], aside_figure[len(near) :]
        with np.errstate(all="ignore"):
            clear = stays_clear(h, figure[near], figure[near + 1], ahead, behind)
        kept = smooth.copy()
        kept[near] = clear
        return kept

    def _pace(self, nodes: Nodes) -> FloatArray:
        scaled = nodes.driven[:3] / self._units[:, None]
        return pace_of(scaled[:, :, :-1], scaled[:, :, 1:], nodes.step[1:])

    def _digits(self, out: FloatArray) -> FloatArray:
        """Conditioning, as far as digits are concerned."""
        figure: FloatArray = self.chart.digits_factor * out[self._layout.outputs.conditioning]
        return figure

    def ending_of(self, walked: Nodes, pair: Nodes) -> Ending:
        """Why there is no way from the first to the second of a pair of moments."""
        time = float(walked.time[-1])
        driven = pair.driven[:3]
        h = np.diff(pair.time)
        pace = self._pace(pair)
        ends, bulk = (
            (driven[..., :1], driven[..., 1:]),
            magnitude_of(pair.driven[0], self._units)[1:],
        )
        noise = self._course.noise
        if not follows(h, *ends, pace, self._units, np.ones(1), bulk, noise).all():
            return Ending(time, Status.NOT_SMOOTH)
        if np.isnan(pair.out[self._layout.outputs.residual, 1]):
            return Ending(time, Status.OUT_OF_REACH)
        earlier = (
            int(
                np.searchsorted(
                    walked.time, time - LOOKBACK * shortest_interval(time), side="right"
                )
            )
            - 1
        )
        rates = self._orders_of(walked.out)[1, self._watched.solved]
        velocity = np.abs(rates).max(axis=0, initial=0.0)
        blown = velocity[-1] > _SPEED_GROWTH * velocity[max(earlier, 0)]
        return Ending(time, Status.OUT_OF_REACH if blown else Status.BRANCH_CHANGE)

    def placed(
        self, nodes: Nodes, samples: Samples, *, parallel: bool
    ) -> tuple[FloatArray, float | None]:
        """Outputs of samples on the walk, and the time of the first that is not where it leads."""
        time = samples.time
        driven = np.array(samples.orders[: len(self._layout.iterated)])
        guess = np.empty((0, len(time)))
        if len(self._layout.iterated[0]):
            known = nodes.out[self._layout.iterated[:3]]
            guess = (
                hermite(nodes.time, known, time)
                if len(nodes.time) > 1
                else known[0].repeat(len(time), axis=1)
            )
        out = self._solved_at(driven, guess, parallel=parallel)
        good = converged(out, self._layout)
        left = np.searchsorted(nodes.time, time, side="right") - 1
        doubtful = np.flatnonzero(~(good & self._plain(nodes, time, out, left)))
        if not len(doubtful):
            return out, None
        orders, pace = self._orders_of(nodes.out), np.append(self._pace(nodes), 0.0)
        bulk = magnitude_of(nodes.driven[0], self._units)
        for start in range(0, len(doubtful), _BLOCK):
            chosen = doubtful[start : start + _BLOCK]
            place = left[chosen]
            h = time[chosen] - nodes.time[place]
            fits = good[chosen] & self._fits(
                h, orders[:, :, place], pace[place], bulk[place], out, chosen
            )
            if not fits.all():
                return out, float(time[chosen[int(np.argmin(fits))]])
        return out, None

    def _plain(
        self, nodes: Nodes, time: FloatArray, out: FloatArray, left: IndexArray
    ) -> BoolArray:
        """Samples that can be nowhere else: a closed form keeps to its root between moments where
        it does, unless its figure has been near zero, and no angle comes to where it wraps.
        """
        if len(self._layout.iterated[0]) or len(nodes.time) < 2:
            return np.zeros(len(left), dtype=bool)
        figure = nodes.out[self._layout.outputs.conditioning]
        least = 0.5 * np.minimum(figure[:-1], figure[1:])
        rows = self._layout.angles
        away = np.abs(nodes.out[rows] - self._watched.centres[:, None])
        swing = np.abs(nodes.out[self._layout.outputs.derivative(rows, 1), :-1]) * _SWING
        h = nodes.time[1:] - nodes.time[:-1]
        wrapping = np.maximum(away[:, :-1] + swing * h, away[:, 1:])
        least[~(wrapping.max(axis=0, initial=0.0) < np.pi - _MARGIN)] = np.inf
        covered = nodes.time[0] <= time[0] and time[-1] <= nodes.time[-1]
        least = np.append(least, least[-1] if covered else np.inf)  # the last may be at the end
        plain: BoolArray = out[self._layout.outputs.conditioning] > least[left]
        return plain

    def _fits(
        self,
        h: FloatArray,
        before: FloatArray,
        pace: FloatArray,
        bulk: FloatArray,
        out: FloatArray,
        chosen: IndexArray,
    ) -> BoolArray:
        """Which of these samples follow from the moment before them; their angles count on."""
        found = out[:, chosen]
        after = self._orders_of(found)
        watched = self._watched
        turns = missing_turns(h, before, after, watched.turning)
        if np.any(turns):
            after[0] += 2 * np.pi * np.nan_to_num(turns)
            out[np.ix_(watched.rows, chosen)] = after[0]
        noise = self._course.noise
        with np.errstate(invalid="ignore"):
            digits = self._digits(found)
            smooth = follows(h, before, after, pace, watched.units, digits, bulk, noise)
        fits: BoolArray = np.logical_and.reduce(smooth[watched.solved])
        return fits


def joined(*parts: Nodes) -> Nodes:
    return Nodes(*(np.concatenate(arrays, axis=-1) for arrays in zip(*parts, strict=True)))
