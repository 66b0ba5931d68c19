"""Forms: how the unknowns of a block follow from its rows.

A single unknown has a closed form; each kind is a value that solves for it, on any scalar, and
gives the figures of conditioning it met on the way. Several unknowns, or one that no row gives
directly, are iterated on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple

import numpy as np

from parakin.algebra.spatial import Functions, Scalar, add, dot, mul, sub
from parakin.arrays import FloatArray
from parakin.kinematics import loops
from parakin.kinematics.closure import CentreDistance, Gap, RodLength, Row
from parakin.kinematics.recursion import Circuits, Turn, slide

_POOR = 0.05  # a home this near to singular, per unknown, is not what others are measured by
_SINGULAR = 1e-7  # a determinant this small, rows of length one, is zero


class Solution(NamedTuple):
    """The unknown, of an angle cosine and sine, and squared figures of conditioning: those whose
    sign, or whose root's sign, distinguishes branches, and those alike on either side of a
    singularity.
    """

    turn: Turn
    signed: tuple[Scalar, ...] = ()
    unsigned: tuple[Scalar, ...] = ()


@dataclass(frozen=True)
class LinearSlide:
    """b q + c = 0. `regular`: b is the same everywhere."""

    regular: bool
    lengths: ClassVar[tuple[float, ...]] = ()

    @property
    def unsigned(self) -> bool:
        """Whether a figure of it keeps no sign where it passes zero."""
        return not self.regular

    def solve(self, base: Circuits, k: int, rows: Sequence[Row], _: Functions) -> Solution:
        """Coordinate `k`, all others that the row depends on being those of `base`."""
        (row,) = rows
        assert isinstance(row, Gap)
        at_zero = base.with_coordinates({k: slide(0.0)})
        end = loops.ends(at_zero, row.cut)
        c = row.value(at_zero, end)
        b = row.derivative(at_zero, end, k, loops.sides(at_zero, row.cut)[k])
        turn = slide(-c / b)
        if self.regular:
            return Solution(turn)
        u = row.direction(at_zero, end)
        return Solution(turn, unsigned=(mul(b, b) / dot(u, u),))


NEAR = 0.01  # of the characteristic length: a distance that counts as one to be watched


@dataclass(frozen=True)
class QuadraticSlide:
    """A distance given: ± q²/2 + b q + c = 0. `sign` is that of the root."""

    regular: bool
    sign: float = 1.0
    unsigned: ClassVar[bool] = False
    lengths: ClassVar[tuple[float, ...]] = ()

    def solve(self, base: Circuits, k: int, rows: Sequence[Row], functions: Functions) -> Solution:
        """Coordinate `k`, all others that the row depends on being those of `base`."""
        (row,) = rows
        assert isinstance(row, (CentreDistance, RodLength))
        at_zero = base.with_coordinates({k: slide(0.0)})
        end, side = loops.ends(at_zero, row.cut), loops.sides(at_zero, row.cut)[k]
        c, b = row.value(at_zero, end), row.derivative(at_zero, end, k, side)
        u, side, _ = row.arm(at_zero, end, k, side)
        reach = sub(mul(b, b), mul(2.0 * side, c))
        root = functions.sqrt(reach)
        turn = slide(mul(side, sub(mul(self.sign, root), b)))
        if self.regular:  # until the centre is reached, beyond which the other root is right
            near = NEAR * base.graph.length
            return Solution(turn, signed=(mul(1.0 / near**2, reach),))
        aside = sub(dot(u, u), mul(b, b))  # the square of the centre's distance from the slide
        return Solution(turn, signed=(reach / add(reach, aside),))


@dataclass(frozen=True)
class TangentAngle:
    """a cos q + b sin q = 0: of two roots half a turn apart the one of this `sign`.

    `regular`: the arm (a, b) is as long everywhere as at home, `reference`.
    """

    regular: bool
    reference: float
    sign: float = 1.0
    unsigned: ClassVar[bool] = False
    lengths: ClassVar[tuple[float, ...]] = ()

    def solve(self, base: Circuits, k: int, rows: Sequence[Row], functions: Functions) -> Solution:
        """Coordinate `k`, all others that the row depends on being those of `base`."""
        (row,) = rows
        a, b = _value(base, k, row, AHEAD), _value(base, k, row, ACROSS)
        size = add(mul(a, a), mul(b, b))
        scale = mul(self.sign, functions.inverse(functions.sqrt(size)))
        turn = Turn(None, mul(b, scale), -mul(a, scale))
        return Solution(turn, _arm_figures(self, size))


@dataclass(frozen=True)
class CosineAngle:
    """a cos q + b sin q + c = 0: of two roots, that meet where the row's slope vanishes, the one
    of this `sign`. `regular` and `reference` as of `TangentAngle`.
    """

    regular: bool
    reference: float
    sign: float = 1.0
    unsigned: ClassVar[bool] = False
    lengths: ClassVar[tuple[float, ...]] = ()

    def solve(self, base: Circuits, k: int, rows: Sequence[Row], functions: Functions) -> Solution:
        """Coordinate `k`, all others that the row depends on being those of `base`."""
        (row,) = rows
        a, b, c = _linear(base, k, row)
        size = add(mul(a, a), mul(b, b))
        reach = sub(size, mul(c, c))
        root = mul(self.sign, functions.sqrt(reach))
        inverse = functions.inverse(size)
        cosine = mul(inverse, sub(mul(b, root), mul(a, c)))
        sine = -mul(inverse, add(mul(b, c), mul(a, root)))
        figures = (mul(reach, inverse), *_arm_figures(self, size))
        return Solution(Turn(None, cosine, sine), figures)


@dataclass(frozen=True)
class TwoRowAngle:
    """Two rows a cos q + b sin q + c = 0, in an overconstrained loop: together they have one
    root.
    """

    unsigned: ClassVar[bool] = True
    lengths: ClassVar[tuple[float, ...]] = ()

    def solve(self, base: Circuits, k: int, rows: Sequence[Row], functions: Functions) -> Solution:
        """Coordinate `k`, all others that the rows depend on being those of `base`."""
        (a, b, c), (d, e, f) = (_linear(base, k, row) for row in rows)
        across = sub(mul(a, e), mul(b, d))
        cosine, sine = sub(mul(b, f), mul(c, e)), sub(mul(c, d), mul(a, f))
        # Both are over `across`, whose sign has to be kept when they are brought to length one.
        size = add(mul(cosine, cosine), mul(sine, sine))
        scale = functions.copysign(functions.inverse(functions.sqrt(size)), across)
        lengths = mul(add(mul(a, a), mul(b, b)), add(mul(d, d), mul(e, e)))
        figure = mul(across, across) / lengths
        return Solution(Turn(None, mul(scale, cosine), mul(scale, sine)), unsigned=(figure,))


@dataclass(frozen=True)
class Iterated:
    """Newton's method. `sign` is that of the rows' determinant at home and `reference` its size,
    the rows being of these `lengths`; of more rows than unknowns (`unsigned`) it is the volume
    that they span.
    """

    unsigned: bool = False
    sign: float = 1.0
    reference: float = 1.0
    lengths: tuple[float, ...] = ()


ITERATED = Iterated()

TwoRoots = QuadraticSlide | TangentAngle | CosineAngle
Form = LinearSlide | QuadraticSlide | TangentAngle | CosineAngle | TwoRowAngle | Iterated

AHEAD, ACROSS, BACK = Turn(0.0, 1.0, 0.0), Turn(0.0, 0.0, 1.0), Turn(0.0, -1.0, 0.0)


def _value(base: Circuits, k: int, row: Row, at: Turn) -> Scalar:
    there = base.with_coordinates({k: at})
    return row.value(there, loops.ends(there, row.cut))


def _linear(base: Circuits, k: int, row: Row) -> tuple[Scalar, Scalar, Scalar]:
    """a, b and c of a row's value a cos + b sin + c."""
    ahead, behind = _value(base, k, row, AHEAD), _value(base, k, row, BACK)
    a, c = mul(0.5, sub(ahead, behind)), mul(0.5, add(ahead, behind))
    return a, sub(_value(base, k, row, ACROSS), c), c


def _arm_figures(form: TangentAngle | CosineAngle, size: Scalar) -> tuple[Scalar, ...]:
    """An arm that shrinks leaves its angle undetermined."""
    return () if form.regular else (mul(1.0 / form.reference**2, size),)


def signed(form: Form, slopes: FloatArray) -> Form | None:
    """The form with the sign of its root, or of its determinant, at home, where its rows have
    these slopes (rows, unknowns), and with what its conditioning is measured by. None where home
    is singular.
    """
    if isinstance(form, TwoRowAngle):
        return form
    rows, unknowns = slopes.shape
    if rows > unknowns:
        return Iterated(unsigned=True, reference=float(np.sqrt(np.linalg.det(slopes.T @ slopes))))
    lengths = np.linalg.norm(slopes, axis=1, keepdims=True)
    determinant = float(np.linalg.det(slopes / np.where(lengths > 0.0, lengths, 1.0)))
    if not abs(determinant) > _SINGULAR:
        return None
    sign = float(np.sign(determinant))
    if isinstance(form, TwoRoots):
        return replace(form, sign=sign)
    if isinstance(form, LinearSlide):
        return form
    if unknowns == 1:
        return Iterated(sign=sign, reference=abs(float(slopes[0, 0])))
    reference = max(abs(determinant), _POOR**unknowns)
    return Iterated(sign=sign, reference=reference, lengths=tuple(lengths[:, 0].tolist()))
