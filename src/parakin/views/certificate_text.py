"""What is proved of a box of poses, as lines for a terminal and as a flat table for a file."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from parakin.views.units import unit_of

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from parakin.arrays import FloatArray

_STYLES = {"proved": "bold green", "refuted": "bold red", "undecided": "bold yellow"}


def certificate_report(found: xr.Dataset) -> RenderableType:
    """What `parakin certify` prints."""
    lines: list[RenderableType] = [
        Text(f"{found.attrs['mechanism']}, {_box_words(found)}", style="bold"),
        Text(outcome_words(found), style=_STYLES[found.attrs["outcome"]]),
    ]
    if found.attrs["outcome"] == "proved" and found.sizes["coordinate"]:
        lines.append(_enclosures(found))
    return Group(*lines)


def outcome_words(found: xr.Dataset) -> str:
    """The outcome, and what speaks against it."""
    outcome, reason = found.attrs["outcome"], found.attrs["reason"]
    if outcome == "proved":
        return f"proved: every pose of it keeps all that is asked ({_parts(found)})"
    where = _at(found, found["where"].values)
    if outcome == "refuted":
        return f"refuted: {reason} at {where}"
    share = np.floor(1e4 * float(found["proved"])) / 100.0  # what is not all is not rounded to it
    known = f"{share:.2f} % of it is proved ({_parts(found)})"
    return f"undecided: {known}; {reason} is not excluded near {where}"


def _parts(found: xr.Dataset) -> str:
    count = int(found["boxes"])
    return f"{count:,} part{'s' * (count != 1)}"


def _at(found: xr.Dataset, values: FloatArray) -> str:
    """Driven values by name."""
    each = zip(found["driven"].values, values.tolist(), found["driven_unit"].values, strict=True)
    return ", ".join(
        f"{name} = {unit_of(unit == 'rad').plain(value, '.3f')}" for name, value, unit in each
    )


def _box_words(found: xr.Dataset) -> str:
    """Each driven coordinate from one end to the other, or where it stays."""
    each = []
    for name, unit, low, high in zip(
        *(found[key].values for key in ("driven", "driven_unit", "within_low", "within_high")),
        strict=True,
    ):
        shown = unit_of(unit == "rad")
        end = shown.plain(float(high), ".3f")
        start = f"{shown.per_si * float(low):z.3f}"
        each.append(f"{name} = {end}" if low == high else f"{name} = {start} to {end}")
    return ", ".join(each)


def _enclosures(found: xr.Dataset) -> Table:
    """What limited coordinates come to, rounded outwards, and their limits."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for k, heading in enumerate(("coordinate", "at least", "at most", "limit from", "to")):
        table.add_column(Text(heading), justify="right" if k else "left", no_wrap=True)
    names = ("coordinate", "unit", "low", "high", "limit_low", "limit_high")
    for name, unit, *ends in zip(*(found[key].values for key in names), strict=True):
        shown = unit_of(unit == "rad")
        low, high, least, most = (shown.per_si * float(end) for end in ends)
        numbers = [np.floor(1e3 * low) / 1e3, np.ceil(1e3 * high) / 1e3, least, most]
        cells = [f"{x:z.3f}" if np.isfinite(x) else "none" for x in numbers]
        table.add_row(Text(f"{name} [{shown.name}]"), *map(Text, cells))
    return table


def frame(found: xr.Dataset) -> pd.DataFrame:
    """A flat table, SI: a row for each limited coordinate."""
    import pandas as pd

    names = ("coordinate", "unit", "low", "high", "limit_low", "limit_high")
    return pd.DataFrame({name: found[name].values for name in names})
