"""How far, how fast and how hard, as tables for a terminal and as a flat one for a file."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from parakin.arrays import PER_TIME
from parakin.views.units import Unit, unit_of

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from parakin.arrays import FloatArray

_MOST = (("velocity", "m/s", "/s"), ("acceleration", "m/s²", "/s²"), ("load", "N", ""))


def range_report(found: xr.Dataset) -> RenderableType:
    """What `parakin range` prints."""
    heading = Text(f"{found.attrs['mechanism']}, {_pose_words(found)}", style="bold")
    if found.attrs["stopped"]:
        return Group(heading, Text(stopped_words(found), style="bold red"))
    lines: list[RenderableType] = [heading, _how_far(found)]
    if _known(found, "max_velocity"):
        lines += [Text(), _how_much(found, ("velocity",))]
    others = tuple(name for name in ("acceleration", "load") if _known(found, f"max_{name}"))
    if others:
        lines += [Text(), _how_much(found, others)]
    if "boundary" in found:
        lines += [Text(), *pair_lines(found)]
    return Group(*lines)


def stopped_words(found: xr.Dataset) -> str:
    """Why there is nothing to count from; "" if there is."""
    stopped, reached = found.attrs["stopped"], found.attrs["reached"]
    if not stopped:
        return ""
    if not reached:
        return f"no range from there: {stopped}"
    return f"no range from there: {100.0 * reached:.4g} % of the way {stopped} stops it"


def _units(found: xr.Dataset) -> list[Unit]:
    return [unit_of(unit == "rad") for unit in found["unit"].values]


def _pose_words(found: xr.Dataset) -> str:
    """Where it is counted from."""
    each = zip(found["driven"].values, found["pose"].values, _units(found), strict=True)
    return "from " + ", ".join(f"{name} = {unit.plain(value, '.3f')}" for name, value, unit in each)


def _table(*headings: str) -> Table:
    """Columns of numbers, but for those of words, whose headings begin with "by" or "stops"."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for k, heading in enumerate(headings):
        words = k == 0 or heading in _WORDS
        table.add_column(Text(heading), justify="left" if words else "right", no_wrap=True)
    return table


_WORDS = ("stopped by", "limited by")


def _how_far(found: xr.Dataset) -> Table:
    headings = ["coordinate", "down", "stopped by", "up", "stopped by"]
    sines = "amplitude" in found
    if sines:
        headings += [f"sine at {found['amplitude'].attrs['frequency']:g} Hz", "limited by"]
    table = _table(*headings)
    for i, (name, unit) in enumerate(zip(found["driven"].values, _units(found), strict=True)):
        row = [Text(f"{name} [{unit.name}]")]
        for side in (0, 1):
            row.append(Text(_number(unit.per_si * float(found["travel"].values[i, side]), "+z.3f")))
            row.append(Text(str(found["stopped_by"].values[i, side]) or "nothing"))
        if sines:
            row.append(Text(_number(unit.per_si * float(found["amplitude"].values[i]), "z.3f")))
            row.append(Text(str(found["amplitude_limited_by"].values[i]) or "nothing"))
        table.add_row(*row)
    return table


def _number(value: float, form: str) -> str:
    if np.isinf(value):
        return "free"
    return "" if np.isnan(value) else f"{value:{form}}"


def _known(found: xr.Dataset, name: str) -> bool:
    return bool(np.isfinite(found[name].values).any())


def _how_much(found: xr.Dataset, names: tuple[str, ...]) -> Table:
    """The most at the pose, down and up, each with what limits it."""
    titles = {"velocity": "velocity", "acceleration": "acceleration", "load": "force or moment"}
    headings = ["at this pose"]
    for name in names:
        headings += [f"{titles[name]} down", "limited by", "up", "limited by"]
    table = _table(*headings)
    for i, (driven, angle) in enumerate(
        zip(found["driven"].values, found["unit"].values == "rad", strict=True)
    ):
        row = [Text(str(driven))]
        for name in names:
            for side in (0, 1):
                value = float(found[f"max_{name}"].values[i, side])
                row.append(Text(_most(name, value, angle=bool(angle))))
                row.append(Text(str(found[f"{name}_limited_by"].values[i, side])))
        table.add_row(*row)
    return table


def _most(name: str, value: float, *, angle: bool) -> str:
    """A velocity, acceleration or load with its unit."""
    if not np.isfinite(value):
        return "free" if np.isinf(value) else ""
    if name == "load":
        return f"{value:+z.1f} {'N m' if angle else 'N'}"
    per = PER_TIME[("velocity", "acceleration").index(name) + 1]
    return f"{np.degrees(value):+z.1f} deg{per}" if angle else f"{value:+z.3f} m{per}"


def pair_lines(found: xr.Dataset) -> list[Text]:
    """What bounds each pair of coordinates, the most frequent first, with its share of the rays."""
    lines = [Text("in pairs", style="bold")]
    for first, second, words in zip(
        found["first"].values,
        found["second"].values,
        found["boundary_stopped_by"].values,
        strict=True,
    ):
        counts = Counter(str(each) or "nothing" for each in words)
        told = ", ".join(
            f"{what} ({round(100 * n / len(words))} %)" for what, n in counts.most_common()
        )
        lines.append(Text(f"{first}, {second}: {told}"))
    return lines


def frame(found: xr.Dataset) -> pd.DataFrame:
    """A flat table, SI: a row for each coordinate and end and, where pairs were asked for, for each
    ray of a pair.
    """
    import pandas as pd

    rows = []
    for i, name in enumerate(found["driven"].values):
        for side, end in enumerate(found["end"].values):
            row = {"coordinate": name, "unit": found["unit"].values[i], "end": end}
            row |= {"pose": found["pose"].values[i]}
            columns = [key for key in found.data_vars if found[key].dims == ("driven", "end")]
            row |= {str(key): found[key].values[i, side] for key in columns}
            columns = [key for key in found.data_vars if found[key].dims == ("driven",)]
            row |= {str(key): found[key].values[i] for key in columns}
            rows.append(row)
    if "boundary" in found:
        rows += _boundary_rows(found)
    return pd.DataFrame(rows)


def _boundary_rows(found: xr.Dataset) -> list[dict[str, object]]:
    rows = []
    for pair in np.arange(found.sizes["pair"]).tolist():
        names = [str(found[key].values[pair]) for key in ("first", "second")]
        boundary: FloatArray = found["boundary"].values[pair]
        for (x, y), words in zip(boundary, found["boundary_stopped_by"].values[pair], strict=True):
            row: dict[str, object] = {"coordinate": names[0], "travel": x, "stopped_by": words}
            rows.append(row | {"with": names[1], "with_travel": y})
    return rows
