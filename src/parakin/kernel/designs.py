"""What kernels tell of a mechanism whose dimensions are left open: homes, limits, sensitivities.

Sensitivities are exact: the recursion is run on dual numbers, whose rates are those by one
parameter or driven coordinate. Of what is iterated the last Newton step alone is differentiated,
from a closed pose: what it adds is the implicit function's derivative.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from parakin.algebra.dual import dual, dual_functions, rate_of, value_of
from parakin.algebra.spatial import Functions, Scalar, add, mul, sub
from parakin.kernel.coordinates import coordinate
from parakin.kernel.motion import Moved, solve_motion
from parakin.kernel.outputs import Outputs
from parakin.kernel.pose import checks
from parakin.kinematics import loops
from parakin.kinematics.closure import all_rows
from parakin.model.designs import Designs
from parakin.planning.plan import Plan


@dataclass(frozen=True)
class HomeRows:
    """What a kernel takes and returns that finds home in any design.

    It takes the parameters left open, their rates, and a guess of what is iterated. It returns
    `outputs`: positions of `coordinates`, what these change at, and figures; then how far other
    coordinates are from what home gives for them, `also`.
    """

    plan: Plan
    coordinates: tuple[int, ...]
    also: tuple[int, ...]

    @property
    def outputs(self) -> Outputs:
        return Outputs(self.coordinates, derivatives=1)

    @property
    def parameters(self) -> int:
        assert self.plan.designs is not None
        return self.plan.designs.count

    @property
    def inputs(self) -> int:
        return 2 * self.parameters + len(self.plan.iterated)

    def at(self, steps: int, inputs: Sequence[Scalar], functions: Functions) -> list[Scalar]:
        m, lifted = self.parameters, dual_functions(functions)
        changing = [dual(a, b) for a, b in zip(inputs[:m], inputs[m : 2 * m], strict=True)]
        plan = self.plan.opened(changing, {}, lifted)
        given = plan.graph.home
        driven = [given.get(k, float(plan.home[k])) for k in plan.driven]
        moved = solve_motion(plan, [driven], inputs[2 * m :], lifted, steps)
        found = [coordinate(plan, moved, k, 0)[0] for k in self.coordinates]
        off = [sub(coordinate(plan, moved, k, 0)[0], given[k]) for k in self.also]
        figures = checks(plan, moved, lifted)
        told = [*found, *(rate_of(a) for a in found), *figures, *off]
        return [value_of(a) for a in told]


def limits_at(designs: Designs, inputs: Sequence[Scalar], functions: Functions) -> list[Scalar]:
    """All lower limits, all upper ones, and the margins of decisions, from parameters left open."""
    graph, conditions = designs.opened(inputs, functions)
    low, high = ([limit.ends[end] for limit in graph.limited] for end in (0, 1))
    return [*low, *high, *(condition.margin for condition in conditions)]


@dataclass(frozen=True)
class SensitivityRows:
    """What a kernel takes and returns that tells sensitivities.

    It takes what the plan's kernel does with these outputs, and then how coordinates at home
    (`Plan.standing`) change by each parameter. It returns the derivatives of an `order` of the
    outputs' coordinates by each driven coordinate, one after the other, then by each parameter;
    and for each of these how far the loops would open, all of their rows counted [m].
    """

    plan: Plan
    outputs: Outputs
    order: int

    @property
    def parameters(self) -> int:
        return self.plan.designs.count if self.plan.designs else 0

    @property
    def seeds(self) -> int:
        return len(self.plan.driven) + self.parameters

    @property
    def changes(self) -> int:
        """How many inputs tell how home changes."""
        if not self.parameters:
            return 0
        return self.parameters * len(self.plan.standing(self.outputs.coordinates))

    def at(self, steps: int, inputs: Sequence[Scalar], functions: Functions) -> list[Scalar]:
        plan, k, m = self.plan, len(self.plan.driven), self.parameters
        standing = plan.standing(self.outputs.coordinates) if m else []
        orders = [list(inputs[k * n : k * (n + 1)]) for n in range(1 + self.order)]
        rest = inputs[k * (1 + self.order) :]
        parameters, at_home = rest[:m], rest[m : m + len(standing)]
        rest = rest[m + len(standing) :]
        guess, changes = rest[: len(plan.iterated)], rest[len(plan.iterated) :]
        lifted = dual_functions(functions)
        found: list[Scalar] = []
        gaps: list[Scalar] = []
        still = plan
        if m:
            still = plan.opened(parameters, dict(zip(standing, at_home, strict=True)), lifted)
        for seed in range(self.seeds):
            here = still
            if seed >= k:
                of_home = changes[(seed - k) * len(standing) :]
                home = {n: dual(a, b) for n, a, b in zip(standing, at_home, of_home, strict=False)}
                here = plan.opened(_seeded(parameters, seed - k), home, lifted)
            there = [_seeded(orders[0], seed), *orders[1:]]
            moved = solve_motion(here, there, guess, lifted, steps)
            for name in self.outputs.coordinates:
                found.append(rate_of(coordinate(here, moved, name, self.order)[self.order]))
            gaps.append(_opening(here, moved, functions))
        return [*found, *gaps]


def _opening(plan: Plan, moved: Moved, functions: Functions) -> Scalar:
    """How fast all closure rows together open [m]: not at all, where dimensions are not tied, as
    they are not where there are as many rows as unknowns, each of which was found from them.
    """
    circuits, rows = moved.circuits, all_rows(plan.graph, plan.tree)
    if len(rows) <= len(plan.unknowns):
        return 0.0
    total: Scalar = 0.0
    for row in rows:
        value = row.value(circuits, loops.ends(circuits, row.cut))
        value = mul(row.per_length(plan.graph), value)
        total = add(total, mul(rate_of(value), rate_of(value)))
    opening: Scalar = functions.sqrt(total)
    return opening


def _seeded(numbers: Sequence[Scalar], seed: int) -> list[Scalar]:
    """The same, with a rate of one in one of them."""
    return [dual(a, 1.0) if k == seed else a for k, a in enumerate(numbers)]
