"""Figures of results: time histories, one row for each quantity, with the source's symbols."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from parakin.arrays import ORDERS, PER_TIME
from parakin.errors import InputError, nearest
from parakin.files.writing import check_suffix, write_figure
from parakin.views.flags import flagged_spans
from parakin.views.thinning import thinned
from parakin.views.units import DEGREES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

    from parakin.labelled import Result

FORCES = ("effort", "power")
SUFFIXES = (".png", ".svg", ".pdf")
_DASHES = ("-", "--", "-.", ":", (0, (5, 1)), (0, (3, 1, 1, 1)))
# Okabe and Ito's colours, safe for colour-blind readers; dashes distinguish them in grey.
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
_BUCKETS = 5000  # of a thinned curve: more than a printer resolves


def check_figure(path: Path) -> None:
    """Raises InputError if the suffix is not one of a figure, or matplotlib is missing."""
    check_suffix(path, SUFFIXES, {"matplotlib": "matplotlib"}, "plot")


def histories(
    ds: Result,
    coordinates: Sequence[str] | None = None,
    symbols: Mapping[str, str] | None = None,
    orders: Sequence[str] | None = None,
    title: str = "",
) -> Figure:
    """Position, velocity, acceleration and, if the result has them, jerk, effort and power over
    time, effort with the band in which friction at rest may change it.

    coordinates: by default the actuated ones, or all if there are none. orders: some of these
    quantities. symbols: by coordinate, as mathtext without the dollar signs. Lengths [m] and
    angles [deg] have a column each. Flagged samples are left out of the lines, and their time is
    shaded. Raises InputError on coordinates that the result does not have.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    names = list(coordinates) if coordinates is not None else _default(ds)
    check_coordinates(names, ds["coordinate"].values.tolist())
    columns = _columns(ds, names)
    orders = orders or _quantities(ds, names)
    style: dict[Any, Any] = {
        "font.size": 9,
        "svg.fonttype": "none",
        "pdf.fonttype": 42,
        "axes.linewidth": 0.6,
    }
    with mpl.rc_context(style):
        figure = Figure(
            figsize=(4.6 * len(columns) + 0.8, 1.9 * len(orders) + 0.6), layout="constrained"
        )
        draw_histories(figure, ds, names, symbols, orders)
        if title:
            figure.suptitle(title, fontsize=10, parse_math=False)
    return figure


def draw_histories(
    figure: Figure | SubFigure,
    ds: Result,
    coordinates: Sequence[str] | None = None,
    symbols: Mapping[str, str] | None = None,
    orders: Sequence[str] | None = None,
) -> None:
    """Draw the same into a figure, or a part of one."""
    names = list(coordinates) if coordinates is not None else _default(ds)
    orders, columns = orders or _quantities(ds, names), _columns(ds, names)
    grid = figure.subplots(len(orders), len(columns), sharex=True, squeeze=False)
    for column, (unit, group) in zip(grid.T, columns, strict=True):
        for axes, order in zip(column, orders, strict=True):
            _draw(axes, ds, group, order, unit, symbols or {})
        column[0].legend(
            loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, frameon=False, fontsize=9
        )
        column[-1].set_xlabel("time  $t$ [s]")


def check_coordinates(names: Sequence[str], known: Sequence[str]) -> None:
    """Raises InputError unless all of these are known, each is there once, and there is one."""
    if not names:
        raise InputError("coordinates", "none", "one or more")
    if len(set(names)) < len(names):
        raise InputError("coordinates", ", ".join(names), "each once")
    for name in names:
        if name not in known:
            raise InputError("coordinates", f"unknown coordinate {name!r}", nearest(name, known))


def _columns(ds: Result, names: Sequence[str]) -> list[tuple[str, list[str]]]:
    """Lengths and angles: the SI unit, and the names with this unit."""
    units = dict(zip(ds["coordinate"].values.tolist(), ds["unit"].values.tolist(), strict=True))
    groups = [(unit, [n for n in names if units[n] == unit]) for unit in ("m", "rad")]
    return [(unit, group) for unit, group in groups if group]


def _default(ds: Result) -> list[str]:
    names = ds["coordinate"].values
    actuated = names[ds["actuated"].values].tolist()
    return list(actuated or names.tolist())


def _quantities(ds: Result, names: Sequence[str]) -> list[str]:
    """What of a result there is to draw: forces only where actuators are among the names."""
    orders = [order for order in ORDERS if order in ds]
    return orders + (list(FORCES) if _actuators(ds, names) else [])


def _actuators(ds: Result, names: Sequence[str]) -> list[str]:
    """Those of the names that have efforts."""
    known = ds["actuator"].values.tolist() if "effort" in ds else []
    return [name for name in names if name in known]


def _draw(
    axes: Axes,
    ds: Result,
    names: Sequence[str],
    quantity: str,
    unit: str,
    symbols: Mapping[str, str],
) -> None:
    time = ds["time"].values
    if quantity in FORCES:
        shown, known = _actuators(ds, names), ds["actuator"].values.tolist()
        if not shown:
            axes.set_axis_off()
            return
        if quantity == "effort":
            _draw_bands(axes, ds, {known.index(name): names.index(name) for name in shown})
    else:
        shown, known = list(names), ds["coordinate"].values.tolist()
    values = ds[quantity].values[:, [known.index(name) for name in shown]]
    values = np.degrees(values) if unit == "rad" and quantity in ORDERS else values
    for name, curve in zip(shown, values.T, strict=True):
        k = names.index(name)
        rows = thinned(curve[None], _BUCKETS)
        axes.plot(
            time[rows],
            curve[rows],
            color=_COLOURS[k % len(_COLOURS)],
            linestyle=_DASHES[k // len(_COLOURS) + k % 3 if k < 3 else k % len(_DASHES)],
            linewidth=1.2,
            label=f"${symbols[name]}$" if name in symbols else name,
        )
    axes.set_ylabel(f"{quantity} [{_unit(quantity, unit)}]")
    axes.grid(visible=True, linewidth=0.3, color="0.8")
    axes.margins(x=0)
    axes.axhline(0.0, color="0.5", linewidth=0.5, zorder=0)
    for span in flagged_spans(ds):
        axes.axvspan(*span, color="#D55E00", alpha=0.12, linewidth=0)


def _draw_bands(axes: Axes, ds: Result, colours: Mapping[int, int]) -> None:
    """Where efforts may be while friction holds actuators at rest. colours: by actuator."""
    time, effort, band = (ds[name].values for name in ("time", "effort", "effort_band"))
    for k, colour in colours.items():
        if np.nanmax(band[:, k], initial=0.0) > 0.0:
            low, high = effort[:, k] - band[:, k], effort[:, k] + band[:, k]
            rows = thinned(np.array([low, high]), _BUCKETS)
            axes.fill_between(
                *(time[rows], low[rows], high[rows]),
                color=_COLOURS[colour % len(_COLOURS)],
                alpha=0.25,
                linewidth=0.6,
            )


def _unit(quantity: str, unit: str) -> str:
    """A quantity's, of coordinates in metres or radians."""
    if quantity == "power":
        return "W"
    if quantity == "effort":
        return "N" if unit == "m" else "N m"
    return f"{DEGREES.name if unit == 'rad' else 'm'}{PER_TIME[ORDERS.index(quantity)]}"


def save(figure: Figure, path: Path) -> None:
    """Write a figure: PNG at 200 dots per inch, or vectors. Raises InputError."""
    check_figure(path)
    try:
        write_figure(figure, path)
    except ValueError as error:  # mathtext that does not parse
        found = " ".join(str(error).split())[:120]
        raise InputError("symbols", found, "symbols in mathtext, such as λ_{21}^A") from None
