"""Inverse dynamics of a pose: the efforts of actuators, and what every joint carries.

By virtual powers along the recursion: the wrenches that bodies need are carried to the base, the
closure rows' multipliers follow from the blocks transposed, and what is left in the driven
coordinates is for the actuators. Where these are not the driven ones, an effort of one in each
tells what it gives the driven ones.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from parakin.algebra.spatial import Functions, Scalar, mul, sub
from parakin.kernel.actuation import Actuation
from parakin.kernel.coordinates import coordinate
from parakin.kernel.energies import energies
from parakin.kernel.force_rows import ForceRows
from parakin.kernel.friction import load_friction
from parakin.kernel.motion import Moved
from parakin.kernel.reactions import reactions
from parakin.kernel.statics import Needs, Statics
from parakin.mechanics.resistance import Resistance, direction, resistance
from parakin.mechanics.wrenches import wrenches_needed
from parakin.planning.plan import Plan


def forces(
    plan: Plan, moved: Moved, wanted: ForceRows, inputs: Sequence[Scalar], functions: Functions
) -> list[Scalar]:
    """The forces behind a motion; see `ForceRows` for what is returned.

    inputs: the numbers that payloads and wrenches take (`Dynamics.inputs`), then `wanted.wound`.
    """
    taken = plan.graph.dynamics.inputs
    wound = dict(zip(wanted.wound, inputs[taken:], strict=True))
    statics = Statics(plan, moved.circuits, moved.systems, functions)
    actuation = Actuation(statics, wanted)
    needs = Needs(wrenches_needed(moved.circuits, plan.graph.dynamics, inputs, functions), {})
    needs, resisting, step = _resisted(plan, moved, wanted, actuation, needs, wound)
    left = statics.answer(needs).left
    efforts, bands, figure = actuation.efforts(
        statics.for_driven(left), {k: found.band for k, found in resisting.items()}
    )
    motion = [coordinate(plan, moved, k, 2)[1:] for k in wanted.actuated]
    results = [*efforts, *bands, *(rate for rate, _ in motion), *(second for _, second in motion)]
    results += [figure, moved.quality.least(functions)]
    if wanted.idle or wanted.joints:
        given = dict(zip(wanted.actuated, efforts, strict=True))
        needs = statics.after_efforts(needs, given)
        for k, found in resisting.items():
            given[k] = sub(given.get(k, 0.0), found.effort)
        results += reactions(statics, wanted, needs, given)
    if wanted.energies:
        results += energies(plan, moved, inputs, resisting)
    return results + step


def _resisted(
    plan: Plan,
    moved: Moved,
    wanted: ForceRows,
    actuation: Actuation,
    needs: Needs,
    wound: Mapping[int, Scalar],
) -> tuple[Needs, dict[int, Resistance], list[Scalar]]:
    """Needs with what springs, dampers and friction in joints add to them, what these are by
    coordinate, and the last step to friction under load, if there is any.
    """
    statics = actuation.statics
    resisting: dict[int, Resistance] = {}
    for k, passive in plan.graph.dynamics.passive.items():
        value, rate, second = coordinate(plan, moved, k, 2)
        value = wound.get(k, value)
        way = direction(rate, statics.functions) if passive.coulomb else 0.0
        resisting[k] = resistance(passive, value, rate, second, way, statics.functions)
        needs = needs.less(statics.unit_effort(k), mul(-1.0, resisting[k].effort))
    if not wanted.loaded:
        return needs, resisting, []
    given = {k: mul(-1.0, found.effort) for k, found in resisting.items()}
    numbers = [each.coordinate for each in wanted.loaded]
    rates = {k: coordinate(plan, moved, k, 1)[1] for k in numbers}
    directions = {k: direction(rate, statics.functions) for k, rate in rates.items()}
    friction = load_friction(statics, actuation, wanted, needs, given, directions)
    for k, effort in friction.efforts.items():
        needs = needs.less(statics.unit_effort(k), mul(-1.0, effort))
        more = Resistance(effort, friction.bands[k], 0.0, mul(effort, rates[k]))
        resisting[k] = resisting[k].plus(more) if k in resisting else more
    return needs, resisting, [friction.step]
