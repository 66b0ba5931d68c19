"""The range of a mechanism as a figure: a bar for each coordinate, and a panel for each pair."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from parakin.errors import InputError
from parakin.views.colours import colours_of
from parakin.views.units import Unit, unit_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

    from parakin.arrays import FloatArray

_FREE = "#F0F0F0"
_ROOM = 1.9  # times the longest bar: what is written at its ends needs room


def ranges(found: xr.Dataset, title: str = "") -> Figure:
    """How far each coordinate goes, down and up, coloured by what stops it, its velocities beside
    it; and, if pairs were asked for, the boundary of each, coloured alike. Lengths in millimetres,
    angles in degrees. Raises InputError where there is nothing to draw.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    if found.attrs["stopped"]:
        raise InputError("range", found.attrs["stopped"], "a pose that something may move from")
    colours = _colours(found)
    groups = [k for k in ("m", "rad") if (found["unit"].values == k).any()]
    count, pairs = found.sizes["driven"], "boundary" in found
    bars_high = 0.5 * count + 0.9 * len(groups) + 0.3
    side = 1.75 * (count - 1) if pairs else 0.0
    style: dict[Any, Any] = {"font.size": 9, "svg.fonttype": "none", "pdf.fonttype": 42}
    with mpl.rc_context(style | {"axes.linewidth": 0.6}):
        figure = Figure(figsize=(9.6, bars_high + side + 0.3), layout="constrained")
        parts: Any = [figure]
        if pairs:
            parts = figure.subfigures(2, 1, height_ratios=[bars_high, side])
        _draw_bars(parts[0], found, groups, colours)
        if pairs:
            _draw_pairs(parts[1], found, colours)
        if title:
            figure.suptitle(title, fontsize=10, parse_math=False)
    return figure


def _colours(found: xr.Dataset) -> dict[str, str]:
    """A colour for each thing that stops something, in order of appearance."""
    words = found["stopped_by"].values.ravel().tolist()
    if "boundary_stopped_by" in found:
        words += found["boundary_stopped_by"].values.ravel().tolist()
    return colours_of(words) | {"": _FREE}


def _draw_bars(
    figure: Figure | SubFigure, found: xr.Dataset, groups: list[str], colours: dict[str, str]
) -> None:
    sizes = [int((found["unit"].values == unit).sum()) for unit in groups]
    grid = figure.subplots(len(groups), 1, squeeze=False, height_ratios=[n + 0.6 for n in sizes])
    for axes, unit in zip(grid[:, 0], groups, strict=True):
        rows = np.flatnonzero(found["unit"].values == unit)
        shown = unit_of(unit == "rad")
        travel: FloatArray = shown.per_si * found["travel"].values[rows]
        finite = np.abs(travel[np.isfinite(travel)])
        longest = float(finite.max(initial=0.0)) or 1.0
        for place, row in enumerate(rows.tolist()):
            for end in (0, 1):
                _draw_bar(
                    axes, found, (row, end), place, float(travel[place, end]), longest, colours
                )
            axes.text(
                1.01, place, _speeds(found, row), transform=axes.get_yaxis_transform(), va="center"
            )
        axes.set_yticks(np.arange(len(rows)), found["driven"].values[rows])
        axes.set_ylim(len(rows) - 0.5, -0.5)
        axes.set_xlim(-_ROOM * longest, _ROOM * longest)
        axes.set_xlabel(f"from the pose [{shown.name}]")
        axes.axvline(0.0, color="0.2", linewidth=0.8)
        axes.grid(visible=True, axis="x", linewidth=0.3, color="0.8")
        axes.set_axisbelow(True)
        axes.tick_params(axis="y", length=0)
    if np.isfinite(found["max_velocity"].values).any():
        grid[0, 0].text(1.01, 1.02, "velocity", transform=grid[0, 0].transAxes, fontweight="bold")


def _draw_bar(
    axes: Axes,
    found: xr.Dataset,
    where: tuple[int, int],
    place: int,
    length: float,
    longest: float,
    colours: dict[str, str],
) -> None:
    """One side of a coordinate, with its length and what stops it."""
    words, sign = str(found["stopped_by"].values[where]), (-1.0, 1.0)[where[1]]
    if np.isnan(length):
        return
    drawn = sign * longest if np.isinf(length) else length
    axes.barh(place, drawn, height=0.62, color=colours[words], edgecolor="white", linewidth=0.6)
    text = "free" if np.isinf(length) else f"{length:+z.1f}  {words}"
    axes.annotate(
        text,
        (drawn, place),
        (4.0 * sign, 0.0),
        textcoords="offset points",
        ha="left" if sign > 0.0 else "right",
        va="center",
        fontsize=8,
        parse_math=False,
    )


def _speeds(found: xr.Dataset, row: int) -> str:
    """The largest velocities of a coordinate, one if both are alike."""
    angle = found["unit"].values[row] == "rad"
    per, unit, form = (np.degrees(1.0), "°/s", ".1f") if angle else (1.0, " m/s", ".3f")
    down, up = per * found["max_velocity"].values[row]
    if not np.isfinite([down, up]).all():
        return ""
    if f"{-down:{form}}" == f"{up:{form}}":
        return f"±{up:{form}}{unit}"
    return f"{down:+z{form}} .. {up:+z{form}}{unit}"


def _draw_pairs(figure: SubFigure | Figure, found: xr.Dataset, colours: dict[str, str]) -> None:
    from matplotlib.patches import Patch

    names = found["driven"].values.tolist()
    units = {name: unit_of(u == "rad") for name, u in zip(names, found["unit"].values, strict=True)}
    n = len(names) - 1
    grid = figure.subplots(n, n, squeeze=False)
    used: dict[str, None] = {}
    for axes in grid.ravel():
        axes.set_axis_off()
    for pair in np.arange(found.sizes["pair"]).tolist():
        first, second = (str(found[key].values[pair]) for key in ("first", "second"))
        column, row = names.index(first), names.index(second) - 1
        axes = grid[row, column]
        axes.set_axis_on()
        words = [str(each) for each in found["boundary_stopped_by"].values[pair]]
        used |= dict.fromkeys(words)
        boundary = found["boundary"].values[pair] * (units[first].per_si, units[second].per_si)
        _draw_boundary(axes, boundary, words, colours)
        if row == n - 1:
            axes.set_xlabel(_label(first, units[first]), fontsize=7)
        if column == 0:
            axes.set_ylabel(_label(second, units[second]), fontsize=7)
        axes.tick_params(labelsize=6, length=2)
    labels = [Patch(color=colours[each], label=each or "free") for each in used]
    figure.legend(handles=labels, loc="upper right", fontsize=7, ncols=2, frameon=False)


def _label(name: str, unit: Unit) -> str:
    return f"{name.removeprefix('platform.')} [{unit.name}]"


def _draw_boundary(
    axes: Axes, boundary: FloatArray, words: list[str], colours: dict[str, str]
) -> None:
    """A closed polygon, each of its sides half and half in the colours of what stops its ends; rays
    that nothing stops are left out.
    """
    from matplotlib.collections import LineCollection

    boundary = boundary.copy()
    boundary[~np.isfinite(boundary).all(axis=1)] = np.nan
    corners = boundary[~np.isnan(boundary).any(axis=1)]
    if len(corners):
        axes.fill(*corners.T, color=_FREE, linewidth=0)
    middle = 0.5 * (boundary + np.roll(boundary, -1, axis=0))
    before = np.roll(middle, 1, axis=0)
    lines = list(np.stack([before, boundary, middle], axis=1))
    known = [k for k, line in enumerate(lines) if np.isfinite(line).all()]
    axes.add_collection(
        LineCollection(
            [lines[k] for k in known],
            colors=[colours[words[k]] for k in known],
            linewidths=1.6,
            capstyle="round",
        )
    )
    axes.plot(0.0, 0.0, "+", color="0.2", markersize=5)
    axes.margins(0.08)
    axes.autoscale_view()
