"""A region on a grid: what keeps everything, what hangs together, its boundary and its size."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from parakin.arrays import BoolArray, FloatArray, IndexArray
from parakin.design.grids import Grid
from parakin.design.probing import Probe
from parakin.design.simplices import Cuts, Pieces, connected, cut, pieces, sizes, sizes_outside

_HALVINGS = 30  # of an edge of the grid: to 1e-9 of it
_ROUGHLY = 20  # where it only serves to tell how sure a size is
_FARTHER = 1e-5  # of an edge: beyond the end of reach, where it is told which limb cannot


class Region(NamedTuple):
    """inside: nodes (by axis). codes: what is wrong with them, as `Probe.words` tells. labels: of
    nodes, what hangs together, `home` being that of the middle. facets (p, d, d): corners of the
    boundary, in the coordinates moved; stops (p, d): by code what stops it there; own (p,): which
    belong to the middle's part. size, islands, holes: areas or volumes; coarse: the size on every
    second node.
    """

    grid: Grid
    inside: BoolArray
    codes: IndexArray
    labels: IndexArray
    home: int
    facets: FloatArray
    stops: IndexArray
    own: BoolArray
    size: float
    coarse: tuple[float, float]
    islands: FloatArray
    holes: FloatArray


def region_of(probe: Probe, grid: Grid) -> Region:
    """All that is told of a grid whose middle keeps everything."""
    points = grid.points
    codes = probe.wrong(points)
    inside = (codes == 0).reshape(grid.shape)
    labels, _ = connected(inside)
    home = int(labels[grid.middle])
    flat = labels.ravel()
    numbers = np.arange(len(points)).reshape(grid.shape)
    cuts = cut(inside, numbers)
    crossings, beyond = located(probe, points, cuts.edges, _HALVINGS)
    stops = probe.stops_next(crossings, beyond)
    vague = np.flatnonzero(probe.is_singular(stops))
    ways = points[cuts.edges[vague, 1]] - crossings[vague]
    farther = probe.stops_next(crossings[vague], beyond[vague] + _FARTHER * ways)
    stops[vague] = np.where(farther > 0, farther, stops[vague])
    found = _pieces(cuts, grid, points, crossings, 1.0)
    cell = float(np.prod(grid.step))
    each = cell * sizes(cuts, found, flat)
    islands = np.delete(each, [0, home])
    half, quarter = (_size_by(n, probe, grid, inside, labels)[home] for n in (2, 4))
    return Region(
        grid,
        inside,
        codes.reshape(grid.shape),
        labels,
        home,
        crossings[found.facets],
        stops[found.facets],
        flat[found.beside] == home,
        float(each[home]),
        (float(half), float(quarter)),
        np.sort(islands)[::-1],
        cell * _holes(cuts, found, inside, flat == home),
    )


def located(
    probe: Probe, points: FloatArray, edges: IndexArray, halvings: int
) -> tuple[FloatArray, FloatArray]:
    """Where everything stops being kept on edges (e, 2) from points inside to others outside: the
    last points that keep it, and the first that do not, (e, d) each. By halving: whether all is
    kept has no values to interpolate where loops can no longer be closed.
    """
    low, high = points[edges[:, 0]], points[edges[:, 1]]
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        kept = probe.keeps(middle)[:, None]
        low, high = np.where(kept, middle, low), np.where(kept, high, middle)
    return low, high


def _pieces(
    cuts: Cuts, grid: Grid, points: FloatArray, crossings: FloatArray, steps: float
) -> Pieces:
    """With cells of so many steps of the grid."""
    unit = steps * grid.step
    return pieces(cuts, (points - grid.origin) / unit, (crossings - grid.origin) / unit)


def _size_by(
    steps: int, probe: Probe, grid: Grid, inside: BoolArray, labels: IndexArray
) -> FloatArray:
    """Sizes by label on every so many-th node."""
    some, points = (slice(None, None, steps),) * inside.ndim, grid.points
    cuts = cut(inside[some], np.arange(len(points)).reshape(grid.shape)[some])
    crossings, _ = located(probe, points, cuts.edges, _ROUGHLY)
    found = _pieces(cuts, grid, points, crossings, float(steps))
    return float(np.prod(steps * grid.step)) * sizes(cuts, found, labels.ravel())


def _holes(cuts: Cuts, found: Pieces, inside: BoolArray, home: BoolArray) -> FloatArray:
    """Sizes of what is enclosed and next to the middle's part, largest first, in cells."""
    labels, count = connected(~inside)
    flat = labels.ravel()
    open_ = np.zeros(count + 1, dtype=bool)
    for axis in np.arange(inside.ndim).tolist():
        for end in (0, -1):
            open_[np.take(labels, end, axis=axis)] = True
    touched = np.zeros(count + 1, dtype=bool)
    touched[flat[cuts.edges[home[cuts.edges[:, 0]], 1]]] = True
    each = sizes_outside(cuts, found, flat)
    return np.sort(each[touched & ~open_])[::-1]
