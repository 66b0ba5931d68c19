"""A region on a grid, bounded where its edges cross the boundary.

Every cell of the grid is divided alike into triangles (two) or tetrahedra (six), after Freudenthal
and Kuhn: along the shortest ways from its lowest corner to its highest. Two corners that share an
edge then differ by steps up alone, or by steps down alone. What is inside of a simplex is cut off
by a straight facet through the points on its edges that are on the boundary; facets of neighbours
meet, so that the boundary is closed, and corners are connected exactly if the regions about them
are (marching tetrahedra; marching cubes are ambiguous).
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
from scipy.ndimage import label

from parakin.arrays import BoolArray, FloatArray, IndexArray


class Cuts(NamedTuple):
    """How a boundary cuts a grid. Corners are numbers of nodes, s simplices have both kinds.

    whole, empty: the first corner of every simplex that is inside, or outside, as a whole.
    corners: of those cut, (s, d + 1), those inside first. inside: how many of them are, (s,).
    edges: which the boundary crosses, from inside to outside (e, 2). crossed: by simplex, the
    numbers of its edges, (s, 3) or (s, 4), by corner inside, then outside; -1 where it has fewer.
    """

    whole: IndexArray
    empty: IndexArray
    corners: IndexArray
    inside: IndexArray
    edges: IndexArray
    crossed: IndexArray


class Pieces(NamedTuple):
    """Facets of a boundary: corners, by number of the edge crossed (p, d), a node inside beside
    each (p,); and the parts of the simplices that are inside (s,), in cells. What is inside is left
    of a line, and behind a triangle whose corners go round to the left.
    """

    facets: IndexArray
    beside: IndexArray
    parts: FloatArray


def connected(inside: BoolArray) -> tuple[IndexArray, int]:
    """Numbers from 1 of what hangs together along edges of the simplices, and how many; 0 is
    outside.
    """
    found, count = label(inside, _neighbours(inside.ndim))
    return found.astype(np.intp), int(count)


def _neighbours(d: int) -> BoolArray:
    """Which of the 3ᵈ nodes around one share an edge with it."""
    steps = np.indices((3,) * d) - 1
    return np.asarray((steps >= 0).all(axis=0) | (steps <= 0).all(axis=0), dtype=bool)


def cut(inside: BoolArray, numbers: IndexArray) -> Cuts:
    """Where the boundary of what is inside cuts a grid, given the numbers of its nodes, in 2 or 3
    dimensions.
    """
    d = inside.ndim
    whole, empty, mixed = [], [], []
    for order in itertools.permutations(range(d)):
        path = np.concatenate([np.zeros((1, d), int), np.cumsum(np.eye(d, dtype=int)[[*order]], 0)])
        corners = np.stack([_shifted(numbers, step).ravel() for step in path])
        kept = np.stack([_shifted(inside, step).ravel() for step in path])
        count = kept.sum(axis=0)
        whole.append(corners[0, count == d + 1])
        empty.append(corners[0, count == 0])
        some = (count > 0) & (count <= d)
        first = np.argsort(~kept[:, some], axis=0, kind="stable")
        mixed.append((np.take_along_axis(corners[:, some], first, axis=0).T, count[some]))
    corners = np.concatenate([each for each, _ in mixed])
    count = np.concatenate([each for _, each in mixed])
    pairs = np.full((len(corners), 3 if d == 2 else 4, 2), -1, dtype=np.intp)
    for k in range(1, d + 1):
        mine = count == k
        crossing = list(itertools.product(range(k), range(k, d + 1)))
        for place, (i, j) in enumerate(crossing):
            pairs[mine, place] = corners[mine][:, [i, j]]
    edges, which = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    which = which.reshape(pairs.shape[:2])
    if len(edges) and edges[0, 0] < 0:  # places of none
        edges, which = edges[1:], which - 1
    return Cuts(np.concatenate(whole), np.concatenate(empty), corners, count, edges, which)


def _shifted(values: np.ndarray, step: IndexArray) -> np.ndarray:
    """Of every cell, the value at the corner so many steps from its lowest."""
    ways = zip(step.tolist(), values.shape, strict=True)
    return values[tuple(slice(one, size - 1 + one) for one, size in ways)]


def pieces(cuts: Cuts, places: FloatArray, crossings: FloatArray) -> Pieces:
    """The boundary and what it encloses, given places of nodes (n, d), a step of the grid being 1
    in each, and of crossings (e, d).
    """
    d = places.shape[1]
    size = 1.0 / math.factorial(d)
    parts = np.empty(len(cuts.corners))
    facets, beside = [], []
    for k in range(1, d + 1):
        mine = np.flatnonzero(cuts.inside == k)
        corners, on = cuts.corners[mine], cuts.crossed[mine]
        if k in (1, d):
            odd = places[corners[:, 0 if k == 1 else d]]
            small = _size(odd, *(crossings[on[:, i]] for i in range(d)))
            parts[mine] = small if k == 1 else size - small
            found = [on[:, :d]]
        else:  # two and two of a tetrahedron: a wedge from edge a, b to a quadrangle
            a, b = places[corners[:, 0]], places[corners[:, 1]]
            ac, ad, bc, bd = (crossings[on[:, i]] for i in range(4))
            parts[mine] = _size(a, ac, ad, bd) + _size(a, ac, bc, bd) + _size(a, b, bc, bd)
            found = [on[:, [0, 1, 3]], on[:, [0, 3, 2]]]
        inwards = places[corners[:, 0]] - places[corners[:, -1]]
        facets += [_oriented(each, crossings, inwards) for each in found]
        beside += [corners[:, 0]] * len(found)
    return Pieces(np.concatenate(facets), np.concatenate(beside), parts)


def _oriented(facets: IndexArray, crossings: FloatArray, inwards: FloatArray) -> IndexArray:
    """Facets (p, d) with their corners in order, given a way inwards from each (p, d)."""
    corners = crossings[facets]
    ways = np.concatenate([corners[:, 1:] - corners[:, :1], inwards[:, None]], axis=1)
    wrong = (np.linalg.det(ways) < 0.0) ^ (facets.shape[1] == 3)
    found: IndexArray = np.where(wrong[:, None], facets[:, ::-1], facets)
    return found


def _size(apex: FloatArray, *others: FloatArray) -> FloatArray:
    """Of simplices (n,), by their corners (n, d)."""
    sides = np.stack([other - apex for other in others], axis=1)
    found: FloatArray = np.abs(np.linalg.det(sides)) / math.factorial(apex.shape[1])
    return found


def sizes(cuts: Cuts, found: Pieces, labels: IndexArray) -> FloatArray:
    """The area or volume inside, in cells, by label of nodes (n,)."""
    mine = labels[cuts.corners[:, 0]]
    return _totals(labels, cuts.whole, mine, found.parts, cuts.corners.shape[1] - 1)


def sizes_outside(cuts: Cuts, found: Pieces, labels: IndexArray) -> FloatArray:
    """The same of what is outside."""
    d = cuts.corners.shape[1] - 1
    mine = labels[cuts.corners[:, -1]]
    return _totals(labels, cuts.empty, mine, 1.0 / math.factorial(d) - found.parts, d)


def _totals(
    labels: IndexArray, whole: IndexArray, mine: IndexArray, parts: FloatArray, d: int
) -> FloatArray:
    count = int(labels.max(initial=0)) + 1
    simplices = np.bincount(labels[whole], minlength=count)
    total: FloatArray = simplices / math.factorial(d) + np.bincount(mine, parts, minlength=count)
    return total
