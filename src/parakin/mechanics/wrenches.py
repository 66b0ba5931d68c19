"""Wrenches on bodies: what inertia and weight need, what springs and applied forces give.

All are about the base's origin, in base components. A wrench needed is what joints have to
exert on a body; one that acts is needed less.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from parakin.algebra.spatial import (
    ZERO,
    Functions,
    Scalar,
    Vector,
    add,
    cross,
    dot,
    mul,
    sub,
)
from parakin.kinematics.closure import Wrench
from parakin.kinematics.recursion import Circuits, point_acceleration, point_velocity
from parakin.model.dynamics import Ball, Dynamics
from parakin.model.loads import BodyWrench, Load, PointSpring
from parakin.model.masses import Mass

Wrenches = dict[int, Wrench]  # by body; those on the base are dropped


def put(on: Wrenches, body: int, wrench: Wrench) -> None:
    """Add a wrench to those on a body."""
    if body:
        gather(on, body, wrench)


def put_between(on: Wrenches, first: int, second: int, wrench: Wrench) -> None:
    """Add a wrench to those on the first body, and its opposite to those on the second."""
    put(on, first, wrench)
    put(on, second, wrench.times(-1.0))


def gather(on: dict[int, Wrench], number: int, wrench: Wrench) -> None:
    """Add a wrench to those under a number, of a joint or a body."""
    on[number] = on[number].plus(wrench) if number in on else wrench


def wrenches_needed(
    circuits: Circuits, dynamics: Dynamics, inputs: Sequence[Scalar], functions: Functions
) -> Wrenches:
    """What the bodies need for their motion, against gravity and what acts on them.

    inputs: the numbers that payloads and wrenches take (`Dynamics.inputs`).
    """
    needed: Wrenches = {}
    given = list(inputs)
    for body, mass in dynamics.masses.items():
        put(needed, body, inertial(circuits, body, mass, dynamics.gravity, mass.mass, 1.0))
    for load in dynamics.loads:
        amount = given.pop(0)
        share = share_of(load, amount)
        put(
            needed,
            load.body,
            inertial(circuits, load.body, load.mass, dynamics.gravity, amount, share),
        )
    for applied in dynamics.wrenches:
        taken, given = given[: applied.inputs], given[applied.inputs :]
        put(needed, applied.body, applied_wrench(circuits, applied, taken).times(-1.0))
    for spring in dynamics.springs:
        (first, _), (second, _) = spring.ends
        put_between(needed, second, first, pull(circuits, spring, functions).wrench)
    for ball in dynamics.balls:
        put_between(needed, ball.child, ball.parent, brake(circuits, ball))
    return needed


def share_of(load: Load, amount: Scalar) -> Scalar:
    """Of the payload's inertia, that of another mass is this."""
    return amount / load.mass.mass if load.mass.mass else 0.0


def inertial(
    circuits: Circuits, body: int, mass: Mass, g: Vector, amount: Scalar, share: Scalar
) -> Wrench:
    """Newton and Euler: f = m (a_C - g), and about the centre of mass I alpha + w x I w.

    amount: of the mass; share: of its inertia tensor.
    """
    X_WB, V_WB, A_WB = circuits.pose(body), circuits.twist(body), circuits.accel(body)
    p_WC = X_WB.p + X_WB.R @ mass.com
    force = (point_acceleration(X_WB, V_WB, A_WB, p_WC) - g) * amount
    moment = cross(p_WC, force)
    if any(any(row) for row in mass.inertia):
        R_BW = X_WB.R.T
        w_B, alpha_B = R_BW @ V_WB.w, R_BW @ A_WB.alpha
        spin = mass.inertia @ alpha_B + cross(w_B, mass.inertia @ w_B)
        moment += X_WB.R @ (spin * share)
    return Wrench(moment, force)


def applied_wrench(circuits: Circuits, applied: BodyWrench, inputs: Sequence[Scalar]) -> Wrench:
    """What a force and moment exert. inputs: nothing, the law's factor, or all six components."""
    X_WB = circuits.pose(applied.body)
    force: Vector = applied.force
    moment: Vector = applied.moment
    if applied.inputs == 6:
        force, moment = Vector(tuple(inputs[:3])), Vector(tuple(inputs[3:]))
    elif applied.inputs == 1:
        force, moment = force * inputs[0], moment * inputs[0]
    if applied.turns:
        force, moment = X_WB.R @ force, X_WB.R @ moment
    point = X_WB.p + X_WB.R @ applied.point
    return Wrench(moment + cross(point, force), force)


def brake(circuits: Circuits, ball: Ball) -> Wrench:
    """What the child needs to turn against the damping of a spherical joint."""
    w = circuits.twist(ball.child).w - circuits.twist(ball.parent).w
    return Wrench(w * ball.damping, ZERO)


class Pull(NamedTuple):
    """What a spring between two points exerts on its first body (and the opposite on the other),
    how long it is and how fast it grows.
    """

    wrench: Wrench
    length: Scalar
    rate: Scalar


def pull(circuits: Circuits, spring: PointSpring, functions: Functions) -> Pull:
    """Its direction is not defined where its ends coincide, and then not needed of a spring of no
    length without damping.
    """
    (first, a), (second, b) = spring.ends
    X_WA, X_WB = circuits.pose(first), circuits.pose(second)
    p_WA, p_WB = X_WA.p + X_WA.R @ a, X_WB.p + X_WB.R @ b
    d: Vector = p_WB - p_WA
    length = functions.sqrt(dot(d, d))
    u = d * (1.0 / length)
    ahead = point_velocity(X_WB, circuits.twist(second), p_WB)
    rate = dot(u, ahead - point_velocity(X_WA, circuits.twist(first), p_WA))
    if spring.length or spring.damping:
        stretch = sub(length, spring.length)
        force = u * add(mul(spring.stiffness, stretch), mul(spring.damping, rate))
    else:
        force = d * spring.stiffness
    return Pull(Wrench(cross(p_WA, force), force), length, rate)
