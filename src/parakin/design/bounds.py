"""Bounds on speeds and efforts of joints, and how much of something they leave room for."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from parakin.arrays import BoolArray, FloatArray, IndexArray
from parakin.model.graph import Graph
from parakin.solving.charts import Chart
from parakin.solving.stops import Stops

ALIKE = 1e-9  # of one another: of what differs by no more, as by symmetry, the first is named
_NONE = 1e-12  # of the largest: slopes below this are rounding, and so are differences


class Bounds(NamedTuple):
    """Of coordinates, by number: `low` and `high` (m,), SI; `stops` gives their words, from 1."""

    coordinates: tuple[int, ...]
    low: FloatArray
    high: FloatArray
    stops: Stops

    def words(self, number: int, *, upper: bool) -> str:
        """A bound as elsewhere: "P6.velocity > 0.6 m/s"; "" for number -1."""
        return self.stops.limit_words(number + 1, upper=upper) if number >= 0 else ""


def _made(rows: Sequence[tuple[int, str, str, float, float]]) -> Bounds:
    numbers = tuple(row[0] for row in rows)
    names, units = ("", *(row[1] for row in rows)), ("", *(row[2] for row in rows))
    low, high = (math.nan, *(row[3] for row in rows)), (math.nan, *(row[4] for row in rows))
    stops = Stops(names, units, low, high, ((),) * len(names))
    return Bounds(numbers, np.array(low[1:]), np.array(high[1:]), stops)


def speed_bounds(graph: Graph) -> Bounds:
    """Declared limits of velocities, and the most that drives give."""
    found = []
    for limit in graph.limited:
        if limit.order == 1:
            k = graph.index(limit.coordinate, "limits")
            found.append((k, limit.name, _unit(graph, k, "/s"), limit.low, limit.high))
    for k, motor in graph.dynamics.motors.items():
        if math.isfinite(motor.max_speed):
            name = f"{graph.coordinates[k].name}.velocity"
            most = motor.max_speed
            found.append((k, name, _unit(graph, k, "/s"), -most, most))
    return _made(found)


def effort_bounds(graph: Graph, actuated: Sequence[int]) -> Bounds:
    """The most that drives give of force or torque, of each actuator; infinite where not said."""
    found = []
    for k in actuated:
        motor, angle = graph.dynamics.motors.get(k), graph.coordinates[k].angle
        most = math.inf if motor is None else motor.max_effort
        name = f"{graph.coordinates[k].name}.effort"
        found.append((k, name, "N m" if angle else "N", -most, most))
    return _made(found)


def _unit(graph: Graph, k: int, per: str) -> str:
    return ("rad" if graph.coordinates[k].angle else "m") + per


class Room(NamedTuple):
    """How much there is room for, down and up, (k, 2); by number which bound ends it, -1 for none;
    and whether its upper end.
    """

    amount: FloatArray
    number: IndexArray
    upper: BoolArray


def room(bounds: Bounds, value: FloatArray, slope: FloatArray) -> Room:
    """For what the bounded values (m,) grow with by slopes (m, k), each alone. Zero where a value
    is beyond its bound already; NaN where one is not known.
    """
    count = slope.shape[1]
    amount = np.full((count, 2), np.inf) * (-1.0, 1.0)
    number, upper = np.full((count, 2), -1, dtype=np.intp), np.zeros((count, 2), dtype=bool)
    if not len(value):
        return Room(amount, number, upper)
    least = _NONE * np.abs(slope).max(axis=0, initial=0.0)
    for side, sign in enumerate((-1.0, 1.0)):
        rate = sign * slope
        rising = rate > 0.0
        above, below = bounds.high - value, value - bounds.low
        left = np.where(rising, above[:, None], below[:, None])
        with np.errstate(divide="ignore", invalid="ignore"):
            each = np.where(np.abs(rate) > least, np.maximum(left, 0.0) / np.abs(rate), np.inf)
        beyond = (value > bounds.high) | (value < bounds.low)
        each[beyond] = 0.0
        each[np.isnan(value) | np.isnan(slope).any(axis=1)] = np.nan
        near = np.min(each, axis=0) * (1.0 + ALIKE)  # NaN, if there is one
        worst = np.argmax(np.isnan(each) | (each <= near), axis=0)  # in the order of the file
        most = each[worst, np.arange(count)]
        amount[:, side] = sign * most
        number[:, side] = np.where(np.isfinite(most), worst, -1)
        rises = rising[worst, np.arange(count)]
        upper[:, side] = np.where(beyond[worst], value[worst] > bounds.high[worst], rises)
    return Room(amount, number, upper)


def moved(chart: Chart, k: int, out: FloatArray, way: FloatArray, order: int) -> FloatArray:
    """The first or second derivative (n,) of a coordinate along a ray's `way` (driven,), from
    outputs (rows, n) there.
    """
    if k in chart.places:
        return np.asarray(out[chart.outputs.derivative(chart.places[k], order)])
    given = dict(zip(chart.plan.driven, way.tolist(), strict=True))
    affine = chart.plan.affine
    factors = affine[k].factors if k in affine else ((k, 1.0),)
    rate = sum(factor * given.get(j, np.nan) for j, factor in factors)
    return np.full(out.shape[1], rate if order == 1 else 0.0 * rate)
