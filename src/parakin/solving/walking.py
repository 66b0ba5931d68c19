"""From guesses to poses: iteration on a batch, and the walk from home to many poses at once."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from parakin.algebra.spatial import as_array
from parakin.arrays import BoolArray, FloatArray, IndexArray, StatusArray
from parakin.kinematics.configuration import Configuration
from parakin.solving.charts import Chart
from parakin.solving.continuity import ASIDE, follows, magnitude_of, stays_clear
from parakin.solving.status import (
    RESIDUAL,
    Layout,
    Status,
    classify,
    converged,
)

CLOSED = 0.01 * RESIDUAL  # what is aimed at by the first steps
_REPEATS = 12  # runs of a kernel (a few Newton steps each) before giving up
_HALVINGS = 14
_SHORT = 1e-4  # of a unit: ways shorter than this count as none
REGULAR = 1e-3  # regularity below this counts as singular
_SERVES = 0.1  # conditioning that a chart must have where it takes over
_SAME = 1e-9  # radians and characteristic lengths between a pose on one chart and on the next
_TO_THE_SIDE = 1e-3  # of a unit
_TOLD = 1e-12  # conditioning below this has no sign
_ATTEMPTS = 500  # steps of all sizes on one way before giving up


class State(NamedTuple):
    """A pose: driven values (orders, k), iterated coordinates (orders, m), each with as many
    derivatives as the kernel knows. Of many designs a pose each, (orders, k, n) and (orders, m, n),
    with what tells the kernel the design (g, n).
    """

    driven: FloatArray
    iterated: FloatArray
    given: FloatArray | None = None


def iterate(
    chart: Chart, driven: FloatArray, guess: FloatArray, *, parallel: bool = False
) -> FloatArray:
    """A batch from guesses, repeated while that may help.

    driven (orders k, n): positions and derivatives; guess (m, n). A column that does not close at
    once has been thrown far, and its last digit may decide where to; and the rounding of machine
    code depends on what else is in a vector. So such a column starts again in a vector of its own.
    """
    layout = chart.layout
    inputs = np.ascontiguousarray(np.concatenate([driven, guess]))
    out = chart.run(inputs, parallel=parallel)
    open_ = np.flatnonzero(~(out[layout.outputs.residual] <= CLOSED * out[layout.outputs.size]))
    if not len(open_):
        return out
    again, known = inputs[:, open_], len(driven)
    for repeat in range(_REPEATS):
        found = chart.run(again.repeat(chart.lanes, axis=1))[:, :: chart.lanes]
        out[:, open_] = found
        # A step or two beyond what is needed reaches round-off, and costs little.
        wanted = CLOSED if repeat < 2 else RESIDUAL
        closed = found[layout.outputs.residual] <= wanted * found[layout.outputs.size]
        kept = ~closed & _hopeful(found, layout)
        if not kept.any():
            break
        open_, again = open_[kept], again[:, kept]
        again[known:] = found[layout.iterated[0]][:, kept]
    return out


def _hopeful(out: FloatArray, layout: Layout) -> BoolArray:
    """Whether another step may help: the iteration is finite and, where what follows from it is
    out of reach, still moving.
    """
    finite = np.isfinite(out[layout.iterated[0]]).all(axis=0)
    settled = np.isnan(out[layout.outputs.residual]) & ~(out[layout.outputs.step] > 1e-10)
    hopeful: BoolArray = finite & ~settled
    return hopeful


def carried_over(chart: Chart, driven: FloatArray, before: Configuration) -> FloatArray | None:
    """Outputs (rows, 1) on this chart of a pose found on another one, if it serves there and the
    mechanism stands the same. driven (orders, k, 1).
    """
    out = _standing_at(chart, driven, before)
    serves = converged(out, chart.layout)[0] and out[chart.outputs.conditioning, 0] > _SERVES
    return out if serves and _same(chart, driven, out, before) else None


def conditioning_beside(
    chart: Chart, other: Chart, driven: FloatArray, found: FloatArray, units: FloatArray
) -> float:
    """The conditioning of a chart a little to the side of a pose where it is singular and another,
    which has `found` it, is not: its sign tells the branch. NaN if they agree nowhere beside it.

    driven (orders, k, 1); units: of the k driven coordinates.
    """
    best = np.nan
    for row, way in itertools.product(range(driven.shape[1]), (_TO_THE_SIDE, -_TO_THE_SIDE)):
        moved = np.zeros_like(driven)
        moved[0] = driven[0]
        moved[0, row] += way * units[row]
        out = iterate(other, moved.reshape(-1, 1), found[other.layout.iterated[0]])
        if not converged(out, other.layout)[0]:
            continue
        at = other.configuration(moved[0, :, 0], out[:, 0])
        mine = _standing_at(chart, moved, at)
        figure = float(mine[chart.outputs.conditioning, 0])
        if abs(figure) > _TOLD and not abs(figure) <= abs(best) and _same(chart, moved, mine, at):
            best = figure
    return best


def _standing_at(chart: Chart, driven: FloatArray, at: Configuration) -> FloatArray:
    """Outputs (rows, 1) for driven values (orders, k, 1), from a configuration as the guess."""
    plan, q = chart.plan, chart.coordinates_at(at)
    guess = np.array([[q[k] - plan.offset(k)] for k in plan.iterated]).reshape(-1, 1)
    return iterate(chart, driven.reshape(-1, 1), guess)


def _same(chart: Chart, driven: FloatArray, out: FloatArray, at: Configuration) -> bool:
    """Whether the mechanism stands as in a configuration of another chart; NaN does not."""
    return _apart(at, chart.configuration(driven[0, :, 0], out[:, 0])) < _SAME


def _apart(one: Configuration, other: Configuration) -> float:
    """How far the bodies of a mechanism are from where they are in another configuration."""
    length, worst = one.circuits.graph.length, 0.0
    for body in range(len(one.circuits.graph.plain.bodies)):
        here, there = one.circuits.pose(body), other.circuits.pose(body)
        places, turns = as_array(here.p - there.p), as_array(here.R) - as_array(there.R)
        worst = max(worst, float(np.abs(places).max()) / length, float(np.abs(turns).max()))
    return worst


def walk(
    chart: Chart, begin: State, goal: FloatArray, units: FloatArray
) -> tuple[FloatArray, StatusArray, FloatArray]:
    """Walk from one state to many poses `goal` (k, n), each straight and in its own steps, all at
    once. Returns outputs, a status for each way, and the part of it (n,) at which the outputs are.

    The chart needs two derivatives, by which each step is predicted and checked. In the outputs,
    driven coordinates move with the velocity that covers a way in one second. units (k,): of the
    driven coordinates.
    """
    with np.errstate(all="ignore"):  # goals that overflow are flagged like any out of reach
        return _walked(chart, begin, goal, units)


class Ways:
    """Many straight ways from one state, each covered as its part goes from 0 to 1."""

    def __init__(self, chart: Chart, begin: State, goal: FloatArray, units: FloatArray) -> None:
        self.chart = chart
        self.start = begin.driven[0].reshape(len(goal), -1)
        self.way = goal - self.start
        self.given = begin.given
        self.pace = np.abs(self.way / units[:, None]).max(axis=0, initial=_SHORT)
        self.bulk = magnitude_of(goal, units)
        self.all = np.arange(goal.shape[1])
        self._driven = np.zeros((len(chart.layout.iterated), *goal.shape))
        self._driven[1] = self.way

    def at(self, part: FloatArray, guess: FloatArray, chosen: IndexArray) -> FloatArray:
        """Outputs at these parts of the ways chosen."""
        columns = self._driven if chosen is self.all else self._driven[:, :, chosen]
        np.multiply(columns[1], part, out=columns[0])
        alone = self.start.shape[1] == 1 or chosen is self.all
        columns[0] += self.start if alone else self.start[:, chosen]
        orders, k, n = columns.shape
        rows = columns.reshape(orders * k, n)
        if self.given is not None:
            given = self.given if chosen is self.all else self.given[:, chosen]
            rows = np.concatenate([rows, given])
        return iterate(self.chart, rows, guess)

    def begun(self, begin: State) -> tuple[FloatArray, FloatArray]:
        """Outputs (rows, n) where the ways begin, and the position, velocity and acceleration
        (3, m, n) with which iterated coordinates set off on each, covering it in one second.
        """
        if self.given is None:
            home, begun = _set_off(self.chart, begin, self.way)
            return home.repeat(len(self.all), axis=1), begun
        home = self.at(np.zeros(len(self.all)), begin.iterated[0], self.all)
        return home, home[self.chart.layout.outputs.motion].reshape(3, -1, len(self.all))

    def smooth(
        self,
        chosen: IndexArray,
        parts: tuple[FloatArray, FloatArray],
        states: tuple[FloatArray, FloatArray],
        outputs: tuple[FloatArray, FloatArray],
    ) -> BoolArray:
        """Which steps one smooth motion leads over, from one part to the next, given the unknowns'
        position, velocity and acceleration (3, m, n) and the outputs at both ends.
        """
        layout = self.chart.layout
        figure = layout.outputs.unsigned
        (part, target), (begun, ended), (out, found) = parts, states, outputs
        h = target - part
        digits = self.chart.digits_factor * found[layout.outputs.conditioning]
        follow = follows(
            h, begun, ended, self.pace[chosen], layout.units, digits, self.bulk[chosen]
        )
        smooth: BoolArray = np.logical_and.reduce(follow)
        if layout.unsigned:
            aside = ASIDE * h
            sides = ((part, begun, aside), (target, ended, -aside))
            near = [self.at(at + on, x + on * v, chosen)[figure] for at, (x, v, _), on in sides]
            smooth &= stays_clear(h, out[figure], found[figure], *near)
        return smooth


def _walked(
    chart: Chart, begin: State, goal: FloatArray, units: FloatArray
) -> tuple[FloatArray, StatusArray, FloatArray]:
    n, layout = goal.shape[1], chart.layout
    ways = Ways(chart, begin, goal, units)
    out, begun = ways.begun(begin)
    verdicts = classify(out, layout)
    part, size, going = np.zeros(n), np.ones(n), ways.all
    if verdicts.any():
        if begin.given is None:
            return out, verdicts, part
        going = np.flatnonzero(verdicts == Status.CONVERGED)
        begun = begun[:, :, going]
    for _ in range(_ATTEMPTS):
        if not len(going):
            return out, verdicts, part
        target = np.minimum(part[going] + size[going], 1.0)
        h = target - part[going]
        x, v, a = begun
        found = ways.at(target, x + h * (v + 0.5 * h * a), going)
        verdict = classify(found, layout)
        ended = found[layout.outputs.motion].reshape(begun.shape)
        before = out if going is ways.all else out[:, going]
        smooth = ways.smooth(going, (part[going], target), (begun, ended), (before, found))
        verdict[(verdict == Status.CONVERGED) & ~smooth] = Status.BRANCH_CHANGE
        good = verdict == Status.CONVERGED
        there = good & (target == 1.0)
        if there.all() and going is ways.all:
            return found, verdict, target
        size[going] *= np.where(good, 2.0, 0.5)
        stuck = ~good & (size[going] < 0.5**_HALVINGS)
        if stuck.any():
            unclear = (verdict == Status.ITERATION_LIMIT) | (verdict == Status.BRANCH_CHANGE)
            verdict[stuck & unclear] = Status.NOT_REACHED
        part[going] = np.where(good, target, part[going])
        back = np.flatnonzero(~good)  # what is stuck stays where it got to
        found[:, back] = before[:, back]
        ended[:, :, back] = begun[:, :, back]
        if going is ways.all:
            out, verdicts = found, verdict
        else:
            out[:, going], verdicts[going] = found, verdict
        on = np.flatnonzero(~(there | stuck))
        going, begun = going[on], ended[:, :, on]
    verdicts[going] = Status.NOT_REACHED
    return out, verdicts, part


def _set_off(chart: Chart, begin: State, way: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Outputs (rows, 1) where many ways (k, n) begin, and the position, velocity and acceleration
    (3, m, n) with which iterated coordinates set off on each, covering it in one second.

    Velocities are linear in those driven and accelerations quadratic.
    """
    layout, k = chart.layout, len(way)
    pairs = [(i, j) for i in range(k) for j in range(i, k)]
    driven = np.zeros((len(layout.iterated), k, 1 + len(pairs)))
    driven[0] = begin.driven[0][:, None]
    for column, (i, j) in enumerate(pairs, 1):
        driven[1, i, column] = driven[1, j, column] = 1.0
    guess = begin.iterated[0][:, None].repeat(1 + len(pairs), axis=1)
    home = iterate(chart, driven.reshape(len(layout.iterated) * k, -1), guess)
    x, velocity, acceleration = home[layout.outputs.motion].reshape(3, -1, 1 + len(pairs))[:, :, 1:]
    alone = [column for column, (i, j) in enumerate(pairs) if i == j]
    second = acceleration.copy()
    for column, (i, j) in enumerate(pairs):
        if i != j:
            second[:, column] -= acceleration[:, alone[i]] + acceleration[:, alone[j]]
    products = np.empty((len(pairs), way.shape[1]))
    for product, (i, j) in zip(products, pairs, strict=True):
        np.multiply(way[i], way[j], out=product)
    begun = np.empty((3, len(x), way.shape[1]))
    begun[0] = x[:, :1]
    begun[1] = _weighted(velocity[:, alone], way)
    begun[2] = _weighted(second, products)
    return home[:, :1], begun


def _weighted(weights: FloatArray, columns: FloatArray) -> FloatArray:
    """The product of weights (m, k) and columns (k, n), each column rounded as in any other batch,
    where a matrix product rounds by the shape of the whole. (Of one column alone einsum sums
    otherwise too.)
    """
    n = columns.shape[1]
    wide = columns if n > 1 else columns.repeat(2, axis=1)
    total: FloatArray = np.einsum("mk,kn->mn", weights, wide)
    return total[:, :n]
