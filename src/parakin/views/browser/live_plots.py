"""Charts on the page: position, velocity and acceleration of the actuators, with a cursor."""

from __future__ import annotations

from typing import Any

import numpy as np

from parakin.arrays import FloatArray
from parakin.views.browser.repertoire import Take
from parakin.views.curves import telling

_BUCKETS = 120
_ORDERS = (("position", ""), ("velocity", "/s"), ("acceleration", "/s²"))
# Okabe and Ito's colours, told apart by colour-blind readers too.
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
_DASHES: tuple[list[int], ...] = ([], [9, 5], [2, 4])
_CURSOR = "#444444"


class Charts:
    """One chart for each quantity and unit. The cursor is a series of its own, upright at a time,
    for which that time stands in the data twice.
    """

    def __init__(self, gui: Any) -> None:
        self._gui = gui
        self._panel = gui.add_folder("Motion of the actuators")
        self._charts: list[tuple[Any, FloatArray, FloatArray]] = []

    def clear(self) -> None:
        """No charts."""
        for chart, _, _ in self._charts:
            chart.remove()
        self._charts.clear()

    def show(self, take: Take) -> None:
        """Charts of a motion."""
        self.clear()
        with self._panel:
            for order, (quantity, over) in enumerate(_ORDERS):
                for unit, shown, scale in (("m", "mm", 1e3), ("rad", "deg", 180 / np.pi)):
                    chosen = [k for k, u in enumerate(take.units) if u == unit]
                    if chosen:
                        values = scale * take.histories[order][:, chosen].T
                        names = [take.actuators[k] for k in chosen]
                        rows = telling(values, _BUCKETS)
                        title = f"{quantity} [{shown}{over}]"
                        self._add(title, take.time[rows], values[:, rows], names)

    def _add(self, title: str, time: FloatArray, values: FloatArray, names: list[str]) -> None:
        series: list[dict[str, Any]] = [{"label": "t [s]"}]
        for k, name in enumerate(names):
            colour = _COLOURS[k % len(_COLOURS)]
            dash = {"dash": _DASHES[k % 3]}  # curves that coincide are all seen
            points = {"show": False}
            series.append({"label": name, "stroke": colour, "width": 1.5, "points": points} | dash)
        series.append({"label": "now", "stroke": _CURSOR, "width": 1, "points": {"show": False}})
        low, high = float(values.min()), float(values.max())
        room = 0.06 * (high - low) or max(1e-3, 0.06 * abs(high))
        chart = self._gui.add_uplot(
            _with_cursor(time, values, float(time[0]), low - room, high + room),
            tuple(series),
            title=title,
            scales={"x": {"time": False}, "y": {"range": (low - room, high + room)}},
            legend={"show": len(names) <= 6},
            height=190,
            padding=(10, 16, 0, 0),
        )
        self._charts.append((chart, time, values))

    def cursor(self, at: float) -> None:
        """Move the cursor to a time [s]."""
        for chart, time, values in self._charts:
            low, high = chart.scales["y"]["range"]
            chart.data = _with_cursor(time, values, at, low, high)


def _with_cursor(
    time: FloatArray, values: FloatArray, at: float, low: float, high: float
) -> tuple[FloatArray, ...]:
    k = int(np.searchsorted(time, at))
    now = [np.interp(at, time, row) for row in values]
    upright = np.full(len(time) + 2, np.nan)
    upright[k : k + 2] = low, high
    rows = [np.insert(row, k, [y, y]) for row, y in zip(values, now, strict=True)]
    return (np.insert(time, k, [at, at]), *rows, upright)
