"""What is drawn of a mechanism: pieces on its bodies, made from its joints and bodies alone.

Every picture starts here, the scene in the browser, the animation and the scheme: which solids a
body carries, which of them stand for which joint, and from where to look. Nothing here moves:
bodies do, and a piece with its body.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from parakin.assembly import assembled, configure
from parakin.graph import Graph, GraphJoint, Placement
from parakin.shapes import Ball, Bar, Block, FloatArray, Form, Plate, outline, perpendicular, spread

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
_SLIDES = ("prismatic", "cylindrical", "helical")
_NEAR = 1e-6  # of the mechanism's size: places that coincide
_STROKE = 0.3  # of a cylinder's length at home, either way, where no limits are given
_LAYER = 2.6  # radii between the planes of two links of a planar mechanism that meet
_THIN = 0.011  # radius of a link, of the mechanism's size


class Piece(NamedTuple):
    """A solid that moves with a body; `joint` is the number of the joint it stands for, if any."""

    body: int
    part: Part
    form: Form
    joint: int | None = None


class Rod(NamedTuple):
    """A rod joint: from a place (3,) on one body to one on another, as long as it is."""

    joint: int
    parent: int
    start: FloatArray
    child: int
    end: FloatArray
    radius: float


class View(NamedTuple):
    """From where to look: unit vectors up, and towards the eye; the middle, and its width."""

    up: FloatArray
    eye: FloatArray
    middle: FloatArray
    span: float


class _End(NamedTuple):
    """A joint's place on a body: its point and its axis there, in the body's frame."""

    joint: int
    point: FloatArray
    axis: FloatArray


@dataclass(frozen=True)
class Drawing:
    """A mechanism's pieces. `poses`: R (3, 3) and p (3,) of every body at home."""

    graph: Graph
    poses: tuple[tuple[FloatArray, FloatArray], ...]
    q: FloatArray
    size: float = field(init=False)
    radius: float = field(init=False)

    def __post_init__(self) -> None:
        places = np.concatenate(
            [self.world(b, e.point) for b in range(len(self.poses)) for e in self._placed(b)]
            or [np.zeros((1, 3))]
        )
        size = float(np.linalg.norm(np.ptp(places, axis=0)))
        object.__setattr__(
            self, "size", size if size > _NEAR * self.graph.length else 2 * self.graph.length
        )
        object.__setattr__(self, "radius", _THIN * self.size)

    def world(self, body: int, points: FloatArray) -> FloatArray:
        """Places (n, 3) on a body, where they are at home."""
        R, p = self.poses[body]
        return np.atleast_2d(points) @ R.T + p

    def axis(self, joint: GraphJoint) -> FloatArray:
        """A joint's axis, its first, as it points at home (3,)."""
        return np.asarray(self.poses[joint.parent][0] @ np.array(joint.F.R, dtype=float)[:, 2])

    @cached_property
    def pieces(self) -> tuple[Piece, ...]:
        """All solids but the rods."""
        made = [piece for body in range(len(self.poses)) for piece in self._body(body)]
        for number in range(len(self.graph.joints)):
            made += self._joint(number)
        return tuple(made)

    @cached_property
    def rods(self) -> tuple[Rod, ...]:
        """The rod joints."""
        return tuple(
            Rod(k, j.parent, _at(j.F), j.child, _at(j.M), 0.8 * self.radius)
            for k, j in enumerate(self.graph.joints)
            if j.kind == "rod"
        )

    @cached_property
    def view(self) -> View:
        """Along the axes of a planar mechanism; otherwise down from the side."""
        up = np.eye(3)["xyz".index(self.graph.mechanism.up)]
        solids = [self.world(p.body, _places(p.form)) for p in self.pieces]
        places = np.concatenate(solids or [np.zeros((1, 3))])
        middle = (places.max(axis=0) + places.min(axis=0)) / 2
        span = float(np.linalg.norm(places.max(axis=0) - places.min(axis=0)))
        axis = self.plane_axis
        if axis is not None and abs(axis @ up) < 0.5:
            side = axis if axis[int(np.argmax(np.abs(axis)))] > 0 else -axis
            eye = side + 0.25 * up + 0.15 * np.cross(up, side)
        else:
            right = np.roll(up, 1)
            eye = 0.55 * up + 0.9 * right - 0.65 * np.cross(right, up)
        return View(up, eye / np.linalg.norm(eye), middle, span)

    @cached_property
    def plane_axis(self) -> FloatArray | None:
        """The direction all turns are about and all slides square to, if there is one."""
        turns, slides = [], []
        for joint in self.graph.joints:
            if joint.kind == "revolute":
                turns.append(self.axis(joint))
            elif joint.kind == "prismatic":
                slides.append(self.axis(joint))
            elif joint.name != "platform":
                return None
        if not turns or any(abs(abs(t @ turns[0]) - 1) > _NEAR for t in turns):
            return None
        return None if any(abs(s @ turns[0]) > _NEAR for s in slides) else turns[0]

    @cached_property
    def _layers(self) -> tuple[int, ...]:
        """Which of parallel planes each body of a planar mechanism is drawn in, the base hindmost:
        bodies that meet in a hinge pass one another; a cylinder and its piston share a plane.
        """
        layers = [0] * len(self.poses)
        if self.plane_axis is None:
            return tuple(layers)
        mates = {
            j.child: j.parent
            for k, j in enumerate(self.graph.joints)
            if j.kind in _SLIDES and self._is_cylinder(k)
        }
        met: list[set[int]] = [set() for _ in layers]
        for joint in self.graph.joints:
            if joint.name != "platform":
                one, other = (mates.get(b, b) for b in (joint.parent, joint.child))
                met[one].add(other)
                met[other].add(one)
        for body in range(1, len(layers)):
            if body not in mates:
                taken = {0} | {layers[b] for b in met[body] if b != body}
                layers[body] = min(set(range(1, len(layers) + 1)) - taken)
        return tuple(layers[mates.get(body, body)] for body in range(len(layers)))

    def _shift(self, body: int, layer: int | None = None) -> FloatArray:
        """From where the file puts things on a body to its plane, or another, in its frame."""
        axis = self.plane_axis
        if axis is None:
            return np.zeros(3)
        toward = axis if axis[int(np.argmax(np.abs(axis)))] > 0 else -axis
        height = self._layers[body] if layer is None else layer
        return np.asarray(_LAYER * self.radius * height * (self.poses[body][0].T @ toward))

    def _placed(self, body: int) -> list[_End]:
        """Joints on a body, where the file puts them."""
        ends = []
        for number, joint in enumerate(self.graph.joints):
            for of, place in ((joint.parent, joint.F), (joint.child, joint.M)):
                if of == body and joint.name != "platform":
                    ends.append(_End(number, _at(place), np.array(place.R, dtype=float)[:, 2]))
        return ends

    @cached_property
    def _concurrent(self) -> float:
        """How far from the centre that axes share they are drawn."""
        points = [self.world(b, e.point) for b in range(len(self.poses)) for e in self._placed(b)]
        alone = np.linalg.norm(np.ptp(np.concatenate(points), axis=0)) < _NEAR * self.size
        return (0.4 if alone else 0.07) * self.size

    def _ends(self, body: int) -> list[_End]:
        """Joints on a body, where they are drawn: apart from a common centre of their axes."""
        drawn = []
        for end in self._placed(body):
            joint = self.graph.joints[end.joint]
            point = end.point + self._shift(body)
            if joint.kind == "revolute" and self._is_centred(end.joint):
                point = point + self._concurrent * end.axis
            if joint.kind in _SLIDES and joint.parent == body and not self._is_cylinder(end.joint):
                point = point + self.stroke(end.joint)[0] * end.axis
            drawn.append(end._replace(point=point))
        return drawn

    def _is_centred(self, number: int) -> bool:
        """Whether a hinge's place is that of all joints of one of its bodies, on other axes."""
        joint = self.graph.joints[number]
        for body in (joint.parent, joint.child):
            ends = self._placed(body)
            points = np.array([end.point for end in ends])
            apart = any(abs(abs(end.axis @ ends[0].axis) - 1) > _NEAR for end in ends)
            hinges = all(self.graph.joints[end.joint].kind == "revolute" for end in ends)
            if hinges and apart and np.ptp(points, axis=0).max() < _NEAR * self.graph.length:
                return True
        return False

    def _other(self, body: int, number: int) -> list[float]:
        """How far along a slide's axis, from its place on a body, the body's other joints are;
        empty where one is off the axis.
        """
        ends = self._placed(body)
        (own,) = (end for end in ends if end.joint == number)
        away = [end.point - own.point for end in ends if end.joint != number]
        along = [float(a @ own.axis) for a in away]
        off = [np.linalg.norm(a - x * own.axis) for a, x in zip(away, along, strict=True)]
        return along if all(d < 1e-3 * self.graph.length for d in off) else []

    def _is_cylinder(self, number: int) -> bool:
        """Whether both bodies of a slide lie along it, as a cylinder and its piston do."""
        joint = self.graph.joints[number]
        both = self._other(joint.parent, number) and self._other(joint.child, number)
        return bool(both) and joint.parent != 0 and abs(self._length(number)) > 4 * self.radius

    def _length(self, number: int) -> float:
        """Of a cylinder with its piston at home, signed along its axis."""
        joint = self.graph.joints[number]
        far = max(self._other(joint.child, number), key=abs)
        near = max(self._other(joint.parent, number), key=abs)
        return self._slide(joint) + far - near

    def _slide(self, joint: GraphJoint) -> float:
        k = joint.first + (joint.kind == "cylindrical")
        return float(self.q[k]) * (joint.pairs[0].pitch if joint.kind == "helical" else 1.0)

    def stroke(self, number: int) -> tuple[float, float]:
        """The ends of a slide's travel [m], as the joint counts: limits, or some way from home."""
        joint = self.graph.joints[number]
        k = joint.first + (joint.kind == "cylindrical")
        home, (low, high) = self._slide(joint), self.graph.coordinates[k].limits
        if np.isfinite(low) and np.isfinite(high) and joint.kind != "helical":
            start = float(self.q[k]) if k in self.graph.from_home else 0.0
            return low + start, high + start
        both = self._other(joint.parent, number) and self._other(joint.child, number)
        reach = _STROKE * abs(self._length(number)) if both and joint.parent else 0.18 * self.size
        return home - reach, home + reach

    def _body(self, body: int) -> list[Piece]:
        part: Part = "link"
        platform = self.graph.platform
        if body == 0:
            part = "base"
        elif platform is not None and self.graph.joints[platform].child == body:
            part = "platform"
        ends, made = self._ends(body), []
        slid = {
            e.joint
            for e in ends
            if self.graph.joints[e.joint].kind in _SLIDES and self._is_cylinder(e.joint)
        }
        if len(slid) == 1 and len({tuple(np.round(e.point / self.size, 6)) for e in ends}) <= 2:
            return self._cylinder(body, slid.pop())
        points = [end.point for end in ends]
        if part == "platform":
            points += [
                np.array(p) + self._shift(body)
                for of, p in self.graph.points.values()
                if of == body
            ]
        if platform is not None and part == "platform":
            points.append(_at(self.graph.joints[platform].M) + self._shift(body))
        thin = self.radius * (0.6 if body == 0 else 1.0)
        arcs = self._arcs(ends, part, body)
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
                    if not (np.abs(flat - c).max(axis=1) < _NEAR * self.size).any()
                ]
            )
            made += [
                Piece(body, part, Bar(np.array([middle, c]), self._strut(c, joints) * thin))
                for c in rest
                if np.linalg.norm(c - middle) > thin
            ]
        return made

    def _strut(self, end: FloatArray, joints: FloatArray) -> float:
        """How thick a bar from a body's middle is: to a mere point on it, such as a head, thin."""
        held = len(joints) and np.linalg.norm(joints - end, axis=1).min() < _NEAR * self.size
        return 0.8 if held else 0.35

    def _arcs(self, ends: list[_End], part: Part, body: int) -> list[Piece]:
        """A link whose hinges meet in a point, bent about it; nothing for other links."""
        if len(ends) < 2 or not all(self._is_centred(end.joint) for end in ends):
            return []
        centres = np.array([end.point - self._concurrent * end.axis for end in ends])
        if np.ptp(centres, axis=0).max() > _NEAR * self.size:
            return []
        first, *rest = ends
        made = []
        for end in rest if len(ends) == 2 else ends:
            start = first.axis if len(ends) == 2 else np.mean([e.axis for e in ends], axis=0)
            t = np.linspace(0, 1, 17)[:, None]
            way = (1 - t) * start + t * end.axis
            if len(ends) == 2:
                way = way / np.linalg.norm(way, axis=1)[:, None]
            made.append(Piece(body, part, Bar(centres[0] + self._concurrent * way, self.radius)))
        return made

    def _cylinder(self, body: int, number: int) -> list[Piece]:
        """The tube of a cylinder, or the rod of its piston, as long as they can be.

        At its shortest the rod must not come out at the bottom, at its longest not leave the tube.
        """
        joint = self.graph.joints[number]
        home, (low, high) = self._slide(joint), self.stroke(number)
        length = self._length(number)
        sign = 1.0 if length > 0 else -1.0
        shortest = abs(length) + sign * (low - home) if sign > 0 else abs(length) - (high - home)
        longest = shortest + high - low
        tube = min(max(0.55 * abs(length), longest - 0.9 * shortest), shortest)
        rod = max(longest - tube + 2 * self.radius, 0.5 * tube)
        if body == joint.parent:
            axis = sign * np.array(joint.F.R, dtype=float)[:, 2]
            start = _at(joint.F) + self._shift(body)
            start = start + sign * max(self._other(body, number), key=abs) * axis
            ends = np.array([start, start + tube * axis])
            return [Piece(body, "cylinder", Bar(ends, 1.6 * self.radius), number)]
        axis = sign * np.array(joint.M.R, dtype=float)[:, 2]
        start = _at(joint.M) + self._shift(body)
        start = start + sign * max(self._other(body, number), key=abs) * axis
        return [
            Piece(body, "piston", Bar(np.array([start, start - rod * axis]), 0.9 * self.radius))
        ]

    def _joint(self, number: int) -> list[Piece]:
        """A joint by its kind."""
        joint, r = self.graph.joints[number], self.radius
        if joint.name == "platform" or joint.kind in ("fixed", "free"):
            return []
        own = {}
        for body in (joint.parent, joint.child):
            (own[body],) = (end for end in self._ends(body) if end.joint == number)
        near, far = own[joint.parent], own[joint.child]

        def bar(body: int, end: _End, radius: float, half: float) -> Piece:
            ends = np.array([end.point - half * end.axis, end.point + half * end.axis])
            return Piece(body, "joint", Bar(ends, radius), number)

        if joint.kind == "revolute":
            if self.plane_axis is not None:  # a pin from plane to plane
                there = far.point - self._shift(joint.child)
                there = there + self._shift(joint.child, self._layers[joint.parent])
                over = (
                    1.4 * r * (there - far.point) / max(float(np.linalg.norm(there - far.point)), r)
                )
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
        return self._slider(number, far)

    def _slider(self, number: int, far: _End) -> list[Piece]:
        """A slide: a collar on a cylinder's piston, or a carriage on a rail; a screw's thread."""
        joint, r = self.graph.joints[number], self.radius
        if self._is_cylinder(number):
            (tube,) = (p.form for p in self._cylinder(joint.parent, number))
            assert isinstance(tube, Bar)
            end = tube.points[1]
            axis = (end - tube.points[0]) / np.linalg.norm(end - tube.points[0])
            rim = Bar(np.array([end - 1.2 * r * axis, end]), 2.1 * r)
            made = [Piece(joint.parent, "joint", rim, number)]
        else:
            low, high = self.stroke(number)
            axis = np.array(joint.F.R, dtype=float)[:, 2]
            foot = _at(joint.F) + self._shift(joint.parent, self._layers[joint.child])
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
        if joint.kind != "prismatic":  # what turns about its slide as well
            for k in range(-1, 2) if joint.kind == "helical" else (0,):
                at = far.point + (2.0 * k) * r * far.axis
                half = 0.45 * r * far.axis
                made.append(
                    Piece(
                        joint.child, "joint", Bar(np.array([at - half, at + half]), 3.2 * r), number
                    )
                )
        return made

    def colour(self, piece: Piece) -> tuple[int, int, int]:
        """Red, green and blue, 0 to 255."""
        moved = piece.joint is not None and self.graph.joints[piece.joint].actuated
        return COLOURS["actuated" if moved else piece.part]


def drawing_of(graph: Graph, q: FloatArray | None = None) -> Drawing:
    """What to draw of a mechanism; q: its coordinates at home, if known. Raises AssemblyError."""
    tree = graph.posed_tree()
    at = configure(graph, tree, assembled(graph).q if q is None else q)
    poses = []
    for body in range(len(graph.bodies)):
        pose = at.circuits.pose(body)
        poses.append((np.array(pose.R, dtype=float), np.array(pose.p, dtype=float)))
    return Drawing(graph, tuple(poses), at.q)


def _at(place: Placement) -> FloatArray:
    return np.array(place.p, dtype=float)


def _places(form: Form) -> FloatArray:
    """Where a form is, roughly."""
    if isinstance(form, Bar):
        return form.points
    if isinstance(form, Plate):
        return form.corners
    return np.atleast_2d(form.vertices if not isinstance(form, (Ball, Block)) else form.centre)
