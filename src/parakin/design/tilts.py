"""How far the platform tilts in every direction, of a boundary over two of its angles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from parakin.arrays import FloatArray
from parakin.solving.solver import Solver

_PREFIX = "platform."
_HALF_TURN = np.pi * (1.0 - 1e-6)
_FLAT = 1e-6  # two axes and z that span less leave no tilt in some direction


class _Turn(NamedTuple):
    """About the platform's axis x, y or z (0, 1, 2), by the moved coordinate of that number, or, if
    there is none, by an angle that is held, counted from `start`.
    """

    axis: int
    moved: int | None
    held: float
    start: float


def largest_tilt(
    solver: Solver, moved: tuple[str, ...], pose: FloatArray, facets: FloatArray
) -> float:
    """The largest angle such that the platform's z axis tilts by less in every direction from where
    it is at the pose, with driven values (k,), before it meets facets (p, 2, 2) of a boundary. NaN
    if what is moved is not two angles of the platform that tilt it to all sides.

    On the sphere of directions, not in the plane of the angles: there a circle is no cone. Half a
    turn from the pose is where angles begin again, and no boundary.
    """
    turns = _turns(solver, moved, pose)
    if turns is None:
        return np.nan
    middle = pose[[solver.driven.index(name) for name in moved]]
    at_pose, spread = _tilted(turns, middle[None])
    start, sense = at_pose[0], float(np.sign(spread[0]))
    if not abs(spread[0]) > _FLAT:
        return np.nan
    around = np.asarray((np.abs(facets - middle) > _HALF_TURN).any(axis=2), dtype=bool)
    # Each line is straight in the angles: both ends, and how near it comes in between.
    part = np.array([0.0, 0.5, 1.0])[:, None, None]
    points = facets[:, 0] + part * (facets[:, 1] - facets[:, 0])
    ways, spreads = _tilted(turns, points.reshape(-1, 2))
    angles = np.arctan2(np.linalg.norm(np.cross(ways, start), axis=1), ways @ start)
    # Beyond where both axes and z lie in a plane, directions come a second time.
    angles[sense * spreads <= 0.0] = np.inf
    left_out = np.stack([around[:, 0], around[:, 0] | around[:, 1], around[:, 1]])
    angles[left_out.ravel()] = np.inf
    return float(np.minimum(np.pi, _least(*angles.reshape(3, -1))))


def _turns(solver: Solver, moved: tuple[str, ...], pose: FloatArray) -> list[_Turn] | None:
    """The turns that tilt z, if just two are moved and the others are held."""
    platform = solver.mechanism.platform
    if platform is None or len(moved) != 2:
        return None
    named = [(_PREFIX + name, "xyz".index(axis)) for name, axis in platform.angles]
    while named and named[-1][1] == 2:  # about z itself
        named.pop()
    found = []
    for name, axis in named:
        if name not in solver.driven:
            return None
        k = solver.driven.index(name)
        start = solver.plan.offset(solver.plan.driven[k])
        found.append(
            _Turn(axis, moved.index(name) if name in moved else None, float(pose[k]), start)
        )
    return found if sum(turn.moved is not None for turn in found) == 2 else None


def _tilted(turns: list[_Turn], points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The platform's z axis at points (n, 2), (n, 3), and the volume that it spans with the axes of
    the two turns (n,): zero where it cannot tilt in every direction.
    """
    rotation = np.tile(np.eye(3), (len(points), 1, 1))
    axes = []
    for turn in turns:
        angle = points[:, turn.moved] if turn.moved is not None else np.full(len(points), turn.held)
        if turn.moved is not None:
            axes.append(rotation[:, :, turn.axis])
        rotation = rotation @ _about(turn.axis, angle + turn.start)
    z = rotation[:, :, 2]
    return z, np.linalg.det(np.stack([*axes, z], axis=1))


def _about(axis: int, angle: FloatArray) -> FloatArray:
    """Turns (n, 3, 3) about x, y or z."""
    found = np.zeros((len(angle), 3, 3))
    i, k = (axis + 1) % 3, (axis + 2) % 3
    found[:, axis, axis] = 1.0
    found[:, i, i] = found[:, k, k] = np.cos(angle)
    found[:, k, i], found[:, i, k] = np.sin(angle), -np.sin(angle)
    return found


def _least(first: FloatArray, middle: FloatArray, last: FloatArray) -> float:
    """The least of values (p,) on lines, by the parabola through three points of each."""
    with np.errstate(all="ignore"):
        bend = first - 2.0 * middle + last
        at = np.clip(0.25 * (first - last) / bend, -0.5, 0.5)
        inner = middle + at * (last - first) + 2.0 * at * at * bend
    inner = np.where((bend > 0.0) & np.isfinite(inner), inner, np.inf)
    return float(np.concatenate([first, middle, last, inner]).min(initial=np.inf))
