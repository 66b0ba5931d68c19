"""The joint graph, in numbers: what the user said, ready for the recursion, and its trees.

Every joint is a chain of pairs, each turning about or sliding along one axis of a moving frame;
revolute and prismatic pairs carry the whole theory. The pose of the platform is such a joint
too, free in all six directions: it closes no loop, yet its coordinates can be driven or read.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from parakin.algebra.spatial import (
    IDENTITY,
    NOWHERE,
    ZERO,
    Matrix,
    Pose,
    Vector,
    cross,
    dot,
    matrix,
    turned,
    vector,
)
from parakin.errors import InputError, nearest
from parakin.model.expressions import ANGLE, LENGTH, Dimension, Parameters
from parakin.model.mechanism import MAX_JOINTS, Frame, Mechanism

AXES = {"x": 0, "y": 1, "z": 2}


class Pair(NamedTuple):
    """One degree of freedom: a slide along, or a turn about, the moving frame's axis.

    `pitch` is how far a turn advances along its axis [m/rad].
    """

    slides: bool
    axis: int
    pitch: float = 0.0


X_TURN, Y_TURN, Z_TURN = (Pair(False, axis) for axis in range(3))
X_SLIDE, Y_SLIDE, Z_SLIDE = (Pair(True, axis) for axis in range(3))

# Theta of eq. (2), active: it turns z onto x, the second axis of a universal joint.
Placement = Pose
THETA: Matrix[float] = matrix(((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)))

PAIRS: dict[str, tuple[Pair, ...]] = {
    "revolute": (Z_TURN,),
    "prismatic": (Z_SLIDE,),
    "cylindrical": (Z_TURN, Z_SLIDE),
    "universal": (Z_TURN, X_TURN),
    "spherical": (X_TURN, Y_TURN, Z_TURN),
    "planar": (X_SLIDE, Y_SLIDE, Z_TURN),
    "free": (X_SLIDE, Y_SLIDE, Z_SLIDE, X_TURN, Y_TURN, Z_TURN),
    "rod": (),
    "fixed": (),
}


@dataclass(frozen=True)
class GraphJoint:
    """A joint in numbers: frame F on its parent, M on its child, pairs and tail between.

    R_FM = turn(pair 1) turn(pair 2) ... tail; `first` numbers its first coordinate.
    """

    name: str
    kind: str
    parent: int
    child: int
    F: Pose[float]
    M: Pose[float]
    pairs: tuple[Pair, ...]
    tail: Matrix[float]
    first: int
    actuated: bool = False
    length: float = 0.0

    @property
    def coordinates(self) -> range:
        return range(self.first, self.first + len(self.pairs))

    @property
    def proper(self) -> bool:
        """Whether the first and last of three turns are about the same axis (Euler's own)."""
        axes = [pair.axis for pair in self.pairs if not pair.slides]
        return len(axes) == 3 and axes[0] == axes[-1]

    @property
    def turns(self) -> list[int]:
        """Those of its coordinates that are angles."""
        return [k for k, pair in zip(self.coordinates, self.pairs, strict=True) if not pair.slides]


class Coordinate(NamedTuple):
    """One joint coordinate; `limits` in SI, infinite where none is given."""

    name: str
    joint: int
    angle: bool
    actuated: bool
    limits: tuple[float, float]

    @property
    def unit(self) -> str:
        return "rad" if self.angle else "m"


@dataclass(frozen=True)
class Tree:
    """A spanning tree of the joint graph.

    `steps` leads from the base to every body: (joint, reversed), the body it starts from being
    placed already; `cuts` are the joints left out, whose loops must close.
    """

    steps: tuple[tuple[int, bool], ...]
    cuts: tuple[int, ...]


@dataclass(frozen=True)
class Graph:
    """A mechanism in numbers. Body 0 is the base.

    `twins`: by joint of three turns, another one beside it whose angles count from an orientation
    nearby (`recentred`).
    """

    mechanism: Mechanism
    parameters: Mapping[str, float]
    bodies: tuple[str, ...]
    points: Mapping[str, tuple[int, Vector[float]]]
    joints: tuple[GraphJoint, ...]
    coordinates: tuple[Coordinate, ...]
    cones: Mapping[str, tuple[int, tuple[float, float]]]
    home: Mapping[int, float]
    stated: Mapping[int, float]
    guess: Mapping[int, float]
    from_home: frozenset[int]
    length: float
    twins: Mapping[int, int] = field(default_factory=dict)

    def index(self, name: str, place: str) -> int:
        """The number of a coordinate. Raises InputError on an unknown name."""
        for number, coordinate in enumerate(self.coordinates):
            if coordinate.name == name:
                return number
        raise InputError(
            place,
            f"unknown coordinate {name!r}",
            nearest(name, (coordinate.name for coordinate in self.coordinates)),
        )

    def inside(self, tree: Tree) -> list[int]:
        """The coordinates of a tree's joints, from the base outwards."""
        return [n for k, _ in tree.steps for n in self.joints[k].coordinates]

    def limits(self, name: str) -> tuple[float, float]:
        """Of a coordinate or a cone angle, infinite where none are given. Raises InputError."""
        if name in self.cones:
            return self.cones[name][1]
        return self.coordinates[self.index(name, "limits")].limits

    def holder(self, name: str) -> int:
        """The number of the joint of a coordinate or a cone angle. Raises InputError."""
        if name in self.cones:
            return self.cones[name][0]
        return self.coordinates[self.index(name, "limits")].joint

    def dimension(self, coordinate: int) -> Dimension:
        return ANGLE if self.coordinates[coordinate].angle else LENGTH

    @property
    def platform(self) -> int | None:
        """The platform's free joint."""
        return next((k for k, joint in enumerate(self.joints) if joint.name == "platform"), None)

    def tree(
        self,
        first: Collection[int] = (),
        second: Collection[int] = (),
        last: Collection[int] = (),
    ) -> Tree:
        """The spanning tree that keeps joints `first` where it can, then joints `second`, and
        joints `last`, and those that have a twin, only where it must.

        Otherwise it leaves out the joints of most freedom, since they close a loop with the
        fewest rows: spherical joints before revolute ones; of equals passive joints before
        actuated ones, turns before slides, those between moving bodies, and the later in the
        file.
        """

        def order(k: int) -> tuple[bool, int, int, bool, bool, bool, int]:
            joint = self.joints[k]
            spare = k in last or k in self.twins
            rank = 0 if k in first else 1 if k in second else 3 if spare else 2
            slides = any(pair.slides for pair in joint.pairs)
            # A screw cannot be cut: its row would have to know how often it has turned.
            return (
                joint.kind != "helical",
                rank,
                len(joint.pairs),
                not joint.actuated,
                not slides,
                0 not in (joint.parent, joint.child),
                k,
            )

        group = list(range(len(self.bodies)))
        kept: list[int] = []
        for k in sorted(range(len(self.joints)), key=order):
            if self.joints[k].kind == "rod":
                continue
            a, b = group[self.joints[k].parent], group[self.joints[k].child]
            if a != b:
                kept.append(k)
                group = [a if g == b else g for g in group]
        return self.tree_of(kept)

    def posed_tree(self) -> Tree:
        """The tree that keeps the platform's pose, and so cuts what carries it: at an end of its
        range a spherical joint in the tree would seem to lack a freedom.
        """
        if self.platform is None:
            return self.tree()
        return self.tree(first=[self.twins.get(self.platform, self.platform)])

    def tree_of(self, kept: Sequence[int]) -> Tree:
        """The tree made of just these joints, walked from the base outwards."""
        steps: list[tuple[int, bool]] = []
        placed, waiting = {0}, sorted(kept)
        while waiting:
            k = next(j for j in waiting if {self.joints[j].parent, self.joints[j].child} & placed)
            joint = self.joints[k]
            backwards = joint.child in placed
            steps.append((k, backwards))
            placed.add(joint.parent if backwards else joint.child)
            waiting.remove(k)
        cuts = tuple(k for k in range(len(self.joints)) if k not in set(kept))
        return Tree(tuple(steps), cuts)

    def recentred(self, number: int, R_FM: Matrix[float]) -> Graph:
        """With a twin beside a joint of three turns, whose angles vanish at orientation `R_FM`.

        Three angles are not defined everywhere; the twin's are, near that orientation. It is a
        joint that is free, closes nothing, and takes the other's place in trees; its coordinates
        come after all others.
        """
        joint = self.joints[number]
        slides = tuple(pair for pair in joint.pairs if pair.slides)
        first = len(self.coordinates)
        twin = replace(
            joint,
            name=f"{joint.name}~",
            kind="free",
            pairs=(*slides, X_TURN, Y_TURN, Z_TURN),
            tail=R_FM,
            first=first,
            actuated=False,
        )
        free = (-math.inf, math.inf)
        named = tuple(
            Coordinate(f"{twin.name}.{k}", len(self.joints), not pair.slides, False, free)
            for k, pair in enumerate(twin.pairs, start=1)
        )
        return replace(
            self,
            joints=(*self.joints, twin),
            coordinates=(*self.coordinates, *named),
            twins={**self.twins, number: len(self.joints)},
        )

    @property
    def plain(self) -> Graph:
        """Without the twins."""
        if not self.twins:
            return self
        joints = self.joints[: -len(self.twins)]
        count = sum(len(joint.pairs) for joint in joints)
        return replace(self, joints=joints, coordinates=self.coordinates[:count], twins={})

    def split(self, number: int) -> Graph:
        """The same with a joint of several freedoms as a chain of single ones, nothing between.

        Coordinates keep their numbers and names; the joint's cone angle is lost.
        """
        joint = self.joints[number]
        joints, coordinates = list(self.joints), list(self.coordinates)
        links = tuple(f"{joint.name}.{k}" for k in range(1, len(joint.pairs)))
        bodies = (*self.bodies, *links)
        along = [joint.parent, *range(len(self.bodies), len(bodies)), joint.child]
        last = Pose(joint.M.R @ joint.tail.T, joint.M.p)
        for i, pair in enumerate(joint.pairs):
            onto = matrix(
                [float(row == (pair.axis + k) % 3) for k in (1, 2, 0)] for row in range(3)
            )  # turns z into the pair's axis
            F = joint.F if i == 0 else NOWHERE
            M = last if i == len(joint.pairs) - 1 else NOWHERE
            k = joint.first + i
            single = GraphJoint(
                coordinates[k].name,
                "prismatic" if pair.slides else "revolute",
                along[i],
                along[i + 1],
                Pose(_snap(F.R @ onto), F.p),
                Pose(_snap(M.R @ onto), M.p),
                (pair._replace(axis=2),),
                IDENTITY,
                k,
                coordinates[k].actuated,
            )
            place = number if i == 0 else len(joints)
            joints[place : place + 1] = [single]
            coordinates[k] = coordinates[k]._replace(joint=place)
        cones = {name: cone for name, cone in self.cones.items() if cone[0] != number}
        return replace(
            self,
            bodies=bodies,
            joints=tuple(joints),
            coordinates=tuple(coordinates),
            cones=cones,
        )


def unit(a: Vector[float], place: str) -> Vector[float]:
    """`a` scaled to length one. Raises InputError where it is zero."""
    norm = math.hypot(*a)
    if not norm > 1e-12:
        raise InputError(place, f"the axis {list(a)}", "an axis that is not zero")
    return vector(entry / norm for entry in a)


def _snap(m: Matrix[float]) -> Matrix[float]:
    """Entries within rounding of 0 and ±1 become exact, so that the recursion can drop them."""

    def entry(a: float) -> float:
        near = float(round(a))
        return near + 0.0 if abs(a - near) < 4e-16 else a

    return matrix([entry(a) for a in row] for row in m)


def placement(frame: Frame, parameters: Parameters, place: str) -> Pose[float]:
    """The numbers of a frame: z along `axis`, x as near as can be to the one asked for.

    Raises InputError on expressions that fail and axes that are zero or parallel.
    """
    p = _vector(frame.at, parameters, f"{place}.at", LENGTH)
    if frame.axis is None and frame.x is None:
        R = IDENTITY
        for number, (axis, angle) in enumerate(frame.turns):
            q = parameters.evaluate(angle, ANGLE, f"{place}.turns[{number}]")
            R = turned(R, AXES[axis], math.cos(q), math.sin(q))
        return Pose(_snap(R), p)
    if frame.turns:
        raise InputError(f"{place}.turns", "turns beside an axis", "either turns or an axis")
    along = frame.axis if frame.axis is not None else (0.0, 0.0, 1.0)
    z = unit(_vector(along, parameters, f"{place}.axis", LENGTH), f"{place}.axis")
    if frame.x is not None:
        x = unit(_vector(frame.x, parameters, f"{place}.x", LENGTH), f"{place}.x")
        if abs(dot(x, z)) > 1 - 1e-9:
            raise InputError(f"{place}.x", f"{list(frame.x)} along the axis", "another direction")
    else:
        x = vector((1.0, 0.0, 0.0) if abs(z[0]) < 1 - 1e-9 else (0.0, 1.0, 0.0))
    x = unit(x - dot(x, z) * z, f"{place}.x")
    return Pose(_snap(Matrix((x, cross(z, x), z)).T), p)


def _vector(
    triple: Sequence[float | int | str], parameters: Parameters, place: str, dimension: Dimension
) -> Vector[float]:
    return vector(
        parameters.evaluate(value, dimension, f"{place}[{k}]") for k, value in enumerate(triple)
    )


def graph_of(mechanism: Mechanism) -> Graph:
    """Evaluate a mechanism's expressions and number its bodies, joints and coordinates.

    Raises InputError with the place of the first thing that does not evaluate.
    """
    where = mechanism.where
    parameters = Parameters(mechanism.parameters, where)
    values = parameters.all()
    others = [body.name for body in mechanism.bodies if body.name != mechanism.base]
    bodies = (mechanism.base, *others)
    number = {name: k for k, name in enumerate(bodies)}
    points = {
        f"{body.name}.{point}": (
            number[body.name],
            _vector(triple, parameters, f"{where}: bodies.{body.name}.points.{point}", LENGTH),
        )
        for body in mechanism.bodies
        for point, triple in body.points.items()
    }
    joints: list[GraphJoint] = []
    named: list[tuple[str, int, bool, bool]] = []
    for joint in mechanism.joints:
        place = f"{where}: joints.{joint.name}"
        pairs = PAIRS.get(joint.kind, ())
        if joint.pitch is not None:
            advance = parameters.evaluate(joint.pitch, LENGTH, f"{place}.pitch")
            pairs = (Z_TURN._replace(pitch=advance / (2 * math.pi)),)
        length = 0.0
        if joint.length is not None:
            length = parameters.evaluate(joint.length, LENGTH, f"{place}.length")
            if not length > 0:
                raise InputError(f"{place}.length", f"{length:g} m", "a length above zero")
        joints.append(
            GraphJoint(
                joint.name,
                joint.kind,
                number[joint.parent],
                number[joint.child],
                placement(joint.on_parent, parameters, f"{place}.on_parent"),
                placement(joint.on_child, parameters, f"{place}.on_child"),
                pairs,
                THETA if joint.kind == "universal" else IDENTITY,
                len(named),
                bool(joint.actuated),
                length,
            )
        )
        moved = joint.actuated
        if isinstance(moved, bool):
            moved = tuple(range(1, len(pairs) + 1)) if moved else ()
        for k in moved:
            if k > len(pairs):
                expected = f"numbers of its coordinates, up to {len(pairs)}"
                raise InputError(f"{place}.actuated", f"{k}", expected)
        for k, pair in enumerate(pairs, start=1):
            name = joint.name if len(pairs) == 1 else f"{joint.name}.{k}"
            named.append((name, len(joints) - 1, not pair.slides, k in moved))
    if len(named) > MAX_JOINTS:
        expected = f"at most {MAX_JOINTS}"
        raise InputError(f"{where}: joints", f"{len(named)} coordinates", expected)
    if mechanism.platform is not None:
        platform = mechanism.platform
        origin = points[f"{platform.body}.{platform.point}"][1] if platform.point else ZERO
        turns = tuple(Pair(False, AXES[axis]) for _, axis in platform.angles)
        slides = tuple(Pair(True, axis) for axis in range(3))
        joints.append(
            GraphJoint(
                "platform",
                "free",
                0,
                number[platform.body],
                NOWHERE,
                Pose(IDENTITY, origin),
                slides + turns,
                IDENTITY,
                len(named),
            )
        )
        labels = ["x", "y", "z", *(name for name, _ in platform.angles)]
        named += [
            (f"platform.{label}", len(joints) - 1, k > 2, False) for k, label in enumerate(labels)
        ]
    return _with_values(mechanism, parameters, values, bodies, points, joints, named)


def _with_values(
    mechanism: Mechanism,
    parameters: Parameters,
    values: Mapping[str, float],
    bodies: tuple[str, ...],
    points: Mapping[str, tuple[int, Vector[float]]],
    joints: Sequence[GraphJoint],
    named: Sequence[tuple[str, int, bool, bool]],
) -> Graph:
    numbers = {name: k for k, (name, *_) in enumerate(named)}
    cones = {f"{j.name}.cone": k for k, j in enumerate(joints) if j.kind == "spherical"}

    def checked(name: str, place: str, known: Collection[str]) -> str:
        if name not in known:
            raise InputError(place, f"unknown coordinate {name!r}", nearest(name, known))
        return name

    def evaluated(table: str) -> dict[int, float]:
        result: dict[int, float] = {}
        for name, text in getattr(mechanism, table).items():
            place = f"{mechanism.where}: {table}.{name}"
            k = numbers[checked(name, place, numbers)]
            result[k] = parameters.evaluate(text, ANGLE if named[k][2] else LENGTH, place)
        return result

    limits: dict[str, tuple[float, float]] = {}
    for name, pair in mechanism.limits.items():
        place = f"{mechanism.where}: limits.{name}"
        checked(name, place, [*numbers, *cones])
        dimension = ANGLE if name in cones or named[numbers[name]][2] else LENGTH
        low, high = (parameters.evaluate(q, dimension, place) for q in pair)
        if not low < high:
            raise InputError(place, f"[{low:g}, {high:g}]", "a lower limit below the upper one")
        limits[name] = (low, high)
    for key in ("driven", "from_home"):
        for name in getattr(mechanism, key):
            checked(name, f"{mechanism.where}: {key}", numbers)
    free = (-math.inf, math.inf)
    reach = [math.hypot(*place.p) for j in joints for place in (j.F, j.M)]
    return Graph(
        mechanism,
        values,
        bodies,
        points,
        tuple(joints),
        tuple(
            Coordinate(name, joint, angle, actuated, limits.get(name, free))
            for name, joint, angle, actuated in named
        ),
        {name: (k, limits.get(name, free)) for name, k in cones.items()},
        evaluated("home"),
        evaluated("stated"),
        evaluated("guess"),
        frozenset(numbers[name] for name in mechanism.from_home),
        max(reach, default=0.0) or 1.0,
    )
