"""A workspace as a figure: a slice with lines of equal stroke left, or a surface in space."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from parakin.errors import InputError
from parakin.views.colours import colours_of
from parakin.views.workspace_shares import decided, percent, shares
from parakin.views.workspace_units import are_mixed, comparable, per_si, units_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.path import Path as Outline

    from parakin.arrays import FloatArray, IndexArray

_INSIDE, _ISLAND, _REST = "#EDF3F7", "#FFFFFF", "#666666"
_AZIMUTH = -52.0  # degrees, that a surface is seen from
_ROOM = 0.05  # around a slice, of its longer side
_NAMED = 13  # things that limit most of the boundary; the rest is drawn alike
_SHOWN = {
    "stroke_left": "stroke left [%]",
    "conditioning": "conditioning",
    "effort": "effort at rest [% of max_effort]",
}
_PERCENT = ("stroke_left", "effort")


def workspaces(found: xr.Dataset, title: str = "", lines: str | None = None) -> Figure:
    """The region in two coordinates with lines of equal stroke left, or of what `lines` names
    ("stroke_left", "conditioning", "effort"); the surface in three. The boundary is coloured by
    what limits it; the pose is marked; islands are hatched. Lengths in millimetres, angles in
    degrees. Raises InputError where there is nothing to draw.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    if found.attrs["stopped"]:
        raise InputError("workspace", found.attrs["stopped"], "a pose to count from")
    if lines is not None:
        _check_lines(found, lines)
    style: dict[Any, Any] = {"font.size": 9, "svg.fonttype": "none", "pdf.fonttype": 42}
    with mpl.rc_context(style | {"axes.linewidth": 0.6}):
        figure = Figure(figsize=_size(found), layout="constrained")
        colours = _colours(found)
        if found.sizes["over"] == 2:
            known = bool(np.isfinite(found["stroke_left"].values).any())
            _draw_slice(figure, found, colours, lines or ("conditioning", "stroke_left")[known])
        else:
            _draw_surface(figure, found, colours)
        _draw_legend(figure, found, colours)
        if title:
            figure.suptitle(title, fontsize=10, parse_math=False)
        if found.sizes["over"] == 2:
            figure.draw_without_rendering()  # equal axes move ticks: one layout cuts labels off
    return figure


def _check_lines(found: xr.Dataset, lines: str) -> None:
    if lines not in _SHOWN:
        raise InputError("lines", repr(lines), " or ".join(_SHOWN))
    if found.sizes["over"] != 2:
        raise InputError("lines", "a surface", "two coordinates to move")
    if not np.isfinite(found[lines].values).any():
        why = found[lines].attrs.get("not_known") or "no slide has limits at both ends"
        raise InputError("lines", f"{lines}, which is not known: {why}", "one that is")


def _size(found: xr.Dataset) -> tuple[float, float]:
    """Of the figure, in inches."""
    if found.sizes["over"] == 3:
        return 11.0, 4.4
    if are_mixed(found):
        return 8.4, 5.6
    wide, high = np.ptp(found["boundary"].values, axis=(0, 1)).tolist()
    return 8.4, float(np.clip(5.6 * high / wide + 1.0, 3.2, 8.0))


def _colours(found: xr.Dataset) -> list[str]:
    """By number of what stops it: a colour each for what limits most of the boundary."""
    most = colours_of(list(shares(found))[:_NAMED])
    return [most.get(str(word), _REST) for word in found["stop"].values]


def _draw_legend(figure: Figure, found: xr.Dataset, colours: list[str]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    words, known = found["stop"].values.tolist(), shares(found)
    handles: list[Any] = [
        Patch(color=colours[words.index(word)], label=f"{word}  ({percent(share)})")
        for word, share in list(known.items())[:_NAMED]
    ]
    if len(known) > _NAMED:
        handles.append(Patch(color=_REST, label=f"{len(known) - _NAMED} others"))
    if found.sizes["over"] == 2:
        handles.append(Line2D([], [], color="0.1", marker="+", linestyle="", label="pose"))
        if not are_mixed(found):
            handles.append(Line2D([], [], color="0.1", linestyle="--", label="largest circle"))
        handles.append(Line2D([], [], color="0.1", linestyle=":", label="largest rectangle"))
        if found.sizes["island"]:
            island = Patch(facecolor=_ISLAND, edgecolor="0.5", hatch="////")
            island.set_label("not connected to the pose")
            handles.append(island)
    figure.legend(handles=handles, loc="outside right upper", fontsize=8, frameon=False)


def _labels(found: xr.Dataset) -> list[str]:
    each = zip(found["over"].values.tolist(), units_of(found), strict=True)
    return [f"{name.removeprefix('platform.')} [{unit.name}]" for name, unit in each]


def _draw_slice(figure: Figure, found: xr.Dataset, colours: list[str], by: str) -> None:
    axes = figure.subplots()
    labels = _labels(found)
    facets = per_si(found) * found["boundary"].values
    own = found["boundary_connected"].values
    if not own.all():
        _fill(axes, _outline(facets[~own]), facecolor=_ISLAND, edgecolor="0.5", hatch="////")
    _fill(axes, _outline(facets[own]), facecolor=_INSIDE, edgecolor="none")
    _draw_lines(axes, found, by)
    _draw_boundary(axes, facets, found["boundary_stopped_by"].values, colours)
    _draw_room(axes, found)
    axes.set_aspect("auto" if are_mixed(found) else "equal")
    axes.set_xlabel(labels[0])
    axes.set_ylabel(labels[1])
    axes.grid(visible=True, linewidth=0.3, color="0.85")
    axes.set_axisbelow(True)
    low, high = facets.min(axis=(0, 1)), facets.max(axis=(0, 1))
    room = _ROOM * ((high - low) if are_mixed(found) else np.full(2, (high - low).max()))
    axes.set_xlim(low[0] - room[0], high[0] + room[0])
    axes.set_ylim(low[1] - room[1], high[1] + room[1])


def _outline(facets: FloatArray) -> Outline:
    """Lines (p, 2, 2), each with what is inside on its left, joined end to end to closed curves."""
    from matplotlib.path import Path

    after = {tuple(start): tuple(end) for start, end in facets.tolist() if start != end}
    corners: list[tuple[float, ...]] = []
    codes: list[int] = []
    while after:
        start, end = after.popitem()
        curve = [start]
        while end in after:
            curve.append(end)
            end = after.pop(end)
        corners += [*curve, start]
        codes += [int(Path.MOVETO)] + [int(Path.LINETO)] * (len(curve) - 1) + [int(Path.CLOSEPOLY)]
    return Path(np.array(corners), codes)


def _fill(axes: Axes, outline: Outline, **look: Any) -> None:
    from matplotlib.patches import PathPatch

    axes.add_patch(PathPatch(outline, linewidth=0.0, zorder=1.0, **look))


def _draw_lines(axes: Axes, found: xr.Dataset, by: str) -> None:
    """Lines of equal figures of what is connected to the pose."""
    values = np.where(found["connected"].values, found[by].values, np.nan)
    if by in _PERCENT:
        values = 100.0 * values
    if not np.isfinite(values).any() or np.nanmax(values) - np.nanmin(values) < 1e-9:
        return
    each = zip(found["over"].values, per_si(found), strict=True)
    x, y = (per * found[name].values for name, per in each)
    levels: Any = 7
    if by == "effort" and np.nanmax(values) > 100.0:  # near a singularity there is no end of it
        levels = np.arange(10.0, 101.0, 10.0)
    lines = axes.contour(
        *(x, y, np.ma.masked_invalid(values.T)),
        levels=levels,
        colors="0.45",
        linewidths=0.7,
        zorder=2.0,
    )
    axes.clabel(lines, fontsize=7, fmt="%g")
    axes.set_title(f"lines: {_SHOWN[by]}", fontsize=8, loc="left")


def _draw_boundary(axes: Axes, facets: FloatArray, numbers: IndexArray, colours: list[str]) -> None:
    """Each line half and half in the colours of what stops its ends."""
    from matplotlib.collections import LineCollection

    middle = facets.mean(axis=1)
    halves = [np.stack([facets[:, end], middle], axis=1) for end in (0, 1)]
    axes.add_collection(
        LineCollection(
            list(np.concatenate(halves)),
            colors=[colours[k] for end in (0, 1) for k in numbers[:, end].tolist()],
            linewidths=2.2,
            capstyle="round",
            zorder=3.0,
        )
    )


def _draw_room(axes: Axes, found: xr.Dataset) -> None:
    """The pose, and the largest circle and rectangle about it."""
    from matplotlib.patches import Circle, Rectangle

    per = per_si(found)
    x, y = (per * found["middle"].values).tolist()
    a, b = (per * found["half_width"].values).tolist()
    look: dict[str, Any] = {"fill": False, "edgecolor": "0.1", "linewidth": 0.9, "zorder": 4.0}
    if not are_mixed(found):
        axes.add_patch(Circle((x, y), per[0] * float(found["radius"]), linestyle="--", **look))
    axes.add_patch(Rectangle((x - a, y - b), 2.0 * a, 2.0 * b, linestyle=":", **look))
    axes.plot(x, y, "+", color="0.1", markersize=9, zorder=5.0)


def _draw_surface(figure: Figure, found: xr.Dataset, colours: list[str]) -> None:
    """Seen from above, and from below on the other side, so that all of it is."""
    from matplotlib.colors import to_rgb
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    labels = _labels(found)
    own = found["boundary_connected"].values
    si = found["boundary"].values[own]
    facets = per_si(found) * si
    numbers = decided(found["boundary_stopped_by"].values[own])
    flat = np.array([to_rgb(colour) for colour in colours])[numbers]
    low, high = facets.min(axis=(0, 1)), facets.max(axis=(0, 1))
    views = ((24.0, _AZIMUTH), (-24.0, _AZIMUTH + 180.0))
    for axes, (elevation, azimuth) in zip(_pair(figure), views, strict=True):
        shade = _brightness(comparable(found, si), elevation, azimuth)[:, None]
        surface = Poly3DCollection(list(facets), facecolors=shade * flat, linewidths=0.0)
        surface.set_antialiased(False)  # no seams between triangles
        surface.set_rasterized(True)  # tens of thousands of triangles are no vectors to read
        axes.add_collection3d(surface)
        for axis, a, b, label in zip("xyz", low, high, labels, strict=True):
            getattr(axes, f"set_{axis}lim")(a, b)
            getattr(axes, f"set_{axis}label")(label, fontsize=8)
        axes.tick_params(labelsize=7)
        axes.set_box_aspect(np.ones(3) if are_mixed(found) else high - low, zoom=0.88)
        axes.view_init(elev=elevation, azim=azimuth)
        where = "from above" if elevation > 0.0 else "from below, on the other side"
        axes.text2D(0.5, -0.02, where, transform=axes.transAxes, ha="center")


def _pair(figure: Figure) -> Any:
    return figure.subplots(1, 2, subplot_kw={"projection": "3d"})


def _brightness(facets: FloatArray, elevation: float, azimuth: float) -> FloatArray:
    """Of facets (p,), lit from beside where they are seen from."""
    normal = np.cross(facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0])
    size = np.linalg.norm(normal, axis=1)
    up, around = np.radians(1.5 * elevation), np.radians(azimuth + 35.0)
    light = [np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)]
    lit = np.divide(normal @ light, size, out=np.zeros(len(size)), where=size > 0.0)
    found: FloatArray = 0.78 + 0.22 * np.clip(lit, -1.0, 1.0)
    return found
