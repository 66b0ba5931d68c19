"""Friction that grows with what a joint carries, which in turn depends on friction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from parakin.algebra.linear import inner, solve
from parakin.algebra.spatial import Functions, Scalar, add, mul, sub
from parakin.kernel.actuation import Actuation
from parakin.kernel.force_rows import ForceRows
from parakin.kernel.reactions import joint_loads
from parakin.kernel.statics import Needs, Statics
from parakin.mechanics.reactions import at_joint

_STEPS = 6  # of Newton's
_TINY = 1e-24  # [N²]: a load's size has a slope at zero, too

Across = list[tuple[Scalar, Scalar]]  # on each loaded joint, the force along its x and y


class LoadFriction(NamedTuple):
    """By coordinate the effort against friction, and how far it may be off at rest; step: the last
    of Newton's [N or N m], not small where friction locks the mechanism.
    """

    efforts: dict[int, Scalar]
    bands: dict[int, Scalar]
    step: Scalar


def load_friction(
    statics: Statics,
    actuation: Actuation,
    wanted: ForceRows,
    needs: Needs,
    given: Mapping[int, Scalar],
    directions: Mapping[int, Scalar],
) -> LoadFriction:
    """Of the joints `wanted.loaded`: coefficient (times radius) times the force across the axis.

    needs, given: as of `joint_loads`, before actuators exert anything. directions: of motion,
    from -1 to 1, 0 at rest, by coordinate.
    """
    functions, loaded = statics.functions, wanted.loaded
    numbers = [each.coordinate for each in loaded]
    loads = _Loads(
        _across(statics, actuation, wanted, needs, given, preloaded=True),
        [
            _across(statics, actuation, wanted, statics.unit_effort(k), {k: -1.0}, preloaded=False)
            for k in numbers
        ],
        functions,
    )
    factors = [mul(each.lever, directions[each.coordinate]) for each in loaded]
    # From none: there may be another answer, with the joint loaded the other way.
    values: list[Scalar] = [0.0] * len(loaded)
    steps = values
    for _ in range(_STEPS):
        steps = _step(loads, factors, values)
        values = [sub(value, step) for value, step in zip(values, steps, strict=True)]
    bands = [
        mul(mul(each.lever, size), sub(1.0, mul(directions[k], directions[k])))
        for k, each, size in zip(numbers, loaded, loads.at(values)[1], strict=True)
    ]
    return LoadFriction(
        dict(zip(numbers, values, strict=True)),
        dict(zip(numbers, bands, strict=True)),
        functions.sqrt(inner(steps, steps)),
    )


class _Loads(NamedTuple):
    """Of the loaded joints, the forces across their axes: without friction, and what an effort of
    one against each adds.
    """

    base: Across
    by: list[Across]
    functions: Functions

    def at(self, values: Sequence[Scalar]) -> tuple[Across, list[Scalar]]:
        """Forces with these efforts against friction, and their sizes."""
        found: Across = []
        for place, (x, y) in enumerate(self.base):
            total = [x, y]
            for value, change in zip(values, self.by, strict=True):
                total = [add(t, mul(value, c)) for t, c in zip(total, change[place], strict=True)]
            found.append((total[0], total[1]))
        sqrt = self.functions.sqrt
        return found, [sqrt(add(add(mul(x, x), mul(y, y)), _TINY)) for x, y in found]


def _step(loads: _Loads, factors: Sequence[Scalar], values: Sequence[Scalar]) -> list[Scalar]:
    """One of Newton's towards efforts that are factors times the sizes of the loads."""
    (forces, sizes), by = loads.at(values), loads.by
    gaps = [
        sub(value, mul(factor, size))
        for value, factor, size in zip(values, factors, sizes, strict=True)
    ]
    slopes = [
        [
            sub(
                float(i == j),
                mul(factors[i] / sizes[i], add(mul(x, by[j][i][0]), mul(y, by[j][i][1]))),
            )
            for j in range(len(values))
        ]
        for i, (x, y) in enumerate(forces)
    ]
    return solve(slopes, [gaps], loads.functions).solutions[0]


def _across(
    statics: Statics,
    actuation: Actuation,
    wanted: ForceRows,
    needs: Needs,
    given: Mapping[int, Scalar],
    *,
    preloaded: bool,
) -> Across:
    """Forces across the axes of the loaded joints when the actuators balance needs."""
    needed = statics.for_driven(statics.answer(needs).left)
    efforts = actuation.solved([needed], preloaded=preloaded)[0][0]
    exerted = dict(zip(wanted.actuated, efforts, strict=True))
    needs = statics.after_efforts(needs, exerted)
    total = dict(given)
    for k, effort in exerted.items():
        total[k] = add(total.get(k, 0.0), effort)
    wrenches = joint_loads(statics, wanted, needs, total)[1]
    found: Across = []
    for each in wanted.loaded:
        x, y, *_ = at_joint(statics.circuits, each.joint, wrenches.get(each.joint.carrier))
        found.append((x, y))
    return found
