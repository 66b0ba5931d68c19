"""Ends of declared limits as functions along a way: negative where kept, zero where met.

Position, velocity and acceleration of what is limited are known at both ends of every step, so the
quintic polynomial through them is. Its Bernstein coefficients enclose it, and tell whether it can
have left a limit and come back in between.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from parakin.arrays import BoolArray, FloatArray, IndexArray
from parakin.solving.charts import Chart
from parakin.solving.continuity import foretold

_FLAT = 1e-9  # sine of a cone angle below which its rates are none: the cosine has its greatest


@dataclass(frozen=True)
class Ends:
    """Ends of limits on positions and cone angles, m of them, as a chart's outputs have them.

    rows: of positions; sign: 1 for an upper end, -1 for a lower; ends: their values, of cones the
    cosines (which are smooth where a cone angle is not), with the sign turned; cone: which those
    are; numbers: of the stops; slack: what of going beyond is rounding.
    """

    chart: Chart
    rows: IndexArray
    sign: FloatArray
    ends: FloatArray
    cone: BoolArray
    numbers: IndexArray
    slack: FloatArray

    @staticmethod
    def of(chart: Chart) -> Ends:
        """Of all that limits positions."""
        limits, count = chart.limits, len(chart.outputs.coordinates)
        found: list[tuple[float, ...]] = []
        for number, row, low, high, slack in zip(
            limits.numbers, limits.rows, limits.low, limits.high, limits.slack, strict=True
        ):
            if row >= count:  # a limit on a rate
                continue
            cone = isinstance(chart.outputs.coordinates[row], str)
            for sign, end in ((-1.0, low), (1.0, high)):
                if cone and 0.0 < end < np.pi:
                    found.append((row, -sign, np.cos(end), cone, number, slack))
                elif not cone and np.isfinite(end):
                    found.append((row, sign, end, cone, number, slack))
        rows, signs, ends, cones, numbers, slacks = np.array(found).reshape(-1, 6).T
        places, stops = rows.astype(np.intp), numbers.astype(np.intp)
        return Ends(chart, places, signs, ends, cones.astype(bool), stops, slacks)

    @property
    def upper(self) -> BoolArray:
        """Which are upper ends."""
        found: BoolArray = (self.sign > 0.0) ^ self.cone
        return found

    def beyond(self, out: FloatArray) -> FloatArray:
        """How far outputs (rows, n) are beyond each end, and its first and second derivative,
        (3, m, n).
        """
        outputs = self.chart.outputs
        found = np.array([out[outputs.derivative(self.rows, order)] for order in range(3)])
        if self.cone.any():
            found[:, self.cone] = _cosine(*found[:, self.cone])
        found *= self.sign[:, None]
        found[0] -= (self.sign * self.ends)[:, None]
        return found


def _cosine(x: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
    """The cosine of an angle and its derivatives. Where it is 1 the angle has a kink and no rates,
    while the cosine is at its greatest.
    """
    cosine, sine = np.cos(x), np.sin(x)
    flat = np.abs(sine) < _FLAT
    first = np.where(flat, 0.0, -sine * v)
    second = np.where(flat, np.nan, -sine * a - cosine * v * v)
    return np.array([cosine, first, second])


class Verdict(NamedTuple):
    """Of each end over each step (m, n): whether it is kept throughout, and whether it is met
    exactly once; what is neither must be looked at more closely.
    """

    kept: BoolArray
    met: BoolArray


def judged(h: FloatArray, before: FloatArray, after: FloatArray, slack: FloatArray) -> Verdict:
    """What becomes of ends over steps (n,), from how far beyond each is before and after (3, m, n),
    the first being kept. NaN is neither.
    """
    before, after = _curved(h, before, after)
    points = _control_points(h, before, after)
    off = np.abs(after[0] - before[0] - foretold(h, before, after))  # falls with h⁵, as h⁶ in truth
    rising = np.diff(points, axis=0)
    monotonic = (rising >= 0.0).all(axis=0) | (rising <= 0.0).all(axis=0)
    slack = slack[:, None]
    inside = points[1:-1].max(axis=0) + off <= slack
    ended = after[0] <= slack
    crosses = ((points[1:] > 0.0) != (points[:-1] > 0.0)).sum(axis=0) == 1
    return Verdict(ended & (inside | monotonic), (after[0] > slack) & (crosses | monotonic))


def _curved(h: FloatArray, before: FloatArray, after: FloatArray) -> tuple[FloatArray, FloatArray]:
    """With second derivatives that are none (of cosines at 1) as those of the parabola."""
    if not (np.isnan(before[2]).any() or np.isnan(after[2]).any()):
        return before, after
    bend = (after[1] - before[1]) / h

    def known(states: FloatArray) -> FloatArray:
        return np.array([*states[:2], np.where(np.isnan(states[2]), bend, states[2])])

    return known(before), known(after)


def _control_points(h: FloatArray, before: FloatArray, after: FloatArray) -> FloatArray:
    """Bernstein coefficients (6, m, n) of the quintic through values, slopes and curvatures."""
    (x0, v0, a0), (x1, v1, a1) = before, after
    return np.array(
        [
            x0,
            x0 + h * v0 / 5.0,
            x0 + 2.0 * h * v0 / 5.0 + h * h * a0 / 20.0,
            x1 - 2.0 * h * v1 / 5.0 + h * h * a1 / 20.0,
            x1 - h * v1 / 5.0,
            x1,
        ]
    )
