"""Vectors, rotations and poses on any scalar: a float, an array, an expression to be compiled.

A literal `0.0` or `1.0` (a Python float) is recognised and dropped from sums and products, so
that the zeros of a mechanism's geometry never reach the compiled code.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, Protocol, SupportsFloat, cast, overload

import numpy as np

from parakin.arrays import FloatArray

if TYPE_CHECKING:
    from typing_extensions import TypeVar  # which knows defaults
else:
    from typing import TypeVar as _TypeVar

    def TypeVar(name, *, bound, default, covariant=False):  # noqa: ARG001
        return _TypeVar(name, covariant=covariant)


class Scalar(Protocol):
    """What the recursion computes with: a float, a NumPy array, a dual number, an expression."""

    def __neg__(self) -> Scalar: ...
    def __add__(self, other: Any, /) -> Scalar: ...
    def __radd__(self, other: Any, /) -> Scalar: ...
    def __sub__(self, other: Any, /) -> Scalar: ...
    def __rsub__(self, other: Any, /) -> Scalar: ...
    def __mul__(self, other: Any, /) -> Scalar: ...
    def __rmul__(self, other: Any, /) -> Scalar: ...
    def __truediv__(self, other: Any, /) -> Scalar: ...
    def __rtruediv__(self, other: Any, /) -> Scalar: ...


class Functions(NamedTuple):
    """The elementary functions of one kind of scalar. inverse: 1 / a, shared by all that is divided
    by a.
    """

    sin: Callable[[Any], Any]
    cos: Callable[[Any], Any]
    sqrt: Callable[[Any], Any]
    atan2: Callable[[Any, Any], Any]
    minimum: Callable[[Any, Any], Any]
    copysign: Callable[[Any, Any], Any]
    inverse: Callable[[Any], Any]


def _atan2_of_floats(y: float, x: float) -> float:
    return math.atan2(y + 0.0, x + 0.0)


def _atan2_of_arrays(y: Any, x: Any) -> Any:
    return np.arctan2(y + 0.0, x + 0.0)


def _inverse(a: Any) -> Any:
    return 1.0 / a


# No zero is negative for the angle of a point: half a turn is π, not -π, whatever computes it.
FLOATS = Functions(math.sin, math.cos, math.sqrt, _atan2_of_floats, min, math.copysign, _inverse)
ARRAYS = Functions(np.sin, np.cos, np.sqrt, _atan2_of_arrays, np.minimum, np.copysign, _inverse)


S = TypeVar("S", bound=Scalar, default=Scalar)
S_co = TypeVar("S_co", bound=Scalar, default=Scalar, covariant=True)


def as_array(a: Scalar | Sequence[Any]) -> FloatArray:
    """Numbers, or arrays of them, as one array."""
    return np.asarray(a, dtype=float)


def as_float(a: Scalar) -> float:
    """A scalar that is a number, as a float. Raises TypeError if it is not one."""
    return float(cast(SupportsFloat, a))


# (What follows is called millions of times, so nothing else is called in it. A NumPy scalar is a
# value, whatever it holds: only a plain float is a literal.)


def add(a: S, b: S) -> S:
    """The sum."""
    if type(a) is float and a == 0.0:
        return b
    return a if type(b) is float and b == 0.0 else a + b  # type: ignore[return-value]


def sub(a: S, b: S) -> S:
    """The difference."""
    if type(b) is float and b == 0.0:
        return a
    return -b if type(a) is float and a == 0.0 else a - b  # type: ignore[return-value]


def mul(a: S, b: S) -> S:
    """The product."""
    if type(a) is float:
        if a == 0.0:
            return 0.0  # type: ignore[return-value]
        if a == 1.0:
            return b
        if type(b) is float and b == 0.0:
            return 0.0  # type: ignore[return-value]
        if a == -1.0:
            return -b  # type: ignore[return-value]
    if type(b) is float:
        if b == 0.0:
            return 0.0  # type: ignore[return-value]
        if b == 1.0:
            return a
        if b == -1.0:
            return -a  # type: ignore[return-value]
    return a * b  # type: ignore[return-value]


class Vector(tuple[S_co, S_co, S_co]):
    """Three components. `+`, `-` and a factor are those of vectors, not of tuples; a factor that is
    not a plain number stands on the right, where no other type's operators come first.
    """

    __slots__ = ()
    __array_ufunc__ = None  # nor those of a NumPy number, wherever it stands

    def __add__(self: Vector[S], other: Vector[S]) -> Vector[S]:  # type: ignore[override]
        return Vector((add(self[0], other[0]), add(self[1], other[1]), add(self[2], other[2])))

    def __sub__(self: Vector[S], other: Vector[S]) -> Vector[S]:
        return Vector((sub(self[0], other[0]), sub(self[1], other[1]), sub(self[2], other[2])))

    def __mul__(self: Vector[S], factor: S) -> Vector[S]:  # type: ignore[override]
        return Vector((mul(factor, self[0]), mul(factor, self[1]), mul(factor, self[2])))

    __rmul__ = __mul__  # type: ignore[assignment]


ZERO: Vector[float] = Vector((0.0, 0.0, 0.0))


def dot(a: Vector[S], b: Vector[S]) -> S:
    """The scalar product."""
    (x, y, z), (u, v, w) = a, b
    if (
        type(x) is float
        and type(y) is float
        and type(z) is float
        and type(u) is float
        and type(v) is float
        and type(w) is float
    ):
        # Plain numbers: the same sum, and no negative zero.
        return x * u + y * v + z * w + 0.0  # type: ignore[return-value]
    return add(add(mul(a[0], b[0]), mul(a[1], b[1])), mul(a[2], b[2]))


def cross(a: Vector[S], b: Vector[S]) -> Vector[S]:
    """The vector product."""
    return Vector(
        (
            sub(mul(a[1], b[2]), mul(a[2], b[1])),
            sub(mul(a[2], b[0]), mul(a[0], b[2])),
            sub(mul(a[0], b[1]), mul(a[1], b[0])),
        )
    )


class Matrix(tuple[Vector[S_co], Vector[S_co], Vector[S_co]]):
    """Three rows; as a rotation R_AB it takes components in B to A, its columns are B's axes."""

    __slots__ = ()

    @property
    def T(self) -> Matrix[S_co]:
        """The transpose: of a rotation R_AB it is R_BA."""
        (a, b, c), (d, e, f), (g, h, i) = self
        return Matrix((Vector((a, d, g)), Vector((b, e, h)), Vector((c, f, i))))

    def column(self, k: int) -> Vector[S_co]:
        """Column 0, 1 or 2: of R_AB the x, y or z axis of B."""
        return Vector((self[0][k], self[1][k], self[2][k]))

    @overload
    def __matmul__(self: Matrix[S], other: Vector[S]) -> Vector[S]: ...
    @overload
    def __matmul__(self: Matrix[S], other: Matrix[S]) -> Matrix[S]: ...
    def __matmul__(self: Matrix[S], other: Vector[S] | Matrix[S]) -> Vector[S] | Matrix[S]:
        if isinstance(other, Vector):
            return Vector((dot(self[0], other), dot(self[1], other), dot(self[2], other)))
        a, b, c = other.T
        return Matrix(Vector((dot(row, a), dot(row, b), dot(row, c))) for row in self)


def matrix(rows: Iterable[Iterable[S]]) -> Matrix[S]:
    """Three rows of three components as a matrix."""
    return Matrix(Vector(row) for row in rows)


IDENTITY: Matrix[float] = matrix(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))


def turned(R: Matrix[S], axis: int, cosine: S, sine: S) -> Matrix[S]:
    """`R` followed by a turn about its own axis 0, 1 or 2 (x, y, z)."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    u, v = R.column(i), R.column(j)
    columns = [R.column(0), R.column(1), R.column(2)]
    columns[i] = u * cosine + v * sine
    columns[j] = v * cosine - u * sine
    return Matrix((columns[0], columns[1], columns[2])).T


class Pose(NamedTuple, Generic[S_co]):
    """X_AB, a frame B seen from A: R_AB and p_AB, B's origin in components of A."""

    R: Matrix[S_co]
    p: Vector[S_co]

    def __matmul__(self: Pose[S], other: Pose[S]) -> Pose[S]:
        """X_AC = X_AB X_BC (eqs. 1, 7 and 8)."""
        return Pose(self.R @ other.R, self.p + self.R @ other.p)

    @property
    def inverse(self) -> Pose[S_co]:
        """X_BA."""
        R_BA = self.R.T
        return Pose(R_BA, ZERO - R_BA @ self.p)


IDENTITY_POSE: Pose[float] = Pose(IDENTITY, ZERO)
