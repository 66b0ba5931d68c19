"""Small dense systems solved without a branch on values, on any scalar.

One and two unknowns by division, three by cross products, more by Householder's orthogonal
triangularisation, which needs no pivots. The determinant, divided by the lengths of the rows,
lies between -1 and 1 and vanishes where the system is singular: it is the conditioning figure
(of a single equation, the slope itself).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from parakin.algebra.spatial import Functions, Scalar, Vector, add, cross, dot, mul, sub


class Solved(NamedTuple):
    """One solution per right-hand side, and the scaled determinant; of more rows than unknowns
    the volume that the columns span.
    """

    solutions: list[list[Scalar]]
    conditioning: Scalar


def solve(
    matrix: Sequence[Sequence[Scalar]],
    sides: Sequence[Sequence[Scalar]],
    functions: Functions,
    typical: Sequence[float] = (),
) -> Solved:
    """Solve matrix x = side for every side; by least squares if there are more rows than unknowns.

    typical: how long the rows usually are. Rows then count by the mean square of that and what
    they are, so that one which vanishes as a whole shows in the conditioning.
    """
    n = len(matrix[0])
    if len(matrix) > n == 1:
        (column,) = zip(*matrix, strict=True)
        square = inner(column, column)
        inverse = functions.inverse(square)
        found = [[mul(inverse, inner(column, side))] for side in sides]
        return Solved(found, functions.sqrt(square))
    if len(matrix) > n:
        solutions, volume = _by_reflections(matrix, sides, functions)
        return Solved(solutions, functions.sqrt(mul(volume, volume)))
    if n == 1:
        inverse = functions.inverse(matrix[0][0])  # which later right-hand sides share
        return Solved([[mul(inverse, side[0])] for side in sides], matrix[0][0])
    lengths: Scalar = 1.0
    for number, row in enumerate(matrix):
        square = inner(row, row)
        if typical:
            square = mul(0.5, add(square, typical[number] ** 2))
        lengths = mul(lengths, square)
    if n <= 3:
        solutions, determinant = _by_minors(matrix, sides, functions)
    else:
        solutions, determinant = _by_reflections(matrix, sides, functions)
    return Solved(solutions, determinant / functions.sqrt(lengths))


def inner(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    """The sum of products, a length squared if both are the same."""
    total: Scalar = 0.0
    for x, y in zip(a, b, strict=True):
        total = add(total, mul(x, y))
    return total


def _by_minors(
    m: Sequence[Sequence[Scalar]], sides: Sequence[Sequence[Scalar]], functions: Functions
) -> tuple[list[list[Scalar]], Scalar]:
    if len(m) == 2:
        determinant = sub(mul(m[0][0], m[1][1]), mul(m[0][1], m[1][0]))
        scale = functions.inverse(determinant)
        return [
            [
                mul(scale, sub(mul(s[0], m[1][1]), mul(m[0][1], s[1]))),
                mul(scale, sub(mul(m[0][0], s[1]), mul(s[0], m[1][0]))),
            ]
            for s in sides
        ], determinant
    a, b, c = (Vector(row) for row in m)
    cofactors: list[Vector] = [cross(b, c), cross(c, a), cross(a, b)]
    determinant = dot(a, cofactors[0])
    scale = functions.inverse(determinant)
    solutions = []
    for s in sides:
        parts = [
            add(
                add(mul(s[0], cofactors[0][k]), mul(s[1], cofactors[1][k])),
                mul(s[2], cofactors[2][k]),
            )
            for k in range(3)
        ]
        solutions.append([mul(scale, part) for part in parts])
    return solutions, determinant


def squared_volume(columns: Sequence[Sequence[Scalar]], functions: Functions) -> Scalar:
    """The square of the volume that columns span, zero where they depend on one another."""
    # Of long chains most components are literal zeros.
    full = [{i: x for i, x in enumerate(column) if not _literal_zero(x)} for column in columns]
    products = [[inner(*_common(a, b)) for b in full] for a in full]
    if len(columns) == 1:
        return products[0][0]
    if len(columns) <= 3:
        return _by_minors(products, [], functions)[1]
    return _by_reflections(products, [], functions)[1]


def _common(a: Mapping[int, Scalar], b: Mapping[int, Scalar]) -> tuple[list[Scalar], list[Scalar]]:
    both = [i for i in a if i in b]
    return [a[i] for i in both], [b[i] for i in both]


def _by_reflections(
    matrix: Sequence[Sequence[Scalar]], sides: Sequence[Sequence[Scalar]], functions: Functions
) -> tuple[list[list[Scalar]], Scalar]:
    n = len(matrix[0])
    rows = [[*row, *(side[i] for side in sides)] for i, row in enumerate(matrix)]
    rows, inverses, determinant = _triangular(rows, n, functions)
    solutions: list[list[Scalar]] = []
    for s in range(len(sides)):
        x: list[Scalar] = [0.0] * n
        for i in reversed(range(n)):
            value = rows[i][n + s]
            for j in range(i + 1, n):
                value = sub(value, mul(rows[i][j], x[j]))
            x[i] = mul(inverses[i], value)
        solutions.append(x)
    return solutions, determinant


def _literal_zero(a: Scalar) -> bool:
    return type(a) is float and a == 0.0


def _triangular(
    rows: list[list[Scalar]], columns: int, functions: Functions
) -> tuple[list[list[Scalar]], list[Scalar], Scalar]:
    """Rows (right-hand sides with them) made triangular: these, the inverses of their diagonal, the
    determinant.
    """
    n = len(rows)
    determinant: Scalar = 1.0
    inverses: list[Scalar] = []
    for k in range(columns):
        if all(_literal_zero(rows[i][k]) for i in range(k + 1, n)):
            inverses.append(functions.inverse(rows[k][k]))  # nothing below to remove
            determinant = mul(determinant, rows[k][k])
            continue
        square: Scalar = 0.0
        for i in range(k, n):
            square = add(square, mul(rows[i][k], rows[i][k]))
        length = functions.copysign(functions.sqrt(square), rows[k][k])
        v = {i: rows[i][k] for i in range(k, n) if not _literal_zero(rows[i][k])}
        v[k] = add(rows[k][k], length)
        half = functions.inverse(mul(length, v[k]))  # v v is twice that product
        for j in range(k + 1, len(rows[0])):
            product: Scalar = 0.0
            for i in sorted(v):
                product = add(product, mul(v[i], rows[i][j]))
            factor = mul(half, product)
            if not _literal_zero(factor):
                for i, value in v.items():
                    rows[i][j] = sub(rows[i][j], mul(factor, value))
        inverses.append(-functions.inverse(length))
        determinant = mul(determinant, length)
    return rows, inverses, determinant
