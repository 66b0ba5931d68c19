"""Plots on a page: the actuators' motion, efforts and power, with a time cursor."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from parakin.arrays import ORDERS, PER_TIME, FloatArray
from parakin.views.browser.playback import Playback
from parakin.views.thinning import thinned
from parakin.views.units import DEGREES, MILLIMETRES

_BUCKETS = 120
# Okabe and Ito's colours, told apart by colour-blind readers too.
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
_DASHES: tuple[list[int], ...] = ([], [9, 5], [2, 4])
_CURSOR = "#444444"
_BESIDE = 17  # pixels of an axis beside its labels
_LETTER = 7  # and of a letter of them


class LivePlots:
    """One plot for each quantity and unit. The cursor is a series of its own: a vertical line at a
    time that is in the data twice.
    """

    def __init__(self, gui: Any) -> None:
        self._gui = gui
        self._panel = gui.add_folder("Motion of the actuators")
        self._plots: list[tuple[Any, FloatArray, FloatArray]] = []
        self._titles: list[str] = []

    def clear(self) -> None:
        """Remove all plots."""
        for plot, _, _ in self._plots:
            plot.remove()
        self._plots.clear()
        self._titles.clear()

    def show(self, playback: Playback) -> None:
        """Plot a motion."""
        self.clear()
        with self._panel:
            for order, (quantity, over) in enumerate(zip(ORDERS[:3], PER_TIME, strict=False)):
                for si, unit in (("m", MILLIMETRES), ("rad", DEGREES)):
                    chosen = [k for k, u in enumerate(playback.units) if u == si]
                    if chosen:
                        values = unit.per_si * playback.histories[order][:, chosen].T
                        names = [playback.actuators[k] for k in chosen]
                        rows = thinned(values, _BUCKETS)
                        title = f"{quantity} [{unit.name}{over}]"
                        self._add(title, playback.time[rows], values[:, rows], names)
            for title, time, values, names in _of_forces(playback):
                self._add(title, time, values, names)

    def show_forces(self, playback: Playback) -> None:
        """Show other efforts and power of the same motion, in the same plots."""
        for title, time, values, _ in _of_forces(playback):
            if title in self._titles:
                k = self._titles.index(title)
                plot = self._plots[k][0]
                low, high = _range(values)
                plot.scales = _scales(low, high)
                plot.axes = _axes(low, high)
                plot.data = _with_cursor(time, values, float(time[0]), low, high)
                self._plots[k] = plot, time, values

    def _add(self, title: str, time: FloatArray, values: FloatArray, names: list[str]) -> None:
        series: list[dict[str, Any]] = [{"label": "t [s]"}]
        for k, name in enumerate(names):
            colour = _COLOURS[k % len(_COLOURS)]
            dash = {"dash": _DASHES[k % 3]}  # so that curves that coincide can all be seen
            points = {"show": False}
            series.append({"label": name, "stroke": colour, "width": 1.5, "points": points} | dash)
        series.append({"label": "now", "stroke": _CURSOR, "width": 1, "points": {"show": False}})
        low, high = _range(values)
        plot = self._gui.add_uplot(
            _with_cursor(time, values, float(time[0]), low, high),
            tuple(series),
            title=title,
            scales=_scales(low, high),
            axes=_axes(low, high),
            legend={"show": len(names) <= 6},
            height=190,
            padding=(10, 16, 0, 0),
        )
        self._plots.append((plot, time, values))
        self._titles.append(title)

    def cursor(self, at: float) -> None:
        """Move the cursor to a time [s]."""
        for plot, time, values in self._plots:
            low, high = plot.scales["y"]["range"]
            plot.data = _with_cursor(time, values, at, low, high)


def _of_forces(
    playback: Playback,
) -> Iterator[tuple[str, FloatArray, FloatArray, list[str]]]:
    """Title, time, curves and names of plots of efforts and power, if any are known."""
    forces = playback.forces
    if forces is None:
        return
    groups = [
        (f"effort [{unit}]", forces.effort, [k for k, u in enumerate(forces.units) if u == unit])
        for unit in ("N", "N m")
    ]
    groups.append(("power [W]", forces.power, list(range(len(forces.actuators)))))
    for title, values, chosen in groups:
        curves = np.where(np.isfinite(values), values, np.nan)[:, chosen].T
        if not np.isnan(curves).all():
            rows = thinned(curves, _BUCKETS)
            names = [forces.actuators[k] for k in chosen]
            yield title, playback.time[rows], curves[:, rows], names


def _range(values: FloatArray) -> tuple[float, float]:
    """Of an axis, with room for the curves."""
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    room = 0.06 * (high - low) or max(1e-3, 0.06 * abs(high))
    return low - room, high + room


def _scales(low: float, high: float) -> dict[str, Any]:
    return {"x": {"time": False}, "y": {"range": (low, high)}}


def _axes(low: float, high: float) -> tuple[dict[str, Any], ...]:
    return {}, {"size": _axis_width(low, high)}


def _axis_width(low: float, high: float) -> int:
    """Pixels that the labels of an axis may need: uPlot cuts off what is wider than its 50."""
    step = (high - low) / 8  # at least that between labels
    decimals = max(0, 1 - math.floor(math.log10(step)))
    longest = max(len(f"{value:,.{decimals}f}") for value in (low, high))
    return max(50, _BESIDE + _LETTER * longest)


def _with_cursor(
    time: FloatArray, values: FloatArray, at: float, low: float, high: float
) -> tuple[FloatArray, ...]:
    k = int(np.searchsorted(time, at))
    now = [np.interp(at, time, row) for row in values]
    upright = np.full(len(time) + 2, np.nan)
    upright[k : k + 2] = low, high
    rows = [np.insert(row, k, [y, y]) for row, y in zip(values, now, strict=True)]
    return (np.insert(time, k, [at, at]), *rows, upright)
