"""The blocks transposed: from efforts in the unknowns to multipliers of the closure rows.

Where rates go through the blocks forwards (eq. 10), efforts come back through them in reverse: by
virtual powers the transpose of the same matrices, block by block.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from parakin.algebra.linear import inner, solve
from parakin.algebra.spatial import Functions, Scalar, add, mul, sub
from parakin.kernel.connectivity import System

Multipliers = list[list[Scalar]]  # one for each row of each block


def multipliers(
    systems: Sequence[System], efforts: Mapping[int, Scalar], functions: Functions
) -> Multipliers:
    """What the rows have to exert where the unknowns need these efforts; what is absent is zero.

    Of more rows than unknowns in a block the least in the sum of squares.
    """
    left = dict(efforts)
    found: Multipliers = []
    for system in reversed(systems):
        sides = [left.get(k, 0.0) for k in system.block.unknowns]
        rows = least_transposed(system.jacobian, sides, functions)
        for row, columns in zip(rows, system.coupling, strict=True):
            for k, slope in columns.items():
                left[k] = sub(left.get(k, 0.0), mul(row, slope))
        found.append(rows)
    return found[::-1]


def least_transposed(
    jacobian: Sequence[Sequence[Scalar]], sides: Sequence[Scalar], functions: Functions
) -> list[Scalar]:
    """The least solution of Jᵀ x = sides."""
    if all(type(side) is float and side == 0.0 for side in sides):
        return [0.0 for _ in jacobian]
    columns = [list(column) for column in zip(*jacobian, strict=True)]
    if len(jacobian) == len(sides):
        return solve(columns, [sides], functions).solutions[0]
    # x = J y, with one step of refinement, as JᵀJ has the square of J's conditioning.
    squares = [[inner(a, b) for b in columns] for a in columns]
    found: list[Scalar] = [0.0 for _ in jacobian]
    for _ in range(2):
        rest = [sub(side, inner(c, found)) for side, c in zip(sides, columns, strict=True)]
        y = solve(squares, [rest], functions).solutions[0]
        found = [add(x, inner(row, y)) for x, row in zip(found, jacobian, strict=True)]
    return found
