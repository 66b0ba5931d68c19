"""The paper's recursion: from body to body along a circuit, poses, then velocities, accelerations.

Each function here is one step, from a body whose motion is known across one joint to the next
(positions by eqs. 1, 7 and 8, velocities by eq. 9, accelerations by its derivative), in base
components. Written once, it serves floats, NumPy arrays and expressions to be compiled. A joint
passed against its direction is the same step with its frames exchanged, its pairs reversed and its
coordinates negated.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import NamedTuple

from parakin.algebra.dual import dual
from parakin.algebra.spatial import (
    IDENTITY_POSE,
    ZERO,
    Functions,
    Matrix,
    Pose,
    Scalar,
    Vector,
    cross,
    mul,
    turned,
)
from parakin.model.graph import Graph, Tree
from parakin.model.joints import GraphJoint, Pair


class Twist(NamedTuple):
    """V_WB: w_WB and v_WB, the velocity of the body's origin."""

    w: Vector
    v: Vector


class Accel(NamedTuple):
    """A_WB: alpha_WB and a_WB, the acceleration of the body's origin."""

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


class Turn(NamedTuple):
    """A coordinate as the recursion needs it: cosine and sine, or, of a slide or screw, its value;
    None where only cosine and sine have been found.
    """

    value: Scalar | None
    cosine: Scalar
    sine: Scalar

    @property
    def amount(self) -> Scalar:
        """The value."""
        assert self.value is not None
        return self.value


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


def _advances(pair: Pair) -> bool:
    """Whether a turn is that of a screw: not so if the pitch is a literal zero, as of a hinge."""
    return not (type(pair.pitch) is float and pair.pitch == 0.0)


def step_pose(
    X_WP: Pose, joint: GraphJoint, reverse: bool, turns: Mapping[int, Turn]
) -> tuple[Pose, dict[int, Axis]]:
    """X_WB of the body across `joint` from P (eqs. 1, 7 and 8), and the joint's axes on the way."""
    X_PF, X_BM = (joint.M, joint.F) if reverse else (joint.F, joint.M)
    R: Matrix
    p: Vector
    R, p = X_WP @ X_PF
    if reverse:
        R = R @ joint.tail.T
    axes: dict[int, Axis] = {}
    sign = -1.0 if reverse else 1.0
    for k, pair in _order(joint, reverse):
        u = R.column(pair.axis)
        axes[k] = Axis(pair.slides, u, p, pair.pitch)
        q = turns[k]
        if pair.slides:
            p += u * mul(sign, q.amount)
        else:
            if _advances(pair):
                p += u * mul(sign, mul(pair.pitch, q.amount))
            R = turned(R, pair.axis, q.cosine, mul(sign, q.sine))
    if not reverse:
        R = R @ joint.tail
    R_WB = R @ X_BM.R.T
    return Pose(R_WB, p - R_WB @ X_BM.p), axes


def step_twist(
    V_WP: Twist,
    p_WP: Vector,
    p_WB: Vector,
    joint: GraphJoint,
    reverse: bool,
    axes: Mapping[int, Axis],
    rates: Mapping[int, Scalar],
) -> Twist:
    """V_WB across a joint from P: each pair adds its own rate along its axis (eq. 9)."""
    sign = -1.0 if reverse else 1.0
    (w, v), at = V_WP, p_WP
    for k, pair in _order(joint, reverse):
        axis = axes[k]
        v, at = v + cross(w, axis.point - at), axis.point
        u_qd = axis.direction * mul(sign, rates[k])
        if pair.slides:
            v += u_qd
        else:
            w, v = w + u_qd, v + u_qd * pair.pitch
    return Twist(w, v + cross(w, p_WB - at))


def step_accel(
    A_WP: Accel,
    V_WP: Twist,
    p_WP: Vector,
    p_WB: Vector,
    joint: GraphJoint,
    reverse: bool,
    axes: Mapping[int, Axis],
    rates: Mapping[int, Scalar],
    second: Mapping[int, Scalar],
) -> Accel:
    """A_WB across a joint from P: the derivative of `step_twist`.

    A slide contributes the Coriolis term 2 w x (u qd), a turn w x (u qd).
    """
    sign = -1.0 if reverse else 1.0
    (alpha, a), w, at = A_WP, V_WP.w, p_WP
    for k, pair in _order(joint, reverse):
        axis = axes[k]
        a, at = _carried(a, alpha, w, axis.point - at), axis.point
        u_qd = axis.direction * mul(sign, rates[k])
        u_qdd = axis.direction * mul(sign, second[k])
        if pair.slides:
            a += u_qdd + 2.0 * cross(w, u_qd)
        else:
            alpha += u_qdd + cross(w, u_qd)
            a += (u_qdd + 2.0 * cross(w, u_qd)) * pair.pitch
            w += u_qd
    return Accel(alpha, _carried(a, alpha, w, p_WB - at))


def _carried(a: Vector, alpha: Vector, w: Vector, r: Vector) -> Vector:
    """The acceleration of a point at `r` from another of the same body."""
    return a + (cross(alpha, r) + cross(w, cross(w, r)))


class Circuits:
    """Every body's motion along the tree, worked out when asked for and then kept.

    `turns`, `rates` and `second` hold the coordinates of the tree's joints, and may still grow:
    a body can be asked for once those on its path are there. `with_coordinates` makes a copy in
    which some differ, sharing all that does not depend on them.
    """

    def __init__(self, graph: Graph, tree: Tree) -> None:
        self.graph = graph
        self.turns: dict[int, Turn] = {}
        self.rates: dict[int, Scalar] = {}
        self.second: dict[int, Scalar] = {}
        self.path: dict[int, tuple[int, ...]] = {0: ()}  # coordinates from base to body
        self.coordinates = graph.tree_coordinates(tree)
        self.sides: dict[int, dict[int, float]] = {}  # by cut joint, kept by `loops.sides`
        self._steps: dict[int, tuple[int, int, bool]] = {}
        for k, reverse in tree.steps:
            joint = graph.joints[k]
            near, far = (joint.child, joint.parent) if reverse else (joint.parent, joint.child)
            self._steps[far] = (near, k, reverse)
            walked = [number for number, _ in _order(joint, reverse)]
            self.path[far] = (*self.path[near], *walked)
        self._poses: dict[int, tuple[Pose, dict[int, Axis]]] = {0: (IDENTITY_POSE, {})}
        self._twists: dict[int, Twist] = {0: AT_REST}
        self._accels: dict[int, Accel] = {0: UNACCELERATED}
        self._axes: dict[int, dict[int, tuple[Axis, float]]] = {0: {}}

    def with_coordinates(
        self,
        turns: Mapping[int, Turn] | None = None,
        rates: Mapping[int, Scalar] | None = None,
        second: Mapping[int, Scalar] | None = None,
    ) -> Circuits:
        """A copy with these coordinates changed; what does not depend on them is shared."""
        other = object.__new__(Circuits)
        other.graph, other.path, other._steps = self.graph, self.path, self._steps
        other.coordinates, other.sides = self.coordinates, self.sides
        other.turns = {**self.turns, **(turns or {})}
        other.rates = {**self.rates, **(rates or {})}
        other.second = {**self.second, **(second or {})}
        moved = {k for k in turns or () if k in self.turns}  # nothing can depend on any other yet
        faster = moved | set(rates or ())
        changed = faster | set(second or ())
        beyond = self._beyond(moved)
        other._poses = {b: x for b, x in self._poses.items() if b not in beyond}
        other._axes = {b: x for b, x in self._axes.items() if b not in beyond}
        beyond = self._beyond(faster)
        other._twists = {b: x for b, x in self._twists.items() if b not in beyond}
        beyond = self._beyond(changed)
        other._accels = {b: x for b, x in self._accels.items() if b not in beyond}
        return other

    def _beyond(self, coordinates: Collection[int]) -> set[int]:
        """The bodies that some of these coordinates carry."""
        joints = {self.graph.coordinates[k].joint for k in coordinates}
        found: set[int] = set()
        if joints:
            for far, (near, k, _) in self._steps.items():  # from the base outwards
                if near in found or k in joints:
                    found.add(far)
        return found

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
            beyond = self._beyond(changed or ())
            for body in [b for b in kept if b in beyond]:
                del kept[body]

    def with_jerk(self, third: Mapping[int, Scalar]) -> Circuits:
        """The same motion on dual numbers that carry every rate, given the coordinates' jerks."""
        return self.with_coordinates(
            {k: _in_motion(turn, self.rates[k]) for k, turn in self.turns.items()},
            {k: dual(rate, self.second[k]) for k, rate in self.rates.items()},
            {k: dual(rate, third[k]) for k, rate in self.second.items()},
        )

    def place(self) -> None:
        """Work out all poses that the coordinates at hand determine, for copies to share."""
        for body, (near, k, _) in self._steps.items():  # from the base outwards
            known = near in self._poses and body not in self._poses
            if known and all(n in self.turns for n in self.graph.joints[k].coordinates):
                self._pose(body)

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
                self.twist(near), self.pose(near).p, far.p, joint, reverse, axes, self.rates
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
                self.pose(near).p,
                far.p,
                joint,
                reverse,
                axes,
                self.rates,
                self.second,
            )
        return self._accels[body]

    def axes(self, body: int) -> dict[int, tuple[Axis, float]]:
        """Every pair between base and body: its axis, and -1 where the tree walks it backwards."""
        if body not in self._axes:
            near, _, reverse = self._steps[body]
            sign = -1.0 if reverse else 1.0
            here = {k: (axis, sign) for k, axis in self._pose(body)[1].items()}
            self._axes[body] = {**here, **self.axes(near)}
        return self._axes[body]


def point_velocity(X_WB: Pose, V_WB: Twist, point: Vector) -> Vector:
    """Velocity of a point of the body, given in base components."""
    return V_WB.v + cross(V_WB.w, point - X_WB.p)


def point_acceleration(X_WB: Pose, V_WB: Twist, A_WB: Accel, point: Vector) -> Vector:
    """Acceleration of a point of the body, given in base components."""
    return _carried(A_WB.a, A_WB.alpha, V_WB.w, point - X_WB.p)


def pair_velocity(axis: Axis, sign: float, point: Vector) -> tuple[Vector, Vector]:
    """What one unit of a pair's rate gives the bodies beyond it: (w, v at `point`)."""
    u = sign * axis.direction
    if axis.slides:
        return ZERO, u
    return u, cross(u, point - axis.point) + u * axis.pitch
