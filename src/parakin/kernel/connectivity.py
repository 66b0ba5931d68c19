"""The matrix conditions of connectivity (eq. 10) and their derivative, solved block by block."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

from parakin.algebra.linear import solve, squared_volume
from parakin.algebra.spatial import Functions, Scalar, add, mul, sub
from parakin.kinematics import loops
from parakin.kinematics.closure import Row, all_rows
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
    slopes = _Slopes(circuits, {})
    rows = all_rows(plan.graph, plan.tree)
    columns: list[list[Scalar]] = []
    for k in plan.unsolved:
        rates = _following(plan, slopes, k, functions)
        columns.append([mul(row.per_length(plan.graph), slopes.drift(row, rates)) for row in rows])
    return squared_volume(columns, functions)


class _Slopes(NamedTuple):
    """Derivatives of rows by coordinates, each worked out once: most loops know few coordinates, so
    that most drifts of a long chain are literal zeros.
    """

    circuits: Circuits
    known: dict[tuple[Row, int], Scalar]

    def slope(self, row: Row, k: int) -> Scalar:
        """Of a row by a coordinate of its loop."""
        if (row, k) not in self.known:
            end, side = loops.ends(self.circuits, row.cut), loops.sides(self.circuits, row.cut)[k]
            self.known[row, k] = row.derivative(self.circuits, end, k, side)
        return self.known[row, k]

    def drift(self, row: Row, rates: Mapping[int, Scalar]) -> Scalar:
        """How a row changes at these rates, all other coordinates resting."""
        total: Scalar = 0.0
        for k in loops.sides(self.circuits, row.cut):
            if k in rates:
                total = add(total, mul(self.slope(row, k), rates[k]))
        return total


def _following(plan: Plan, slopes: _Slopes, k: int, functions: Functions) -> dict[int, Scalar]:
    """Rates where a coordinate moves at one and the unknowns follow; what rests is left out."""
    rates: dict[int, Scalar] = {k: 1.0}
    for block in plan.blocks:
        drifts = [slopes.drift(row, rates) for row in block.rows]
        if all(type(drift) is float and drift == 0.0 for drift in drifts):
            continue
        matrix = jacobian(slopes.circuits, block)
        found = solve(matrix, [drifts], functions, block.form.lengths).solutions[0]
        rates |= {n: sub(0.0, rate) for n, rate in zip(block.unknowns, found, strict=True)}
    return rates


def signed_square(a: Scalar, functions: Functions) -> Scalar:
    """The square of what is given, with its sign."""
    size: Scalar = functions.sqrt(mul(a, a))
    return mul(a, size)
