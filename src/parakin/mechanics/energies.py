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
    given = list(inputs)
    parts: list[tuple[int, Mass, Scalar, Scalar]] = [
        (body, mass, mass.mass, 1.0) for body, mass in dynamics.masses.items()
    ]
    for load in dynamics.loads:
        amount = given.pop(0)
        parts.append((load.body, load.mass, amount, share_of(load, amount)))
    for body, mass, amount, share in parts:
        kinetic = add(kinetic, _kinetic(circuits, body, mass, amount, share))
        potential = add(potential, _weight(circuits, body, mass, dynamics.gravity, amount))
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


def _kinetic(circuits: Circuits, body: int, mass: Mass, amount: Scalar, share: Scalar) -> Scalar:
    """½ m v_C² + ½ w · I w."""
    X_WB, V_WB = circuits.pose(body), circuits.twist(body)
    v = point_velocity(X_WB, V_WB, X_WB.p + X_WB.R @ mass.com)
    energy = mul(mul(0.5, amount), dot(v, v))
    if any(any(row) for row in mass.inertia):
        w_B = X_WB.R.T @ V_WB.w
        energy = add(energy, mul(mul(0.5, share), dot(w_B, mass.inertia @ w_B)))
    return energy


def _weight(circuits: Circuits, body: int, mass: Mass, g: Vector, amount: Scalar) -> Scalar:
    """-m g · p_C."""
    X_WB = circuits.pose(body)
    return mul(-1.0, mul(amount, dot(g, X_WB.p + X_WB.R @ mass.com)))


def power_on(circuits: Circuits, body: int, wrench: Wrench) -> Scalar:
    """What a wrench gives a body that moves [W]."""
    X_WB, V_WB = circuits.pose(body), circuits.twist(body)
    v_O = V_WB.v - cross(V_WB.w, X_WB.p)  # of the body's point at the base's origin
    return add(dot(V_WB.w, wrench.moment), dot(v_O, wrench.force))
