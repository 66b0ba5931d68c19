"""Arrows of efforts in a film, to the scale of the largest, with the numbers beside them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from parakin.arrays import FloatArray, IntArray
from parakin.views.force_arrows import COLOURS, LONGEST, ForceArrows, largest_of
from parakin.views.force_text import figure
from parakin.views.solids.drawing import Drawing
from parakin.views.solids.painting import Painter

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

_SHORTEST = 0.02  # of the longest: what is shorter has a number alone
_BESIDE = 0.12  # of the longest: from an arrow's tip to its number


class FilmArrows:
    """The artists of a result's efforts in axes that a painter paints a mechanism in; none of a
    result without.
    """

    def __init__(self, drawing: Drawing, painter: Painter, axes: Axes, ds: xr.Dataset) -> None:
        self._painter = painter
        self.artists: list[Artist] = []
        if "effort" not in ds:
            return
        names = tuple(ds["actuator"].values.tolist())
        units = ds["effort_unit"].values.tolist()
        size = min(drawing.arrangement.size, float(drawing.view.span))
        self._length = LONGEST * size
        self._arrows = ForceArrows(drawing.arrangement.graph, names, size)
        self._efforts: FloatArray = ds["effort"].values
        self._largest = largest_of(self._efforts, units)
        self._units = [units[k] for k in self._arrows.shown]
        none = np.zeros(len(self._units))
        colours = [tuple(part / 255 for part in COLOURS[unit]) for unit in self._units]
        self._quiver = axes.quiver(
            *(none, none, none, none),
            color=colours,
            angles="xy",
            scale_units="xy",
            scale=1.0,
            width=0.006,
            zorder=5,
        )
        self._numbers = [
            axes.text(0.0, 0.0, "", fontsize=8, color=colour, zorder=6, ha="center", va="center")
            for colour in colours
        ]
        self.artists = [self._quiver, *self._numbers]

    def reach(self, R: FloatArray, p: FloatArray, samples: IntArray) -> FloatArray:
        """Points (n, 2) of the picture that must be in it, of some samples' poses."""
        if not self.artists:
            return np.zeros((0, 2))
        every = zip(R, p, samples.tolist(), strict=True)
        tips = [self._placed(*pose)[2] for pose in every]
        return np.concatenate(tips)

    def _placed(
        self, R: FloatArray, p: FloatArray, sample: int
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Starts and ends of arrows in the picture, and the middles of their numbers."""
        points = self._arrows.at(R, p, self._efforts[sample], self._largest)
        start, end = (self._painter.seen(points[:, k]) for k in (0, 1))
        size = np.linalg.norm(end - start, axis=1, keepdims=True)
        upright = np.broadcast_to([0.0, 1.0], end.shape)
        away = np.divide(end - start, size, out=upright.copy(), where=size > 1e-9 * self._length)
        return start, end, end + _BESIDE * self._length * away

    def show(self, R: FloatArray, p: FloatArray, sample: int) -> None:
        """Show the efforts of a sample, with all bodies at R (bodies, 3, 3) and p (bodies, 3)."""
        if not self.artists:
            return
        start, end, beside = self._placed(R, p, sample)
        along = end - start
        along[np.linalg.norm(along, axis=1) < _SHORTEST * self._length] = np.nan
        self._quiver.set_offsets(start)
        self._quiver.set_UVC(*along.T)
        for k, text in enumerate(self._numbers):
            effort = float(self._efforts[sample, self._arrows.shown[k]])
            text.set_position((float(beside[k, 0]), float(beside[k, 1])))
            text.set_text(f"{figure(effort)} {self._units[k]}" if np.isfinite(effort) else "")
