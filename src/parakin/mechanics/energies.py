"""Energies: of what moves, is lifted and is stretched, and the powers that change them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from parakin.algebra.spatial import Functions, Scalar, Vector, add, cross, dot, mul, sub
from parakin.kinematics.closure import Wrench
from parakin.kinematics.recursion import Circuits, point_velocity
from parakin.mechanics.wrenches import applied_wrench, pull, share_of
from parakin.model.dynamics import Dynamics
from parakin.model.masses import Mass


class Energies(NamedTuple):
    """kinetic, potential [J]: the latter of weight, counted from the base's origin, and springs.
    lost, applied [W]: power to friction and dampers, and from applied wrenches.
    """

    kinetic: Scalar
    potential: Scalar
    lost: Scalar
    applied: Scalar


def energies_of_bodies(
    circuits: Circuits, dynamics: Dynamics, inputs: Sequence[Scalar], functions: Functions
) -> Energies:
    """Of all but what is in joints. inputs: as of `wrenches_needed`."""
    kinetic: Scalar = 0.0
    potential: Scalar = 0.0
    lost: Scalar = 0.0
    for part in parts_of(dynamics, inputs):
        kinetic = add(kinetic, mul(0.5, inertia_of(circuits, circuits, part)))
        potential = add(potential, _weight(circuits, part, dynamics.gravity))
    given = list(inputs)[len(dynamics.loads) :]
    for spring in dynamics.springs:
        found = pull(circuits, spring, functions)
        stretch = sub(found.length, spring.length)
        potential = add(potential, mul(0.5 * spring.stiffness, mul(stretch, stretch)))
        lost = add(lost, mul(spring.damping, mul(found.rate, found.rate)))
    for ball in dynamics.balls:
        w = circuits.twist(ball.child).w - circuits.twist(ball.parent).w
        lost = add(lost, mul(ball.damping, dot(w, w)))
    applied: Scalar = 0.0
    for wrench in dynamics.wrenches:
        taken, given = given[: wrench.inputs], given[wrench.inputs :]
        exerted = applied_wrench(circuits, wrench, taken)
        applied = add(applied, power_on(circuits, wrench.body, exerted))
    return Energies(kinetic, potential, lost, applied)


class Part(NamedTuple):
    """A mass on a body, of an amount [kg], with this share of its inertia tensor."""

    body: int
    mass: Mass
    amount: Scalar
    share: Scalar


def parts_of(dynamics: Dynamics, inputs: Sequence[Scalar]) -> list[Part]:
    """Of all bodies, payloads included. inputs: as of `wrenches_needed`."""
    parts = [Part(body, mass, mass.mass, 1.0) for body, mass in dynamics.masses.items()]
    return parts + [
        Part(load.body, load.mass, amount, share_of(load, amount))
        for load, amount in zip(dynamics.loads, inputs, strict=False)
    ]


def inertia_of(one: Circuits, other: Circuits, part: Part) -> Scalar:
    """Of two motions at one pose, m v_C · v_C' + w · I w'; of one with itself, twice its energy."""
    body, mass, amount, share = part
    X_WB, V_WB = one.pose(body), one.twist(body)
    p_WC, V2_WB = X_WB.p + X_WB.R @ mass.com, other.twist(body)
    v, v2 = point_velocity(X_WB, V_WB, p_WC), point_velocity(X_WB, V2_WB, p_WC)
    found = mul(amount, dot(v, v2))
    if any(any(row) for row in mass.inertia):
        R_BW = X_WB.R.T
        w_B, w2_B = R_BW @ V_WB.w, R_BW @ V2_WB.w
        found = add(found, mul(share, dot(w_B, mass.inertia @ w2_B)))
    return found


def _weight(circuits: Circuits, part: Part, g: Vector) -> Scalar:
    """-m g · p_C."""
    X_WB = circuits.pose(part.body)
    return mul(-1.0, mul(part.amount, dot(g, X_WB.p + X_WB.R @ part.mass.com)))


def power_on(circuits: Circuits, body: int, wrench: Wrench) -> Scalar:
    """What a wrench gives a body that moves [W]."""
    X_WB, V_WB = circuits.pose(body), circuits.twist(body)
    v_O = V_WB.v - cross(V_WB.w, X_WB.p)  # of the body's point at the base's origin
    return add(dot(V_WB.w, wrench.moment), dot(v_O, wrench.force))
