"""How large a ball or a box about a point is free of a boundary, which is given by its facets."""

from __future__ import annotations

import itertools

import numpy as np

from parakin.arrays import FloatArray


def radius(facets: FloatArray) -> float:
    """The distance from the origin to the nearest of facets (p, d, d): lines in the plane,
    triangles in space. Infinite if there are none.
    """
    if not len(facets):
        return float("inf")
    best = min(_to_lines(facets[:, [i, j]]) for i, j in _sides(facets))
    if facets.shape[1] == 3:
        best = min(best, _to_planes(facets))
    return best


def half_width(facets: FloatArray) -> float:
    """The largest h such that no facet (p, d, d) comes within |x| < h in all coordinates at once.

    The largest coordinate is a convex function on a facet, piecewise linear. So it is least at a
    corner, on a side where two coordinates are as large, or where all three are.
    """
    if not len(facets):
        return float("inf")
    d = facets.shape[1]
    best = float(np.abs(facets).max(axis=2).min())
    for i, j in _sides(facets):
        start, way = facets[:, i], facets[:, j] - facets[:, i]
        for (a, b), sign in itertools.product(itertools.combinations(range(d), 2), (1.0, -1.0)):
            with np.errstate(all="ignore"):
                t = (sign * start[:, b] - start[:, a]) / (way[:, a] - sign * way[:, b])
            on = (t > 0.0) & (t < 1.0)
            best = _least(best, np.abs(start[on] + t[on, None] * way[on]).max(axis=1))
    if d == 3:
        for signs in itertools.product((1.0, -1.0), repeat=3):
            best = _least(best, _along(facets, np.array(signs)))
    return best


def _sides(facets: FloatArray) -> list[tuple[int, int]]:
    return list(itertools.combinations(range(facets.shape[1]), 2))


def _least(best: float, values: FloatArray) -> float:
    return min(best, float(values.min(initial=np.inf)))


def _to_lines(lines: FloatArray) -> float:
    """The distance to the nearest of lines (p, 2, d) between two points."""
    start, way = lines[:, 0], lines[:, 1] - lines[:, 0]
    with np.errstate(all="ignore"):
        t = -(start * way).sum(axis=1) / (way * way).sum(axis=1)
    t = np.clip(np.nan_to_num(t), 0.0, 1.0)
    return float(np.linalg.norm(start + t[:, None] * way, axis=1).min())


def _to_planes(facets: FloatArray) -> float:
    """The distance to the nearest of triangles whose inside is nearer than their sides."""
    normal = np.cross(facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0])
    with np.errstate(all="ignore"):
        scale = (facets[:, 0] * normal).sum(axis=1) / (normal * normal).sum(axis=1)
    foot = scale[:, None] * normal
    sides = [np.cross(facets[:, (k + 1) % 3] - facets[:, k], foot - facets[:, k]) for k in range(3)]
    within = np.all([(side * normal).sum(axis=1) > 0.0 for side in sides], axis=0)
    return float(np.linalg.norm(foot[within], axis=1).min(initial=np.inf))


def _along(facets: FloatArray, way: FloatArray) -> FloatArray:
    """How far along a way from the origin it meets triangles, where it does, in steps of it."""
    sides = np.stack([-np.broadcast_to(way, facets[:, 0].shape)], axis=1)
    system = np.concatenate(
        [sides, facets[:, 1:2] - facets[:, :1], facets[:, 2:] - facets[:, :1]], axis=1
    ).swapaxes(1, 2)
    regular = np.abs(np.linalg.det(system)) > 0.0
    t, u, v = np.linalg.solve(system[regular], -facets[regular, 0, :, None])[:, :, 0].T
    found: FloatArray = t[(t > 0.0) & (u > 0.0) & (v > 0.0) & (u + v < 1.0)]
    return found
