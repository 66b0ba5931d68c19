"""From home to poses that come without a guess, straight, and on with other charts if need be."""

from __future__ import annotations

import numpy as np

from parakin.arrays import FloatArray, IndexArray, StatusArray
from parakin.kinematics.cones import cone_angles
from parakin.kinematics.configuration import circuits_at
from parakin.model.graph import Graph
from parakin.motion.course import Course
from parakin.motion.laws import from_laws, polynomial345
from parakin.planning.plan import Plan
from parakin.solving.atlas import Atlas
from parakin.solving.charts import Chart
from parakin.solving.locks import Locks, near_lock, off_the_lock, try_again
from parakin.solving.status import TURNS, Status
from parakin.solving.tracking import POORER, Track
from parakin.solving.walking import CLOSED, REGULAR, State, iterate, walk

# Figure of a plan whose sign is about to change; at an end of reach it is left sooner.
_POOR = 2e-3
_CALM = 30.0  # times what is driven: what goes no faster is not at an end of reach


def home_state(chart: Chart) -> State:
    """Where a chart was made, at rest."""
    plan, iterated = chart.plan, chart.plan.iterated
    orders = 1 + chart.outputs.derivatives
    driven, found = np.zeros((orders, len(plan.driven))), np.zeros((orders, len(iterated)))
    driven[0] = [plan.home[k] - plan.offset(k) for k in plan.driven]
    found[0] = [plan.home[k] - plan.offset(k) for k in iterated]
    return State(driven, found)


def home_values(graph: Graph, plan: Plan) -> dict[str, float]:
    """Position of every coordinate at home, as it is counted, and every cone angle."""
    home = {c.name: float(plan.home[k]) - plan.offset(k) for k, c in enumerate(graph.coordinates)}
    circuits = circuits_at(plan.graph, plan.tree, plan.home)
    return home | cone_angles(circuits, plan.cones)


def from_home(atlas: Atlas, locks: Locks, goal: FloatArray) -> tuple[FloatArray, StatusArray]:
    """Iterated coordinates (m, n) from which poses `goal` (k, n) are found, and what became of the
    way to each.
    """
    walker, home = atlas.home.walker, home_state(atlas.home)
    steps, walked, part = walk(walker, home, goal, atlas.units)
    start = steps[walker.layout.iterated[0]]
    if not walked.any():
        return start, walked
    begin = home.driven[0][:, None]
    for column in _stopped_by_plan(atlas, locks, steps, walked, goal - begin):
        there = begin[:, 0] + part[column] * (goal[:, column] - begin[:, 0])
        figure = float(steps[walker.outputs.conditioning, column])
        if not _regular(atlas, there, start[:, column], figure):
            continue
        found = _tracked(atlas, goal[:, column])
        if found is not None:
            start[:, column], walked[column] = found, Status.CONVERGED
    return start, walked


def _stopped_by_plan(
    atlas: Atlas, locks: Locks, steps: FloatArray, walked: StatusArray, way: FloatArray
) -> IndexArray:
    """Columns in which the walk from home may have ended where only the plan is singular: near a
    lock, or at a figure near zero while nothing goes as fast as at an end of reach.
    """
    layout = atlas.home.walker.layout
    pace = np.abs(way / atlas.units[:, None]).max(axis=0)
    rates = np.abs(steps[layout.iterated[1]] / layout.units[:, None]).max(axis=0)
    slow = (np.abs(steps[layout.outputs.conditioning]) < _POOR) & (rates < _CALM * pace)
    near = slow | near_lock(locks, steps[layout.iterated[0]])
    return np.flatnonzero((walked != 0) & near & (pace < TURNS))


def _regular(atlas: Atlas, y: FloatArray, found: FloatArray, figure: float) -> bool:
    """Whether the mechanism is held much better than a plan with this figure can tell."""
    chart = atlas.followed
    driven = np.zeros((len(chart.layout.iterated), len(y), 1))
    driven[0] = y[:, None]
    out = iterate(chart, driven.reshape(-1, 1), found[:, None])
    regularity = chart.regularity(chart.configuration(y, out[:, 0]))
    return regularity > max(REGULAR, POORER * abs(figure))


def _tracked(atlas: Atlas, y: FloatArray) -> FloatArray | None:
    """Iterated coordinates (m,) at a pose that the walk from home did not reach, by the same way as
    a motion, which goes on with other charts; none if that does not arrive either.
    """
    chart = atlas.followed
    home = home_state(chart)
    ways = enumerate(zip(home.driven[0], y, strict=True))
    laws = {str(k): polynomial345(begin, end - begin, 1.0) for k, (begin, end) in ways}
    straight = from_laws("straight", laws, 1.0, 1.0)
    track = Track(chart, Course(straight), home, atlas.units, atlas.others)
    pieces, status = track.solve(straight.samples(), parallel=False)
    if status[-1] != Status.CONVERGED:
        return None
    q = chart.coordinates_at(pieces[-1].chart.configuration(y, pieces[-1].out[:, -1]))
    return np.array([q[k] - chart.plan.offset(k) for k in chart.plan.iterated])


def from_guess(
    atlas: Atlas, locks: Locks, inputs: FloatArray, guess: FloatArray | None
) -> tuple[FloatArray, StatusArray | int]:
    """Outputs of driven inputs (rows,) or (rows, n) from a guess of what is iterated; without one
    from home, with the status of the walk from there.
    """
    chart = atlas.home
    outputs = chart.outputs
    guess = None if guess is None else off_the_lock(locks, guess)
    if inputs.ndim == 1 and guess is not None:
        alone = chart.alone(inputs, guess)
        if alone[outputs.residual] <= CLOSED * alone[outputs.size]:
            return alone, 0
    columns = inputs[:, None] if inputs.ndim == 1 else inputs
    walked: StatusArray | None = None
    if guess is None:
        start, walked = from_home(atlas, locks, columns[: len(chart.plan.driven)])
    else:
        start = guess[:, None] if guess.ndim == 1 else guess
        if start.shape[1] != columns.shape[1]:
            start = np.broadcast_to(start, (len(start), columns.shape[1]))
    out = iterate(chart, columns, start)
    if locks:
        try_again(chart, locks, out, columns, start)
    if inputs.ndim == 1:
        return out[:, 0], 0 if walked is None else int(walked[0])
    return out, 0 if walked is None else walked
