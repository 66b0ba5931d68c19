"""Where the joints of a mechanism are drawn on its bodies, at home.

Mostly where its file puts them. But links of a planar mechanism lie in parallel planes, hinges of
a spherical one are moved away from their common centre, and slides have a length.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from parakin.algebra.spatial import Pose
from parakin.arrays import FloatArray
from parakin.caching import cached_property
from parakin.kinematics.assembly import assembled
from parakin.kinematics.configuration import configure
from parakin.model.graph import Graph
from parakin.model.joints import GraphJoint

SLIDES = ("prismatic", "cylindrical", "helical")
NEAR = 1e-6  # of the mechanism's size: places that coincide
_STROKE = 0.3  # of a cylinder's length at home, either way, where no limits are given
_LAYER = 2.6  # radii between adjacent planes of a planar mechanism
_THIN = 0.011  # radius of a link, of the mechanism's size


class End(NamedTuple):
    """A joint's place on a body: its point and its axis there, in the body's frame."""

    joint: int
    point: FloatArray
    axis: FloatArray


@dataclass(frozen=True)
class Arrangement:
    """A mechanism at home. `poses`: R (3, 3) and p (3,) of every body; `q`: all coordinates;
    `size`: of the box about its joints; `radius`: of a link.
    """

    graph: Graph
    poses: tuple[tuple[FloatArray, FloatArray], ...]
    q: FloatArray
    size: float = field(init=False)
    radius: float = field(init=False)

    def __post_init__(self) -> None:
        places = np.concatenate(
            [self.world(b, e.point) for b in range(len(self.poses)) for e in self.placed(b)]
            or [np.zeros((1, 3))]
        )
        size = float(np.linalg.norm(np.ptp(places, axis=0)))
        object.__setattr__(
            self, "size", size if size > NEAR * self.graph.length else 2 * self.graph.length
        )
        object.__setattr__(self, "radius", _THIN * self.size)

    def world(self, body: int, points: FloatArray) -> FloatArray:
        """Points (n, 3) of a body, in the world at home."""
        R, p = self.poses[body]
        return np.atleast_2d(points) @ R.T + p

    def axis(self, joint: GraphJoint) -> FloatArray:
        """A joint's first axis in the world at home (3,)."""
        return np.asarray(self.poses[joint.parent][0] @ np.array(joint.F.R, dtype=float)[:, 2])

    @cached_property
    def plane_axis(self) -> FloatArray | None:
        """The common axis of all hinges, perpendicular to all slides, if there is one."""
        turns, slides = [], []
        for joint in self.graph.joints:
            if joint.kind == "revolute":
                turns.append(self.axis(joint))
            elif joint.kind == "prismatic":
                slides.append(self.axis(joint))
            elif joint.name != "platform":
                return None
        if not turns or any(abs(abs(t @ turns[0]) - 1) > NEAR for t in turns):
            return None
        return None if any(abs(s @ turns[0]) > NEAR for s in slides) else turns[0]

    @cached_property
    def layers(self) -> tuple[int, ...]:
        """The plane that each body of a planar mechanism is drawn in, the base at the back: bodies
        that share a hinge have different planes, a cylinder and its piston the same.
        """
        layers = [0] * len(self.poses)
        if self.plane_axis is None:
            return tuple(layers)
        mates = {
            j.child: j.parent
            for k, j in enumerate(self.graph.joints)
            if j.kind in SLIDES and self.is_cylinder(k)
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

    def shift(self, body: int, layer: int | None = None) -> FloatArray:
        """The displacement that brings a body to its plane, or another, in the body's frame."""
        axis = self.plane_axis
        if axis is None:
            return np.zeros(3)
        toward = axis if axis[int(np.argmax(np.abs(axis)))] > 0 else -axis
        height = self.layers[body] if layer is None else layer
        return np.asarray(_LAYER * self.radius * height * (self.poses[body][0].T @ toward))

    def placed(self, body: int) -> list[End]:
        """The joints on a body, where its file puts them."""
        ends = []
        for number, joint in enumerate(self.graph.joints):
            for of, place in ((joint.parent, joint.F), (joint.child, joint.M)):
                if of == body and joint.name != "platform":
                    ends.append(End(number, point_of(place), np.array(place.R, dtype=float)[:, 2]))
        return ends

    @cached_property
    def concurrent(self) -> float:
        """How far from the common centre of their axes hinges are drawn."""
        points = [self.world(b, e.point) for b in range(len(self.poses)) for e in self.placed(b)]
        alone = np.linalg.norm(np.ptp(np.concatenate(points), axis=0)) < NEAR * self.size
        return (0.4 if alone else 0.07) * self.size

    def ends(self, body: int) -> list[End]:
        """The joints on a body, where they are drawn."""
        drawn = []
        for end in self.placed(body):
            joint = self.graph.joints[end.joint]
            point = end.point + self.shift(body)
            if joint.kind == "revolute" and self.is_centred(end.joint):
                point = point + self.concurrent * end.axis
            if joint.kind in SLIDES and joint.parent == body and not self.is_cylinder(end.joint):
                point = point + self.stroke(end.joint)[0] * end.axis
            drawn.append(end._replace(point=point))
        return drawn

    def is_centred(self, number: int) -> bool:
        """Whether all hinges of one of a hinge's bodies meet in its point, with different axes."""
        joint = self.graph.joints[number]
        for body in (joint.parent, joint.child):
            ends = self.placed(body)
            points = np.array([end.point for end in ends])
            apart = any(abs(abs(end.axis @ ends[0].axis) - 1) > NEAR for end in ends)
            hinges = all(self.graph.joints[end.joint].kind == "revolute" for end in ends)
            if hinges and apart and np.ptp(points, axis=0).max() < NEAR * self.graph.length:
                return True
        return False

    def along_slide(self, body: int, number: int) -> list[float]:
        """Where the other joints of a body are along the axis of one of its slides, from its
        place; empty if one of them is off the axis.
        """
        ends = self.placed(body)
        (own,) = (end for end in ends if end.joint == number)
        away = [end.point - own.point for end in ends if end.joint != number]
        along = [float(a @ own.axis) for a in away]
        off = [np.linalg.norm(a - x * own.axis) for a, x in zip(away, along, strict=True)]
        return along if all(d < 1e-3 * self.graph.length for d in off) else []

    def is_cylinder(self, number: int) -> bool:
        """Whether both bodies of a slide lie along it, as a cylinder and its piston do."""
        joint = self.graph.joints[number]
        both = self.along_slide(joint.parent, number) and self.along_slide(joint.child, number)
        return bool(both) and joint.parent != 0 and abs(self.length(number)) > 4 * self.radius

    def length(self, number: int) -> float:
        """The length of a cylinder with its piston at home, signed along its axis."""
        joint = self.graph.joints[number]
        far = max(self.along_slide(joint.child, number), key=abs)
        near = max(self.along_slide(joint.parent, number), key=abs)
        return self.travel(joint) + far - near

    def travel(self, joint: GraphJoint) -> float:
        """The position of a slide at home [m], as its coordinate is counted."""
        k = joint.first + (joint.kind == "cylindrical")
        return float(self.q[k]) * (joint.pairs[0].pitch if joint.kind == "helical" else 1.0)

    def stroke(self, number: int) -> tuple[float, float]:
        """The ends of a slide's travel [m], counted as its coordinate: limits, or around home."""
        joint = self.graph.joints[number]
        k = joint.first + (joint.kind == "cylindrical")
        home = self.travel(joint)
        low, high = self.graph.limits(self.graph.coordinates[k].name)
        if np.isfinite(low) and np.isfinite(high) and joint.kind != "helical":
            start = float(self.q[k]) if k in self.graph.from_home else 0.0
            return low + start, high + start
        both = self.along_slide(joint.parent, number) and self.along_slide(joint.child, number)
        reach = _STROKE * abs(self.length(number)) if both and joint.parent else 0.18 * self.size
        return home - reach, home + reach


def arrangement_of(graph: Graph, q: FloatArray | None = None) -> Arrangement:
    """Arrange a mechanism; q: its coordinates at home, if known. Raises AssemblyError."""
    tree = graph.posed_tree()
    home = configure(graph, tree, assembled(graph).q if q is None else q)
    poses = []
    for body in range(len(graph.bodies)):
        pose = home.circuits.pose(body)
        poses.append((np.array(pose.R, dtype=float), np.array(pose.p, dtype=float)))
    return Arrangement(graph, tuple(poses), home.q)


def point_of(place: Pose) -> FloatArray:
    """A place's point (3,)."""
    return np.array(place.p, dtype=float)
