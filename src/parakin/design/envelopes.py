"""How fast and how hard each driven coordinate may move at a pose, alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from parakin.analysis.stiffness import stiffness
from parakin.arrays import FloatArray
from parakin.design.bounds import Bounds, Room, room, speed_bounds
from parakin.design.march import Node
from parakin.design.strength import efforts_if_known, rates_at
from parakin.errors import InputError
from parakin.solving.solver import Solver

Words = NDArray[np.object_]


class Envelope(NamedTuple):
    """The most of something down and up (k, 2), what limits it in words (k, 2), and why it is not
    known, "" where it is.
    """

    most: FloatArray
    words: Words
    why: str = ""


class Envelopes(NamedTuple):
    """Of velocities [m/s or rad/s], accelerations [m/s² or rad/s²] and loads [N or N m]."""

    velocity: Envelope
    acceleration: Envelope
    load: Envelope


def envelopes(
    solver: Solver, y: FloatArray, node: Node, loads: Mapping[str, ArrayLike] | None
) -> Envelopes:
    """At a pose with driven values y (k,)."""
    speeds = speed_bounds(solver.graph)
    rates = rates_at(node.chart, node.out[:, None], y[:, None], speeds.coordinates)[:, :, 0]
    velocity = _told(speeds, room(speeds, np.zeros(len(rates)), rates))
    efforts, why = efforts_if_known(solver, loads)
    if efforts is None:
        return Envelopes(velocity, *[nothing_known(len(y), why)] * 2)
    resting, slope = efforts.by_acceleration(node, y)
    acceleration = _told(efforts.bounds, room(efforts.bounds, resting, slope))
    return Envelopes(velocity, acceleration, _loads(solver, y, efforts.bounds, resting))


def nothing_known(count: int, why: str) -> Envelope:
    """What is told of so many coordinates where something is missing."""
    return Envelope(np.full((count, 2), np.nan), np.full((count, 2), "", dtype=object), why)


def _told(bounds: Bounds, found: Room) -> Envelope:
    words = np.empty(found.number.shape, dtype=object)
    for place, number in np.ndenumerate(found.number):
        words[place] = bounds.words(int(number), upper=bool(found.upper[place]))
    return Envelope(found.amount, words)


def _loads(solver: Solver, y: FloatArray, bounds: Bounds, resting: FloatArray) -> Envelope:
    """The most that may push the platform along each of its coordinates, at rest: a force at its
    point along a slide, a moment about the axis of a turn. NaN for other coordinates.
    """
    try:
        there = stiffness(solver, y)
    except InputError as error:
        return nothing_known(len(y), str(error))
    there = replace(there, efforts=resting)
    platform = [name.startswith("platform.") for name in solver.driven]
    if not any(platform):
        return nothing_known(len(y), "no coordinate of the platform is driven")
    wrenches = np.zeros((6, len(y)))
    for i, name in enumerate(solver.driven):
        rows = slice(3, 6) if solver.graph.is_angle(name) else slice(0, 3)
        axis = there.jacobian[rows, i]
        wrenches[rows, i] = axis / np.linalg.norm(axis)
    found = _told(bounds, room(bounds, resting, there.effort_per_wrench @ wrenches))
    found.most[~np.array(platform)] = np.nan
    found.words[~np.array(platform)] = ""
    return found
