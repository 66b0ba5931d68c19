"""Integration of a state over time, until its plan's rows lose their grip.

SciPy's DOP853 (Dormand and Prince, of order 8, with dense output of order 7) is kept and tested by
others, and takes efforts that are Python functions. heyoka's Taylor series, on request, are exact
to the last digits, and know constant efforts alone.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from parakin.arrays import FloatArray
from parakin.kernel.backends import Taylor

_ASIDE = 0.02  # of a step: where slopes of its polynomial are taken


class Integrated(NamedTuple):
    """states: those at any times (n,) within, (s, n). knots (k,): from the first time to the last
    [s], the states being smooth between two. lost: whether the end came early, since nothing was
    left; failed: or since steps vanished.
    """

    states: Callable[[FloatArray], FloatArray]
    knots: FloatArray
    last: FloatArray
    lost: bool
    failed: bool

    @property
    def end(self) -> float:
        return float(self.knots[-1])

    def slopes(self, times: FloatArray) -> FloatArray:
        """The states' rates (s, n) as their polynomials have them, to 1e-4 of a step's change."""
        at = np.clip(np.searchsorted(self.knots, times) - 1, 0, max(len(self.knots) - 2, 0))
        width = _ASIDE * np.diff(self.knots)[at]
        slopes: FloatArray = self.states(times + width) - self.states(times - width)
        return slopes / (2.0 * width)


def integrated(
    rates: Callable[[float, FloatArray], FloatArray],
    left: Callable[[float, FloatArray], float],
    state: FloatArray,
    span: tuple[float, float],
    *,
    rtol: float,
    scales: FloatArray,
    step: float,
) -> Integrated:
    """From a state (s,) on, until nothing is `left` or to the end of the span [s]. scales (s,):
    what counts as one of each; step: the longest [s].
    """
    from scipy.integrate import solve_ivp

    left.terminal = True  # type: ignore[attr-defined]
    found = solve_ivp(
        rates,
        span,
        state,
        method="DOP853",
        events=left,
        rtol=rtol,
        atol=rtol * scales,
        max_step=step,
        dense_output=True,
    )
    lost, failed = found.status == 1, found.status < 0
    return Integrated(found.sol, np.array(found.sol.ts), found.y[:, -1], lost, failed)


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
    if output is None:  # not a single step
        return Integrated(
            lambda t: np.full((len(state), len(t)), np.nan), np.array(span[:1]), state, False, True
        )
    return Integrated(
        lambda times: output(times).T.copy(),
        np.array(output.times),
        found.last,
        found.stopped,
        found.failed,
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
