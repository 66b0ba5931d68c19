"""The largest sine of one driven coordinate about a pose, at a frequency.

With the coordinate at s = A sin ωt a joint goes at q'(s) ω √(A² - s²), where q' is its rate by s.
It keeps a speed limit v wherever A² <= s² + (v / (ω q'))²: so the least of the right side over the
way is what A² may be, whatever A is. The least is a root of s = (v/ω)² q''/q'³.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from parakin.arrays import FloatArray
from parakin.design.answer import Alone, Amplitudes
from parakin.design.bounds import ALIKE, Bounds, moved, speed_bounds
from parakin.design.cuts import sampled
from parakin.design.rays import Ray, along, places
from parakin.design.strength import Efforts
from parakin.solving.atlas import Atlas
from parakin.solving.charts import Chart
from parakin.solving.solver import Solver

_CLOSE = 1.2  # times the least of the samples: what may turn out to be less between them
_PHASES = 65  # of half a cycle, at which efforts are sampled
_PHASE = (
    1e-8  # rad: how well the phase of the greatest effort is found; its square is what it costs
)
_TOLERANCE = 4 * np.finfo(float).eps


class Swing(NamedTuple):
    """The largest amplitude [m or rad], and which bound ends it by number, -1 for none."""

    amplitude: float
    number: int


def by_speed(atlas: Atlas, ray: Ray, most: float, bounds: Bounds, pulsation: float) -> Swing:
    """As far as speeds go, over one side of the pose; `most`, if none is met below that.

    ray: along one driven coordinate; most: an amplitude within it; pulsation: ω [rad/s].
    """
    if not bounds.coordinates:
        return Swing(most, -1)
    far = float(np.abs(ray.goal - ray.origin).max())
    w = np.maximum(np.minimum(bounds.high, -bounds.low), 0.0)[:, None] / pulsation

    def rates(chart: Chart, _: FloatArray, out: FloatArray) -> FloatArray:
        way = ray.goal - ray.origin
        found = [
            moved(chart, c, out, way, order) / far**order
            for order in (1, 2)
            for c in bounds.coordinates
        ]
        return np.array(found)

    def squares(s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """What A² may be (m, n), and half its derivative by s."""
        first, second = np.split(along(atlas, ray, s / far, rates), 2)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            still = first == 0.0  # keeps any speed limit, one of zero too
            square = np.where(still, np.inf, s * s + (w / first) ** 2)
            return square, np.where(still, s, s - w * w * second / first**3)

    s = far * sampled(ray, most / far)
    square, slope = squares(s)
    unknown = np.isnan(square).any(axis=1)
    if unknown.any():
        return Swing(np.nan, int(unknown.argmax()))
    least = square.min(axis=1)
    close = (slope[:, :-1] < 0.0) & (slope[:, 1:] > 0.0)
    close &= np.minimum(square[:, :-1], square[:, 1:]) <= _CLOSE * least.min()
    for row, k in np.argwhere(close).tolist():
        at = brentq(lambda x, row=row: float(squares(np.array([x]))[1][row, 0]), s[k], s[k + 1])
        least[row] = min(least[row], float(squares(np.array([at]))[0][row, 0]))
    amplitude = float(np.sqrt(least.min()))
    if not amplitude < (1.0 - ALIKE) * most:
        return Swing(most, -1)
    return Swing(amplitude, int(np.argmax(least <= (1.0 + ALIKE) * least.min())))


def by_effort(
    atlas: Atlas, rays: tuple[Ray, Ray], most: float, efforts: Efforts, pulsation: float
) -> Swing:
    """As far as efforts go, over both sides (down and up); `most` if they suffice for that.

    Numbers: of the actuators, whose efforts are below their bounds, then above, (2m).
    """

    def shares(amplitude: float, ray: Ray, phase: FloatArray) -> FloatArray:
        """Of the bounds, at phases (n,) up to π, (2m, n)."""
        way = ray.goal - ray.origin
        far = float(np.abs(way).max())
        found = np.empty((2 * len(efforts.bounds.high), len(phase)))
        for columns, chart, out in places(atlas, ray, amplitude / far * np.sin(phase)):
            sine, cosine = np.sin(phase[columns]), np.cos(phase[columns])
            along_way = amplitude * (way / far)[:, None]
            y = ray.origin[:, None] + along_way * sine
            yd, ydd = along_way * pulsation * cosine, -along_way * pulsation**2 * sine
            share = efforts.of(chart, out, y, yd, ydd) / efforts.bounds.high[:, None]
            found[:, columns] = np.nan_to_num(np.concatenate([-share, share]), nan=np.inf)
        return found

    def worst(amplitude: float) -> tuple[float, int]:
        """The largest share over the cycle, less one, and whose it is."""
        best, number = -np.inf, -1
        for ray in rays:
            phase = np.linspace(0.0, np.pi, _PHASES)
            found = shares(amplitude, ray, phase)
            row, k = divmod(int(found.argmax()), _PHASES)
            peak = minimize_scalar(
                lambda at, ray=ray, row=row: -float(shares(amplitude, ray, np.array([at]))[row, 0]),
                bounds=(phase[max(k - 1, 0)], phase[min(k + 1, _PHASES - 1)]),
                method="bounded",
                options={"xatol": _PHASE},
            )
            value = max(float(found[row, k]), -float(peak.fun))
            if value > best:
                best, number = value, row
        return best - 1.0, number

    if worst(most)[0] <= 0.0:
        return Swing(most, -1)
    if worst(0.0)[0] >= 0.0:
        return Swing(0.0, worst(0.0)[1])
    amplitude = float(
        brentq(lambda a: worst(a)[0], 0.0, most, xtol=_TOLERANCE * most, rtol=_TOLERANCE)
    )
    return Swing(amplitude, worst(amplitude)[1])


def amplitudes(
    solver: Solver,
    alone: Alone,
    ways: list[tuple[Ray, Ray]],
    frequency: float,
    efforts: Efforts | None,
) -> Amplitudes:
    """Of each driven coordinate alone, given how far it goes and the rays followed there."""
    speeds, pulsation = speed_bounds(solver.graph), 2.0 * np.pi * frequency
    most, words = np.empty(len(ways)), np.empty(len(ways), dtype=object)
    for i, rays in enumerate(ways):
        goes = np.abs(alone.travel[i])
        side = int(goes.argmin())
        far = min(float(np.abs(ray.goal - ray.origin).max()) for ray in rays)
        best, word = min(float(goes[side]), far), str(alone.words[i, side])
        for ray in rays:
            found = by_speed(solver.atlas, ray, best, speeds, pulsation)
            if found.number >= 0:
                upper = bool(speeds.high[found.number] <= -speeds.low[found.number])
                best, word = found.amplitude, speeds.words(found.number, upper=upper)
            if np.isnan(best):
                break
        if efforts is not None and efforts.limited and not np.isnan(best):
            found = by_effort(solver.atlas, rays, best, efforts, pulsation)
            if found.number >= 0:
                best, word = found.amplitude, efforts.words(found.number)
        most[i], words[i] = best if word else np.inf, word
    return Amplitudes(frequency, most, words)
