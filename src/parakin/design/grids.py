"""Grids of points about a pose, and how large a box to look at."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from parakin.arrays import BoolArray, FloatArray, IndexArray
from parakin.design.probing import Probe
from parakin.design.simplices import connected

_COARSE = {2: 33, 3: 17}  # nodes along each side of the boxes that are tried
_BEGIN = 0.25  # characteristic lengths, or radians: half a side of the first
_TRIALS = 60
_MARGIN = 2.0  # steps of the grid that was tried, around what was found
_SMALL = 0.4  # of a box: what fills less of a side is looked at in a smaller one


class Box(NamedTuple):
    """Two corners (d,)."""

    low: FloatArray
    high: FloatArray


class Grid(NamedTuple):
    """Nodes that go beyond a box on all sides, one of them the middle, four times so many steps
    from either end: axes (nodes,), the steps between them (d,), and the middle's place (d,).
    """

    axes: tuple[FloatArray, ...]
    step: FloatArray
    middle: tuple[int, ...]

    @property
    def points(self) -> FloatArray:
        """All nodes (n, d), the last coordinate varying fastest."""
        found = np.stack(np.meshgrid(*self.axes, indexing="ij"), axis=-1)
        return found.reshape(-1, len(self.axes))

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(len(axis) for axis in self.axes)

    @property
    def origin(self) -> FloatArray:
        """The lowest node (d,)."""
        return np.array([axis[0] for axis in self.axes])


def grid_over(box: Box, middle: FloatArray, count: int) -> Grid:
    """About so many nodes along each side of a box around a point."""
    step = (box.high - box.low) / (count - 1)
    below = _fours_above((middle - box.low) / step)
    above = _fours_above((box.high - middle) / step)
    axes = tuple(
        x + h * np.arange(-a, b + 1) for x, h, a, b in zip(middle, step, below, above, strict=True)
    )
    return Grid(axes, step, tuple(below.tolist()))


def _fours_above(steps: FloatArray) -> IndexArray:
    """The least multiples of four above."""
    found: IndexArray = 4 * (np.floor(0.25 * steps).astype(np.intp) + 1)
    return found


def box_around(probe: Probe, middle: FloatArray, units: FloatArray) -> Box:
    """A box around all that is connected to a point, within what a probe looks at, by ever larger
    and smaller boxes. units (d,): characteristic lengths, or 1 for angles.
    """
    most = Box(probe.low, probe.high)
    box = _within(Box(middle - _BEGIN * units, middle + _BEGIN * units), most)
    for _ in range(_TRIALS):
        grid = grid_over(box, middle, _COARSE[len(middle)])
        inside = replace(probe, low=box.low, high=box.high).keeps(grid.points)
        found = around(inside.reshape(grid.shape), grid)
        larger = widened(box, most, found, grid, 0.5)
        if larger is not None:
            box = larger
            continue
        margin = _MARGIN * grid.step
        close = _within(Box(found.low - margin, found.high + margin), box)
        filled = close.high - close.low > _SMALL * (box.high - box.low)
        box = close
        if filled.all():
            break
    return box


def widened(box: Box, most: Box, found: Box, grid: Grid, by: float) -> Box | None:
    """A box made wider by a part of itself where what was found on a grid comes near to its sides,
    or none where it does not, or must not grow.
    """
    down = (found.low - box.low < grid.step) & (box.low > most.low)
    up = (box.high - found.high < grid.step) & (box.high < most.high)
    if not (down.any() or up.any()):
        return None
    wider = by * (box.high - box.low)
    return _within(Box(box.low - down * wider, box.high + up * wider), most)


def _within(box: Box, most: Box) -> Box:
    return Box(np.maximum(box.low, most.low), np.minimum(box.high, most.high))


def around(inside: BoolArray, grid: Grid) -> Box:
    """The nodes that are connected to the grid's middle, in a box."""
    labels, _ = connected(inside)
    mine = np.argwhere(labels == labels[grid.middle])
    return Box(
        grid.origin + mine.min(axis=0) * grid.step, grid.origin + mine.max(axis=0) * grid.step
    )
