"""Forces in words and tables, for a terminal; a page uses the same words."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from parakin.arrays import BoolArray
from parakin.model.graph import Graph
from parakin.views.force_extremes import RPM, ForceExtremes, Reactions, motor_of, uses
from parakin.views.ranges import Range

if TYPE_CHECKING:
    import xarray as xr

NEAR = 0.01  # how firmly actuators hold, home being 1: below, efforts grow without bound
_NOTHING = 1e-9  # below it is rounding


def figure(value: float) -> str:
    """A number to four digits, without an exponent where that is short."""
    if not math.isfinite(value):
        return ""
    size = abs(value)
    if size < _NOTHING:
        return "0"
    if not 1e-4 <= size < 1e9:
        return f"{value:.3e}"
    return f"{value:,.{max(0, 3 - math.floor(math.log10(size)))}f}"


def forces_report(found: ForceExtremes, graph: Graph) -> RenderableType:
    """What `parakin solve --forces` adds: efforts and power, drives, reactions, and warnings."""
    headings: tuple[str, ...]
    headings = ("effort of the actuators", "peak", "RMS", "power taken .. given [W]")
    tables = [_table(headings, effort_rows(found))]
    rows = drive_rows(found, graph)
    if rows:
        headings = ("motor", "peak torque", "RMS torque", "peak speed", "peak current")
        tables.append(_table(headings, rows))
    rows = limit_rows(found, graph)
    if rows:
        tables.append(_table(("limit of a drive", "peak", "limit", "used"), rows))
    if found.reactions is not None and found.unknown < found.solved:
        headings = ("reaction", "largest force [N]", "largest moment [N m]")
        tables.append(_table(headings, reaction_rows(found.reactions)))
    parts: list[RenderableType] = [part for table in tables for part in (Text(), table)]
    parts += [Text(line) for line in work_words(found)]
    parts += [Text(line, style="bold red") for line in warnings(found, graph)]
    return Group(*parts)


def effort_rows(found: ForceExtremes) -> list[tuple[str, ...]]:
    """Cells of each actuator: its name, peak and RMS effort, and power."""
    power = found.ranges["power"]
    return [
        (
            f"{name} [{unit}]",
            figure(found.peak("effort", k)[0]),
            figure(found.rms("effort", k)),
            " .. ".join(figure(float(end[k])) for end in (power.low, power.high)),
        )
        for k, (name, unit) in enumerate(zip(found.actuators, found.units, strict=True))
    ]


def limit_rows(found: ForceExtremes, graph: Graph) -> list[tuple[str, ...]]:
    """Cells of each limit of a drive: which, the peak, the limit and how much is used."""
    return [
        (
            f"{use.actuator}, {use.what}",
            f"{figure(use.peak)} {use.unit}",
            f"{use.limit:,.6g} {use.unit}",
            f"{100 * use.part:.0f} %",
        )
        for use in uses(found, graph)
    ]


def drive_rows(found: ForceExtremes, graph: Graph) -> list[tuple[str, ...]]:
    """Cells of each drive: its name, peak and RMS torque, peak speed and current."""
    rows: list[tuple[str, ...]] = []
    for k, name in enumerate(found.actuators):
        motor = motor_of(graph, name)
        if motor is None:
            continue
        torque, speed, scale = ("N m", "rpm", RPM) if motor.turns else ("N", "m/s", 1.0)
        values = (
            (found.peak("motor_torque", k)[0], torque),
            (found.rms("motor_torque", k), torque),
            (scale * found.peak("motor_speed", k)[0], speed),
            (found.peak("motor_current", k)[0], "A"),
        )
        cells = (f"{figure(v)} {unit}" if math.isfinite(v) else "" for v, unit in values)
        rows.append((name, *cells))
    return rows


def reaction_rows(found: Reactions) -> list[tuple[str, ...]]:
    """Cells of each joint: its name, and the largest force and moment in it."""
    return [
        (
            name,
            _largest(found.force, found.force_known[k], k),
            _largest(found.moment, found.moment_known[k], k),
        )
        for k, name in enumerate(found.joints)
    ]


def _largest(range_: Range, known: BoolArray, k: int) -> str:
    if not known.any():
        return "indeterminate"
    words = figure(float(range_.high[k]))
    if not known.all():
        open_ = ", ".join(axis for axis, here in zip("xyz", known, strict=True) if not here)
        words += f" ({open_} indeterminate)"
    return words


def work_words(found: ForceExtremes) -> Iterator[str]:
    """What the actuators do in all, and how firmly they hold at least."""
    given, taken = found.work
    if given or taken:
        back = f", and take back {figure(taken)} J" if taken else ""
        yield f"the actuators give {figure(given)} J{back}"
    if np.isfinite(found.conditioning.low[0]):
        least, at = found.least_conditioning()
        yield f"least conditioning of the actuators {least:.3f} at {at:.6g} s (home is 1)"


def drift_words(result: xr.Dataset) -> str:
    """How true a simulation is."""
    energy, loops = (
        float(np.fmax.reduce(np.abs(result[name].values), initial=0.0))
        for name in ("energy_drift", "closure_drift")
    )
    drifts = f"energy drifts by {energy:.1e} J at most, loops open by {loops:.1e} m"
    if "ended" in result.attrs:
        return f"{drifts}\nended {result.attrs['ended']}"
    return drifts


def warnings(found: ForceExtremes, graph: Graph) -> Iterator[str]:
    """Efforts that are not known, limits of drives that are exceeded, type 2 singularities near."""
    if found.unknown:
        why = "numbers overflow, or a force has no direction"
        if graph.dynamics.levers:
            why = "friction under load locks the mechanism"
        yield (
            f"efforts are not known at {found.unknown:,} of {found.solved:,} samples, first at "
            f"{found.unknown_from:.6g} s: {why}"
        )
    for use in uses(found, graph):
        if use.part > 1.0:
            yield (
                f"beyond its drive: {use.actuator} needs a{_article(use.what)} {use.what} of "
                f"{figure(use.peak)} {use.unit} at {use.time:.6g} s, limit {use.limit:,.6g} "
                f"{use.unit}"
            )
    if found.changes_sign:
        yield "efforts grow without bound: the motion crosses a type 2 singularity"
    elif found.least_conditioning()[0] < NEAR:
        yield "efforts grow without bound near a type 2 singularity"


def _article(word: str) -> str:
    return "n" if word[0] in "aeiou" else ""


def _table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    table = Table(box=None, pad_edge=False, header_style="bold")
    full = [k for k in range(len(headings)) if any(row[k] for row in rows)]
    for j, k in enumerate(full):
        table.add_column(Text(headings[k]), justify="left" if j == 0 else "right", no_wrap=True)
    for row in rows:
        table.add_row(*(Text(row[k]) for k in full))
    return table
