"""The solids of a mechanism, made from its joints and bodies alone.

Every picture starts here, be it the scene in the browser, a film or a scheme: which solids belong
to a body, which of them represent a joint, and where to look from. A solid moves with its body.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from parakin.arrays import FloatArray
from parakin.model.graph import Graph
from parakin.views.solids.arrangement import (
    NEAR,
    SLIDES,
    Arrangement,
    End,
    arrangement_of,
    point_of,
)
from parakin.views.solids.shapes import (
    Ball,
    Bar,
    Block,
    Form,
    Plate,
    outline,
    perpendicular,
    spread,
)

Part = Literal["base", "platform", "link", "cylinder", "piston", "joint"]
COLOURS: Mapping[str, tuple[int, int, int]] = {
    "base": (128, 136, 146),
    "platform": (86, 180, 233),
    "link": (70, 110, 170),
    "cylinder": (92, 100, 112),
    "piston": (196, 202, 210),
    "joint": (58, 62, 70),
    "actuated": (230, 126, 34),
    "offending": (222, 28, 40),
}


class Piece(NamedTuple):
    """A solid that moves with a body; `joint` is the number of the joint it represents, if any."""

    body: int
    part: Part
    form: Form
    joint: int | None = None


class Rod(NamedTuple):
    """A rod joint, from a point (3,) of one body to one of another."""

    joint: int
    parent: int
    start: FloatArray
    child: int
    end: FloatArray
    radius: float


class View(NamedTuple):
    """Where to look from: unit vectors up and towards the eye, the middle, and the width."""

    up: FloatArray
    eye: FloatArray
    middle: FloatArray
    span: float


@dataclass(frozen=True)
class Drawing:
    """All solids but the rods, the rods, and where to look from."""

    arrangement: Arrangement
    pieces: tuple[Piece, ...]
    rods: tuple[Rod, ...]
    view: View

    def colour(self, piece: Piece) -> tuple[int, int, int]:
        """Red, green and blue, 0 to 255."""
        moved = piece.joint is not None and self.arrangement.graph.joints[piece.joint].actuated
        return COLOURS["actuated" if moved else piece.part]


def drawing_of(graph: Graph, q: FloatArray | None = None) -> Drawing:
    """Draw a mechanism; q: its coordinates at home, if known. Raises AssemblyError."""
    arrangement = arrangement_of(graph, q)
    pieces = _pieces(arrangement)
    return Drawing(arrangement, pieces, _rods(arrangement), _view(arrangement, pieces))


def _pieces(arrangement: Arrangement) -> tuple[Piece, ...]:
    """All solids but the rods."""
    made = [piece for body in range(len(arrangement.poses)) for piece in _body(arrangement, body)]
    for number in range(len(arrangement.graph.joints)):
        made += _joint(arrangement, number)
    return tuple(made)


def _rods(arrangement: Arrangement) -> tuple[Rod, ...]:
    """The rod joints."""
    return tuple(
        Rod(k, j.parent, point_of(j.F), j.child, point_of(j.M), 0.8 * arrangement.radius)
        for k, j in enumerate(arrangement.graph.joints)
        if j.kind == "rod"
    )


def _view(arrangement: Arrangement, pieces: Sequence[Piece]) -> View:
    """Along the axes of a planar mechanism; otherwise down from the side."""
    up = np.eye(3)["xyz".index(arrangement.graph.mechanism.up)]
    solids = [arrangement.world(p.body, _places(p.form)) for p in pieces]
    places = np.concatenate(solids or [np.zeros((1, 3))])
    middle = (places.max(axis=0) + places.min(axis=0)) / 2
    span = float(np.linalg.norm(places.max(axis=0) - places.min(axis=0)))
    axis = arrangement.plane_axis
    if axis is not None and abs(axis @ up) < 0.5:
        side = axis if axis[int(np.argmax(np.abs(axis)))] > 0 else -axis
        eye = side + 0.25 * up + 0.15 * np.cross(up, side)
    else:
        right = np.roll(up, 1)
        eye = 0.55 * up + 0.9 * right - 0.65 * np.cross(right, up)
    return View(up, eye / np.linalg.norm(eye), middle, span)


def _body(arrangement: Arrangement, body: int) -> list[Piece]:
    part: Part = "link"
    platform = arrangement.graph.platform
    if body == 0:
        part = "base"
    elif platform is not None and arrangement.graph.joints[platform].child == body:
        part = "platform"
    ends, made = arrangement.ends(body), []
    slid = {
        e.joint
        for e in ends
        if arrangement.graph.joints[e.joint].kind in SLIDES and arrangement.is_cylinder(e.joint)
    }
    if len(slid) == 1 and len({tuple(np.round(e.point / arrangement.size, 6)) for e in ends}) <= 2:
        return _cylinder(arrangement, body, slid.pop())
    points = [end.point for end in ends]
    if part == "platform":
        points += [
            np.array(p) + arrangement.shift(body)
            for of, p in arrangement.graph.points.values()
            if of == body
        ]
    if platform is not None and part == "platform":
        points.append(point_of(arrangement.graph.joints[platform].M) + arrangement.shift(body))
    thin = arrangement.radius * (0.6 if body == 0 else 1.0)
    arcs = _arcs(arrangement, ends, part, body)
    if arcs:
        return arcs
    corners = np.array(points or [np.zeros(3)])
    if spread(corners) == 2 and len(points) > 2:
        made.append(Piece(body, part, Plate(outline(corners), 1.4 * thin)))
    elif spread(corners) == 1:
        along = (corners - corners[0]) @ np.linalg.svd(corners - corners.mean(axis=0))[2][0]
        pair = corners[[int(np.argmin(along)), int(np.argmax(along))]]
        made.append(Piece(body, part, Bar(pair, thin)))
    elif spread(corners) == 3:
        joints = np.array([end.point for end in ends])
        flat = outline(joints) if len(joints) > 2 and spread(joints) == 2 else None
        if flat is not None:
            made.append(Piece(body, part, Plate(flat, 1.4 * thin)))
        middle = corners.mean(axis=0) if flat is None else flat.mean(axis=0)
        rest = (
            corners
            if flat is None
            else [
                c
                for c in corners
                if not (np.abs(flat - c).max(axis=1) < NEAR * arrangement.size).any()
            ]
        )
        made += [
            Piece(body, part, Bar(np.array([middle, c]), _strut(arrangement, c, joints) * thin))
            for c in rest
            if np.linalg.norm(c - middle) > thin
        ]
    return made


def _strut(arrangement: Arrangement, end: FloatArray, joints: FloatArray) -> float:
    """How thick a bar from a body's middle is: thin if it ends at a point and not a joint."""
    held = len(joints) and np.linalg.norm(joints - end, axis=1).min() < NEAR * arrangement.size
    return 0.8 if held else 0.35


def _arcs(arrangement: Arrangement, ends: list[End], part: Part, body: int) -> list[Piece]:
    """A link whose hinges' axes meet in a point, bent about it; nothing for other links."""
    if len(ends) < 2 or not all(arrangement.is_centred(end.joint) for end in ends):
        return []
    centres = np.array([end.point - arrangement.concurrent * end.axis for end in ends])
    if np.ptp(centres, axis=0).max() > NEAR * arrangement.size:
        return []
    first, *rest = ends
    made = []
    for end in rest if len(ends) == 2 else ends:
        start = first.axis if len(ends) == 2 else np.mean([e.axis for e in ends], axis=0)
        t = np.linspace(0, 1, 17)[:, None]
        way = (1 - t) * start + t * end.axis
        if len(ends) == 2:
            way = way / np.linalg.norm(way, axis=1)[:, None]
        made.append(
            Piece(body, part, Bar(centres[0] + arrangement.concurrent * way, arrangement.radius))
        )
    return made


def _cylinder(arrangement: Arrangement, body: int, number: int) -> list[Piece]:
    """The tube of a cylinder, or the rod of its piston, as long as possible.

    Retracted, the rod must not come out at the bottom; extended, it must not leave the tube.
    """
    joint = arrangement.graph.joints[number]
    home, (low, high) = arrangement.travel(joint), arrangement.stroke(number)
    length = arrangement.length(number)
    sign = 1.0 if length > 0 else -1.0
    shortest = abs(length) + sign * (low - home) if sign > 0 else abs(length) - (high - home)
    longest = shortest + high - low
    tube = min(max(0.55 * abs(length), longest - 0.9 * shortest), shortest)
    rod = max(longest - tube + 2 * arrangement.radius, 0.5 * tube)
    if body == joint.parent:
        axis = sign * np.array(joint.F.R, dtype=float)[:, 2]
        start = point_of(joint.F) + arrangement.shift(body)
        start = start + sign * max(arrangement.along_slide(body, number), key=abs) * axis
        ends = np.array([start, start + tube * axis])
        return [Piece(body, "cylinder", Bar(ends, 1.6 * arrangement.radius), number)]
    axis = sign * np.array(joint.M.R, dtype=float)[:, 2]
    start = point_of(joint.M) + arrangement.shift(body)
    start = start + sign * max(arrangement.along_slide(body, number), key=abs) * axis
    return [
        Piece(body, "piston", Bar(np.array([start, start - rod * axis]), 0.9 * arrangement.radius))
    ]


def _joint(arrangement: Arrangement, number: int) -> list[Piece]:
    """The solids of a joint, by its kind."""
    joint, r = arrangement.graph.joints[number], arrangement.radius
    if joint.name == "platform" or joint.kind in ("fixed", "free"):
        return []
    own = {}
    for body in (joint.parent, joint.child):
        (own[body],) = (end for end in arrangement.ends(body) if end.joint == number)
    near, far = own[joint.parent], own[joint.child]

    def bar(body: int, end: End, radius: float, half: float) -> Piece:
        ends = np.array([end.point - half * end.axis, end.point + half * end.axis])
        return Piece(body, "joint", Bar(ends, radius), number)

    if joint.kind == "revolute":
        if arrangement.plane_axis is not None:  # a pin from plane to plane
            there = far.point - arrangement.shift(joint.child)
            there = there + arrangement.shift(joint.child, arrangement.layers[joint.parent])
            over = 1.4 * r * (there - far.point) / max(float(np.linalg.norm(there - far.point)), r)
            pin = Bar(np.array([far.point - over, there + over]), 1.0 * r)
            return [
                bar(joint.parent, near, 1.7 * r, 1.0 * r),
                Piece(joint.child, "joint", pin, number),
            ]
        return [
            bar(joint.parent, near, 1.7 * r, 2.0 * r),
            bar(joint.child, far, 0.9 * r, 2.8 * r),
        ]
    if joint.kind == "universal":
        return [
            bar(joint.parent, near, 0.8 * r, 2.6 * r),
            bar(joint.child, far, 0.8 * r, 2.6 * r),
            Piece(joint.parent, "joint", Ball(near.point, 1.3 * r), number),
        ]
    if joint.kind == "spherical":
        return [Piece(joint.parent, "joint", Ball(near.point, 2.0 * r), number)]
    if joint.kind == "rod":
        return [
            Piece(joint.parent, "joint", Ball(near.point, 1.5 * r), number),
            Piece(joint.child, "joint", Ball(far.point, 1.5 * r), number),
        ]
    if joint.kind == "planar":
        x = perpendicular(near.axis)
        y = np.cross(near.axis, x)
        corners = near.point + 5 * r * np.array([x + y, y - x, -x - y, x - y])
        return [Piece(joint.parent, "joint", Plate(corners, 0.6 * r), number)]
    return _slider(arrangement, number, far)


def _slider(arrangement: Arrangement, number: int, far: End) -> list[Piece]:
    """A slide: a collar on a cylinder's piston, or a carriage on a rail, or a screw's thread."""
    joint, r = arrangement.graph.joints[number], arrangement.radius
    if arrangement.is_cylinder(number):
        (tube,) = (p.form for p in _cylinder(arrangement, joint.parent, number))
        assert isinstance(tube, Bar)
        end = tube.points[1]
        axis = (end - tube.points[0]) / np.linalg.norm(end - tube.points[0])
        rim = Bar(np.array([end - 1.2 * r * axis, end]), 2.1 * r)
        made = [Piece(joint.parent, "joint", rim, number)]
    else:
        low, high = arrangement.stroke(number)
        axis = np.array(joint.F.R, dtype=float)[:, 2]
        foot = point_of(joint.F) + arrangement.shift(joint.parent, arrangement.layers[joint.child])
        start, end = foot + (low - 2 * r) * axis, foot + (high + 2 * r) * axis
        x = perpendicular(far.axis)
        R = np.column_stack([x, np.cross(far.axis, x), far.axis])
        block = Block(far.point, R, (4 * r, 4 * r, 5 * r))
        made = [
            Piece(
                joint.parent,
                "base" if joint.parent == 0 else "link",
                Bar(np.array([start, end]), 0.8 * r),
            ),
            Piece(joint.child, "joint", block, number),
        ]
    if joint.kind != "prismatic":  # a ring for what also turns
        for k in range(-1, 2) if joint.kind == "helical" else (0,):
            at = far.point + (2.0 * k) * r * far.axis
            half = 0.45 * r * far.axis
            made.append(
                Piece(joint.child, "joint", Bar(np.array([at - half, at + half]), 3.2 * r), number)
            )
    return made


def _places(form: Form) -> FloatArray:
    """Points that bound a form, roughly."""
    if isinstance(form, Bar):
        return form.points
    if isinstance(form, Plate):
        return form.corners
    return np.atleast_2d(form.vertices if not isinstance(form, (Ball, Block)) else form.centre)
