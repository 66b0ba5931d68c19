"""The matrix conditions of connectivity (eq. 10) and their derivative, solved block by block."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import NamedTuple

from parakin import closure
from parakin.closure import Row
from parakin.linear import solve
from parakin.plan import Block, Plan
from parakin.recursion import Circuits
from parakin.spatial import Functions, Scalar, add, mul, sub


class System(NamedTuple):
    """A block's rows as the matrix conditions of connectivity (eq. 10): columns by coordinate."""

    block: Block
    ends: list[closure.Ends]
    own: list[list[Scalar]]
    earlier: list[dict[int, Scalar]]

    @classmethod
    def of(cls, circuits: Circuits, block: Block) -> System:
        ends = [closure.ends(circuits, row.cut) for row in block.rows]
        earlier: list[dict[int, Scalar]] = []
        for row, end in zip(block.rows, ends, strict=True):
            sides = closure.loop(circuits, row.cut)
            earlier.append(
                {
                    k: closure.derivative(circuits, row, end, k, sides[k])
                    for k in block.needs
                    if k in sides
                }
            )
        return cls(block, ends, jacobian(circuits, block), earlier)

    def drifts(
        self, circuits: Circuits, of: Callable[[Circuits, Row, closure.Ends], Scalar]
    ) -> list[Scalar]:
        """How the rows change while every unknown rests (or keeps its rate)."""
        return [of(circuits, row, e) for row, e in zip(self.block.rows, self.ends, strict=True)]


def jacobian(circuits: Circuits, block: Block, later: Collection[int] = ()) -> list[list[Scalar]]:
    """The rows' slopes; loops with coordinates still to come (`later`) are open."""
    matrix: list[list[Scalar]] = []
    for row in block.rows:
        end, sides = closure.ends(circuits, row.cut), closure.loop(circuits, row.cut)
        open_ = not sides.keys().isdisjoint(later)
        matrix.append(
            [
                closure.derivative(circuits, row, end, k, sides[k], open_=open_)
                if k in sides
                else 0.0
                for k in block.unknowns
            ]
        )
    return matrix


def substituted(
    plan: Plan,
    systems: Sequence[System],
    drifts: Sequence[Sequence[Scalar]],
    functions: Functions,
) -> tuple[dict[int, Scalar], list[Scalar]]:
    """The unknowns' rates block by block: what the rows drift, and what is found, add to zero."""
    found: dict[int, Scalar] = {}
    figures: list[Scalar] = []
    for block, system, drift in zip(plan.blocks, systems, drifts, strict=True):
        sides: list[Scalar] = []
        for start, columns in zip(drift, system.earlier, strict=True):
            side = start
            for k, slope in columns.items():
                side = add(side, mul(slope, found[k]))
            sides.append(side)
        matrix: Sequence[Sequence[Scalar]] = system.own
        if len(matrix) > len(block.unknowns):  # more rows than unknowns: by least squares
            columns_of = list(zip(*matrix, strict=True))
            sides = [_inner(column, sides) for column in columns_of]
            matrix = [[_inner(a, b) for b in columns_of] for a in columns_of]
        solved = solve(matrix, [sides], functions, block.lengths)
        found |= {
            k: sub(0.0, value) for k, value in zip(block.unknowns, solved.solutions[0], strict=True)
        }
        if block.form == "newton":
            figure = mul(block.sign / block.lever, solved.conditioning)
            figures.append(signed_square(figure, functions))
    return found, figures


def _inner(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    total: Scalar = 0.0
    for x, y in zip(a, b, strict=True):
        total = add(total, mul(x, y))
    return total


def signed_square(a: Scalar, functions: Functions) -> Scalar:
    return mul(a, functions.sqrt(mul(a, a)))
