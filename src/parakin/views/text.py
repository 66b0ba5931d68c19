"""Tables and text for a terminal: a mechanism's mobility and home, modes, and results."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from parakin.arrays import PER_TIME, FloatArray
from parakin.solving.status import Status
from parakin.views.extremes import Extremes
from parakin.views.reaction_text import reaction_lines
from parakin.views.units import unit_of

if TYPE_CHECKING:
    from parakin.analysis.diagnosis import Diagnosis
    from parakin.analysis.mobility import Mobility
    from parakin.analysis.singularities import Closeness
    from parakin.labelled import Result
    from parakin.model.graph import Graph
    from parakin.solving.modes import Search

_CLOSES = 1e-9  # of the characteristic length: what stated values may be off


def catalogue_table(entries: Mapping[str, tuple[str, str]]) -> RenderableType:
    """Mechanisms by name with their titles and motions: what `parakin list` prints."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for heading in ("mechanism", "what it is", "motions"):
        table.add_column(Text(heading), no_wrap=heading == "mechanism")
    for name, (title, motions) in entries.items():
        table.add_row(Text(name), Text(title), Text(motions or "none"))
    return table


def _table(*headings: str) -> Table:
    """A table of numbers, for a console wide enough not to fold them."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for k, heading in enumerate(headings):
        table.add_column(Text(heading), justify="left" if k == 0 else "right", no_wrap=True)
    return table


def mechanism_report(found: Diagnosis) -> RenderableType:
    """Home and mobility of a mechanism, and warnings: what `parakin check` prints."""
    graph, home = found.graph, np.array(found.home)
    mechanism = graph.mechanism
    lines = [Text(": ".join(filter(None, (mechanism.name, mechanism.title))), style="bold")]
    if mechanism.source:
        lines.append(Text(f"source: {mechanism.source}"))
    if mechanism.notes:
        lines.append(Text(mechanism.notes.strip()))
    return Group(
        *lines,
        Text(),
        *mobility_lines(graph, found.mobility),
        *reaction_lines(found.indeterminacy),
        Text(),
        _home_table(graph, home),
        *_home_notes(graph, home),
        *([Text()] if found.warnings else []),
        *(Text(f"warning: {each}", style="bold yellow") for each in found.warnings),
    )


def mobility_lines(graph: Graph, found: Mobility) -> list[Text]:
    """The mobility and where it comes from: a heading, then one line for each finding."""
    return [
        Text("Mobility", style="bold"),
        *_counted(found),
        *_notable(found),
        *_driving(graph.mechanism.driven, found),
    ]


def _counted(found: Mobility) -> list[Text]:
    """The mobility by formula and by rank, and the loops' redundancy."""
    lines = [
        f"  Grübler-Kutzbach: {found.grubler} "
        f"({found.bodies} bodies with the base, {found.joints} joints)",
        f"  by rank: {found.home} at home, {_nearby(found)}",
    ]
    if found.cuts:
        lines.append(
            f"  {found.tree_coordinates} coordinates in the tree; cut at "
            f"{', '.join(found.cuts)}: {found.rows} closure rows, {found.rank} independent, "
            f"{found.redundant} redundant"
        )
    lines += [
        f"  the loop {', '.join(loop.joints)} has rank {loop.rank}: "
        f"{6 - loop.rank} of its six equations come for free"
        for loop in found.loops
        if 1 < loop.rank < 6
    ]
    return [Text(line) for line in lines]


def _notable(found: Mobility) -> list[Text]:
    """Idle freedoms, and what is special about the mobility."""
    lines = []
    if found.idle:
        lines.append(
            Text(
                f"  {len(found.idle)} idle: freedoms that move neither platform nor actuators; "
                f"held at home by {', '.join(found.idle)}"
            )
        )
    if found.generic == 0:
        lines.append(Text("  a structure: nothing can move", style="bold red"))
    if found.special:
        special = f"  home is special: {found.home} there, {min(found.nearby)} in general"
        lines.append(Text(special, style="bold yellow"))
    return lines


def _driving(driven: Sequence[str], found: Mobility) -> list[Text]:
    """What is driven, and whether its number is the mobility."""
    lines = [Text(f"  driven: {', '.join(driven)}")] if driven else []
    more = found.generic - len(found.idle) - found.wanted
    if found.generic < found.wanted:
        only = f"  {found.wanted} coordinates are to be driven, but only {found.generic} can move"
        lines.append(Text(only, style="bold red"))
        if found.to_blame:
            what = ("joint", "a spherical joint", "one it")
            if len(found.to_blame) > 1:
                what = ("joints", "spherical joints", "ones they")
            cause = (
                f"  cause: {what[0]} {' and '.join(found.to_blame)}: as {what[1]} instead of "
                f"universal {what[2]} would give mobility {found.mobility_if_spherical}"
            )
            lines.append(Text(cause, style="bold red"))
    elif found.wanted and more > 0:
        freedoms = "freedom" if more == 1 else "freedoms"
        words = f"  {more} more {freedoms} than driven coordinates"
        lines.append(Text(words, style="bold yellow"))
    return lines


def _nearby(found: Mobility) -> str:
    values = sorted(set(found.nearby))
    if not values:
        return "unconfirmed, as no other closed configuration was found near it"
    what = " or ".join(str(value) for value in values)
    return f"{what} at {len(found.nearby)} closed configurations around it"


def _home_table(graph: Graph, home: FloatArray) -> Table:
    table = _table("coordinate at home", "assembled", "stated or guessed", "difference")
    counted_from_home = graph.from_home
    given = {**graph.guess, **graph.stated, **graph.home}
    for k, coordinate in enumerate(graph.coordinates):
        name = coordinate.name + (" *" if coordinate.actuated else "")
        unit = unit_of(coordinate.angle)
        row = [unit.plain(float(home[k]))]
        if k in counted_from_home:
            name += " (counted from here)"
        if k in given:
            word = "held" if k in graph.home else ("stated" if k in graph.stated else "guess")
            row.append(f"{unit.plain(given[k])} {word}")
            row.append(unit.plain(float(home[k]) - given[k]))
        else:
            row += ["", ""]
        table.add_row(Text(name), *row)
    return table


def _home_notes(graph: Graph, home: FloatArray) -> list[Text]:
    notes = [Text("  * actuated", style="dim")]
    if graph.stated:
        off = {k: float(home[k]) - value for k, value in graph.stated.items()}
        size = {
            k: abs(d) * (graph.length if graph.coordinates[k].angle else 1) for k, d in off.items()
        }
        worst = max(size, key=lambda k: size[k])
        said = "  The stated values close the loops."
        if size[worst] > _CLOSES * graph.length:
            said = (
                "  The stated values do not quite close the loops: the largest difference is "
                f"{unit_of(graph.coordinates[worst].angle).plain(off[worst])} at "
                f"{graph.coordinates[worst].name}."
            )
        notes.append(Text(said))
    return notes


def modes_report(graph: Graph, driven: Sequence[str], found: Search) -> RenderableType:
    """The assembly modes of a mechanism: what `parakin modes` prints."""
    units = {c.name: unit_of(c.angle) for c in graph.coordinates}
    heading = [f"{n} [{units[n].name}]" for n in found.distinguished_by]
    headings = ("conditioning", "found", "variants", "beyond limits", "turned through")
    table = _table("mode", *heading, *headings)
    for mode in found.modes:
        values = [f"{units[n].per_si * mode.coordinates[n]:z.3f}" for n in found.distinguished_by]
        table.add_row(
            mode.name,
            *values,
            f"{mode.conditioning:.3f}",
            str(mode.found),
            str(mode.variants),
            ", ".join(mode.limits_exceeded),
            ", ".join(mode.turned_through),
        )
    return Group(
        Text(f"{graph.mechanism.name}, driven: {', '.join(driven)}", style="bold"),
        table,
        Text(found.summary),
        *(
            [Text(f"{found.singular:,} more are singular, not isolated, and left out.")]
            if found.singular
            else []
        ),
    )


def singularities_report(found: Closeness) -> RenderableType:
    """How close a motion comes to singularities: what `parakin solve --singularities` adds."""
    return Group(*singularity_lines(found))


def singularity_lines(found: Closeness) -> list[Text]:
    """The least closeness of each type, and every crossing."""
    lines = []
    for what, figure in (
        ("type 1 (actuators move, outputs rest)", found.type1),
        ("type 2 (outputs move, actuators are locked)", found.type2),
        ("all closure rows", found.whole),
    ):
        if np.isfinite(figure).any():
            i = int(np.nanargmin(figure))
            lines.append(Text(f"{what}: least {figure[i]:.3f} at {found.time[i]:.6g} s"))
    for c in found.crossings:
        what = "the end of its angles" if c.kind == "angles" else f"a {c.kind} singularity"
        verb = "ends at" if c.ends else "crosses"
        lines.append(Text(f"{verb} {what} at {c.time:.9f} s: {c.words}", style="bold red"))
    return lines


def solve_report(ds: Result, found: Extremes, seconds: float | None) -> RenderableType:
    """What `parakin solve` prints: strokes, peaks, the worst residual, flags, time and rate.

    ds: any window of the result, for names, units and home. seconds: time spent solving,
    if that is to be told.
    """
    names = ("peak speed", "peak accel.", "peak jerk")[: len(found.low) - 1]
    table = _table("actuated", "from", "to", "stroke from home", *names)
    chosen = np.flatnonzero(ds["actuated"].values).tolist() or range(ds.sizes["coordinate"])
    for k in chosen:
        unit, home = unit_of(ds["unit"].values[k] == "rad"), float(ds["home"].values[k])
        name = Text(f"{found.coordinates[k]} [{unit.name}]")
        low, high = float(found.low[0, k]), float(found.high[0, k])
        if not np.isfinite(low):
            table.add_row(name, "nothing solved", *[""] * (len(table.columns) - 2))
            continue
        peaks = [found.peak(order, k)[0] for order in range(1, len(found.low))]
        table.add_row(
            name,
            *(f"{unit.per_si * value:z.3f}" for value in (low, high)),
            " .. ".join(f"{unit.per_si * (value - home):+z.3f}" for value in (low, high)),
            *(unit.plain(peak, ".3f", per) for peak, per in zip(peaks, PER_TIME[1:], strict=False)),
        )
    took = ""
    if seconds is not None:
        rate = found.samples / seconds if seconds else math.inf
        took = f" solved in {_time(seconds)} ({_rate(rate)})"
    lines = [
        Text(
            f"{found.samples:,} samples{took}; worst residual "
            f"{found.residual:.1e} m, least conditioning {found.conditioning:.3f}"
        )
    ]
    if "spline" in ds.attrs["motion_derivatives"]:
        lines.append(Text(f"velocity and acceleration driven: {ds.attrs['motion_derivatives']}"))
    flagged = flag_words(found)
    if flagged:
        lines.append(Text(flagged, style="bold red"))
    return Group(table, *lines)


def flag_words(found: Extremes) -> str:
    """How many samples are flagged, for what reason, the first, and when each other stop is first
    met; "" if there are none.
    """
    first = found.first_flag
    if first is None:
        return ""
    each = ", ".join(
        f"{int(count):,} {Status(k).words}"
        for k, count in enumerate(found.counts)
        if count and k != Status.CONVERGED
    )
    words = f"flagged: {each}; the first at sample {first.sample}, t = {first.time:.6g} s: "
    words += first.words
    return f"{words}; in all: {found.met}" if ", " in found.met else words


def _time(seconds: float) -> str:
    return f"{seconds:.2f} s" if seconds >= 1 else f"{1e3 * seconds:.2f} ms"


def _rate(per_second: float) -> str:
    if not math.isfinite(per_second):
        return "too fast to time"
    return f"{1e9 / per_second:,.0f} ns a pose"
