"""Integration of a state over time, until its plan's rows lose their grip.

SciPy's DOP853 (Dormand and Prince, of order 8, with dense output of order 7) is kept and tested by
others, and takes efforts that are Python functions; so is and does its Radau, for what is stiff.
heyoka's Taylor series, on request, are exact to the last digits, and know constant efforts alone.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from parakin.arrays import FloatArray
from parakin.kernel.backends import Taylor

_ASIDE = 0.02  # of a step: where slopes of its polynomial are taken
_FINEST = 2.3e-14  # rtol, as SciPy has it
_COUNTED = 2000  # steps over which it is seen how fast time goes by
_MOST = 5e7  # evaluations, if it went on like that to the end: more are not worth waiting for
STIFF = "its steps have become too short; method 'radau' is for what is stiff"
VANISHED = "its steps have vanished"


class Integrated(NamedTuple):
    """states: those at any times (n,) within, (s, n). knots (k,): from the first time to the last
    [s], the states being smooth between two. lost: whether the end came early, since nothing was
    left; failed: or since steps were too short, and why. evaluations: of the rates, where known.
    """

    states: Callable[[FloatArray], FloatArray]
    knots: FloatArray
    last: FloatArray
    lost: bool
    failed: str
    evaluations: int = 0

    @property
    def end(self) -> float:
        return float(self.knots[-1])

    def slopes(self, times: FloatArray) -> FloatArray:
        """The states' rates (s, n) as their polynomials have them, to 1e-4 of a step's change."""
        if len(self.knots) < 2:
            return np.zeros((len(self.last), len(times)))
        at = np.clip(np.searchsorted(self.knots, times) - 1, 0, len(self.knots) - 2)
        width = _ASIDE * np.diff(self.knots)[at]
        slopes: FloatArray = self.states(times + width) - self.states(times - width)
        return slopes / (2.0 * width)


def resting(state: FloatArray, time: float, failed: str) -> Integrated:
    """Of not a single step."""
    at = partial(np.repeat, state[:, None], axis=1)
    return Integrated(lambda times: at(len(times)), np.array([time]), state, False, failed)


def integrated(
    rates: Callable[[float, FloatArray], FloatArray],
    left: Callable[[float, FloatArray], float],
    state: FloatArray,
    span: tuple[float, float],
    *,
    rtol: float,
    scales: FloatArray,
    step: float,
    stiff: bool,
) -> Integrated:
    """From a state (s,) on, until nothing is `left` or to the end of the span [s]. rtol: of each
    component in each step. scales (s,): what counts as one of each; step: the longest [s]; stiff:
    by the implicit Radau method.
    """
    from scipy.integrate import DOP853, OdeSolution, Radau

    method = Radau if stiff else DOP853
    each = rtol / np.sqrt(len(state))  # SciPy bounds the root of the mean of squares
    bounds = {"rtol": max(each, _FINEST), "atol": each * scales}
    with np.errstate(all="ignore"):  # what runs away ends, and is flagged
        way = method(rates, span[0], state, span[1], max_step=step, **bounds)
        knots, pieces, lost, failed = [span[0]], [], False, ""
        if not np.isfinite(way.h_abs):
            return resting(state, span[0], VANISHED)
        mark = (way.t, way.nfev)
        while way.status == "running" and not lost:
            way.step()
            if way.status == "failed" or not np.isfinite(way.y).all():
                failed = VANISHED
                break
            knots.append(float(way.t))
            pieces.append(way.dense_output())
            lost = not left(way.t, way.y) > 0.0
            if len(pieces) % _COUNTED == 0:
                pace = (way.nfev - mark[1]) / (way.t - mark[0])
                bounded = 2.0 * (way.t - mark[0]) > _COUNTED * step  # they could not be longer
                if not bounded and pace * (span[1] - span[0]) > _MOST:
                    failed = VANISHED if stiff else STIFF
                    break
                mark = (way.t, way.nfev)
        if lost:
            knots[-1] = _last_time(left, pieces[-1], knots[-2], knots[-1])
            if not knots[-1] > knots[-2]:
                knots, pieces = knots[:-1], pieces[:-1]
        if not pieces:
            return resting(state, span[0], failed)
    last = way.y if not lost else pieces[-1](knots[-1])
    return Integrated(OdeSolution(knots, pieces), np.array(knots), last, lost, failed, way.nfev)


def _last_time(
    left: Callable[[float, FloatArray], float],
    states: Callable[[float], FloatArray],
    begin: float,
    end: float,
) -> float:
    """When nothing is left, between two times [s]."""
    from scipy.optimize import brentq

    ends = [left(time, states(time)) for time in (begin, end)]
    if not (ends[0] > 0.0 > ends[1]):
        return end
    return float(brentq(lambda time: left(time, states(time)), begin, end))


def by_taylor(
    flow: Taylor,
    given: FloatArray,
    left: Callable[[float, FloatArray], float],
    state: FloatArray,
    span: tuple[float, float],
) -> Integrated:
    """The same by Taylor series, what is `given` beside the state being constant."""
    found = flow(state, given, span, lambda time, there: left(time, there) > 0.0)
    output = found.output
    if output is None:
        return resting(state, span[0], VANISHED)
    return Integrated(
        lambda times: output(times).T.copy(),
        np.array(output.times),
        found.last,
        found.stopped,
        VANISHED if found.failed else "",
    )


def runge_kutta(
    rates: Callable[[float, FloatArray], FloatArray],
    state: FloatArray,
    span: tuple[float, float],
    count: int,
) -> FloatArray:
    """A batch of states (s, n) after so many steps of the classical method of order 4."""
    begin, end = span
    h = (end - begin) / count
    for number in range(count):
        time = begin + number * h
        one = rates(time, state)
        two = rates(time + 0.5 * h, state + 0.5 * h * one)
        three = rates(time + 0.5 * h, state + 0.5 * h * two)
        four = rates(time + h, state + h * three)
        state = state + h / 6.0 * (one + 2.0 * (two + three) + four)
    return state
