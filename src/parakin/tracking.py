"""Tracking: along a motion, from each pose to the next on the same branch, and nowhere else.

Where every unknown has a closed form, a pose needs no guess: all samples are solved at once and
only checked. Where Newton iterates, coarse samples are followed one after the other from home,
and those between are solved in one batch from Hermite guesses. A sample whose correction is
large against its step, or whose determinant has changed sign, is not accepted.
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from parakin.kernel import CHECKS
from parakin.motion import Samples

FloatArray = NDArray[np.float64]
StatusArray = NDArray[np.int8]

RESIDUAL = 1e-12  # of the characteristic length: what counts as closed
SINGULAR = 1e-6  # conditioning below this leaves no digits to trust in accelerations
_WRAP = -0.8  # cosine of an angle's distance from home, below which it may wrap
_STRIDE = 32
_REPEATS = 12  # runs of a kernel (two Newton steps each) before giving up
_HALVINGS = 14
_ATTEMPTS = 500  # steps of all sizes between two samples before giving up
_FOLD = 0.1  # conditioning of the last good pose, below which it is reach that ends there


class Status(enum.IntEnum):
    """What became of a sample. Anything but CONVERGED and LIMIT_EXCEEDED comes with NaN."""

    CONVERGED = 0
    ITERATION_LIMIT = 1
    OUT_OF_REACH = 2
    SINGULAR = 3
    BRANCH_CHANGE = 4
    LIMIT_EXCEEDED = 5
    NOT_REACHED = 6

    @property
    def words(self) -> str:
        return self.name.lower().replace("_", " ")


class State(NamedTuple):
    """Where a track has got to: time; driven values (orders, k), iterated coordinates (orders, m),
    each with as many derivatives as the kernel knows.
    """

    time: float
    driven: FloatArray
    found: FloatArray


@dataclass(frozen=True)
class Layout:
    """Where a kernel's outputs lie: rows of iterated coordinates (orders, m), of angles, of checks.

    `tolerance` is the residual that counts as closed [m].
    """

    found: NDArray[np.intp]
    angles: NDArray[np.intp]
    coordinates: int
    checks: int
    tolerance: float


Run = Callable[[FloatArray], FloatArray]


def classify(out: FloatArray, layout: Layout) -> StatusArray:
    """A status per sample from its residual and conditioning; of NaN, both are made NaN."""
    residual, conditioning = out[layout.checks], out[layout.checks + 1]
    status = np.zeros(out.shape[1], dtype=np.int8)
    if residual.max(initial=0.0) <= layout.tolerance and conditioning.min(initial=1.0) >= SINGULAR:
        return status
    conditioning[np.isnan(residual)] = np.nan
    status[~(conditioning >= SINGULAR)] = Status.SINGULAR
    status[conditioning < -SINGULAR] = Status.BRANCH_CHANGE
    status[~(residual <= layout.tolerance)] = Status.ITERATION_LIMIT
    status[np.isnan(residual)] = Status.OUT_OF_REACH
    return status


class Ending(NamedTuple):
    """The end of a window: time, angles as solved, their rates, and the full turns added."""

    time: float
    angles: FloatArray
    rates: FloatArray
    shift: FloatArray


def unwrap(
    out: FloatArray, layout: Layout, time: FloatArray, before: Ending | None
) -> Ending | None:
    """Let angles run on past half a turn from home, from sample to sample by their velocities.

    `before` is the end of the window before this one, what is returned that of this one.
    """
    rows = layout.angles
    if not len(rows) or not len(time):
        return before
    angles, rates = out[rows[:, None], [0, -1]], out[rows + layout.coordinates][:, [0, -1]]
    zero = np.zeros(len(rows))
    ending = Ending(float(time[-1]), angles[:, 1], rates[:, 1], zero)
    turned = before is not None and before.shift.any()
    if not (out[layout.checks + 3].min(initial=1.0) < _WRAP or turned):
        return ending
    before = before or Ending(float(time[0]), angles[:, 0], rates[:, 0], zero)
    angles = np.column_stack([before.angles, out[rows]])
    rates = np.column_stack([before.rates, out[rows + layout.coordinates]])
    expected = 0.5 * np.diff(time, prepend=before.time) * (rates[:, 1:] + rates[:, :-1])
    turns = np.nan_to_num(np.round((np.diff(angles) - expected) / (2 * np.pi)))
    shift = before.shift[:, None] - 2 * np.pi * np.cumsum(turns, axis=1)
    out[rows] += shift
    return ending._replace(shift=shift[:, -1])


def crossings(conditioning: FloatArray, status: StatusArray) -> StatusArray:
    """Flag what follows a singularity passed between two samples.

    The conditioning of a closed form is the size of a smooth quantity that keeps its sign. Where
    it falls towards zero, and from the other side does too, within one step, the quantity itself
    has changed sign: the closed form has gone on with the wrong one of its two roots. Newton,
    too, may be thrown back there from one branch onto the other.
    """
    c = conditioning
    if len(c) < 4 or not (np.fmin.reduce(c) < 0.2):
        return status
    falls = 2 * c[1:-2] - c[:-3] < 0
    rises = 2 * c[2:-1] - c[3:] < 0
    for i in np.flatnonzero(falls & rises):
        status[i + 2 :] = np.maximum(status[i + 2 :], Status.BRANCH_CHANGE)
        break
    return status


def solve_all(run: Run, samples: Samples, layout: Layout) -> tuple[FloatArray, StatusArray]:
    """Every sample at once, where all has a closed form."""
    out = run(np.concatenate(samples.orders[: len(layout.found)]))
    status = classify(out, layout)
    return out, crossings(out[layout.checks + 1], status)


def iterate(run: Run, layout: Layout, driven: FloatArray, guess: FloatArray) -> FloatArray:
    """A batch from guesses, repeated while that may help.

    driven (orders k, n): positions and derivatives; guess (m, n).
    """
    out = run(np.ascontiguousarray(np.concatenate([driven, guess])))
    residual = out[layout.checks]
    for repeat in range(_REPEATS):
        # A step or two beyond what is needed reaches round-off, and costs little.
        wanted = layout.tolerance * (0.01 if repeat < 2 else 1.0)
        if residual.max(initial=0.0) <= wanted:
            break
        open_ = ~(residual <= wanted) & _hopeful(out, layout)
        if not open_.any():
            break
        again = np.concatenate([driven[:, open_], out[layout.found[0]][:, open_]])
        out[:, open_] = run(np.ascontiguousarray(again))
    return out


def _hopeful(out: FloatArray, layout: Layout) -> NDArray[np.bool_]:
    """Whether another step may help: the iteration is finite, and it moves while what follows
    from it is still out of reach.
    """
    finite = np.isfinite(out[layout.found[0]]).all(axis=0)
    settled = np.isnan(out[layout.checks]) & ~(out[layout.checks + 2] > 1e-10)
    hopeful: NDArray[np.bool_] = finite & ~settled
    return hopeful


def _trusted(
    found: FloatArray, guess: FloatArray, before: FloatArray, axis: int | None = None
) -> NDArray[np.bool_]:
    """Whether a step's correction is small against the step, as on one branch it has to be."""
    moved = np.abs(found - before).max(axis=axis, initial=0.0)
    corrected = np.abs(found - guess).max(axis=axis, initial=0.0)
    trusted: NDArray[np.bool_] = (corrected <= 0.25 * moved + 1e-3) & (corrected <= 0.3)
    return trusted


def walk(
    run: Run, layout: Layout, begin: State, goal: FloatArray
) -> tuple[FloatArray, StatusArray]:
    """From one state to many poses `goal` (k, n), each straight and in its own steps, all at once.

    Takes outputs with one derivative at least, by which each step is foretold; in those returned
    driven coordinates move at `goal` less where they began.
    """
    with np.errstate(all="ignore"):  # goals beyond all numbers are flagged like any out of reach
        return _walked(run, layout, begin, goal)


def _walked(
    run: Run, layout: Layout, begin: State, goal: FloatArray
) -> tuple[FloatArray, StatusArray]:
    n, k = goal.shape[1], len(goal)
    start = begin.driven[0][:, None]
    driven = np.zeros((len(layout.found), k, n))
    driven[1] = goal - start

    def at(part: FloatArray, guess: FloatArray, chosen: NDArray[np.intp]) -> FloatArray:
        columns = driven[:, :, chosen]
        columns[0] = start + part * columns[1]
        return iterate(run, layout, columns.reshape(-1, len(chosen)), guess)

    here = np.repeat(begin.found[0][:, None], n, axis=1)
    part, size = np.zeros(n), np.ones(n)
    out = at(part, here, np.arange(n))
    status = classify(out, layout)
    tangent = out[layout.found[1]]
    going = np.flatnonzero(status == Status.CONVERGED)
    for _ in range(_ATTEMPTS):
        if not len(going):
            return out, status
        target = np.minimum(part[going] + size[going], 1.0)
        guess = here[:, going] + (target - part[going]) * tangent[:, going]
        found = at(target, guess, going)
        verdict = classify(found, layout)
        position = found[layout.found[0]]
        doubtful = ~_trusted(position, guess, here[:, going], axis=0)
        verdict[(verdict == Status.CONVERGED) & doubtful] = Status.BRANCH_CHANGE
        good = verdict == Status.CONVERGED
        done = going[good]
        here[:, done], part[done] = position[:, good], target[good]
        tangent[:, done] = found[layout.found[1]][:, good]
        size[done] *= 2.0
        size[going[~good]] *= 0.5
        stuck = size[going] < 0.5**_HALVINGS
        given_up = stuck & np.isin(verdict, (Status.ITERATION_LIMIT, Status.BRANCH_CHANGE))
        verdict[given_up] = Status.NOT_REACHED
        out[:, going], status[going] = found, verdict
        going = going[~(good & (target == 1.0)) & ~stuck]
    status[going] = Status.NOT_REACHED
    return out, status


_START = np.array([[1, 0, 0, -10, 15, -6], [0, 1, 0, -6, 8, -3], [0, 0, 0.5, -1.5, 1.5, -0.5]])
_END = np.array([[0, 0, 0, 10, -15, 6], [0, 0, 0, -4, 7, -3], [0, 0, 0, 0.5, -1, 0.5]])


def hermite(nodes: FloatArray, values: FloatArray, at: FloatArray, order: int = 0) -> FloatArray:
    """Quintic Hermite interpolation: nodes (K,), values with two derivatives or more (3+, m, K).

    Returns (m, len(at)), or its derivative of the given order.
    """
    left = np.clip(np.searchsorted(nodes, at, side="right") - 1, 0, len(nodes) - 2)
    h = nodes[left + 1] - nodes[left]
    x = (at - nodes[left]) / h
    total = np.zeros((values.shape[1], len(at)))
    for k in range(3):
        for table, node in ((_START[k], left), (_END[k], left + 1)):
            poly = np.polynomial.polynomial.polyder(table, order) if order else table
            weight = np.polynomial.polynomial.polyval(x, poly) * h ** (k - order)
            total += values[k][:, node] * weight
    return total


class Tracker:
    """Follows a motion where Newton iterates; keeps the last good state between windows."""

    def __init__(self, run: Run, layout: Layout, home: State) -> None:
        self._run = run
        self._layout = layout
        self._figure = 1.0  # conditioning of the last good pose
        self.state = home

    def solve(self, y: FloatArray, guess: FloatArray) -> FloatArray:
        """A batch from guesses: y (orders, k, n), guess (m, n)."""
        return iterate(self._run, self._layout, y.reshape(-1, y.shape[2]), guess)

    def _reached(self, time: float, y: FloatArray, out: FloatArray) -> None:
        self.state = State(time, y, out[self._layout.found])
        self._figure = float(out[self._layout.checks + 1])

    def step(self, time: float, y: FloatArray) -> tuple[FloatArray, Status]:
        """One step from the last state to `y` (orders, k), accepted only on the same branch."""
        a = self.state
        h = time - a.time
        guess = a.found[0] + h * a.found[1] + 0.5 * h * h * a.found[2]
        out = self.solve(y[:, :, None], guess[:, None])
        status = Status(int(classify(out, self._layout)[0]))
        if status == Status.CONVERGED:
            if not _trusted(out[self._layout.found[0], 0], guess, a.found[0]):
                return out, Status.BRANCH_CHANGE
            self._reached(time, y, out[:, 0])
        return out, status

    def enter(self, time: float, y: FloatArray) -> tuple[FloatArray, Status]:
        """From home to where a motion begins."""
        out, status = walk(self._run, self._layout, self.state, y[0][:, None])
        verdict = Status(int(status[0]))
        if verdict == Status.CONVERGED:
            out = self.solve(y[:, :, None], out[self._layout.found[0]])
            self._reached(time, y, out[:, 0])
        return out, verdict

    def reach(self, time: float, y: FloatArray) -> tuple[FloatArray, Status]:
        """From the last state to `y` in as many steps as it takes.

        In between, the driven values follow a quintic in time. Gives up, leaving the state at the
        last good pose, when steps become tiny.
        """
        begin = self.state
        nodes, ends = np.array([begin.time, time]), np.stack([begin.driven, y], axis=2)
        fraction, size = 0.0, 1.0
        for _ in range(_ATTEMPTS):
            last = fraction + size >= 1.0
            target = 1.0 if last else fraction + size
            at = begin.time + target * (time - begin.time)
            there = [hermite(nodes, ends, np.array([at]), order)[:, 0] for order in range(len(y))]
            out, status = self.step(at, y if last else np.array(there))
            if status == Status.CONVERGED:
                if last:
                    return out, status
                fraction, size = target, min(2 * size, 1.0)
            elif size < 0.5**_HALVINGS:
                return out, Status.OUT_OF_REACH if self._figure < _FOLD else status
            else:
                size /= 2
        return out, Status.ITERATION_LIMIT

    def follow(self, samples: Samples) -> tuple[FloatArray, StatusArray]:
        """All samples of a window: coarse ones one by one, then those between in one batch."""
        n, time = len(samples.time), samples.time
        y = np.array(samples.orders[: len(self._layout.found)])
        out = np.full((self._layout.checks + CHECKS, n), np.nan)
        status = np.full(n, Status.NOT_REACHED, dtype=np.int8)
        nodes, states = [-1], [self.state]
        while nodes[-1] < n - 1:
            goal = 0 if nodes[-1] < 0 else min(nodes[-1] + _STRIDE, n - 1)
            if np.isnan(self.state.time):
                column, verdict = self.enter(float(time[goal]), y[:, :, goal])
            else:
                column, verdict = self.step(float(time[goal]), y[:, :, goal])
                if verdict != Status.CONVERGED:  # sample by sample through the hard part
                    goal = nodes[-1] + 1
                    column, verdict = self.reach(float(time[goal]), y[:, :, goal])
            status[goal] = verdict
            if verdict != Status.CONVERGED:
                break
            out[:, goal] = column[:, 0]
            nodes.append(goal)
            states.append(self.state)
        between = np.setdiff1d(np.arange(max(nodes[-1], 0)), nodes)
        if len(between):
            self._fill(time, y, out, status, between, states)
            failed = between[status[between] != Status.CONVERGED]
            if len(failed):
                self._retrace(time, y, out, status, nodes, states)
        return out, crossings(out[self._layout.checks + 1], status)

    def _fill(
        self,
        time: FloatArray,
        y: FloatArray,
        out: FloatArray,
        status: StatusArray,
        between: NDArray[np.intp],
        states: list[State],
    ) -> None:
        """Samples between the coarse ones, from guesses interpolated between those."""
        inside = [state for state in states if state.time >= time[0]]
        times = np.array([state.time for state in inside])
        found = np.stack([state.found for state in inside], axis=2)
        guess = hermite(times, found, time[between])
        solved = self.solve(np.ascontiguousarray(y[:, :, between]), guess)
        verdict = classify(solved, self._layout)
        corrected = np.abs(solved[self._layout.found[0]] - guess).max(axis=0, initial=0.0)
        moves = np.abs(np.diff(found[0], axis=1)).max(axis=0, initial=0.0)
        segment = np.clip(np.searchsorted(times, time[between], "right") - 1, 0, len(moves) - 1)
        far = ~(corrected <= 0.25 * moves[segment] + 1e-3)
        verdict[(verdict == Status.CONVERGED) & far] = Status.BRANCH_CHANGE
        out[:, between], status[between] = solved, verdict

    def _retrace(
        self,
        time: FloatArray,
        y: FloatArray,
        out: FloatArray,
        status: StatusArray,
        nodes: list[int],
        states: list[State],
    ) -> None:
        """Segments in which the batch failed, sample by sample; where that fails too, the end."""
        final = self.state
        for (first, state), last in zip(zip(nodes, states, strict=True), nodes[1:], strict=False):
            if (status[first + 1 : last] == Status.CONVERGED).all():
                continue
            self.state = state
            for i in range(first + 1, last + 1):
                column, verdict = self.reach(float(time[i]), y[:, :, i])
                status[i] = verdict
                if verdict != Status.CONVERGED:
                    status[i + 1 :] = Status.NOT_REACHED
                    out[:, i:] = np.nan
                    return
                out[:, i] = column[:, 0]
            if not np.allclose(self.state.found[0], states[nodes.index(last)].found[0], atol=1e-8):
                # The coarse step had come to another branch: all that follows it is void.
                status[last:] = Status.NOT_REACHED
                status[last] = Status.BRANCH_CHANGE
                out[:, last:] = np.nan
                return
        self.state = final
