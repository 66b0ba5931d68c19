"""A report about a motion: one HTML file that needs no other, to be sent or printed.

Text from a mechanism's file is escaped, titles and names included. Figures are inline SVG.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from html import escape
from importlib import resources
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING

import numpy as np

from parakin.analysis.indeterminacy import indeterminacy
from parakin.analysis.mobility import mobility
from parakin.analysis.singularities import Closeness, singularities
from parakin.arrays import PER_TIME
from parakin.errors import InputError
from parakin.files.writing import check_suffix, replacing
from parakin.kinematics.assembly import assembled
from parakin.model.limits import Limit
from parakin.solving.solver import Solver
from parakin.solving.stops import keeps
from parakin.version import __version__
from parakin.views.extremes import Extremes
from parakin.views.force_text import warnings
from parakin.views.reaction_text import reaction_lines
from parakin.views.report_curves import (
    coordinate_curves,
    driven_curves,
    inline_svg,
    quality_curves,
)
from parakin.views.report_forces import forces_parts
from parakin.views.report_parts import at, drawn, lines, section, table
from parakin.views.scheme.dimensioning import parameters
from parakin.views.scheme.scheme import scheme
from parakin.views.text import flag_words, mobility_lines, singularity_lines
from parakin.views.units import Unit, unit_of

if TYPE_CHECKING:
    import xarray as xr

    from parakin.motion.motion import Motion

SUFFIXES = (".html", ".htm")
_NO_LIMITS = '<p class="soft">The mechanism\'s file gives no limits for these.</p>'
_CONES = (
    '<p class="soft">A cone angle is how far a spherical or universal joint is bent: see '
    "the notes on mechanism files.</p>"
)


@dataclass(frozen=True)
class Solved:
    """A motion and its result: `picture` is thinned if the motion is long, `extremes` are of all
    samples.
    """

    solver: Solver
    motion: Motion
    picture: xr.Dataset
    extremes: Extremes


def check_report(path: Path) -> None:
    """Raises InputError if the suffix is not one of a page, or matplotlib is missing."""
    check_suffix(path, SUFFIXES, {"matplotlib": "matplotlib"}, "plot")


def write(text: str, path: Path) -> None:
    """Write a report. Raises InputError."""
    check_report(path)
    with replacing(path) as temporary:
        temporary.write_text(text, "utf-8", newline="\n")


def report(solved: Solved, command: str, made: datetime) -> str:
    """The page's HTML. command: the one that made it, as typed."""
    mechanism = solved.solver.mechanism
    template = Template((resources.files("parakin.views") / "page.html").read_text("utf-8"))
    closeness, reason = _closeness(solved)
    body = [
        section("Scheme", _scheme(solved.solver), _notes(mechanism.notes)),
        section("Dimensions", _dimensions(solved.solver)),
        section("Mobility", _mobility(solved.solver)),
        section("Motion", _motion(solved)),
        section("Actuated coordinates", *_actuated(solved)),
        section("Platform and passive joints", _passive(solved)),
        *(section("Limits on rates", rates) for rates in [_rates(solved)] if rates),
        *(section("Forces", *forces) for forces in [_forces(solved)] if forces),
        section("Conditioning and residuals", *_quality(solved, closeness, reason)),
    ]
    return template.substitute(
        version=escape(__version__),
        name=escape(mechanism.name),
        motion=escape(solved.motion.name),
        title=escape(mechanism.title or mechanism.name),
        source=escape(mechanism.source),
        verdict=_verdict(solved) + _overload(solved),
        body="\n".join(body),
        origin=_origin(solved, command, made),
    )


# ---- top and bottom


def _verdict(solved: Solved) -> str:
    flagged = flag_words(solved.extremes)
    if flagged:
        return (
            f'<div class="verdict bad" role="alert"><p>Not all of this motion is solved or within '
            f"limits.</p><p>{solved.extremes.samples:,} samples, {escape(flagged)}</p></div>"
        )
    limits = len(solved.solver.graph.limited)
    kept = f"all {limits} limits kept" if limits > 1 else "its one limit kept"
    kept = kept if limits else "the mechanism's file gives no limits"
    return (
        f'<div class="verdict">All {solved.extremes.samples:,} samples are solved, {kept}; worst '
        f"residual {solved.extremes.residual:.1e} m, least conditioning "
        f"{solved.extremes.conditioning:.3f}.</div>"
    )


def _overload(solved: Solved) -> str:
    """What is wrong with the forces; "" if nothing is."""
    forces = solved.extremes.forces
    words = [] if forces is None else list(warnings(forces, solved.solver.graph))
    said = "".join(f"<p>{escape(each)}</p>" for each in words)
    return f'<div class="verdict bad" role="alert">{said}</div>' if said else ""


def _forces(solved: Solved) -> list[str]:
    return forces_parts(solved.solver, solved.picture, solved.extremes.forces)


def _origin(solved: Solved, command: str, made: datetime) -> str:
    mechanism = solved.solver.mechanism
    how = "machine code" if solved.solver.machine_code else "NumPy"
    rows = [
        ("command", f"<code>{escape(command)}</code>"),
        ("mechanism", escape(mechanism.where)),
        ("motion", escape(solved.motion.name)),
        ("parakin", f"{escape(__version__)}, {how}"),
        ("made", escape(made.isoformat(" ", "seconds"))),
    ]
    cells = [f'<tr><td>{a}</td><td class="left wrap">{b}</td></tr>' for a, b in rows]
    return f'<table class="short"><tbody>{"".join(cells)}</tbody></table>'


# ---- the mechanism


def _scheme(solver: Solver) -> str:
    figure = scheme(solver.graph, table=False)
    label = "Kinematic scheme"
    return drawn(inline_svg(figure, "scheme", label), f"{label} at home; orange: actuated.")


def _notes(notes: str) -> str:
    return f'<p class="soft notes">{escape(notes.strip())}</p>' if notes.strip() else ""


def _dimensions(solver: Solver) -> str:
    known = parameters(solver.mechanism)
    if not known:
        return "<p>The mechanism's file names no parameters.</p>"
    rows = [(escape(p.name), escape(p.value), escape(p.as_given)) for p in known]
    half = -(-len(rows) // 2)
    pairs = [
        (*row, *(rows[half + k] if half + k < len(rows) else ("", "", "")))
        for k, row in enumerate(rows[:half])
    ]
    return table(("name", "value", "as given") * 2, pairs, "paired")


def _mobility(solver: Solver) -> str:
    graph = solver.graph
    home = assembled(graph)
    found = mobility(graph, home, len(graph.mechanism.driven))
    said = mobility_lines(graph, found)[1:]  # the section has the heading
    return lines([*said, *reaction_lines(indeterminacy(graph, home))])


# ---- the motion


def _motion(solved: Solved) -> str:
    motion, found = solved.motion, solved.extremes
    title = str(solved.solver.mechanism.motions.get(motion.name, {}).get("title", ""))
    first, last = (float(motion.window(i, i + 1).time[0]) for i in (0, max(motion.count - 1, 0)))
    angles = {c.name: c.angle for c in solved.solver.graph.coordinates}
    said = f"{motion.name}: {title}" if title else motion.name
    driven = ", ".join(motion.coordinates)
    return (
        f"<p><strong>{escape(said)}</strong></p>\n"
        f"<p>{last - first:.6g} s, {found.samples:,} samples; driven: {escape(driven)}; velocity "
        f"and acceleration: {escape(motion.derivatives)}.</p>\n"
        + drawn(
            inline_svg(driven_curves(motion, angles), "driven", "Driven coordinates over time"),
            "The prescribed motion of the driven coordinates.",
        )
    )


def _unit(solved: Solved, name: str) -> Unit:
    return unit_of(str(solved.picture["unit"].sel(coordinate=name).item()) == "rad")


def _actuated(solved: Solved) -> list[str]:
    """Table and curves of the actuated coordinates or, without actuators, of the driven ones."""
    picture = solved.picture
    names = picture["coordinate"].values[picture["actuated"].values].tolist()
    parts = []
    if not names:
        names = list(solved.motion.coordinates)
        parts.append(
            "<p>The mechanism's file names no actuators: these are the driven coordinates.</p>"
        )
    headings = ("coordinate", "least", "greatest", "stroke", "peak speed", "peak acceleration")
    rows = [(*_travel(solved, n), *_peak_cells(solved, n), *_margin(solved, n)) for n in names]
    parts.append(table((*headings, "limits", "margin", "kept"), rows) + _unlimited(rows))
    for k, name in enumerate(names):
        limits = solved.solver.graph.limits(name)
        figure = coordinate_curves(picture, name, solved.extremes, limits)
        svg = inline_svg(figure, f"curve{k}", f"{escape(name)} over time")
        parts.append(drawn(svg, name))
    return parts


def _passive(solved: Solved) -> str:
    picture = solved.picture
    named = picture["coordinate"].values[~picture["actuated"].values].tolist()
    names = [n for n in named if not n.endswith(".cone")]
    names += [n for n in named if n.endswith(".cone")]
    if not names:
        return "<p>None.</p>"
    rows = [(*_travel(solved, n), *_margin(solved, n)) for n in names]
    headings = ("coordinate", "least", "greatest", "stroke", "limits", "margin", "kept")
    cones = any(name.endswith(".cone") for name in names)
    return table(headings, rows) + _unlimited(rows) + _CONES * cones


def _rates(solved: Solved) -> str:
    """Table of the velocities and accelerations that have limits."""
    rows = []
    for limit in solved.solver.graph.limited:
        if limit.order:
            k = list(solved.extremes.coordinates).index(limit.coordinate)
            unit, per = _unit(solved, limit.coordinate), PER_TIME[limit.order]
            ends = (solved.extremes.low[limit.order, k], solved.extremes.high[limit.order, k])
            cells = [unit.typeset(float(end), per=per) if np.isfinite(end) else "" for end in ends]
            margin = _margin(solved, limit.coordinate, limit.order)
            rows.append((escape(limit.name), *cells, *margin))
    return table(("rate", "least", "greatest", "limits", "margin", "kept"), rows) if rows else ""


def _unlimited(rows: Sequence[Sequence[str]]) -> str:
    return "" if any(row[-2] for row in rows) else _NO_LIMITS


def _travel(solved: Solved, name: str) -> tuple[str, str, str, str]:
    """Cells: a coordinate's name, its extremes with their times, and its stroke."""
    found, k = solved.extremes, list(solved.extremes.coordinates).index(name)
    unit = _unit(solved, name)
    low, high = float(found.low[0, k]), float(found.high[0, k])
    if not np.isfinite(low):
        return escape(name), "nothing solved", "", ""
    return (
        escape(name),
        at(unit.typeset(low), float(found.low_time[0, k])),
        at(unit.typeset(high), float(found.high_time[0, k])),
        unit.typeset(high - low),
    )


def _peak_cells(solved: Solved, name: str) -> tuple[str, str]:
    found, k = solved.extremes, list(solved.extremes.coordinates).index(name)
    unit = _unit(solved, name)
    cells = []
    for order in (1, 2):
        value, time = found.peak(order, k)
        text = unit.typeset(value, per=PER_TIME[order])
        cells.append(at(text, time) if np.isfinite(value) else "")
    return cells[0], cells[1]


def _margin(solved: Solved, name: str, order: int = 0) -> tuple[str, str, str]:
    """Cells: the limits of a coordinate or a derivative of it, how far it stays from the nearer
    one, and the verdict.
    """
    graph = solved.solver.graph
    low, high = graph.limits(name, order)
    if not np.isfinite([low, high]).any():
        return "", "", ""
    k = list(solved.extremes.coordinates).index(name)
    unit = _unit(solved, name)
    ends = [f"{unit.per_si * limit:.6g}" if np.isfinite(limit) else "none" for limit in (low, high)]
    shown = f"{ends[0]} .. {ends[1]}{unit.symbol}{PER_TIME[order]}"
    reached = (float(solved.extremes.low[order, k]), float(solved.extremes.high[order, k]))
    if not np.isfinite(reached[0]):
        return shown, "", ""
    margin = min(reached[0] - low, high - reached[1])
    kept = all(keeps(graph, Limit(name, order, low, high), value) for value in reached)
    word = '<span class="good">ok</span>' if kept else '<span class="bad">exceeded</span>'
    return shown, unit.typeset(margin, per=PER_TIME[order]), word


# ---- quality of the solution


def _closeness(solved: Solved) -> tuple[Closeness | None, str]:
    """How close the motion comes to singularities, or why that is not known."""
    whole = solved.picture.sizes["time"] == solved.motion.count
    try:
        motion = solved.motion if whole else None
        return singularities(solved.solver, solved.picture, motion), ""
    except InputError as error:
        return None, f"Types of singularity are not distinguished: {error}"


def _quality(solved: Solved, closeness: Closeness | None, reason: str) -> list[str]:
    figure = quality_curves(solved.picture, closeness)
    label = "Conditioning, closeness to singularities and residual over time"
    parts = [drawn(inline_svg(figure, "quality", label), f"{label}.")]
    parts.append(
        f"<p>Worst residual {solved.extremes.residual:.1e} m, least conditioning "
        f"{solved.extremes.conditioning:.3f}.</p>"
    )
    if closeness is None:
        parts.append(f'<p class="soft">{escape(reason)}</p>')
    else:
        parts.append(lines(singularity_lines(closeness)))
    if solved.picture.sizes["time"] < solved.motion.count:
        parts.append(
            f'<p class="soft">Curves and closeness show every '
            f"{-(-solved.motion.count // solved.picture.sizes['time'])}th sample; extremes, "
            "residuals and flags cover all.</p>"
        )
    return parts
