"""Energies at a pose and its rates: of bodies, and of what acts in joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from parakin.algebra.spatial import Scalar, add, mul
from parakin.kernel.coordinates import coordinate
from parakin.kernel.motion import Moved
from parakin.mechanics.energies import Energies, energies_of_bodies
from parakin.mechanics.resistance import Resistance
from parakin.planning.plan import Plan


def energies(
    plan: Plan, moved: Moved, inputs: Sequence[Scalar], resisting: Mapping[int, Resistance]
) -> Energies:
    """inputs: as of `wrenches_needed`. resisting: what acts in joints, by coordinate."""
    dynamics = plan.graph.dynamics
    bodies = energies_of_bodies(moved.circuits, dynamics, inputs, moved.angles.functions)
    kinetic, potential, lost, applied = bodies
    for k, each in resisting.items():
        rate = coordinate(plan, moved, k, 1)[1]
        armature = dynamics.passive[k].armature if k in dynamics.passive else 0.0
        kinetic = add(kinetic, mul(0.5 * armature, mul(rate, rate)))
        potential, lost = add(potential, each.stored), add(lost, each.lost)
    return Energies(kinetic, potential, lost, applied)
