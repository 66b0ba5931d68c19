"""Vectors and rotations on any scalar: a float, a NumPy array, an expression to be compiled.

A vector is a tuple of three scalars, a matrix a tuple of three rows. A literal `0.0` or `1.0`
(a Python float) is recognised and dropped from sums and products, so that the zeros of a
mechanism's geometry never reach the compiled code.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

Scalar = Any  # float | FloatArray | heyoka.expression: whatever + - * / works on
Vector = tuple[Scalar, Scalar, Scalar]
Matrix = tuple[Vector, Vector, Vector]

ZERO: Vector = (0.0, 0.0, 0.0)
IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class Functions(NamedTuple):
    """The elementary functions of one kind of scalar."""

    sin: Callable[[Scalar], Scalar]
    cos: Callable[[Scalar], Scalar]
    sqrt: Callable[[Scalar], Scalar]
    atan2: Callable[[Scalar, Scalar], Scalar]
    minimum: Callable[[Scalar, Scalar], Scalar]
    copysign: Callable[[Scalar, Scalar], Scalar]


FLOATS = Functions(math.sin, math.cos, math.sqrt, math.atan2, min, math.copysign)
ARRAYS = Functions(np.sin, np.cos, np.sqrt, np.arctan2, np.minimum, np.copysign)


def _is(a: Scalar, literal: float) -> bool:
    return type(a) is float and a == literal  # a NumPy scalar is a value, whatever it holds


def add(a: Scalar, b: Scalar) -> Scalar:
    if _is(a, 0.0):
        return b
    return a if _is(b, 0.0) else a + b


def sub(a: Scalar, b: Scalar) -> Scalar:
    if _is(b, 0.0):
        return a
    return -b if _is(a, 0.0) else a - b


def mul(a: Scalar, b: Scalar) -> Scalar:
    if _is(a, 0.0) or _is(b, 0.0):
        return 0.0
    if _is(a, 1.0):
        return b
    if _is(b, 1.0):
        return a
    if _is(a, -1.0):
        return -b
    return -a if _is(b, -1.0) else a * b


def plus(a: Vector, b: Vector) -> Vector:
    return (add(a[0], b[0]), add(a[1], b[1]), add(a[2], b[2]))


def minus(a: Vector, b: Vector) -> Vector:
    return (sub(a[0], b[0]), sub(a[1], b[1]), sub(a[2], b[2]))


def times(factor: Scalar, a: Vector) -> Vector:
    return (mul(factor, a[0]), mul(factor, a[1]), mul(factor, a[2]))


def dot(a: Vector, b: Vector) -> Scalar:
    return add(add(mul(a[0], b[0]), mul(a[1], b[1])), mul(a[2], b[2]))


def cross(a: Vector, b: Vector) -> Vector:
    return (
        sub(mul(a[1], b[2]), mul(a[2], b[1])),
        sub(mul(a[2], b[0]), mul(a[0], b[2])),
        sub(mul(a[0], b[1]), mul(a[1], b[0])),
    )


def transpose(m: Matrix) -> Matrix:
    (a, b, c), (d, e, f), (g, h, i) = m
    return ((a, d, g), (b, e, h), (c, f, i))


def column(m: Matrix, k: int) -> Vector:
    return (m[0][k], m[1][k], m[2][k])


def apply(m: Matrix, a: Vector) -> Vector:
    return (dot(m[0], a), dot(m[1], a), dot(m[2], a))


def compose(m: Matrix, n: Matrix) -> Matrix:
    columns = transpose(n)
    return (
        (dot(m[0], columns[0]), dot(m[0], columns[1]), dot(m[0], columns[2])),
        (dot(m[1], columns[0]), dot(m[1], columns[1]), dot(m[1], columns[2])),
        (dot(m[2], columns[0]), dot(m[2], columns[1]), dot(m[2], columns[2])),
    )


def turned(m: Matrix, axis: int, cosine: Scalar, sine: Scalar) -> Matrix:
    """`m` followed by a turn about its own axis 0, 1 or 2 (x, y, z)."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    u, v = column(m, i), column(m, j)
    columns = [column(m, 0), column(m, 1), column(m, 2)]
    columns[i] = plus(times(cosine, u), times(sine, v))
    columns[j] = minus(times(cosine, v), times(sine, u))
    return transpose((columns[0], columns[1], columns[2]))
