"""A workspace as lines for a terminal and as a flat table for a file."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from parakin.design.probing import EDGE_WORDS
from parakin.views.units import unit_of
from parakin.views.workspace_shares import percent, shares
from parakin.views.workspace_units import are_mixed, size_unit, units_of

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

_SEVERAL = {"reachable": "in any of:", "dexterous": "in all of:"}
_DIGITS = 9  # after the point; what needs more is written with a power of ten


def workspace_report(found: xr.Dataset) -> RenderableType:
    """What `parakin workspace` prints."""
    kind = found.attrs["kind"].replace("constant-orientation", "constant orientation")
    what = f"{found.attrs['mechanism']}, workspace ({kind}) over {', '.join(found['over'].values)}"
    heading = [Text(what, style="bold"), Text(_pose_words(found))]
    if found.attrs["kind"] in _SEVERAL:
        heading.append(Text(_orientation_words(found)))
    if found.attrs["stopped"]:
        return Group(*heading, Text(stopped_words(found), style="bold red"))
    known = shares(found)
    lines: list[RenderableType] = [
        *heading,
        Text(size_words(found)),
        _extent(found),
        *_room(found),
        Text("limited by: " + ", ".join(f"{w} ({percent(s)})" for w, s in known.items())),
        Text(
            _parts("islands, which are not connected to the pose", found["islands"].values, found)
        ),
        Text(_parts("holes", found["holes"].values, found)),
    ]
    if EDGE_WORDS in known:
        lines.append(Text("it goes on beyond what was looked at", style="bold yellow"))
    return Group(*lines)


def stopped_words(found: xr.Dataset) -> str:
    """Why there is nothing to count from; "" if there is."""
    stopped = found.attrs["stopped"]
    return f"no workspace from there: {stopped}" if stopped else ""


def size_words(found: xr.Dataset) -> str:
    """Its area or volume: "volume 0.0795 ± 0.0003 m³"."""
    return f"{_measure(found)} {_with_doubt(found)}"


def _box(found: xr.Dataset) -> str:
    """What the box is called that fits."""
    alike = not are_mixed(found) and np.ptp(found["half_width"].values) == 0.0
    named = ("square", "cube") if alike else ("rectangle", "box")
    return named[found.sizes["over"] - 2]


def _forms(found: xr.Dataset) -> list[str]:
    """How numbers are written of each coordinate moved: so that they tell a tenth of the longest
    step of the grid in its unit; extents and what fits are no surer.
    """
    units = units_of(found)
    steps = [
        unit.per_si * np.diff(found[name].values[:2]).item()
        for name, unit in zip(found["over"].values, units, strict=True)
    ]
    longest = {
        unit: max(s for s, of in zip(steps, units, strict=True) if of == unit) for unit in units
    }
    return [f".{max(0, 1 - int(np.floor(np.log10(longest[unit]))))}f" for unit in units]


def _room(found: xr.Dataset) -> list[Text]:
    """What fits about the pose; no circle or ball where slides and angles are mixed."""
    round_, flat = "circle" if found.sizes["over"] == 2 else "ball", _box(found)
    units, forms = units_of(found), _forms(found)
    each = zip(found["half_width"].values, units, forms, strict=True)
    halves = [f"±{unit.per_si * value:{form}}" for value, unit, form in each]
    if are_mixed(found):
        half = " x ".join(f"{one} {unit.name}" for one, unit in zip(halves, units, strict=True))
        return [Text(f"largest {flat} about the pose: {half}")]
    radius = units[0].plain(float(found["radius"]), forms[0])
    tilt = float(found["tilt"])
    cone = (
        []
        if np.isnan(tilt)
        else [Text(f"largest tilt in every direction: {units[0].plain(tilt, forms[0])}")]
    )
    return [
        Text(f"largest {round_} about the pose: radius {radius}"),
        Text(f"largest {flat} about the pose: {' x '.join(halves)} {units[0].name}"),
        *cone,
    ]


def _measure(found: xr.Dataset) -> str:
    if are_mixed(found):
        return "size"
    return "area" if found.sizes["over"] == 2 else "volume"


def _pose_words(found: xr.Dataset) -> str:
    """Where it is counted from."""
    units = [unit_of(unit == "rad") for unit in found["driven_unit"].values]
    each = zip(found["driven"].values, found["pose"].values, units, strict=True)
    return "from " + ", ".join(f"{name} = {unit.plain(value, '.3f')}" for name, value, unit in each)


def _orientation_words(found: xr.Dataset) -> str:
    """The angles of all orientations."""
    units = [unit_of(unit == "rad") for unit in found["driven_unit"].values]
    each = []
    for angles in found["poses"].values:
        row = zip(found["driven"].values, angles, units, strict=True)
        named = [f"{name} = {unit.plain(x, '.3f')}" for name, x, unit in row if unit.name != "mm"]
        each.append(", ".join(named))
    return f"{_SEVERAL[found.attrs['kind']]} {'; '.join(each)}"


def _with_doubt(found: xr.Dataset) -> str:
    """The size with its uncertainty, in as many digits as this has two."""
    per, unit = size_unit(found)
    size, doubt = per * float(found["size"]), per * float(found["size_uncertainty"])
    digits = max(0, 1 - int(np.floor(np.log10(doubt)))) if doubt > 0.0 else 9
    if digits > _DIGITS:
        return f"{size:.6g} ± {doubt:.1g} {unit}"
    return f"{size:.{digits}f} ± {doubt:.{digits}f} {unit}"


def _parts(what: str, sizes: np.ndarray, found: xr.Dataset) -> str:
    """How many of something there are, and their sizes."""
    if not len(sizes):
        return f"{what}: none"
    per, unit = size_unit(found)
    each = [f"{per * size:.4g}" for size in sizes[:6].tolist()]
    return f"{what}: {len(sizes)}, of {', '.join(each)}{', ...' * (len(sizes) > 6)} {unit}"


def _extent(found: xr.Dataset) -> Table:
    table = Table(box=None, pad_edge=False, header_style="bold")
    for k, heading in enumerate(("coordinate", "from", "to")):
        table.add_column(Text(heading), justify="right" if k else "left", no_wrap=True)
    rows = zip(found["over"].values, found["extent"].values, strict=True)
    for (name, ends), unit, form in zip(rows, units_of(found), _forms(found), strict=True):
        numbers = [Text(f"{unit.per_si * end:+z{form}}") for end in ends.tolist()]
        table.add_row(Text(f"{name} [{unit.name}]"), *numbers)
    return table


def frame(found: xr.Dataset) -> pd.DataFrame:
    """A flat table, SI: a row for each node of the grid."""
    import pandas as pd

    names = found["over"].values.tolist()
    axes = np.meshgrid(*(found[name].values for name in names), indexing="ij")
    columns = {name: axis.ravel() for name, axis in zip(names, axes, strict=True)}
    for name in ("inside", "connected", "conditioning", "stroke_left", "effort"):
        columns[name] = found[name].values.ravel()
    columns["stopped_by"] = found["stop"].values[found["stopped_by"].values.ravel()]
    return pd.DataFrame(columns)
