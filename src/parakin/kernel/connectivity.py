"""The matrix conditions of connectivity (eq. 10) and their derivative, solved block by block."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

from parakin.algebra.linear import solve, squared_volume
from parakin.algebra.spatial import Functions, Scalar, add, mul, sub
from parakin.kinematics import loops
from parakin.kinematics.closure import all_rows
from parakin.kinematics.recursion import Circuits
from parakin.planning.forms import Iterated
from parakin.planning.plan import Block, Plan


class System(NamedTuple):
    """A block's rows as the matrix conditions of connectivity (eq. 10): columns by coordinate."""

    block: Block
    ends: list[loops.Ends]
    jacobian: list[list[Scalar]]
    coupling: list[dict[int, Scalar]]

    @classmethod
    def of(cls, circuits: Circuits, block: Block) -> System:
        ends = [loops.ends(circuits, row.cut) for row in block.rows]
        earlier: list[dict[int, Scalar]] = []
        for row, end in zip(block.rows, ends, strict=True):
            sides = loops.sides(circuits, row.cut)
            earlier.append(
                {k: row.derivative(circuits, end, k, sides[k]) for k in block.needs if k in sides}
            )
        return cls(block, ends, jacobian(circuits, block), earlier)

    def rates(self, circuits: Circuits) -> list[Scalar]:
        """How the rows change while every unknown rests."""
        pairs = zip(self.block.rows, self.ends, strict=True)
        return [row.rate(circuits, end) for row, end in pairs]

    def accelerations(self, circuits: Circuits) -> list[Scalar]:
        """The rows' second derivatives while every unknown keeps its rate."""
        return [
            r.acceleration(circuits, e) for r, e in zip(self.block.rows, self.ends, strict=True)
        ]


def jacobian(circuits: Circuits, block: Block, later: Collection[int] = ()) -> list[list[Scalar]]:
    """The rows' slopes; loops with coordinates still to come (`later`) are open."""
    matrix: list[list[Scalar]] = []
    for row in block.rows:
        end, sides = loops.ends(circuits, row.cut), loops.sides(circuits, row.cut)
        open_ = not sides.keys().isdisjoint(later)
        matrix.append(
            [
                row.derivative(circuits, end, k, sides[k], open_=open_) if k in sides else 0.0
                for k in block.unknowns
            ]
        )
    return matrix


def solve_blocks(
    plan: Plan,
    systems: Sequence[System],
    drifts: Sequence[Sequence[Scalar]],
    functions: Functions,
) -> tuple[dict[int, Scalar], list[tuple[Block, Scalar]]]:
    """The unknowns' rates block by block: what the rows drift, and what is found, add to zero.

    With them the conditioning of the blocks that are iterated, squared.
    """
    found: dict[int, Scalar] = {}
    figures: list[tuple[Block, Scalar]] = []
    for block, system, drift in zip(plan.blocks, systems, drifts, strict=True):
        sides: list[Scalar] = []
        for start, columns in zip(drift, system.coupling, strict=True):
            side = start
            for k, slope in columns.items():
                side = add(side, mul(slope, found[k]))
            sides.append(side)
        solved = solve(system.jacobian, [sides], functions, block.form.lengths)
        found |= {
            k: sub(0.0, value) for k, value in zip(block.unknowns, solved.solutions[0], strict=True)
        }
        if isinstance(block.form, Iterated):
            figure = mul(block.form.sign / block.form.reference, solved.conditioning)
            figures.append((block, signed_square(figure, functions)))
    return found, figures


def unsolved_volume(plan: Plan, circuits: Circuits, functions: Functions) -> Scalar:
    """How firmly the loops hold coordinates that are affine on this branch and so not solved for.

    Each of them alone is given a unit rate, the unknowns follow, and what the closure rows then
    drift spans a volume: zero where an unsolved coordinate could move as well. Its square is given.
    """
    systems = [System.of(circuits, block) for block in plan.blocks]
    rows = all_rows(plan.graph, plan.tree)
    rest: dict[int, Scalar] = dict.fromkeys([*plan.affine, *plan.unknowns], 0.0)
    columns: list[list[Scalar]] = []
    for k in plan.unsolved:
        moving = circuits.with_coordinates(rates={**rest, k: 1.0})
        drifts = [system.rates(moving) for system in systems]
        moving.set_rates(rates=solve_blocks(plan, systems, drifts, functions)[0])
        ends = {cut: loops.ends(moving, cut) for cut in plan.tree.cuts}
        columns.append(
            [mul(row.per_length(plan.graph), row.rate(moving, ends[row.cut])) for row in rows]
        )
    return squared_volume(columns, functions)


def signed_square(a: Scalar, functions: Functions) -> Scalar:
    """The square of what is given, with its sign."""
    size: Scalar = functions.sqrt(mul(a, a))
    return mul(a, size)
