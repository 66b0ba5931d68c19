"""The kinematic scheme of a mechanism at home: ISO 3952 symbols, names, frames and dimensions.

Everything is laid out on a sheet in points before anything is drawn, so that symbols, arrows and
lettering have the same size for every mechanism, and labels can avoid one another.
"""

from __future__ import annotations

import base64
import io
import textwrap
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from parakin.arrays import FloatArray
from parakin.errors import ParakinError
from parakin.files.writing import check_suffix, write_figure
from parakin.model.evaluation import graph_of
from parakin.views.scheme import symbols
from parakin.views.scheme.annotation import annotate
from parakin.views.scheme.dimensioning import parameters
from parakin.views.scheme.lettering import Label, width_of
from parakin.views.scheme.sheet import (
    DRIVEN,
    FIXED,
    INK,
    STYLE,
    WIDTH,
    Sheet,
    draw_arrow,
    draw_line,
    draw_stroke,
    outline_of,
    write,
)
from parakin.views.scheme.symbols import Stroke
from parakin.views.solids.arrangement import SLIDES
from parakin.views.solids.drawing import Drawing, Piece, drawing_of
from parakin.views.solids.shapes import Bar, Block, Plate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from parakin.model.graph import Graph
    from parakin.model.mechanism import Mechanism
from parakin.model.joints import GraphJoint

SUFFIXES = (".svg", ".pdf", ".png")
_ROW = 11.0  # of the table of parameters
_FILL = {"driven": "#f6b26b", "passive": "white"}


def scheme(graph: Graph, drawing: Drawing | None = None, *, table: bool = True) -> Figure:
    """The scheme of a mechanism, with the table of its parameters below.

    drawing: of the mechanism, if known. Raises AssemblyError.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    sheet = Sheet.of(drawing or drawing_of(graph))
    with mpl.rc_context({**STYLE}):
        rows = _table_rows(graph) if table else []
        heading = _heading(graph) if table else []
        above = sum(1.4 * size for _, size, _ in heading) + 8
        below = _ROW * len(rows) + 8 * bool(rows)
        total = sheet.height + above + below
        figure = Figure(figsize=(WIDTH / 72, total / 72))
        axes = figure.add_axes((0, 0, 1, 1))
        axes.set(xlim=(0, WIDTH), ylim=(-below, sheet.height + above))
        axes.set_axis_off()
        _skeleton(axes, sheet)
        for number in range(len(graph.joints)):
            _joint(axes, sheet, number)
        annotate(axes, sheet)
        y = sheet.height + above - 2
        for words, size, weight in heading:
            y -= 1.4 * size
            write(axes, np.array([12.0, y]), words, size, weight=weight)
        _tabulate(axes, rows)
    return figure


def check_scheme(path: Path) -> None:
    """Raises InputError where the suffix is not one for schemes, or matplotlib is missing."""
    check_suffix(path, SUFFIXES, {"matplotlib": "matplotlib"}, "plot")


def save(figure: Figure, path: Path) -> None:
    """Write a scheme. Raises InputError."""
    import matplotlib as mpl

    check_scheme(path)
    undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    with mpl.rc_context({**STYLE}):
        write_figure(figure, path, metadata=undated.get(path.suffix.lower()))


def html(mechanism: Mechanism) -> str:
    """An image of the scheme for a notebook; "" where it cannot be drawn."""
    try:
        figure = scheme(graph_of(mechanism), table=False)
    except (ImportError, ParakinError):  # no matplotlib, or it does not assemble
        return ""
    import matplotlib as mpl

    svg = io.BytesIO()
    with mpl.rc_context({**STYLE}):
        figure.savefig(svg, format="svg", metadata={"Date": None})
    data = base64.b64encode(svg.getvalue()).decode("ascii")
    style = "max-width: 100%; background: white"
    return f'<img alt="kinematic scheme" style="{style}" src="data:image/svg+xml;base64,{data}">'


# ---- bodies


def _skeleton(axes: Axes, sheet: Sheet) -> None:
    from matplotlib.patches import Polygon

    pieces = sheet.drawing.pieces
    rails = {k for k, (_, after) in enumerate(pairwise(pieces)) if isinstance(after.form, Block)}
    for k, piece in enumerate(pieces):
        if piece.joint is not None or piece.part == "cylinder":
            continue
        points = sheet.at(piece.body, outline_of(piece))
        sheet.taken.line(points, closed=isinstance(piece.form, Plate))
        base = piece.part == "base"
        if isinstance(piece.form, Plate):
            face = {"platform": "#cfe6f5", "base": "0.93"}.get(piece.part, "0.96")
            edge = FIXED if base else INK
            axes.add_patch(
                Polygon(
                    points,
                    facecolor=face,
                    edgecolor=edge,
                    linewidth=0.8 if base else 1.7,
                    zorder=0.5 if base else 1,
                    alpha=0.85,
                    joinstyle="round",
                )
            )
        elif base and k in rails:
            along = points[1] - points[0]
            way = np.array([along[1], -along[0]]) / max(float(np.linalg.norm(along)), 1e-9)
            away = points.mean(axis=0) - np.array([WIDTH, sheet.height]) / 2
            way = way if way @ away > 0 or (abs(way @ away) < 1 and way[1] < 0) else -way
            for stroke in symbols.hatched(points, way, sheet.s):
                draw_stroke(axes, stroke, INK, "none", 1.5, width=0.8)
        elif base:
            draw_line(axes, points, 0.8, FIXED, 0.6, "--")
        else:
            draw_line(axes, points, 1.9, INK, 2)
    for body, p in sheet.drawing.arrangement.graph.points.values():
        _point_line(axes, sheet, body, sheet.at(body, np.array(p, dtype=float))[0])
    for rod in sheet.drawing.rods:
        start, end = sheet.at(rod.parent, rod.start), sheet.at(rod.child, rod.end)
        points = np.concatenate([start, end])
        sheet.taken.line(points)
        draw_line(axes, points, 1.5, INK, 2)


def _point_line(axes: Axes, sheet: Sheet, body: int, at: FloatArray) -> None:
    """A thin triangle from a link to a point off its line, such as a coupler's."""
    own = [p for p in sheet.drawing.pieces if p.body == body and p.joint is None]
    if (
        body == 0
        or len(own) != 1
        or not isinstance(own[0].form, Bar)
        or len(own[0].form.points) > 2
    ):
        return
    a, b = sheet.at(body, own[0].form.points)
    off = abs(np.linalg.det(np.array([b - a, at - a]))) / max(float(np.linalg.norm(b - a)), 1e-9)
    if off > 2 * sheet.s:
        draw_line(axes, np.array([a, at, b]), 1.0, INK, 1.9)
        sheet.taken.line(np.array([a, at, b]))


# ---- joints


class _Symbol(NamedTuple):
    """A joint's symbol at a point of the sheet: filled strokes, and lines on top of them. `half`:
    the half length of a slide [pt].
    """

    at: FloatArray
    strokes: list[Stroke]
    lines: list[Stroke]
    half: float = 0.0


def _joint(axes: Axes, sheet: Sheet, number: int) -> None:
    """The symbol of a joint; its first stroke has the joint's kind and number as its id."""
    joint = sheet.drawing.arrangement.graph.joints[number]
    pieces = [p for p in sheet.drawing.pieces if p.joint == number]
    if joint.name == "platform" or not pieces:
        return
    if joint.kind == "rod":
        _rod(axes, sheet, number)
        return
    slides = joint.kind in SLIDES
    place = sheet.drawing.arrangement.world(pieces[0].body, outline_of(pieces[0])).mean(axis=0)
    child = _away(sheet.drawing, joint.child, place)
    if slides:
        symbol = _slide(axes, sheet, joint, place, [p for p in pieces if p.part == "cylinder"])
    else:
        symbol = _turn(sheet, joint, place, child)
        if 0 in (joint.parent, joint.child):
            _ground(axes, sheet, symbol.at, child if joint.parent == 0 else -child)
    name, fill = f"{joint.kind}-{number}", _FILL["driven" if joint.actuated else "passive"]
    order = (2.6 if slides else 3.2) + 0.2 * _depth(sheet, place)  # what turns lies on what slides
    for k, stroke in enumerate(symbol.strokes):
        draw_stroke(axes, stroke, INK, fill, order + 1e-3 * k, "" if k else name)
        sheet.taken.line(stroke.points)
    for stroke in symbol.lines:
        draw_stroke(axes, stroke, INK, fill, order + 1e-2)
        sheet.taken.line(stroke.points)
    if joint.actuated:
        _drive(axes, sheet, number, symbol)
    colour = DRIVEN if joint.actuated else INK
    sheet.labels.append(Label(joint.name, symbol.at, 1.6 * sheet.s, colour, weight="bold"))


def _turn(sheet: Sheet, joint: GraphJoint, place: FloatArray, child: FloatArray) -> _Symbol:
    """The symbol of a joint that does not slide along its axis; child: towards that body."""
    sight, s, at = sheet.sight, sheet.s, sheet.flat(place)[0]
    axis = sheet.drawing.arrangement.axis(joint)
    if joint.kind == "revolute":
        strokes = symbols.sleeve(sight, at, axis, 1.25 * s, 0.85 * s)
        return _Symbol(at, strokes, symbols.axis_line(sight, at, axis, 2.6 * s))
    if joint.kind == "universal":
        R = sheet.drawing.arrangement.poses[joint.child][0]
        second = R @ np.array(joint.M.R, dtype=float)[:, 2]
        return _Symbol(at, symbols.cross(sight, at, (axis, second), child, s), [])
    if joint.kind == "spherical":
        return _Symbol(at, symbols.ball(at, sight.flat(child), s), [])
    return _Symbol(at, symbols.plates(sight, at, axis, s), [])


def _slide(
    axes: Axes, sheet: Sheet, joint: GraphJoint, place: FloatArray, tubes: Sequence[Piece]
) -> _Symbol:
    """The symbol of a joint that slides along its axis, as long as its tube if it has one."""
    sight, s, at = sheet.sight, sheet.s, sheet.flat(place)[0]
    axis = sheet.drawing.arrangement.axis(joint)
    half, r = 1.9 * s, 1.05 * s
    if tubes:
        ends = sheet.at(tubes[0].body, outline_of(tubes[0]))
        draw_line(axes, ends, 1.9, INK, 2)
        half = _half_length(sheet, tubes[0])
        gap = min(2.4 * s / (2 * half), 0.4)  # so that the joint at its end can be seen
        at, half = ends.mean(axis=0) + gap / 2 * (ends[1] - ends[0]), half * (1 - gap)
        r = 0.65 * s
    turns = joint.kind != "prismatic"
    sleeve = symbols.sleeve if turns or tubes else symbols.box
    lines: list[Stroke] = []
    if joint.kind == "helical":
        lines = symbols.thread(sight, at, axis, min(half, 1.5 * s), r)
    elif turns:
        lines = symbols.axis_line(sight, at, axis, half + 1.5 * s)
        lines += symbols.sleeve(sight, at, axis, 0.35 * s, 1.35 * r)
    return _Symbol(at, sleeve(sight, at, axis, half, r), lines, half)


def _ground(axes: Axes, sheet: Sheet, at: FloatArray, away: FloatArray) -> None:
    """The fixed link at a joint, below it unless the mechanism is there; away: towards it."""
    way = sheet.sight.flat(away)
    down = np.array([0.0, 1.0 if way[1] < -0.35 * np.linalg.norm(way) else -1.0])
    bracket, hatching = symbols.ground(at, down, sheet.s)
    for stroke in (*bracket, *hatching):
        draw_stroke(axes, stroke, INK, "white", 2.5, width=0.8)
        sheet.taken.line(stroke.points)


def _rod(axes: Axes, sheet: Sheet, number: int) -> None:
    (rod,) = (r for r in sheet.drawing.rods if r.joint == number)
    start, end = sheet.at(rod.parent, rod.start)[0], sheet.at(rod.child, rod.end)[0]
    name, r = f"rod-{number}", 0.75 * sheet.s
    for k, (at, way) in enumerate(((start, end - start), (end, start - end))):
        for j, stroke in enumerate(symbols.ball(at, way, r)):
            draw_stroke(axes, stroke, INK, "white", 3.2, "" if j or k else name, 0.9)
            sheet.taken.line(stroke.points)
    text = sheet.drawing.arrangement.graph.joints[number].name
    sheet.labels.append(Label(text, (start + end) / 2, 4.0, INK))


def _away(drawing: Drawing, body: int, place: FloatArray) -> FloatArray:
    """The vector from a joint's place to the middle of a body."""
    own = [drawing.arrangement.world(body, outline_of(p)) for p in drawing.pieces if p.body == body]
    own += [
        drawing.arrangement.world(body, r.end if r.child == body else r.start)
        for r in drawing.rods
        if body in (r.parent, r.child)
    ]
    return np.asarray(np.concatenate(own).mean(axis=0) - place) if own else np.zeros(3)


def _half_length(sheet: Sheet, tube: Piece) -> float:
    ends = outline_of(tube)
    return float(sheet.scale * np.linalg.norm(ends[-1] - ends[0]) / 2)


def _depth(sheet: Sheet, place: FloatArray) -> float:
    """From -1, far, to 1, near."""
    view = sheet.drawing.view
    return float(np.clip((place - view.middle) @ sheet.sight.eye / max(view.span, 1e-12), -1, 1))


def _drive(axes: Axes, sheet: Sheet, number: int, symbol: _Symbol) -> None:
    """The arrow of a driven joint: straight along a slide, curved about a hinge."""
    joint, s, at = sheet.drawing.arrangement.graph.joints[number], sheet.s, symbol.at
    axis = sheet.drawing.arrangement.axis(joint)
    if joint.kind in SLIDES:
        along = sheet.sight.flat(axis)
        size = float(np.linalg.norm(along))
        if size < 0.25:
            return
        u = along / size
        n = np.array([-u[1], u[0]])
        reach = max(2.2 * s, 0.5 * symbol.half) * size
        points = at + 2.0 * s * n + np.linspace(-reach, reach, 7)[:, None] * u
    else:
        points = symbols.ring(sheet.sight, at, axis, 2.3 * s)
    draw_arrow(axes, points, DRIVEN, "<|-|>" if joint.kind in SLIDES else "-|>", 1.1, 3.6)
    sheet.taken.line(points)


def _heading(graph: Graph) -> list[tuple[str, float, str]]:
    mechanism = graph.mechanism
    title = textwrap.wrap(mechanism.title or mechanism.name, 70)
    lines = [(line, 10.5, "bold") for line in title]
    lines += [(line, 7.0, "normal") for line in textwrap.wrap(mechanism.source, 130)]
    return lines


def _table_rows(graph: Graph) -> list[list[tuple[str, str]]]:
    cells = [(p.name, p.value) for p in parameters(graph.mechanism)]
    actuated = [c.name for c in graph.coordinates if c.actuated]
    if actuated:
        cells.append(("actuated", ", ".join(actuated)))
    widest = max(
        (width_of(f"{a} = {b}", 7.5) for a, b in cells[: len(cells) - bool(actuated)]),
        default=100.0,
    )
    columns = max(1, int((WIDTH - 24) // (widest + 14)))
    short = cells[:-1] if actuated else cells
    rows = [short[k : k + columns] for k in range(0, len(short), columns)]
    return rows + ([[cells[-1]]] if actuated else [])


def _tabulate(axes: Axes, rows: Sequence[Sequence[tuple[str, str]]]) -> None:
    columns = max((len(row) for row in rows), default=1)
    if rows:
        draw_line(axes, np.array([[12.0, 0.0], [WIDTH - 12, 0.0]]), 0.4, FIXED)
    for k, row in enumerate(rows):
        for j, (name, value) in enumerate(row):
            at = np.array([12 + j * (WIDTH - 24) / columns, -_ROW * (k + 1) - 1])
            driven = name == "actuated"
            text = f"{name}: {value}" if driven else f"{name} = {value}"
            write(axes, at, text, 7.5, colour=DRIVEN if driven else INK)
