"""The forces of a report: masses, tables of efforts, drives and reactions, and curves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape
from typing import TYPE_CHECKING

import numpy as np
from rich.text import Text

from parakin.model.graph import Graph
from parakin.solving.solver import Solver
from parakin.views.force_extremes import ForceExtremes, motor_of, uses
from parakin.views.force_text import (
    drive_rows,
    figure,
    limit_rows,
    reaction_rows,
    warnings,
    work_words,
)
from parakin.views.report_curves import force_curves, inline_svg
from parakin.views.report_parts import at, drawn, lines, table

if TYPE_CHECKING:
    import xarray as xr


def forces_parts(solver: Solver, picture: xr.Dataset, found: ForceExtremes | None) -> list[str]:
    """The parts of the section; none of a mechanism without dynamics."""
    graph = solver.graph
    if not graph.dynamics.any:
        return []
    parts = [*_masses(graph)]
    if found is None:
        reason = solver.no_forces or "they were not asked for"
        return [f'<p class="soft">There are no efforts: {escape(reason)}</p>', *parts]
    words = [Text(line, style="bold red") for line in warnings(found, graph)]
    words += [Text(line[0].upper() + line[1:] + ".") for line in work_words(found)]
    parts += [lines(words), _efforts(found), *_drives(found, graph)]
    for k, name in enumerate(found.actuators):
        motor = motor_of(graph, name)
        label = f"Effort and power of {name}"
        if motor is not None:
            label = f"Effort and power of {name}, and its motor's torque over its speed"
        svg = inline_svg(force_curves(picture, name, found, motor), f"force{k}", escape(label))
        parts.append(drawn(svg, f"{label}."))
    if found.reactions is not None:
        headings = ("reaction in joint", "largest force [N]", "largest moment [N m]")
        parts.append(table(headings, _escaped(reaction_rows(found.reactions))))
        if not (found.reactions.force_known.all() and found.reactions.moment_known.all()):
            parts.append(
                '<p class="soft">Components are along the joint\'s axes on its parent; for rigid '
                "bodies those that are indeterminate may be anything.</p>"
            )
    return parts


def _masses(graph: Graph) -> Iterator[str]:
    """Table of what has a mass."""
    dynamics = graph.dynamics
    found = [(graph.bodies[body], mass) for body, mass in sorted(dynamics.masses.items())]
    found += [(f"{load.name} on {graph.bodies[load.body]}", load.mass) for load in dynamics.loads]
    if found:
        rows = [
            (
                escape(name),
                f"{mass.mass:,.6g}",
                ", ".join(f"{1e3 * x:z,.5g}" for x in mass.com),
            )
            for name, mass in found
        ]
        total = sum(mass.mass for _, mass in found)
        rows.append(("<strong>total</strong>", f"<strong>{total:,.6g}</strong>", ""))
        yield table(("body", "mass [kg]", "centre of mass, on the body [mm]"), rows)


def _efforts(found: ForceExtremes) -> str:
    rows = []
    power = found.ranges["power"]
    for k, (name, unit) in enumerate(zip(found.actuators, found.units, strict=True)):
        peak, time = found.peak("effort", k)
        cells = [
            at(f"{figure(float(value))} W", float(when)) if np.isfinite(value) else ""
            for value, when in (
                (power.low[k], power.low_time[k]),
                (power.high[k], power.high_time[k]),
            )
        ]
        shown = at(f"{figure(peak)} {unit}", time) if np.isfinite(peak) else "nothing solved"
        rms = found.rms("effort", k)
        rows.append(
            (escape(name), shown, f"{figure(rms)} {unit}" if np.isfinite(rms) else "", *cells)
        )
    return table(("actuator", "peak effort", "RMS effort", "least power", "greatest power"), rows)


def _drives(found: ForceExtremes, graph: Graph) -> Iterator[str]:
    """Tables of motors, and of how much of each limit is used."""
    rows = _escaped(drive_rows(found, graph))
    if rows:
        yield table(("motor", "peak torque", "RMS torque", "peak speed", "peak current"), rows)
    limits = []
    for use, cells in zip(uses(found, graph), limit_rows(found, graph), strict=True):
        name, peak, limit, part = map(escape, cells)
        tone, word = ("bad", "exceeded") if use.part > 1.0 else ("good", "ok")
        kept = f'<span class="{tone}">{word}</span>'
        limits.append((name, at(peak, use.time), limit, part, kept))
    if limits:
        yield table(("limit of a drive", "peak", "limit", "used", "kept"), limits)


def _escaped(rows: Sequence[Sequence[str]]) -> list[tuple[str, ...]]:
    return [tuple(map(escape, row)) for row in rows]
