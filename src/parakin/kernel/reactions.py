"""Reactions: what closure rows exert, and what every joint then carries."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from parakin.algebra.linear import inner, solve
from parakin.algebra.spatial import Scalar, add, mul
from parakin.kernel.connectivity import System
from parakin.kernel.force_rows import ForceRows
from parakin.kernel.statics import Needs, Statics
from parakin.kernel.transposed import least_transposed
from parakin.kinematics import loops
from parakin.kinematics.closure import Row, Wrench, all_rows
from parakin.kinematics.readings import rate_wrenches
from parakin.mechanics.powers import carried
from parakin.mechanics.reactions import at_joint
from parakin.mechanics.wrenches import brake, gather, put_between
from parakin.planning.plan import Block


class Exerted(NamedTuple):
    """A closure row, its two ends and its multiplier."""

    row: Row
    end: loops.Ends
    value: Scalar


def reactions(
    statics: Statics, wanted: ForceRows, needs: Needs, given: Mapping[int, Scalar]
) -> list[Scalar]:
    """Efforts that hold idle coordinates; what each joint exerts on its child; the imbalance.

    needs, given: as of `joint_loads`.
    """
    left, wrenches = joint_loads(statics, wanted, needs, given)
    results = [left[k] for k in wanted.idle]
    if not wanted.joints:
        return results
    balls = {ball.joint: ball for ball in statics.plan.graph.dynamics.balls}
    for joint in wanted.joints:
        wrench = wrenches.get(joint.carrier)
        if joint.name in balls:  # its damping was counted among what acts on bodies
            braking = brake(statics.circuits, balls[joint.name]).times(-1.0)
            wrench = braking if wrench is None else wrench.plus(braking)
        results += at_joint(statics.circuits, joint, wrench)
    return [*results, _norm(statics, {k: x for k, x in left.items() if k not in wanted.idle})]


def joint_loads(
    statics: Statics, wanted: ForceRows, needs: Needs, given: Mapping[int, Scalar]
) -> tuple[dict[int, Scalar], dict[int, Wrench]]:
    """Efforts left in the coordinates of the tree, and what each joint exerts on its child.

    needs: what is left when actuators and resistances exert their efforts, which are `given`.
    """
    exerted = _least(statics, needs) if wanted.least else _exerted(statics, wanted.extra, needs)
    on_cuts: dict[int, Wrench] = {}
    wrenches = dict(needs.wrenches)
    for row, end, value in exerted:
        wrench = statics.wrench_of(row, end).times(value)
        gather(on_cuts, row.cut, wrench)
        put_between(wrenches, end.parent, end.child, wrench)
    for k, effort in given.items():
        if k not in statics.inside:
            cut = statics.plan.graph.coordinates[k].joint
            end = loops.ends(statics.circuits, cut)
            units = rate_wrenches(statics.circuits, cut, end, statics.functions)
            gather(on_cuts, cut, units[k].times(effort))
    found = carried(statics.circuits, statics.plan.tree, wrenches)
    left = {
        k: add(found.efforts.get(k, 0.0), needs.efforts.get(k, 0.0)) for k in sorted(statics.inside)
    }
    return left, found.joints | on_cuts


def _norm(statics: Statics, efforts: Mapping[int, Scalar]) -> Scalar:
    """Of efforts [N]; torques count by the characteristic length."""
    graph = statics.plan.graph
    parts = [
        mul(1.0 / graph.length if graph.coordinates[k].angle else 1.0, effort)
        for k, effort in efforts.items()
    ]
    size: Scalar = statics.functions.sqrt(inner(parts, parts))
    return size


def _exerted(statics: Statics, extra: Sequence[Row], needs: Needs) -> list[Exerted]:
    """By the blocks' rows, and by extra ones that hold the coordinates that are not solved for."""
    base = statics.answer(needs)
    total, values = base.rows, []
    ends = [loops.ends(statics.circuits, row.cut) for row in extra]
    if extra:
        answers = [
            statics.answer(Needs({}, {}).less(statics.unit_multiplier(row, end), 1.0))
            for row, end in zip(extra, ends, strict=True)
        ]
        unsolved = statics.plan.unsolved
        matrix = [[mul(-1.0, each.left.get(u, 0.0)) for each in answers] for u in unsolved]
        sides = [base.left.get(u, 0.0) for u in unsolved]
        values = solve(matrix, [sides], statics.functions).solutions[0]
        for answer, value in zip(answers, values, strict=True):
            total = [
                [add(x, mul(value, more)) for x, more in zip(block, blocks, strict=True)]
                for block, blocks in zip(total, answer.rows, strict=True)
            ]
    found = [
        Exerted(row, end, value)
        for system, block in zip(statics.systems, total, strict=True)
        for row, end, value in zip(system.block.rows, system.ends, block, strict=True)
    ]
    return found + [Exerted(*each) for each in zip(extra, ends, values, strict=True)]


def _least(statics: Statics, needs: Needs) -> list[Exerted]:
    """By all canonical rows, the least in the sum of squares [N²], cosines by the characteristic
    length.
    """
    plan, graph = statics.plan, statics.plan.graph
    unknowns = tuple(sorted((*plan.unknowns, *plan.unsolved)))
    block = Block(unknowns, tuple(all_rows(graph, plan.tree)))
    system = System.of(statics.circuits, block)
    scales = [row.per_length(graph) for row in block.rows]
    scaled = [
        [mul(scale, x) for x in row] for scale, row in zip(scales, system.jacobian, strict=True)
    ]
    efforts = statics.efforts_in(unknowns, needs)
    sides = [efforts.get(k, 0.0) for k in unknowns]
    values = least_transposed(scaled, sides, statics.functions)
    return [
        Exerted(row, end, mul(scale, value))
        for row, end, scale, value in zip(block.rows, system.ends, scales, values, strict=True)
    ]
