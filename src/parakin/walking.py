"""From guesses to poses: iteration on a batch, and the walk from home to many poses at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from parakin.atlas import Chart
from parakin.continuity import ASIDE, follows, stays_clear
from parakin.status import RESIDUAL, FloatArray, Layout, Status, StatusArray, classify

CLOSED = 0.01 * RESIDUAL  # what is aimed at by the first steps
_REPEATS = 12  # runs of a kernel (a few Newton steps each) before giving up
_HALVINGS = 14
_SHORT = 1e-4  # of a unit: a way no longer than this is all but none
_ATTEMPTS = 500  # steps of all sizes on one way before giving up


class State(NamedTuple):
    """A pose: driven values (orders, k), iterated coordinates (orders, m), each with as many
    derivatives as the kernel knows.
    """

    driven: FloatArray
    found: FloatArray


def iterate(
    chart: Chart, driven: FloatArray, guess: FloatArray, *, parallel: bool = False
) -> FloatArray:
    """A batch from guesses, repeated while that may help.

    driven (orders k, n): positions and derivatives; guess (m, n). What does not close at once has
    been thrown far, and the last digit may decide where to; machine code rounds by what else is in
    a vector. So it begins anew with a vector to itself.
    """
    layout = chart.layout
    inputs = np.ascontiguousarray(np.concatenate([driven, guess]))
    out = chart.run(inputs, parallel=parallel)
    open_ = np.flatnonzero(~(out[layout.checks] <= CLOSED * out[layout.checks + 3]))
    if not len(open_):
        return out
    again, known = inputs[:, open_], len(driven)
    for repeat in range(_REPEATS):
        found = chart.run(again.repeat(chart.lanes, axis=1))[:, :: chart.lanes]
        out[:, open_] = found
        # A step or two beyond what is needed reaches round-off, and costs little.
        wanted = CLOSED if repeat < 2 else RESIDUAL
        closed = found[layout.checks] <= wanted * found[layout.checks + 3]
        kept = ~closed & _hopeful(found, layout)
        if not kept.any():
            break
        open_, again = open_[kept], again[:, kept]
        again[known:] = found[layout.found[0]][:, kept]
    return out


def _hopeful(out: FloatArray, layout: Layout) -> NDArray[np.bool_]:
    """Whether another step may help: the iteration is finite, and it moves while what follows
    from it is still out of reach.
    """
    finite = np.isfinite(out[layout.found[0]]).all(axis=0)
    settled = np.isnan(out[layout.checks]) & ~(out[layout.checks + 2] > 1e-10)
    hopeful: NDArray[np.bool_] = finite & ~settled
    return hopeful


def walk(
    chart: Chart, begin: State, goal: FloatArray, units: FloatArray
) -> tuple[FloatArray, StatusArray]:
    """From one state to many poses `goal` (k, n), each straight and in its own steps, all at once.

    Takes a chart with two derivatives, by which each step is foretold and judged; in those
    returned driven coordinates move at `goal` less where they began. units (k,): of these.
    """
    with np.errstate(all="ignore"):  # goals beyond all numbers are flagged like any out of reach
        return _walked(chart, begin, goal, units)


def _walked(
    chart: Chart, begin: State, goal: FloatArray, units: FloatArray
) -> tuple[FloatArray, StatusArray]:
    n, k = goal.shape[1], len(goal)
    layout = chart.layout
    start = begin.driven[0][:, None]
    driven = np.zeros((len(layout.found), k, n))
    driven[1] = goal - start
    pace = np.abs(driven[1] / units[:, None]).max(axis=0, initial=_SHORT)

    def at(part: FloatArray, guess: FloatArray, chosen: NDArray[np.intp]) -> FloatArray:
        columns = driven[:, :, chosen]
        columns[0] = start + part * columns[1]
        return iterate(chart, columns.reshape(-1, len(chosen)), guess)

    here = np.repeat(begin.found[0][:, None], n, axis=1)
    part, size = np.zeros(n), np.ones(n)
    out = at(part, here, np.arange(n))
    status = classify(out, layout)
    now = out.copy()
    solved = layout.unknowns + layout.rows * np.arange(3)[:, None]
    going = np.flatnonzero(status == Status.CONVERGED)
    for _ in range(_ATTEMPTS):
        if not len(going):
            return out, status
        target = np.minimum(part[going] + size[going], 1.0)
        h = target - part[going]
        before = now if len(going) == n else now[:, going]
        x, v, a = before[layout.found[:3]]
        guess = x + h * (v + 0.5 * h * a)
        found = at(target, guess, going)
        verdict = classify(found, layout)
        figures = chart.grip * found[layout.checks + 1]
        ends = before[solved], found[solved]
        smooth = follows(h, *ends, pace[going], layout.units, figures).all(axis=0)
        if layout.unsigned:
            aside = ASIDE * h
            figure, row = [], layout.checks + 4
            for place, end, way in ((part[going], before, aside), (target, found, -aside)):
                x, v, _ = end[layout.found[:3]]
                figure.append(at(place + way, x + way * v, going)[row])
            smooth &= stays_clear(h, before[row], found[row], *figure)
        verdict[(verdict == Status.CONVERGED) & ~smooth] = Status.BRANCH_CHANGE
        good = verdict == Status.CONVERGED
        there = good & (target == 1.0)
        if there.all() and len(going) == n:
            return found, verdict
        size[going] *= np.where(good, 2.0, 0.5)
        stuck = ~good & (size[going] < 0.5**_HALVINGS)
        given_up = stuck & np.isin(verdict, (Status.ITERATION_LIMIT, Status.BRANCH_CHANGE))
        verdict[given_up] = Status.NOT_REACHED
        leaving, on = there | stuck, good & ~there
        out[:, going[leaving]], status[going[leaving]] = found[:, leaving], verdict[leaving]
        now[:, going[on]], part[going[on]] = found[:, on], target[on]
        going = going[~leaving]
    status[going] = Status.NOT_REACHED
    return out, status
