"""The solids that pictures are made of: bars, balls, blocks and plates, as triangles.

Forms are in the frame of their body; `mesh` gives their triangles in the same frame.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from parakin.arrays import FloatArray, IntArray

_SIDES = 20
_SAME = 1e-9  # of their distance from the origin: points that coincide
_FLAT = 1e-6  # of the largest extent: a thinner cloud of points is flat


class Mesh(NamedTuple):
    """Triangles: `vertices` (n, 3) [m], `faces` (m, 3), counter-clockwise from outside."""

    vertices: FloatArray
    faces: IntArray


@dataclass(frozen=True)
class Bar:
    """A round bar along a chain of points (n, 3)."""

    points: FloatArray
    radius: float


@dataclass(frozen=True)
class Ball:
    """A ball."""

    centre: FloatArray
    radius: float


@dataclass(frozen=True)
class Block:
    """A box; the columns of `R` are its edges' directions, `sides` (3,) their lengths."""

    centre: FloatArray
    R: FloatArray
    sides: tuple[float, float, float]


@dataclass(frozen=True)
class Plate:
    """A flat plate: its corners (n, 3) in order, and its thickness."""

    corners: FloatArray
    thickness: float


Form = Bar | Ball | Block | Plate | Mesh


def mesh(form: Form, sides: int = _SIDES) -> Mesh:
    """The triangles of a form; sides: of what is round."""
    if isinstance(form, Mesh):
        return form
    if isinstance(form, Bar):
        return joined([_round(a, b, form.radius, sides) for a, b in _steps(form.points)])
    if isinstance(form, Ball):
        return _ball(form.centre, form.radius, sides)
    if isinstance(form, Block):
        corners = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]) / 2
        return hull(form.centre + (corners * form.sides) @ form.R.T)
    normal = plane(form.corners)[2] * form.thickness / 2
    return hull(np.concatenate([form.corners + normal, form.corners - normal]))


def joined(meshes: list[Mesh]) -> Mesh:
    """Several meshes as one."""
    starts = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    faces = [m.faces + start for m, start in zip(meshes, starts, strict=False)]
    return Mesh(np.concatenate([m.vertices for m in meshes]), np.concatenate(faces))


def hull(points: FloatArray) -> Mesh:
    """The convex hull of points that do not lie in a plane; faces share no corners."""
    from scipy.spatial import ConvexHull

    found = ConvexHull(points)
    triangles = points[found.simplices]
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    inward = (normals * found.equations[:, :3]).sum(axis=1) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return Mesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))


def plane(points: ArrayLike) -> FloatArray:
    """Principal directions of points, as rows: the widest first; the last is a plane's normal."""
    points = np.asarray(points, dtype=float)
    return np.asarray(np.linalg.svd(points - points.mean(axis=0))[2])


def spread(points: FloatArray) -> int:
    """Whether points coincide (0), lie on a line (1), in a plane (2), or in none (3)."""
    values = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    least = max(_SAME * float(np.abs(points).max()), _FLAT * float(values.max()))
    return int((values > least).sum())


def outline(points: FloatArray) -> FloatArray:
    """The corners of the convex polygon around points in a plane, in order."""
    from scipy.spatial import ConvexHull

    flat = (points - points.mean(axis=0)) @ plane(points)[:2].T
    return np.asarray(points[ConvexHull(flat).vertices])


def perpendicular(axis: FloatArray) -> FloatArray:
    """A unit vector perpendicular to another."""
    other = np.eye(3)[int(np.argmin(np.abs(axis)))]
    across = np.cross(axis, other)
    return np.asarray(across / np.linalg.norm(across))


def _steps(points: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
    pairs = list(itertools.pairwise(points))
    return [(a, b) for a, b in pairs if np.linalg.norm(b - a) > 0] or pairs[:1]


def _round(a: FloatArray, b: FloatArray, radius: float, sides: int) -> Mesh:
    """A cylinder; its ends share no corners with the walls, so that edges stay sharp."""
    length = float(np.linalg.norm(b - a))
    axis = (b - a) / length if length else np.array([0.0, 0.0, 1.0])
    x = perpendicular(axis)
    angle = np.linspace(0, 2 * np.pi, sides, endpoint=False)[:, None]
    ring = radius * (np.cos(angle) * x + np.sin(angle) * np.cross(axis, x))
    n = np.arange(sides)
    m = (n + 1) % sides
    walls = np.concatenate(
        [np.column_stack([n, m, m + sides]), np.column_stack([n, m + sides, n + sides])]
    )
    below = np.column_stack([np.zeros(sides - 2, int), n[2:], n[1:-1]]) + 2 * sides
    above = np.column_stack([np.zeros(sides - 2, int), n[1:-1], n[2:]]) + 3 * sides
    return Mesh(np.concatenate([a + ring, b + ring] * 2), np.concatenate([walls, below, above]))


def _ball(centre: FloatArray, radius: float, sides: int) -> Mesh:
    rows, columns = sides // 2, sides
    polar = np.linspace(0, np.pi, rows + 1)[:, None]
    around = np.linspace(0, 2 * np.pi, columns, endpoint=False)
    x, y = np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around)
    z = np.broadcast_to(np.cos(polar), x.shape)
    points = np.stack([x, y, z], axis=2).reshape(-1, 3)
    k, c = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    a, b = k * columns + c, k * columns + (c + 1) % columns
    upper = np.stack([a, a + columns, b], axis=2).reshape(-1, 3)
    lower = np.stack([b, a + columns, b + columns], axis=2).reshape(-1, 3)
    return Mesh(centre + radius * points, np.concatenate([upper, lower]))
