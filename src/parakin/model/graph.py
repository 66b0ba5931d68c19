"""A mechanism in numbers, ready for the recursion, and the spanning trees of its joints.

The pose of the platform is a joint too, free in all six directions: it closes no loop, yet its
coordinates can be driven or read.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from parakin.algebra.spatial import IDENTITY, IDENTITY_POSE, Matrix, Pose, Vector, matrix
from parakin.errors import InputError, nearest
from parakin.model.cycles import edges_of, shared, total_length
from parakin.model.dynamics import Dynamics
from parakin.model.joints import X_TURN, Y_TURN, Z_TURN, Coordinate, GraphJoint
from parakin.model.limits import UNLIMITED, Limit
from parakin.model.mechanism import Mechanism
from parakin.model.placement import snapped
from parakin.model.units import ANGLE, LENGTH, Dimension

_SHORT = 6  # joints on a loop beside the one cut: no fewer are looked for
_LONGER = 2  # times as long as they need be: loops that are too long


@dataclass(frozen=True)
class Tree:
    """A spanning tree of the joint graph.

    steps: from the base to every body, (joint, reversed); each starts at a body that has been
    placed. cuts: the joints left out, which close loops.
    """

    steps: tuple[tuple[int, bool], ...]
    cuts: tuple[int, ...]


@dataclass(frozen=True)
class Graph:
    """A mechanism in numbers, SI. Body 0 is the base.

    points: by `body.point`, the body and the point in its components. cones: by cone angle, its
    joint as declared. limited: all declared limits. home, stated, guess: by coordinate, as in the
    Mechanism. from_home: the coordinates that are counted from home. length: the characteristic
    length. dynamics: masses and what acts. twins: by joint of three turns, a second joint whose
    angles are counted from a nearby orientation (`recentred`). splits: joints that were
    `split`, one after the other.
    """

    mechanism: Mechanism
    parameters: Mapping[str, float]
    bodies: tuple[str, ...]
    points: Mapping[str, tuple[int, Vector[float]]]
    joints: tuple[GraphJoint, ...]
    coordinates: tuple[Coordinate, ...]
    cones: Mapping[str, GraphJoint]
    limited: tuple[Limit, ...]
    home: Mapping[int, float]
    stated: Mapping[int, float]
    guess: Mapping[int, float]
    from_home: frozenset[int]
    length: float
    dynamics: Dynamics = field(default_factory=Dynamics)
    twins: Mapping[int, int] = field(default_factory=dict)
    splits: tuple[int, ...] = ()

    def index(self, name: str, place: str) -> int:
        """The number of a coordinate. Raises InputError, naming `place`, if there is none."""
        for number, coordinate in enumerate(self.coordinates):
            if coordinate.name == name:
                return number
        raise InputError(
            place,
            f"unknown coordinate {name!r}",
            nearest(name, (coordinate.name for coordinate in self.coordinates)),
        )

    def tree_coordinates(self, tree: Tree) -> list[int]:
        """The coordinates of a tree's joints, from the base outwards."""
        return [n for k, _ in tree.steps for n in self.joints[k].coordinates]

    def limits(self, name: str, order: int = 0) -> tuple[float, float]:
        """Limits of a coordinate or cone angle, or of a derivative; infinite if none are given.
        Raises InputError.
        """
        self.holder(name)  # which refuses unknown names
        for limit in self.limited:
            if limit.coordinate == name and limit.order == order:
                return limit.low, limit.high
        return UNLIMITED

    def is_angle(self, name: str) -> bool:
        """Whether a coordinate or cone angle is one. Raises InputError."""
        return name in self.cones or self.coordinates[self.index(name, "coordinates")].angle

    def holder(self, name: str) -> int:
        """The joint that a coordinate or cone angle belongs to. Raises InputError."""
        if name in self.cones:
            return self.coordinates[self.cones[name].first].joint
        return self.coordinates[self.index(name, "limits")].joint

    def dimension(self, coordinate: int) -> Dimension:
        """ANGLE or LENGTH."""
        return ANGLE if self.coordinates[coordinate].angle else LENGTH

    @property
    def platform(self) -> int | None:
        """The number of the free joint that is the platform's pose, if there is a platform."""
        return next((k for k, joint in enumerate(self.joints) if joint.name == "platform"), None)

    def tree(
        self,
        first: Collection[int] = (),
        second: Collection[int] = (),
        last: Collection[int] = (),
    ) -> Tree:
        """The spanning tree that keeps joints `first` if possible, then joints `second`, and
        only if necessary joints `last` and those that have a twin.

        Otherwise it cuts the joints with most freedoms, since they close a loop with the fewest
        rows: spherical before revolute. Among equals it cuts passive before actuated joints,
        turns before slides, those between moving bodies, and those later in the file. In a chain of
        many loops this may make some that go all the way back to the base; if those that are on
        the fewest of the shortest loops are cut instead, each loop concerns its neighbours alone.
        """
        plain = self._spanning(first, second, last, {})
        length = total_length(self.joints, plain.steps)
        if length <= _SHORT * len(plain.cuts):
            return plain
        near = self._spanning(first, second, last, shared(edges_of(self.joints)))
        return near if _LONGER * total_length(self.joints, near.steps) < length else plain

    def _spanning(
        self,
        first: Collection[int],
        second: Collection[int],
        last: Collection[int],
        share: Mapping[int, int],
    ) -> Tree:
        """As `tree`; share: on how many of the shortest loops joints are, if that matters."""

        def order(k: int) -> tuple[bool, int, int, bool, bool, int, bool, int]:
            joint = self.joints[k]
            spare = k in last or k in self.twins
            rank = 0 if k in first else 1 if k in second else 3 if spare else 2
            slides = any(pair.slides for pair in joint.pairs)
            # A screw cannot be cut: its row would need to know how often it has turned.
            return (
                joint.kind != "helical",
                rank,
                len(joint.pairs),
                not joint.actuated,
                not slides,
                -share.get(k, 0),
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
        """The tree that contains the platform's pose, and so cuts the joints that carry it.

        A spherical joint in the tree would seem to lack a freedom at the end of its range.
        """
        if self.platform is None:
            return self.tree()
        return self.tree(first=[self.twins.get(self.platform, self.platform)])

    def tree_of(self, kept: Sequence[int]) -> Tree:
        """The tree that consists of these joints, from the base outwards."""
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
        """The graph with a twin of a joint of three turns, whose angles are 0 at `R_FM`.

        Three angles are not defined everywhere; the twin's are, near that orientation. The twin
        is a free joint, closes nothing, and replaces the other in trees; its coordinates come
        after all others.
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
        named = tuple(
            Coordinate(f"{twin.name}.{k}", len(self.joints), not pair.slides, False)
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
        """The graph without twins."""
        if not self.twins:
            return self
        joints = self.joints[: -len(self.twins)]
        count = sum(len(joint.pairs) for joint in joints)
        return replace(self, joints=joints, coordinates=self.coordinates[:count], twins={})

    def split(self, number: int) -> Graph:
        """The graph with a joint of several freedoms split into a chain of single ones.

        Coordinates keep their numbers and names.
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
            F = joint.F if i == 0 else IDENTITY_POSE
            M = last if i == len(joint.pairs) - 1 else IDENTITY_POSE
            k = joint.first + i
            single = GraphJoint(
                coordinates[k].name,
                "prismatic" if pair.slides else "revolute",
                along[i],
                along[i + 1],
                Pose(snapped(F.R @ onto), F.p),
                Pose(snapped(M.R @ onto), M.p),
                (pair._replace(axis=2),),
                IDENTITY,
                k,
                coordinates[k].actuated,
            )
            place = number if i == 0 else len(joints)
            joints[place : place + 1] = [single]
            coordinates[k] = coordinates[k]._replace(joint=place)
        return replace(
            self,
            bodies=bodies,
            joints=tuple(joints),
            coordinates=tuple(coordinates),
            splits=(*self.splits, number),
        )
