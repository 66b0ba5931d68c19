"""The paper's recursion: from body to body along a circuit, poses, then velocities, accelerations.

Each function here is one step, from a body whose motion is known across one joint to the next
(eqs. 1, 8 and 9 and their derivatives), in base components. Written once, it serves floats,
NumPy arrays and expressions to be compiled. A joint walked against its direction is the same
step with its frames exchanged, its pairs reversed and its coordinates negated.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from parakin.algebra.dual import dual
from parakin.algebra.spatial import (
    IDENTITY,
    ZERO,
    Functions,
    Matrix,
    Scalar,
    Vector,
    apply,
    column,
    compose,
    cross,
    minus,
    mul,
    plus,
    times,
    transpose,
    turned,
)
from parakin.model.graph import Graph, Tree
from parakin.model.joints import GraphJoint, Pair


class Pose(NamedTuple):
    """R_WB (columns are the body's axes) and p_WB, the body's origin, in base components."""

    R: Matrix
    p: Vector


class Twist(NamedTuple):
    """w_WB and v_WB, the velocity of the body's origin."""

    w: Vector
    v: Vector


class Accel(NamedTuple):
    """alpha_WB and a_WB, the acceleration of the body's origin."""

    alpha: Vector
    a: Vector


class Axis(NamedTuple):
    """A pair as it stands in space: direction (along increasing coordinate) and a point on it."""

    slides: bool
    direction: Vector
    point: Vector
    pitch: float = 0.0


AT_REST = Twist(ZERO, ZERO)
UNACCELERATED = Accel(ZERO, ZERO)
BASE = Pose(IDENTITY, ZERO)


class Turn(NamedTuple):
    """A coordinate as the recursion needs it: its value (of a slide) or cosine and sine."""

    value: Scalar
    cosine: Scalar
    sine: Scalar


def slide(value: Scalar) -> Turn:
    return Turn(value, 1.0, 0.0)


def turn(value: Scalar, functions: Functions) -> Turn:
    if type(value) is float and value == 0.0:
        return Turn(0.0, 1.0, 0.0)
    return Turn(value, functions.cos(value), functions.sin(value))


def _in_motion(at: Turn, rate: Scalar) -> Turn:
    value = None if at.value is None else dual(at.value, rate)
    # (Of a slide only the value counts.)
    return Turn(
        value,
        dual(at.cosine, mul(-1.0, mul(at.sine, rate))),
        dual(at.sine, mul(at.cosine, rate)),
    )


def _order(joint: GraphJoint, reverse: bool) -> list[tuple[int, Pair]]:
    numbered = list(zip(joint.coordinates, joint.pairs, strict=True))
    return numbered[::-1] if reverse else numbered


def step_pose(
    near: Pose, joint: GraphJoint, reverse: bool, turns: Mapping[int, Turn]
) -> tuple[Pose, dict[int, Axis]]:
    """The pose of the body across `joint`, and the joint's axes on the way."""
    start, end = (joint.M, joint.F) if reverse else (joint.F, joint.M)
    R = compose(near.R, start.R)
    p = plus(near.p, apply(near.R, start.p))
    if reverse:
        R = compose(R, transpose(joint.tail))
    axes: dict[int, Axis] = {}
    sign = -1.0 if reverse else 1.0
    for k, pair in _order(joint, reverse):
        direction = column(R, pair.axis)
        axes[k] = Axis(pair.slides, direction, p, pair.pitch)
        if pair.slides:
            p = plus(p, times(mul(sign, turns[k].value), direction))
        else:
            if pair.pitch:
                p = plus(p, times(mul(sign * pair.pitch, turns[k].value), direction))
            R = turned(R, pair.axis, turns[k].cosine, mul(sign, turns[k].sine))
    if not reverse:
        R = compose(R, joint.tail)
    R = compose(R, transpose(end.R))
    return Pose(R, minus(p, apply(R, end.p))), axes


def step_twist(
    twist: Twist,
    near: Pose,
    far: Pose,
    joint: GraphJoint,
    reverse: bool,
    axes: Mapping[int, Axis],
    rates: Mapping[int, Scalar],
) -> Twist:
    """The velocities across a joint: each pair adds its own rate along its axis (eq. 9)."""
    sign = -1.0 if reverse else 1.0
    w, v, at = twist.w, twist.v, near.p
    for k, pair in _order(joint, reverse):
        axis = axes[k]
        v, at = plus(v, cross(w, minus(axis.point, at))), axis.point
        along = times(mul(sign, rates[k]), axis.direction)
        if pair.slides:
            v = plus(v, along)
        else:
            w, v = plus(w, along), plus(v, times(pair.pitch, along))
    return Twist(w, plus(v, cross(w, minus(far.p, at))))


def step_accel(
    accel: Accel,
    twist: Twist,
    near: Pose,
    far: Pose,
    joint: GraphJoint,
    reverse: bool,
    axes: Mapping[int, Axis],
    rates: Mapping[int, Scalar],
    second: Mapping[int, Scalar],
) -> Accel:
    """The accelerations across a joint: the derivative of `step_twist`.

    A slide contributes the Coriolis term 2 w x (a qd), a turn w x (a qd).
    """
    sign = -1.0 if reverse else 1.0
    alpha, a = accel
    w, at = twist.w, near.p

    def carried(to: Vector) -> Vector:
        r = minus(to, at)
        return plus(a, plus(cross(alpha, r), cross(w, cross(w, r))))

    for k, pair in _order(joint, reverse):
        axis = axes[k]
        a, at = carried(axis.point), axis.point
        rate = times(mul(sign, rates[k]), axis.direction)
        along = times(mul(sign, second[k]), axis.direction)
        turning = cross(w, rate)
        if pair.slides:
            a = plus(a, plus(along, times(2.0, turning)))
        else:
            alpha = plus(alpha, plus(along, turning))
            a = plus(a, times(pair.pitch, plus(along, times(2.0, turning))))
            w = plus(w, rate)
    return Accel(alpha, carried(far.p))


class Circuits:
    """Every body's motion along the tree, worked out when asked for and then kept.

    `turns`, `rates` and `second` hold the coordinates of the tree's joints, and may still grow:
    a body can be asked for once those on its path are there. `varied` makes a copy in which
    some coordinates differ, sharing all that does not depend on them.
    """

    def __init__(self, graph: Graph, tree: Tree) -> None:
        self.graph = graph
        self.turns: dict[int, Turn] = {}
        self.rates: dict[int, Scalar] = {}
        self.second: dict[int, Scalar] = {}
        self.path: dict[int, tuple[int, ...]] = {0: ()}  # coordinates from base to body
        self._steps: dict[int, tuple[int, int, bool]] = {}
        for k, reverse in tree.steps:
            joint = graph.joints[k]
            near, far = (joint.child, joint.parent) if reverse else (joint.parent, joint.child)
            self._steps[far] = (near, k, reverse)
            walked = [number for number, _ in _order(joint, reverse)]
            self.path[far] = (*self.path[near], *walked)
        self._poses: dict[int, tuple[Pose, dict[int, Axis]]] = {0: (BASE, {})}
        self._twists: dict[int, Twist] = {0: AT_REST}
        self._accels: dict[int, Accel] = {0: UNACCELERATED}

    def varied(
        self,
        turns: Mapping[int, Turn] | None = None,
        rates: Mapping[int, Scalar] | None = None,
        second: Mapping[int, Scalar] | None = None,
    ) -> Circuits:
        """A copy with these coordinates changed; what does not depend on them is shared."""
        other = object.__new__(Circuits)
        other.graph, other.path, other._steps = self.graph, self.path, self._steps
        other.turns = {**self.turns, **(turns or {})}
        other.rates = {**self.rates, **(rates or {})}
        other.second = {**self.second, **(second or {})}
        moved = set(turns or ())
        faster = moved | set(rates or ())
        changed = faster | set(second or ())
        other._poses = {b: x for b, x in self._poses.items() if moved.isdisjoint(self.path[b])}
        other._twists = {b: x for b, x in self._twists.items() if faster.isdisjoint(self.path[b])}
        other._accels = {b: x for b, x in self._accels.items() if changed.isdisjoint(self.path[b])}
        return other

    def set_rates(
        self, rates: Mapping[int, Scalar] | None = None, second: Mapping[int, Scalar] | None = None
    ) -> None:
        """Set rates or accelerations, forgetting what was worked out with others."""
        self.rates |= rates or {}
        self.second |= second or {}
        for kept, changed in (
            (self._twists, rates),
            (self._accels, {**(rates or {}), **(second or {})}),
        ):
            for body in [b for b in kept if not set(changed or ()).isdisjoint(self.path[b])]:
                del kept[body]

    def with_jerk(self, third: Mapping[int, Scalar]) -> Circuits:
        """The same motion with the rate of everything beside it, given the coordinates' jerks."""
        return self.varied(
            {k: _in_motion(turn, self.rates[k]) for k, turn in self.turns.items()},
            {k: dual(rate, self.second[k]) for k, rate in self.rates.items()},
            {k: dual(rate, third[k]) for k, rate in self.second.items()},
        )

    def pose(self, body: int) -> Pose:
        return self._pose(body)[0]

    def _pose(self, body: int) -> tuple[Pose, dict[int, Axis]]:
        if body not in self._poses:
            near, k, reverse = self._steps[body]
            joint = self.graph.joints[k]
            self._poses[body] = step_pose(self.pose(near), joint, reverse, self.turns)
        return self._poses[body]

    def twist(self, body: int) -> Twist:
        if body not in self._twists:
            near, k, reverse = self._steps[body]
            far, axes = self._pose(body)
            joint = self.graph.joints[k]
            self._twists[body] = step_twist(
                self.twist(near), self.pose(near), far, joint, reverse, axes, self.rates
            )
        return self._twists[body]

    def accel(self, body: int) -> Accel:
        if body not in self._accels:
            near, k, reverse = self._steps[body]
            far, axes = self._pose(body)
            joint = self.graph.joints[k]
            self._accels[body] = step_accel(
                self.accel(near),
                self.twist(near),
                self.pose(near),
                far,
                joint,
                reverse,
                axes,
                self.rates,
                self.second,
            )
        return self._accels[body]

    def axes(self, body: int) -> dict[int, tuple[Axis, float]]:
        """Every pair between base and body: its axis, and -1 where the tree walks it backwards."""
        found: dict[int, tuple[Axis, float]] = {}
        while body in self._steps:
            near, _, reverse = self._steps[body]
            for k, axis in self._pose(body)[1].items():
                found[k] = (axis, -1.0 if reverse else 1.0)
            body = near
        return found


def point_velocity(pose: Pose, twist: Twist, point: Vector) -> Vector:
    """Velocity of a point of the body, given in base components."""
    return plus(twist.v, cross(twist.w, minus(point, pose.p)))


def point_acceleration(pose: Pose, twist: Twist, accel: Accel, point: Vector) -> Vector:
    r = minus(point, pose.p)
    return plus(accel.a, plus(cross(accel.alpha, r), cross(twist.w, cross(twist.w, r))))


def pair_velocity(axis: Axis, sign: float, point: Vector) -> tuple[Vector, Vector]:
    """What one unit of a pair's rate gives the bodies beyond it: (w, v at `point`)."""
    direction = times(sign, axis.direction)
    if axis.slides:
        return ZERO, direction
    around = cross(direction, minus(point, axis.point))
    return direction, plus(around, times(axis.pitch, direction))
