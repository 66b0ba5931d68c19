"""The annotation of a scheme: frames, points, names and dimensions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from parakin.arrays import FloatArray
from parakin.views.scheme.dimensioning import Length, lengths
from parakin.views.scheme.lettering import Label, placed
from parakin.views.scheme.sheet import (
    FIXED,
    INK,
    MANY,
    MEASURE,
    PLATFORM,
    WIDTH,
    Sheet,
    draw_arrow,
    draw_line,
    outline_of,
    write,
)
from parakin.views.scheme.symbols import TURN
from parakin.views.solids.shapes import Bar

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_AXIS = 30.0  # [pt] of a frame
_SHORTEST = 16.0  # [pt]: shorter dimensions have no room for arrows


def annotate(axes: Axes, sheet: Sheet) -> None:
    """Annotate a scheme whose bodies and joints are drawn."""
    _frames(axes, sheet)
    _points(axes, sheet)
    _dimensions(axes, sheet)
    _names(sheet)
    _letter(axes, sheet)


def _frames(axes: Axes, sheet: Sheet) -> None:
    """The base's frame, and the platform's at its point unless they coincide at home."""
    drawing = sheet.drawing
    origin = sheet.flat(np.zeros(3))[0]
    if sheet.holds(origin):
        _frame(axes, sheet, np.eye(3), origin, "", FIXED, _AXIS)
    number = drawing.arrangement.graph.platform
    if number is None:
        return
    joint = drawing.arrangement.graph.joints[number]
    R, _ = drawing.arrangement.poses[joint.child]
    place = drawing.arrangement.world(joint.child, np.array(joint.M.p, dtype=float))[0]
    if np.linalg.norm(place) < 1e-6 * drawing.arrangement.size and np.allclose(R, np.eye(3)):
        return
    _frame(axes, sheet, R, sheet.flat(place)[0], "′", PLATFORM, 0.8 * _AXIS)


def _frame(
    axes: Axes,
    sheet: Sheet,
    R: FloatArray,
    origin: FloatArray,
    mark: str,
    colour: str,
    length: float,
) -> None:
    for name, axis in zip("xyz", R.T, strict=True):
        along = length * sheet.sight.flat(axis)
        size = float(np.linalg.norm(along))
        if size < 0.15 * length:  # seen end on: a dot if it points to the eye, else a cross
            circle = origin + 3.2 * np.column_stack([np.cos(TURN), np.sin(TURN)])
            draw_line(axes, circle, 0.8, colour, 4.2)
            towards = axis @ sheet.sight.eye > 0
            marker = "." if towards else "x"
            axes.plot(*origin, marker, color=colour, markersize=3.0, zorder=4.2)
            sheet.taken.line(circle)
            sheet.labels.append(Label(name + mark, origin, 5.0, colour, size=7.5, slant=True))
            continue
        draw_arrow(axes, np.array([origin, origin + along]), colour, "-|>", 0.9, 4.1, 5.5)
        sheet.taken.line(np.array([origin, origin + along]))
        tip = origin + along * (1 + 5 / size)
        sheet.labels.append(Label(name + mark, tip, 0.0, colour, size=7.5, slant=True))


def _points(axes: Axes, sheet: Sheet) -> None:
    """Named points, unless a joint has the same name."""
    graph = sheet.drawing.arrangement.graph
    joints = {joint.name for joint in graph.joints}
    for full, (body, p) in graph.points.items():
        name = full.rpartition(".")[2]
        at = sheet.at(body, np.array(p, dtype=float))[0]
        if name in joints or not sheet.holds(at):
            continue
        axes.plot(*at, "o", color=INK, markersize=2.6, zorder=4.5)
        sheet.labels.append(Label(name, at, 4.0, INK, slant=True))


def _names(sheet: Sheet) -> None:
    """The name of the platform or, if there are few bodies, of every link."""
    drawing = sheet.drawing
    number = drawing.arrangement.graph.platform
    platform = -1 if number is None else drawing.arrangement.graph.joints[number].child
    few = len(drawing.arrangement.graph.bodies) <= 8
    for body, name in enumerate(drawing.arrangement.graph.bodies):
        if body == 0 or not (few or body == platform):
            continue
        own = [p for p in drawing.pieces if p.body == body and p.joint is None]
        if own:
            spans = [np.ptp(sheet.at(body, outline_of(p)), axis=0).sum() for p in own]
            longest = own[int(np.argmax(spans))]
            points = sheet.at(body, outline_of(longest))
            bent = isinstance(longest.form, Bar) and len(points) > 2
            middle = points[len(points) // 2] if bent else points.mean(axis=0)
            sheet.labels.append(Label(name, middle, 5.0, PLATFORM, size=7.0, slant=True))


# ---- dimensions


def _dimensions(axes: Axes, sheet: Sheet) -> None:
    """A dimension line for each parameter that is a visible length, where there is most room."""
    used: set[tuple[float, ...]] = set()
    for candidates in lengths(sheet.drawing).values():
        best: tuple[float, FloatArray, FloatArray, Length, tuple[float, ...]] | None = None
        for length in candidates:
            ends = np.concatenate([sheet.flat(length.start), sheet.flat(length.end)])
            size = float(np.linalg.norm(ends[1] - ends[0]))
            key = tuple(np.round(np.sort(ends, axis=0).ravel(), 1).tolist())
            if size < _SHORTEST or key in used:
                continue
            u = (ends[1] - ends[0]) / size
            for shift in (15, -15, 23, -23, 32, -32, 44, -44):
                line = ends + shift * np.array([-u[1], u[0]])
                cost = sheet.taken.crossed(line) + 0.02 * abs(shift) - 0.01 * size
                cost += 0.0 if all(sheet.holds(end) for end in line) else 100.0
                if best is None or cost < best[0]:
                    best = (cost, ends, line, length, key)
        if best is not None:
            _, ends, line, length, key = best
            used.add(key)
            _dimension(axes, sheet, ends, line, length.name)


def _dimension(axes: Axes, sheet: Sheet, ends: FloatArray, line: FloatArray, name: str) -> None:
    for end, foot in zip(ends, line, strict=True):
        beyond = (foot - end) / np.linalg.norm(foot - end)
        draw_line(axes, np.array([end + 3 * beyond, foot + 3 * beyond]), 0.4, MEASURE, 1.2)
        sheet.taken.line(np.array([end, foot + 3 * beyond]))
    draw_arrow(axes, line, MEASURE, "<|-|>", 0.6, 1.3, 4.5)
    sheet.taken.line(line)
    middle = line.mean(axis=0)
    out = (line[0] - ends[0]) / np.linalg.norm(line[0] - ends[0])
    sheet.labels.append(
        Label(name, middle + 1.0 * out, 2.5, MEASURE, size=7.5, slant=True, first=True)
    )


# ---- lettering


def _letter(axes: Axes, sheet: Sheet) -> None:
    size = 8.0 if len(sheet.drawing.arrangement.graph.joints) <= MANY else 6.5
    labels = [label if label.size else label._replace(size=size) for label in sheet.labels]
    for label, at in placed(labels, sheet.taken, (WIDTH, sheet.height)):
        if np.linalg.norm(at - label.at) > label.clear + 16:
            draw_line(axes, np.array([label.at, at]), 0.35, FIXED, 4.4)
        write(
            axes,
            at,
            label.text,
            label.size,
            colour=label.colour,
            weight=label.weight,
            slant=label.slant,
            centred=True,
        )
