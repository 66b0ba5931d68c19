"""Rays: straight ways of the driven coordinates from one pose, each followed to the first limit.

All rays are followed at once, each in its own steps, which obey the rule of continuity
(`parakin.solving.continuity`), so that none jumps to another assembly. A step that may have left a
limit and come back is halved (`parakin.design.ends`). What is met within a step is located by
Newton's steps in a bracket, with the kernel's own rates.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from parakin.arrays import BoolArray, FloatArray, IndexArray, StatusArray
from parakin.design.march import March, Node, outputs_at
from parakin.solving.atlas import Atlas
from parakin.solving.charts import Chart
from parakin.solving.tracking import POORER
from parakin.solving.walking import REGULAR, State, Ways, carried_over

_POOR = 0.1  # a figure of conditioning that may be about to vanish


class Met(NamedTuple):
    """How far each of n rays goes, as a part of its way, 1 if to its end; the number of the limit
    that is met there, 0 for none, and whether its upper end; else the status that tells why it
    ends; and what is reported there (coordinates, n).
    """

    part: FloatArray
    number: IndexArray
    upper: BoolArray
    status: StatusArray
    position: FloatArray


def no_limit(atlas: Atlas, node: Node, n: int) -> Met:
    """Of n rays that have not set off from a node."""
    return Met(
        np.full(n, node.part),
        np.zeros(n, dtype=np.intp),
        np.zeros(n, dtype=bool),
        np.zeros(n, dtype=np.int8),
        _told(atlas, node.chart, node.out[:, None]).repeat(n, axis=1),
    )


def follow(
    atlas: Atlas,
    start: Node,
    origin: FloatArray,
    goal: FloatArray,
    traces: list[list[Node]] | None = None,
) -> Met:
    """Follow rays from `origin` (k,) to `goal` (k, n), as far as no limit is met.

    start: the pose at the origin, which keeps all limits. traces: by ray, where its nodes are
    added.
    """
    with np.errstate(all="ignore"):  # goals that overflow end like any out of reach
        met = no_limit(atlas, start, goal.shape[1])
        rays = np.arange(goal.shape[1])
        _follow(atlas, start, origin, goal, rays, met, traces)
    return met


def _follow(
    atlas: Atlas,
    start: Node,
    origin: FloatArray,
    goal: FloatArray,
    rays: IndexArray,
    met: Met,
    traces: list[list[Node]] | None,
) -> None:
    """The same from any node on these rays, written to `met`; on other charts where need be."""
    chart = start.chart
    march = March(chart, Ways(chart, _at_rest(origin), goal[:, rays], atlas.units), start)
    if traces is not None:
        march.traces = [traces[ray] for ray in rays.tolist()]
        march.note(march.ways.all)
    march.run(patient=chart.layout.unsigned)
    for k in np.flatnonzero(march.stuck):
        node = Node(float(march.part[k]), chart, march.out[:, k])
        other = other_chart(atlas, node, origin, goal[:, rays[k]])
        if other is not None:
            march.stuck[k] = False
            _follow(atlas, other, origin, goal, rays[k : k + 1], met, traces)
            march.passed_on[k] = True
    march.finish()
    _tell(atlas, march, origin)
    mine = ~march.passed_on
    ray = rays[mine]
    met.part[ray], met.number[ray] = march.part[mine], march.number[mine]
    met.upper[ray], met.status[ray] = march.upper[mine], march.status[mine]
    met.position[:, ray] = _told(atlas, chart, march.out[:, mine])


def _at_rest(origin: FloatArray) -> State:
    return State(np.array([origin]), np.empty((1, 0)))


def _tell(atlas: Atlas, march: March, origin: FloatArray) -> None:
    """What ends rays that met no limit: loops that cannot be closed any more, or a singularity."""
    ended = np.flatnonzero((march.status != 0) & (march.number == 0) & ~march.passed_on)
    if len(ended):
        rays, out = march.told(ended)
        driven = origin[:, None] + march.part[rays] * march.ways.way[:, rays]
        march.number[rays] = atlas.loop_stops(march.chart, driven, out)


def _told(atlas: Atlas, chart: Chart, out: FloatArray) -> FloatArray:
    """Positions of what the solver reports, (coordinates, n)."""
    return out[[chart.places[c] for c in atlas.outputs.coordinates]]


def other_chart(atlas: Atlas, node: Node, origin: FloatArray, goal: FloatArray) -> Node | None:
    """The same place on another chart, if it is only the plan that ends here."""
    chart, figure = node.chart, float(node.out[node.chart.outputs.conditioning])
    if not abs(figure) < _POOR:
        return None
    driven = np.zeros((len(chart.layout.iterated), len(origin), 1))
    driven[0, :, 0] = origin + node.part * (goal - origin)
    driven[1, :, 0] = goal - origin
    at = chart.configuration(driven[0, :, 0], node.out)
    if not chart.regularity(at) > max(REGULAR, POORER * abs(figure)):
        return None
    for other in atlas.others(chart, at, at):
        found = carried_over(other, driven, at)
        if found is not None:
            return Node(node.part, other, found[:, 0])
    return None


class Ray(NamedTuple):
    """One ray that was followed: from `origin` (k,) to `goal` (k,), with its nodes."""

    origin: FloatArray
    goal: FloatArray
    nodes: list[Node]

    def driven(self, part: FloatArray) -> FloatArray:
        """Driven positions (k, n) at parts (n,)."""
        found: FloatArray = self.origin[:, None] + part * (self.goal - self.origin)[:, None]
        return found


Measure = Callable[[Chart, FloatArray, FloatArray], FloatArray]
"""Some figures (m, n), given a chart, parts (n,) of a ray and outputs there (rows, n)."""


class Stretch(NamedTuple):
    """Places on a ray that one chart knows: their numbers, and outputs (rows, n)."""

    columns: IndexArray
    chart: Chart
    out: FloatArray


def places(atlas: Atlas, ray: Ray, part: FloatArray) -> list[Stretch]:
    """Parts (n,) of a ray that was followed so far, chart by chart."""
    before = np.array([node.part for node in ray.nodes])
    nearest = np.maximum(np.searchsorted(before, part, side="right") - 1, 0)
    charts = list(dict.fromkeys(node.chart for node in ray.nodes))
    on = np.array([charts.index(node.chart) for node in ray.nodes])[nearest]
    found = []
    with np.errstate(all="ignore"):
        for number in np.unique(on).tolist():
            columns = np.flatnonzero(on == number)
            goal = ray.goal[:, None].repeat(len(columns), axis=1)
            ways = Ways(charts[number], _at_rest(ray.origin), goal, atlas.units)
            known = np.array([ray.nodes[k].out for k in nearest[columns]]).T
            begun = before[nearest[columns]]
            out = outputs_at(ways, ways.all, part[columns], (begun, known))
            found.append(Stretch(columns, charts[number], out))
    return found


def along(atlas: Atlas, ray: Ray, part: FloatArray, measure: Measure) -> FloatArray:
    """Figures (m, n) at parts (n,) of a ray that was followed so far."""
    found = places(atlas, ray, part)
    with np.errstate(all="ignore"):
        pieces = [measure(chart, part[columns], out) for columns, chart, out in found]
    figures = np.empty((len(pieces[0]), len(part)))
    for (columns, *_), values in zip(found, pieces, strict=True):
        figures[:, columns] = values
    return figures


def reported(atlas: Atlas, ray: Ray, part: float) -> FloatArray:
    """Positions of what the solver reports (coordinates,) at a part of a ray."""
    _, chart, out = places(atlas, ray, np.array([part]))[0]
    return _told(atlas, chart, out)[:, 0]
