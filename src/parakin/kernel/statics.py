"""Statics: what wrenches and efforts at one pose ask of loops, and of the driven coordinates.

Virtual powers, linear in what is needed: nothing here knows what moves or acts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import NamedTuple

from parakin.algebra.spatial import Functions, Scalar, add, mul, sub
from parakin.kernel.connectivity import System
from parakin.kernel.transposed import Multipliers, multipliers
from parakin.kinematics import loops
from parakin.kinematics.closure import Row, Wrench, axis_on_loop
from parakin.kinematics.readings import rate_wrenches
from parakin.kinematics.recursion import Circuits
from parakin.mechanics.powers import carried
from parakin.mechanics.wrenches import Wrenches, put, put_between
from parakin.planning.plan import Plan


class Needs(NamedTuple):
    """What is to be balanced: wrenches that bodies need, and efforts that coordinates of the tree
    need beside.
    """

    wrenches: Wrenches
    efforts: dict[int, Scalar]

    def less(self, given: Needs, factor: Scalar) -> Needs:
        """After so many times a unit of something has been given."""
        wrenches, efforts = dict(self.wrenches), dict(self.efforts)
        for body, wrench in given.wrenches.items():
            put(wrenches, body, wrench.times(mul(-1.0, factor)))
        for k, effort in given.efforts.items():
            efforts[k] = sub(efforts.get(k, 0.0), mul(factor, effort))
        return Needs(wrenches, efforts)


class Answer(NamedTuple):
    """What the loops make of needs: multipliers, and what is left for coordinates that are not
    solved for, `left`.
    """

    rows: Multipliers
    left: dict[int, Scalar]


class Statics:
    """Virtual powers at one pose, whatever moves or acts there."""

    def __init__(
        self, plan: Plan, circuits: Circuits, systems: Sequence[System], functions: Functions
    ) -> None:
        self.plan, self.circuits, self.functions = plan, circuits, functions
        self.systems = systems
        self.inside = set(plan.graph.tree_coordinates(plan.tree))

    def unit_effort(self, k: int) -> Needs:
        """What an effort of one in a coordinate needs, or gives to others' needs."""
        if k in self.inside:
            return Needs({}, {k: 1.0})
        cut = self.plan.graph.coordinates[k].joint
        end = loops.ends(self.circuits, cut)
        wrench = rate_wrenches(self.circuits, cut, end, self.functions)[k]
        return self._between(end, wrench)

    def after_efforts(self, needs: Needs, efforts: Mapping[int, Scalar]) -> Needs:
        """What is left to be balanced when coordinates exert these efforts."""
        for k, effort in efforts.items():
            needs = needs.less(self.unit_effort(k), effort)
        return needs

    def wrench_of(self, row: Row, end: loops.Ends) -> Wrench:
        """What a multiplier of one in a closure row exerts on the child."""
        return row.wrench(end, partial(axis_on_loop, self.circuits, end))

    def unit_multiplier(self, row: Row, end: loops.Ends) -> Needs:
        """What a multiplier of one in a closure row gives its two bodies."""
        return self._between(end, self.wrench_of(row, end))

    def _between(self, end: loops.Ends, wrench: Wrench) -> Needs:
        wrenches: Wrenches = {}
        put_between(wrenches, end.child, end.parent, wrench)
        return Needs(wrenches, {})

    def answer(self, needs: Needs) -> Answer:
        """Of the closure rows that the plan solves."""
        tree, affine = self.plan.tree, self.plan.affine
        efforts = self.efforts_in(self.plan.unknowns, needs)
        rows = multipliers(self.systems, efforts, self.functions)
        after = self.after(needs, rows)
        left = carried(self.circuits, tree, after.wrenches, affine).efforts
        for k in affine:
            left[k] = add(left.get(k, 0.0), after.efforts.get(k, 0.0))
        return Answer(rows, left)

    def efforts_in(self, unknowns: Sequence[int], needs: Needs) -> dict[int, Scalar]:
        """What needs are in these coordinates."""
        found = carried(self.circuits, self.plan.tree, needs.wrenches, unknowns).efforts
        for k, effort in needs.efforts.items():
            if k in unknowns:
                found[k] = add(found.get(k, 0.0), effort)
        return found

    def after(self, needs: Needs, rows: Multipliers) -> Needs:
        """What is left to be balanced when the closure rows exert these multipliers."""
        wrenches = dict(needs.wrenches)
        for system, values in zip(self.systems, rows, strict=True):
            for row, end, value in zip(system.block.rows, system.ends, values, strict=True):
                if not is_zero(value):
                    wrench = self.wrench_of(row, end).times(value)
                    put_between(wrenches, end.parent, end.child, wrench)
        return Needs(wrenches, needs.efforts)

    def for_driven(self, left: Mapping[int, Scalar]) -> list[Scalar]:
        """What is left for the driven coordinates, those affine in them included."""
        plan = self.plan
        totals: dict[int, Scalar] = {}
        for k, rule in plan.affine.items():
            for j, factor in rule.factors:
                totals[j] = add(totals.get(j, 0.0), mul(factor, left.get(k, 0.0)))
        return [totals.get(j, 0.0) for j in plan.driven]

    def given_by(self, k: int) -> list[Scalar]:
        """What an effort of one in a coordinate gives the driven ones: its rate by each of them."""
        if k in self.plan.affine:
            known = dict(self.plan.affine[k].factors)
            return [known.get(j, 0.0) for j in self.plan.driven]
        return self.for_driven(self.answer(self.unit_effort(k)).left)


def is_zero(a: Scalar) -> bool:
    """Whether it is known to be."""
    return type(a) is float and a == 0.0
