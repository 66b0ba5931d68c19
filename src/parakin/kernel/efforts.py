"""Inverse dynamics of a pose: the efforts of actuators, and what every joint carries.

By virtual powers along the recursion: the wrenches that bodies need are carried to the base, the
closure rows' multipliers follow from the blocks transposed, and what is left in the driven
coordinates is for the actuators. Where these are not the driven ones, an effort of one in each
tells what it gives the driven ones.
"""

from __future__ import annotations

from collections.abc import Sequence

from parakin.algebra.spatial import Functions, Scalar, add, mul, sub
from parakin.kernel.actuation import Actuation
from parakin.kernel.coordinates import coordinate
from parakin.kernel.force_rows import ForceRows
from parakin.kernel.motion import Moved
from parakin.kernel.reactions import reactions
from parakin.kernel.statics import Needs, Statics
from parakin.mechanics.energies import energies_of_bodies
from parakin.mechanics.resistance import Resistance, resistance
from parakin.mechanics.wrenches import wrenches_needed
from parakin.planning.plan import Plan


def forces(
    plan: Plan, moved: Moved, wanted: ForceRows, inputs: Sequence[Scalar], functions: Functions
) -> list[Scalar]:
    """The forces behind a motion; see `ForceRows` for what is returned.

    inputs: the numbers that payloads and wrenches take (`Dynamics.inputs`).
    """
    circuits, dynamics = moved.circuits, plan.graph.dynamics
    statics = Statics(plan, circuits, moved.systems, functions)
    needs = Needs(wrenches_needed(circuits, dynamics, inputs, functions), {})
    resisting: dict[int, Resistance] = {}
    for k, passive in dynamics.passive.items():
        value, rate, second = coordinate(plan, moved, k, 2)
        resisting[k] = resistance(passive, value, rate, second, functions)
        needs = needs.less(statics.unit_effort(k), mul(-1.0, resisting[k].effort))
    actuation = Actuation(statics, wanted)
    left = statics.answer(needs).left
    efforts, bands, figure = actuation.efforts(
        statics.for_driven(left), {k: found.band for k, found in resisting.items()}
    )
    rates = [coordinate(plan, moved, k, 2)[1:] for k in wanted.actuated]
    results = [*efforts, *bands, *(rate for rate, _ in rates), *(second for _, second in rates)]
    results += [figure, moved.quality.least(functions)]
    if wanted.idle or wanted.joints:
        for k, effort in zip(wanted.actuated, efforts, strict=True):
            needs = needs.less(statics.unit_effort(k), effort)
        given = dict(zip(wanted.actuated, efforts, strict=True))
        for k, found in resisting.items():
            given[k] = sub(given.get(k, 0.0), found.effort)
        results += reactions(statics, wanted, needs, given)
    if wanted.energies:
        bodies = energies_of_bodies(circuits, dynamics, inputs, functions)
        kinetic, potential, lost, applied = bodies
        for k, each in resisting.items():
            rate = coordinate(plan, moved, k, 1)[1]
            armature = mul(0.5 * dynamics.passive[k].armature, mul(rate, rate))
            kinetic, potential = add(kinetic, armature), add(potential, each.stored)
            lost = add(lost, each.lost)
        results += [kinetic, potential, lost, applied]
    return results
