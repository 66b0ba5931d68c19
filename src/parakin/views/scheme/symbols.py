"""Symbols of joints after ISO 3952, as strokes in a picture.

Symbols are made in the joint's frame and projected, so that they degenerate as on paper: a hinge's
bush is a rectangle from the side and a circle end on. All lengths in points.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from parakin.arrays import FloatArray
from parakin.views.solids.shapes import perpendicular

TURN = np.linspace(0, 2 * np.pi, 49)
_HALF = np.linspace(0, np.pi, 25)


class Stroke(NamedTuple):
    """A line (n, 2) [pt]; a closed one is filled."""

    points: FloatArray
    closed: bool = False
    axis: bool = False


class Sight(NamedTuple):
    """A direction of view: unit vectors right and up as rows (2, 3), and to the eye (3,)."""

    across: FloatArray
    eye: FloatArray

    def flat(self, vector: FloatArray) -> FloatArray:
        """A vector, or several as rows, in the picture."""
        return np.asarray(vector @ self.across.T)


def sleeve(sight: Sight, at: FloatArray, axis: FloatArray, half: float, r: float) -> list[Stroke]:
    """The outline of a round sleeve of length 2 `half`, and its rim nearer to the eye."""
    u, n, deep = _directions(sight, axis)
    along = half * sight.flat(axis)

    def arc(centre: FloatArray, t: FloatArray) -> FloatArray:
        return centre + r * (np.cos(t)[:, None] * n + deep * np.sin(t)[:, None] * u)

    outline = np.concatenate([arc(at + along, _HALF), arc(at - along, _HALF + np.pi)])
    strokes = [Stroke(outline, closed=True)]
    if deep > 0.02 and np.linalg.norm(along) > 0.02 * r:
        near = along if axis @ sight.eye > 0 else -along
        strokes.append(Stroke(arc(at + near, TURN), closed=True))
    return strokes


def box(sight: Sight, at: FloatArray, axis: FloatArray, half: float, r: float) -> list[Stroke]:
    """The faces towards the eye of a square sleeve of length 2 `half`."""
    side = np.cross(axis, sight.eye)
    size = np.linalg.norm(side)
    x = side / size if size > 1e-6 else perpendicular(axis)
    edges = [r * x, r * np.cross(axis, x), half * axis]
    faces = []
    for k, edge in enumerate(edges):
        towards = float(edge @ sight.eye)
        if abs(towards) > 1e-3 * np.linalg.norm(edge):
            a, b = edges[k - 2], edges[k - 1]
            middle = edge * np.sign(towards)
            corners = np.array([middle + a + b, middle + a - b, middle - a - b, middle - a + b])
            faces.append(Stroke(at + sight.flat(corners), closed=True))
    return faces


def axis_line(sight: Sight, at: FloatArray, axis: FloatArray, half: float) -> list[Stroke]:
    """The centre line of a joint; nothing if it is seen end on."""
    along = half * sight.flat(axis)
    if np.linalg.norm(along) < 0.2 * half:
        return []
    return [Stroke(np.array([at - along, at + along]), axis=True)]


def ball(at: FloatArray, towards: FloatArray, s: float) -> list[Stroke]:
    """A ball in its socket, which opens `towards` (2,) the child."""
    size = np.linalg.norm(towards)
    turn = np.arctan2(towards[1], towards[0]) if size > 1e-6 else np.pi / 2
    t = turn + np.linspace(0.5 * np.pi, 1.5 * np.pi, 25)
    socket = at + 1.3 * s * np.column_stack([np.cos(t), np.sin(t)])
    round_ = at + 0.85 * s * np.column_stack([np.cos(TURN), np.sin(TURN)])
    return [Stroke(socket), Stroke(round_, closed=True)]


def cross(
    sight: Sight, at: FloatArray, axes: tuple[FloatArray, FloatArray], child: FloatArray, s: float
) -> list[Stroke]:
    """A universal joint: a cross between two forks, one to each body.

    axes: of the turns, at the parent and at the child. child: any vector (3,) towards that body.
    """
    normal = np.cross(*axes)
    normal = normal / np.linalg.norm(normal)
    normal = normal if normal @ child >= 0 else -normal
    strokes = []
    for axis, way in zip(axes, (-normal, normal), strict=True):
        fork = np.cos(_HALF)[:, None] * axis + 1.1 * np.sin(_HALF)[:, None] * way
        strokes.append(Stroke(at + 1.5 * s * sight.flat(fork)))
        strokes.append(Stroke(at + 1.5 * s * sight.flat(np.array([-axis, axis]))))
    dot = at + 0.4 * s * np.column_stack([np.cos(TURN), np.sin(TURN)])
    return [*strokes, Stroke(dot, closed=True)]


def plates(sight: Sight, at: FloatArray, axis: FloatArray, s: float) -> list[Stroke]:
    """Two parallel plates that slide on each other, the nearer one last."""
    x = perpendicular(axis)
    y = np.cross(axis, x)
    square = 2.2 * s * np.array([x + y, y - x, -x - y, x - y])
    near = axis if axis @ sight.eye > 0 else -axis
    return [
        Stroke(at + sight.flat(square + shift * s * near), closed=True) for shift in (-0.45, 0.45)
    ]


def thread(sight: Sight, at: FloatArray, axis: FloatArray, half: float, r: float) -> list[Stroke]:
    """The zigzag of a screw in its nut."""
    u, n, _ = _directions(sight, axis)
    along = np.linspace(-half, half, 9) * np.linalg.norm(sight.flat(axis))
    across = 0.8 * r * np.array([(-1.0) ** k for k in range(9)])
    return [Stroke(at + along[:, None] * u + across[:, None] * n)]


def ring(sight: Sight, at: FloatArray, axis: FloatArray, r: float) -> FloatArray:
    """Most of a circle about an axis, for the arrow of a driven turn."""
    x = perpendicular(axis)
    side = np.cross(axis, sight.eye)
    if np.linalg.norm(side) > 1e-6:
        x = side / np.linalg.norm(side)
    y = np.cross(axis, x)
    y = y if y @ sight.eye >= 0 else -y
    t = np.linspace(-0.25 * np.pi, 1.15 * np.pi, 40)[:, None]
    return at + r * sight.flat(np.cos(t) * x + np.sin(t) * y)


def ground(at: FloatArray, way: FloatArray, s: float) -> tuple[list[Stroke], list[Stroke]]:
    """The fixed link at a joint: a bracket in the direction `way` (2,), and a hatched line."""
    along = np.array([-way[1], way[0]])
    foot = at + 2.6 * s * way
    bracket = np.array([at, foot - 1.3 * s * along, foot + 1.3 * s * along])
    line = np.array([foot - 2 * s * along, foot + 2 * s * along])
    return [Stroke(bracket, closed=True)], hatched(line, way, s)


def hatched(line: FloatArray, way: FloatArray, s: float) -> list[Stroke]:
    """A fixed line (2, 2), hatched on the side that `way` (2,) points to."""
    length = float(np.linalg.norm(line[1] - line[0]))
    along = (line[1] - line[0]) / max(length, 1e-9)
    starts = np.arange(0.5 * s, length + 1e-9, 0.75 * s)
    slant = 0.85 * s * (way - along * 0.8)
    marks = [line[0] + k * along for k in starts]
    return [Stroke(line), *(Stroke(np.array([mark, mark + slant])) for mark in marks)]


def _directions(sight: Sight, axis: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Unit vectors along an axis in the picture and across it, and how far it points to the eye."""
    along = sight.flat(axis)
    size = np.linalg.norm(along)
    u = along / size if size > 1e-6 else np.array([1.0, 0.0])
    return u, np.array([-u[1], u[0]]), abs(float(axis @ sight.eye))
