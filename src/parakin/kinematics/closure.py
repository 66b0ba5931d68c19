"""Closure rows: what a joint left out of the tree demands of the two bodies it joins.

A row is a scalar that vanishes when the loop is closed. Each kind is a value with its own
`value`, `derivative` by a coordinate, `rate` (a row of eq. 10), `acceleration`, and `wrench`. Gaps
and distances say the same thing in different directions; which of them are solved is a matter of
cost (`parakin.planning`), what is reported is always the canonical set.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import ClassVar, Literal, NamedTuple, Protocol

from parakin.algebra.spatial import ZERO, Scalar, Vector, add, cross, dot, mul, sub
from parakin.kinematics.loops import Ends, gap_acceleration, gap_velocity
from parakin.kinematics.recursion import Axis, Circuits, pair_velocity
from parakin.model.graph import Graph, Tree
from parakin.model.joints import GraphJoint

AxisOf = Callable[[int], Axis]  # of a coordinate


class Wrench(NamedTuple):
    """What a row's rate is on the closed loop: moment . w + force . v, where w and v are the
    child's angular velocity and velocity at the base's origin, less the parent's.
    """

    moment: Vector
    force: Vector

    def plus(self, other: Wrench) -> Wrench:
        """Both together."""
        return Wrench(self.moment + other.moment, self.force + other.force)

    def times(self, factor: Scalar) -> Wrench:
        """So many times as much."""
        return Wrench(self.moment * factor, self.force * factor)


class Row(Protocol):
    """One scalar equation of the joint `cut`, of which `end` are the two ends."""

    quadratic: ClassVar[bool]  # in the coordinate of a slide; else linear

    @property
    def cut(self) -> int:
        """The joint."""

    def per_length(self, graph: Graph) -> float:
        """What turns the value into metres; a cosine counts at the characteristic length."""

    def value(self, circuits: Circuits, end: Ends) -> Scalar:
        """What vanishes on the closed loop."""

    def derivative(
        self, circuits: Circuits, end: Ends, coordinate: int, side: float, *, open_: bool = False
    ) -> Scalar:
        """By a coordinate on one side of the loop (+1: the child's), on the closed loop; with
        `open_` on an open one too, whose gap counts where the row's direction turns.
        """

    def rate(self, circuits: Circuits, end: Ends) -> Scalar:
        """The time derivative from the bodies' twists, on the closed loop (eq. 10)."""

    def acceleration(self, circuits: Circuits, end: Ends) -> Scalar:
        """The second time derivative from the bodies' accelerations, on the closed loop."""

    def wrench(self, end: Ends, axis_of: AxisOf) -> Wrench:
        """The rate as a function of the twists, given where the axes of coordinates are."""


@dataclass(frozen=True)
class FrameAxis:
    """An axis of the joint's frame on its parent (F) or on its child (M), or of the base (W)."""

    frame: Literal["F", "M", "W"]
    axis: int

    def direction(self, end: Ends, axis_of: AxisOf) -> Vector:  # noqa: ARG002
        """In base components."""
        if self.frame == "W":
            return Vector((float(self.axis == 0), float(self.axis == 1), float(self.axis == 2)))
        return (end.X_WF if self.frame == "F" else end.X_WM).R.column(self.axis)

    def turns(self, circuits: Circuits, end: Ends, coordinate: int, side: float) -> bool:  # noqa: ARG002
        """Whether it turns with a coordinate of the loop."""
        return (self.frame, side) in (("F", -1.0), ("M", 1.0))


@dataclass(frozen=True)
class PairAxis:
    """The axis of a coordinate of the loop."""

    coordinate: int

    def direction(self, end: Ends, axis_of: AxisOf) -> Vector:  # noqa: ARG002
        """In base components."""
        return axis_of(self.coordinate).direction

    def turns(self, circuits: Circuits, end: Ends, coordinate: int, side: float) -> bool:
        """Whether it turns with a coordinate of the loop."""
        return _precedes(circuits, end, side, coordinate, self.coordinate)


@dataclass(frozen=True)
class Gap:
    """The gap between the joint's points along an axis [m]. Of a joint that slides across the axis
    the gap is not zero when the loop is closed, and counts where the axis turns.
    """

    cut: int
    along: FrameAxis | PairAxis
    slides: bool = False
    quadratic: ClassVar[bool] = False

    def direction(self, circuits: Circuits, end: Ends) -> Vector:
        """In which the row measures."""
        return self.along.direction(end, partial(axis_on_loop, circuits, end))

    def per_length(self, graph: Graph) -> float:  # noqa: ARG002
        return 1.0

    def value(self, circuits: Circuits, end: Ends) -> Scalar:
        return dot(self.direction(circuits, end), end.d)

    def derivative(
        self, circuits: Circuits, end: Ends, coordinate: int, side: float, *, open_: bool = False
    ) -> Scalar:
        u = self.direction(circuits, end)
        w, v = _unit_twist(circuits, end, coordinate, side, _own_point(end, side))
        slope = dot(u, v)
        if (open_ or self.slides) and self.along.turns(circuits, end, coordinate, side):
            # (w is minus the rate at which F turns with the parent.)
            slope = add(slope, mul(side, dot(cross(w, u), end.d)))
        return slope

    def rate(self, circuits: Circuits, end: Ends) -> Scalar:
        u = self.direction(circuits, end)
        if self.slides:
            return slide_rate(circuits, u, end)
        return dot(u, gap_velocity(circuits, end))

    def acceleration(self, circuits: Circuits, end: Ends) -> Scalar:
        u = self.direction(circuits, end)
        if self.slides:
            return slide_acceleration(circuits, u, end)
        return dot(u, gap_acceleration(circuits, end))

    def wrench(self, end: Ends, axis_of: AxisOf) -> Wrench:
        u = self.along.direction(end, axis_of)
        # At M: where the gap is not zero, F turns with the parent just as that carries M's place.
        return Wrench(cross(end.X_WM.p, u), u)


def slide_rate(circuits: Circuits, u: Vector, end: Ends) -> Scalar:
    """The rate of the gap along a direction that turns with the parent."""
    swing = cross(circuits.twist(end.parent).w, u)
    return add(dot(u, gap_velocity(circuits, end)), dot(swing, end.d))


def slide_acceleration(circuits: Circuits, u: Vector, end: Ends) -> Scalar:
    """The second derivative of the gap along a direction that turns with the parent."""
    w_WP, alpha_WP = circuits.twist(end.parent).w, circuits.accel(end.parent).alpha
    swing = cross(w_WP, u)
    swung = cross(alpha_WP, u) + cross(w_WP, swing)
    along = dot(u, gap_acceleration(circuits, end))
    coriolis = mul(2.0, dot(swing, gap_velocity(circuits, end)))
    return add(along, add(dot(swung, end.d), coriolis))


@dataclass(frozen=True)
class CentreDistance:
    """Half the difference of the squared distances of the joint's two points from a point on the
    axis of a coordinate of the loop [m²]. What turns about that point does not change it.
    """

    cut: int
    coordinate: int
    quadratic: ClassVar[bool] = True

    def per_length(self, graph: Graph) -> float:  # noqa: ARG002
        return 1.0

    def arm(
        self, circuits: Circuits, end: Ends, coordinate: int, side: float
    ) -> tuple[Vector, float, Vector]:
        """How the row sees a coordinate: the arm, the sign of its square in the row, and the point
        that the coordinate moves.

        It moves the joint's point on its own side about a fixed centre or, where the centre is
        beyond it on that side, the centre, and with it the arm to the point opposite.
        """
        centre = axis_on_loop(circuits, end, self.coordinate).point
        carried = _precedes(circuits, end, side, coordinate, self.coordinate)
        sign = -side if carried else side
        arm = _own_point(end, sign) - centre
        return arm, sign, centre if carried else _own_point(end, side)

    def _to_gap(self, end: Ends, axis_of: AxisOf) -> Vector:
        """From the centre to the middle of the gap."""
        return 0.5 * (end.X_WM.p + end.X_WF.p) - axis_of(self.coordinate).point

    def value(self, circuits: Circuits, end: Ends) -> Scalar:
        centre = axis_on_loop(circuits, end, self.coordinate).point
        ahead, behind = end.X_WM.p - centre, end.X_WF.p - centre
        return mul(0.5, sub(dot(ahead, ahead), dot(behind, behind)))

    def derivative(
        self, circuits: Circuits, end: Ends, coordinate: int, side: float, *, open_: bool = False
    ) -> Scalar:
        del open_  # exact on open loops in any case
        return _arm_derivative(self, circuits, end, coordinate, side)

    def rate(self, circuits: Circuits, end: Ends) -> Scalar:
        u = self._to_gap(end, partial(axis_on_loop, circuits, end))
        return dot(u, gap_velocity(circuits, end))

    def acceleration(self, circuits: Circuits, end: Ends) -> Scalar:
        u = self._to_gap(end, partial(axis_on_loop, circuits, end))
        return dot(u, gap_acceleration(circuits, end))

    def wrench(self, end: Ends, axis_of: AxisOf) -> Wrench:
        u = self._to_gap(end, axis_of)
        return Wrench(cross(end.X_WM.p, u), u)


@dataclass(frozen=True)
class RodLength:
    """Half of what the square of the gap differs from the square of a rod's length [m²]."""

    cut: int
    quadratic: ClassVar[bool] = True

    def per_length(self, graph: Graph) -> float:
        return 1.0 / graph.joints[self.cut].length

    def arm(
        self,
        circuits: Circuits,  # noqa: ARG002
        end: Ends,
        coordinate: int,  # noqa: ARG002
        side: float,
    ) -> tuple[Vector, float, Vector]:
        """As of `CentreDistance`: the arm is the rod."""
        return end.d, 1.0, _own_point(end, side)

    def value(self, circuits: Circuits, end: Ends) -> Scalar:
        length = circuits.graph.joints[self.cut].length
        return mul(0.5, sub(dot(end.d, end.d), length * length))

    def derivative(
        self, circuits: Circuits, end: Ends, coordinate: int, side: float, *, open_: bool = False
    ) -> Scalar:
        del open_  # exact on open loops in any case
        return _arm_derivative(self, circuits, end, coordinate, side)

    def rate(self, circuits: Circuits, end: Ends) -> Scalar:
        return dot(end.d, gap_velocity(circuits, end))

    def acceleration(self, circuits: Circuits, end: Ends) -> Scalar:
        v = gap_velocity(circuits, end)
        return add(dot(end.d, gap_acceleration(circuits, end)), dot(v, v))

    def wrench(self, end: Ends, axis_of: AxisOf) -> Wrench:  # noqa: ARG002
        return Wrench(cross(end.X_WM.p, end.d), end.d)


Distance = CentreDistance | RodLength


@dataclass(frozen=True)
class Perpendicular:
    """The cosine between axis `a` of F and axis `b` of M, which must stay perpendicular."""

    cut: int
    a: int
    b: int
    quadratic: ClassVar[bool] = False

    def per_length(self, graph: Graph) -> float:
        return graph.length

    def value(self, circuits: Circuits, end: Ends) -> Scalar:  # noqa: ARG002
        return dot(end.X_WF.R.column(self.a), end.X_WM.R.column(self.b))

    def _across(self, end: Ends) -> Vector:
        return cross(end.X_WM.R.column(self.b), end.X_WF.R.column(self.a))

    def derivative(
        self, circuits: Circuits, end: Ends, coordinate: int, side: float, *, open_: bool = False
    ) -> Scalar:
        del open_  # exact on open loops in any case
        w, _ = _unit_twist(circuits, end, coordinate, side, end.X_WF.p)
        return dot(w, self._across(end))

    def rate(self, circuits: Circuits, end: Ends) -> Scalar:
        w = circuits.twist(end.child).w - circuits.twist(end.parent).w
        return dot(w, self._across(end))

    def acceleration(self, circuits: Circuits, end: Ends) -> Scalar:
        w_WP, w_WC = circuits.twist(end.parent).w, circuits.twist(end.child).w
        alpha = circuits.accel(end.child).alpha - circuits.accel(end.parent).alpha
        u, v = end.X_WF.R.column(self.a), end.X_WM.R.column(self.b)
        turning = cross(cross(w_WC, v), u) + cross(v, cross(w_WP, u))
        return add(dot(alpha, cross(v, u)), dot(w_WC - w_WP, turning))

    def wrench(self, end: Ends, axis_of: AxisOf) -> Wrench:  # noqa: ARG002
        return Wrench(self._across(end), ZERO)


def axis_on_loop(circuits: Circuits, end: Ends, coordinate: int) -> Axis:
    """The axis of a coordinate of the loop."""
    side = end.child if coordinate in circuits.path[end.child] else end.parent
    return circuits.axes(side)[coordinate][0]


def _own_point(end: Ends, side: float) -> Vector:
    """The joint's point on one side of the loop."""
    return end.X_WM.p if side > 0 else end.X_WF.p


def _unit_twist(
    circuits: Circuits, end: Ends, coordinate: int, side: float, point: Vector
) -> tuple[Vector, Vector]:
    """What one unit of a coordinate's rate gives the child relative to the parent: (w, v at
    `point`).
    """
    axis, sign = circuits.axes(end.child if side > 0 else end.parent)[coordinate]
    return pair_velocity(axis, sign * side, point)


def _precedes(circuits: Circuits, end: Ends, side: float, first: int, second: int) -> bool:
    """Whether two coordinates are on this side of the loop, in this order from the base."""
    path = circuits.path[end.child if side > 0 else end.parent]
    return second in path and path.index(first) < path.index(second)


def _arm_derivative(
    row: Distance, circuits: Circuits, end: Ends, coordinate: int, side: float
) -> Scalar:
    arm, _, moved = row.arm(circuits, end, coordinate, side)
    return dot(arm, _unit_twist(circuits, end, coordinate, side, moved)[1])


_POINT = (0, 1, 2)  # axes of F along which there is no gap
_AXIS = ((0, 2), (1, 2))  # axes of F and M that are perpendicular
_TURNLESS = ((0, 1), (1, 2), (2, 0))
_CANONICAL: dict[str, tuple[tuple[int, ...], tuple[tuple[int, int], ...]]] = {
    "revolute": (_POINT, _AXIS),
    "prismatic": ((0, 1), _TURNLESS),
    "cylindrical": ((0, 1), _AXIS),
    "universal": (_POINT, ((2, 2),)),
    "spherical": (_POINT, ()),
    "fixed": (_POINT, _TURNLESS),
    "planar": ((2,), _AXIS),
}


def canonical_rows(joint: GraphJoint, cut: int) -> list[Row]:
    """All rows of a cut joint: six less its freedom."""
    if joint.kind == "rod":
        return [RodLength(cut)]
    gaps, axes = _CANONICAL.get(joint.kind, ((), ()))
    rows: list[Row] = [Gap(cut, FrameAxis("F", axis), gaps != _POINT) for axis in gaps]
    return rows + [Perpendicular(cut, a, b) for a, b in axes]


def candidate_rows(graph: Graph, cut: int, on_loop: list[int]) -> list[Row]:
    """The canonical rows of a cut joint, and all that say the same in other directions."""
    joint = graph.joints[cut]
    rows = canonical_rows(joint, cut)
    if _CANONICAL.get(joint.kind, ((), ()))[0] == _POINT:
        rows += [Gap(cut, FrameAxis("M", axis)) for axis in range(3)]
        rows += [Gap(cut, FrameAxis("W", axis)) for axis in range(3)]
        rows += [Gap(cut, PairAxis(k)) for k in on_loop]
        rows += [CentreDistance(cut, k) for k in on_loop if graph.coordinates[k].angle]
    return rows


def all_rows(graph: Graph, tree: Tree) -> list[Row]:
    """The canonical rows of all joints that a tree leaves out."""
    return [row for cut in tree.cuts for row in canonical_rows(graph.joints[cut], cut)]


_FACING = {  # axes of the two bodies that must not only be parallel, but point the same way
    "revolute": (2,),
    "cylindrical": (2,),
    "planar": (2,),
    "prismatic": (0, 1, 2),
    "fixed": (0, 1, 2),
}


def cosines(circuits: Circuits, cut: int, end: Ends) -> list[Scalar]:
    """Between axes of a cut joint that have to point the same way: 1 where they do."""
    axes = _FACING.get(circuits.graph.joints[cut].kind, ())
    return [dot(end.X_WF.R.column(a), end.X_WM.R.column(a)) for a in axes]
