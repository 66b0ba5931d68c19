"""The sheet that a scheme is drawn on, in points: projection, lines and text.

Symbols, arrows and lettering have the same size for every mechanism.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from parakin.arrays import FloatArray
from parakin.views.scheme.lettering import Label, Obstacles
from parakin.views.scheme.symbols import Sight, Stroke
from parakin.views.solids.drawing import Drawing, Piece
from parakin.views.solids.shapes import Ball, Bar, Block, Plate

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STYLE: Mapping[Any, Any] = {  # text stays text, in a font that comes with matplotlib
    "svg.fonttype": "none",
    "svg.hashsalt": "parakin",  # the same drawing is the same file
    "pdf.fonttype": 42,
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans", "Verdana", "Arial", "Helvetica", "sans-serif"],
}
WIDTH, TALLEST = 510.0, 430.0  # [pt]: A4 between its margins
_MARGIN = 50.0  # around the mechanism, for labels and dimensions
_SYMBOL, _SMALL = 6.0, 4.8  # [pt]; small where joints are many
MANY = 16
INK, DRIVEN, FIXED, PLATFORM, MEASURE = "black", "#d2691e", "0.45", "#2a7fb8", "#4a4a8a"


@dataclass
class Sheet:
    """The projection of a mechanism onto paper, and what is already there.

    `scale` [pt/m]; `corner`, `height` [pt]; `s`: size of symbols [pt].
    """

    drawing: Drawing
    sight: Sight
    scale: float
    corner: FloatArray
    height: float
    s: float
    taken: Obstacles = field(default_factory=Obstacles)
    labels: list[Label] = field(default_factory=list)

    @classmethod
    def of(cls, drawing: Drawing) -> Sheet:
        """A sheet with room for the whole mechanism, and a margin for labels."""
        sight = sight_of(drawing)
        forms = [(p.body, outline_of(p)) for p in drawing.pieces]
        places = [drawing.arrangement.world(body, points) for body, points in forms]
        places += [
            drawing.arrangement.world(b, np.array(p))
            for b, p in drawing.arrangement.graph.points.values()
        ]
        places += (
            [drawing.arrangement.world(0, np.zeros(3))]
            if drawing.arrangement.graph.platform is not None
            else []
        )
        flat = sight.flat(np.concatenate(places or [np.zeros((1, 3))]))
        low, high = flat.min(axis=0), flat.max(axis=0)
        span = np.maximum(high - low, 0.05 * drawing.arrangement.size)
        scale = float(min((np.array([WIDTH, TALLEST]) - 2 * _MARGIN) / span))
        height = float(scale * span[1]) + 2 * _MARGIN
        corner = np.array([WIDTH, height]) / 2 - scale * (low + high) / 2
        s = _SYMBOL if len(drawing.arrangement.graph.joints) <= MANY else _SMALL
        return cls(drawing, sight, scale, corner, height, s)

    def at(self, body: int, points: FloatArray) -> FloatArray:
        """Points (n, 3) of a body [m], on the sheet (n, 2) [pt]."""
        return self.flat(self.drawing.arrangement.world(body, points))

    def flat(self, places: FloatArray) -> FloatArray:
        """Points (n, 3) in the world [m], on the sheet (n, 2) [pt]."""
        return self.scale * self.sight.flat(np.atleast_2d(places)) + self.corner

    def holds(self, at: FloatArray) -> bool:
        """Whether a point (2,) is on the sheet."""
        return bool((at > 4).all() and at[0] < WIDTH - 4 and at[1] < self.height - 4)


def sight_of(drawing: Drawing) -> Sight:
    """Along the common axis of a planar mechanism, otherwise as in other pictures."""
    up, eye, axis = drawing.view.up, drawing.view.eye, drawing.arrangement.plane_axis
    if axis is not None:
        eye = axis if axis[int(np.argmax(np.abs(axis)))] > 0 else -axis
        up = up if abs(eye @ up) < 0.5 else np.roll(up, -1)  # seen from above: y up, x right
    right = np.cross(up, eye)
    right = right / np.linalg.norm(right)
    return Sight(np.array([right, np.cross(eye, right)]), eye)


def outline_of(piece: Piece) -> FloatArray:
    """A piece's corners, chain or centre, in its body's frame."""
    form = piece.form
    if isinstance(form, Bar):
        return form.points
    if isinstance(form, Plate):
        return form.corners
    return np.atleast_2d(form.centre if isinstance(form, (Ball, Block)) else form.vertices)


def draw_line(
    axes: Axes,
    points: FloatArray,
    width: float,
    colour: str = INK,
    order: float = 2,
    style: str = "-",
) -> None:
    """Draw a chain of points (n, 2); a higher order lies above."""
    axes.plot(
        points[:, 0],
        points[:, 1],
        color=colour,
        linewidth=width,
        zorder=order,
        linestyle=style,
        solid_capstyle="round",
        solid_joinstyle="round",
    )


def draw_stroke(
    axes: Axes,
    stroke: Stroke,
    colour: str,
    fill: str,
    order: float,
    name: str = "",
    width: float = 1.0,
) -> None:
    """Draw a stroke of a symbol; name: its id in SVG."""
    from matplotlib.patches import Polygon

    if stroke.axis:
        draw_line(axes, stroke.points, 0.5, colour, order, "-.")
        return
    patch = Polygon(
        stroke.points,
        closed=stroke.closed,
        fill=stroke.closed,
        facecolor=fill,
        edgecolor=colour,
        linewidth=width,
        zorder=order,
        joinstyle="round",
    )
    if name:
        patch.set_gid(name)
    axes.add_patch(patch)


def draw_arrow(
    axes: Axes,
    points: FloatArray,
    colour: str,
    style: str,
    width: float,
    order: float,
    size: float = 6.0,
) -> None:
    """Draw a line with arrowheads."""
    from matplotlib.patches import FancyArrowPatch
    from matplotlib.path import Path as Line

    axes.add_patch(
        FancyArrowPatch(
            path=Line(points),
            arrowstyle=style,
            mutation_scale=size,
            color=colour,
            linewidth=width,
            zorder=order,
            shrinkA=0,
            shrinkB=0,
            joinstyle="miter",
        )
    )


def write(
    axes: Axes,
    at: FloatArray,
    text: str,
    size: float,
    *,
    colour: str = INK,
    weight: str = "normal",
    slant: bool = False,
    centred: bool = False,
) -> None:
    """Write a text verbatim, never as mathtext; centred text has a background."""
    axes.text(
        float(at[0]),
        float(at[1]),
        text,
        fontsize=size,
        color=colour,
        fontweight=weight,
        fontstyle="italic" if slant else "normal",
        ha="center" if centred else "left",
        va="center" if centred else "baseline",
        parse_math=False,
        zorder=5,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.4}
        if centred
        else None,
    )
