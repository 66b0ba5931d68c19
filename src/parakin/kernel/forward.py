"""Forward dynamics of a pose: the accelerations that forces make.

All coordinates of the tree are known, so that no position is solved for. Where the driven
coordinates are not accelerated, virtual powers tell what forces they lack (as in inverse dynamics,
`kernel.efforts`); the mass matrix of the driven coordinates, by the motions at a rate of one in
each, turns that into accelerations: M ydd = τ - h.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from parakin.algebra.linear import inner, solve
from parakin.algebra.spatial import Functions, Scalar, add, mul, sub
from parakin.caching import cached_property
from parakin.kernel.coordinates import coordinate
from parakin.kernel.energies import energies
from parakin.kernel.motion import Moved, motion_at, unit_motions
from parakin.kernel.statics import Needs, Statics
from parakin.kinematics import loops
from parakin.kinematics.closure import all_rows
from parakin.kinematics.recursion import Circuits
from parakin.mechanics.energies import inertia_of, parts_of
from parakin.mechanics.resistance import Resistance, resistance, smooth_direction
from parakin.mechanics.wrenches import wrenches_needed
from parakin.planning.plan import Plan


@dataclass(frozen=True)
class ForwardRows:
    """What a kernel of forward dynamics takes and returns, a scalar each.

    It takes the positions of the plan's driven coordinates, its unknowns, and `wound`: angles of
    joints that are cut, which are to count full turns; then the
    driven coordinates' rates, the work done [J], efforts of `actuated`, with `servos` the stiffness
    and damping by which each falls with its coordinate's position and rate, and what it is at most;
    and what loads take (`Dynamics.inputs`). It returns the rates of what it takes as positions
    without the driven; the driven coordinates' accelerations; the power of efforts and applied
    wrenches less what friction and dampers take; and for each block how well its rows determine its
    unknowns, as of `algebra.linear.solve`, to be compared with what that is elsewhere.

    rest: the speed [m/s or rad/s] below which Coulomb friction goes over from one direction to the
    other. told: it also returns the efforts and the rates of the actuated coordinates; kinetic and
    potential energy [J], power lost and power applied [W]; and how far the loops are open [m].
    seen: at last, positions and then rates of these coordinates, angles of joints that are cut
    within half a turn of home unless they are wound.
    """

    plan: Plan
    actuated: tuple[int, ...]
    wound: tuple[int, ...]
    rest: float
    servos: bool = False
    told: bool = False
    seen: tuple[int, ...] = ()

    @cached_property
    def state(self) -> int:
        """How many of what is taken are integrated: positions, driven rates, work."""
        plan = self.plan
        return len(plan.unknowns) + len(self.wound) + 2 * len(plan.driven) + 1

    @cached_property
    def count(self) -> int:
        """How many rows are returned."""
        told = (2 * len(self.actuated) + 5) * self.told
        return (
            self.state - len(self.plan.driven) + len(self.plan.blocks) + told + 2 * len(self.seen)
        )

    @property
    def inputs(self) -> int:
        """How many scalars are taken."""
        return self.state + self.efforts + self.plan.graph.dynamics.inputs

    @cached_property
    def efforts(self) -> int:
        """How many scalars tell efforts."""
        return len(self.actuated) * (4 if self.servos else 1)


class Taken(NamedTuple):
    """What such a kernel takes."""

    driven: Sequence[Scalar]
    unknowns: Sequence[Scalar]
    wound: Mapping[int, Scalar]
    rates: Sequence[Scalar]
    efforts: Sequence[Scalar]
    loads: Sequence[Scalar]

    @classmethod
    def of(cls, rows: ForwardRows, inputs: Sequence[Scalar]) -> Taken:
        """The inputs, sorted."""
        sizes = [len(rows.plan.driven), len(rows.plan.unknowns), len(rows.wound)]
        sizes += [len(rows.plan.driven), 1, rows.efforts]
        parts, rest = [], list(inputs)
        for size in sizes:
            parts.append(rest[:size])
            rest = rest[size:]
        driven, unknowns, wound, rates, _, efforts = parts
        return cls(
            driven,
            unknowns,
            dict(zip(rows.wound, wound, strict=True)),
            rates,
            efforts,
            rest,
        )


def accelerations(
    rows: ForwardRows, inputs: Sequence[Scalar], functions: Functions
) -> list[Scalar]:
    """The rates of a state; see `ForwardRows`."""
    plan, taken = rows.plan, Taken.of(rows, inputs)
    moved = motion_at(plan, taken.driven, taken.unknowns, taken.rates, functions)
    statics = Statics(plan, moved.circuits, moved.systems, functions)
    resisting = _resisting(rows, taken, moved, functions)
    efforts, moving = _efforts(rows, taken, moved, functions)
    lacking = _lacking(rows, taken, moved, statics, efforts, resisting)
    units = unit_motions(plan, moved, functions)
    matrix = mass_matrix(plan, moved, units, taken.loads)
    solved = solve(matrix, [[mul(-1.0, force) for force in lacking]], functions)
    found = [moved.circuits.rates[k] for k in plan.unknowns]
    found += [coordinate(plan, moved, k, 1)[1] for k in rows.wound]
    figures = [solve(system.jacobian, [], functions).conditioning for system in moved.systems]
    told = energies(plan, moved, taken.loads, resisting)
    given, rates = list(efforts.values()), list(moving.values())
    power = add(inner(given, rates), sub(told.applied, told.lost))
    found += [*solved.solutions[0], power, *figures]
    if rows.told:
        found += [*given, *rates, *told, open_by(plan, moved.circuits, functions)]
    seen = [coordinate(plan, moved, k, 1)[:2] for k in rows.seen]
    found += [taken.wound.get(k, value) for k, (value, _) in zip(rows.seen, seen, strict=True)]
    return found + [rate for _, rate in seen]


def _efforts(
    rows: ForwardRows, taken: Taken, moved: Moved, functions: Functions
) -> tuple[dict[int, Scalar], dict[int, Scalar]]:
    """Efforts, and rates, by actuated coordinate."""
    columns = [taken.efforts[k :: len(rows.actuated)] for k in range(len(rows.actuated))]
    efforts: dict[int, Scalar] = {}
    rates: dict[int, Scalar] = {}
    for k, (effort, *servo) in zip(rows.actuated, columns, strict=True):
        value, rates[k] = coordinate(rows.plan, moved, k, 1)[:2]
        efforts[k] = effort
        if servo:
            stiffness, damping, most = servo
            pull = mul(stiffness, taken.wound.get(k, value))
            asked = sub(effort, add(pull, mul(damping, rates[k])))
            bounded = functions.minimum(asked, most)
            efforts[k] = mul(-1.0, functions.minimum(mul(-1.0, bounded), most))
    return efforts, rates


def _resisting(
    rows: ForwardRows, taken: Taken, moved: Moved, functions: Functions
) -> dict[int, Resistance]:
    """Springs, dampers and friction in joints, by coordinate."""
    found = {}
    for k, passive in rows.plan.graph.dynamics.passive.items():
        value, rate, second = coordinate(rows.plan, moved, k, 2)
        value = taken.wound.get(k, value)
        way = smooth_direction(rate, rows.rest, functions) if passive.coulomb else 0.0
        found[k] = resistance(passive, value, rate, second, way, functions)
    return found


def _lacking(
    rows: ForwardRows,
    taken: Taken,
    moved: Moved,
    statics: Statics,
    efforts: Mapping[int, Scalar],
    resisting: Mapping[int, Resistance],
) -> list[Scalar]:
    """What the driven coordinates need beyond their efforts where they are not accelerated."""
    dynamics = rows.plan.graph.dynamics
    wrenches = wrenches_needed(moved.circuits, dynamics, taken.loads, statics.functions)
    needs = statics.after_efforts(Needs(wrenches, {}), efforts)
    for k, found in resisting.items():
        needs = needs.less(statics.unit_effort(k), mul(-1.0, found.effort))
    return statics.for_driven(statics.answer(needs).left)


def open_by(plan: Plan, circuits: Circuits, functions: Functions) -> Scalar:
    """The norm of all closure rows [m]."""
    total: Scalar = 0.0
    for row in all_rows(plan.graph, plan.tree):
        end = loops.ends(circuits, row.cut)
        gap = mul(row.per_length(plan.graph), row.value(circuits, end))
        total = add(total, mul(gap, gap))
    size: Scalar = functions.sqrt(total)
    return size


def mass_matrix(
    plan: Plan, moved: Moved, units: Sequence[Circuits], loads: Sequence[Scalar]
) -> list[list[Scalar]]:
    """That of the driven coordinates, armatures included. units: of `unit_motions`."""
    dynamics = plan.graph.dynamics
    parts = parts_of(dynamics, loads)
    armatures = {k: p.armature for k, p in dynamics.passive.items() if p.armature}
    rates = [
        [coordinate(plan, moved._replace(circuits=unit, moving=unit), k, 1)[1] for k in armatures]
        for unit in units
    ]
    matrix: list[list[Scalar]] = [[0.0] * len(units) for _ in units]
    for i, one in enumerate(units):
        weighted = [mul(a, r) for a, r in zip(armatures.values(), rates[i], strict=True)]
        for j, other in enumerate(units[: i + 1]):
            total = inner(weighted, rates[j])
            for part in parts:
                total = add(total, inertia_of(one, other, part))
            matrix[i][j] = matrix[j][i] = total
    return matrix
