"""What holds throughout a box of poses, enclosed by interval arithmetic."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from parakin.algebra.intervals import centred_functions, ends, parts, spanning
from parakin.algebra.spatial import Scalar
from parakin.arrays import FloatArray
from parakin.kernel.coordinates import coordinate
from parakin.kernel.motion import Moved, solve_motion
from parakin.kernel.pose import conditioning
from parakin.kinematics.cones import cone_cosine
from parakin.planning.plan import Plan

_ROUNDING = 1e-12  # of a matrix with all its products: more than double precision loses


class Enclosed(NamedTuple):
    """Of n boxes: from `low` to `high` (rows, n), rates by the driven coordinates alike
    (rows, k, n), and the least of all figures of conditioning (n,), squared. NaN where not known.
    """

    low: FloatArray
    high: FloatArray
    rate_low: FloatArray
    rate_high: FloatArray
    least: FloatArray

    @property
    def gentlest(self) -> FloatArray:
        """The least that a rate can be, either way (rows, k, n)."""
        found: FloatArray = np.maximum(np.maximum(self.rate_low, -self.rate_high), 0.0)
        return found

    @property
    def steepest(self) -> FloatArray:
        """The greatest that a rate can be, either way (rows, k, n)."""
        found: FloatArray = np.maximum(np.abs(self.rate_low), np.abs(self.rate_high))
        return found


@dataclass(frozen=True)
class Enclosing:
    """A plan without iterated blocks; what is enclosed: coordinates by number, and cosines of cone
    angles by name.
    """

    plan: Plan
    rows: tuple[int | str, ...]

    def over(self, middle: FloatArray, radius: FloatArray) -> Enclosed:
        """Of boxes about driven values, both (k, n)."""
        k, n = middle.shape
        with np.errstate(all="ignore"):  # what is not known is NaN, and proves nothing
            driven = spanning(middle, radius)
            moved = solve_motion(self.plan, [driven], [], centred_functions(), 0)
            found = [parts(self._row(moved, row)) for row in self.rows]
            least = ends(parts(conditioning(self.plan, moved, moved.angles.functions))[0])[0]
        values = _both([value for value, _ in found], (n,))
        rates = _both([rate for _, rate in found], (k, n))
        return Enclosed(*values, *rates, np.broadcast_to(least, n))

    def _row(self, moved: Moved, row: int | str) -> Scalar:
        if isinstance(row, str):
            return cone_cosine(moved.circuits, self.plan.cones[row])
        return coordinate(self.plan, moved, row, 0)[0]


def _both(values: list[Any], shape: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
    """The lower and the upper ends of all, each of a shape."""
    low, high = np.empty((2, len(values), *shape))
    for row, value in enumerate(values):
        low[row], high[row] = ends(value)
    return low, high


def least_firmness(low: FloatArray, high: FloatArray) -> FloatArray:
    """What the least singular value of any matrix between two (m, k, n), m at least k, is at
    least (n,); 0 where it is not known to be above.

    With Y a left inverse of the middle, and E what Y J differs from the identity by, it is at least
    (1 - |E|) / |Y| (Rump, "Verification methods", Acta Numerica 2010, sec. 10).
    """
    found = np.zeros(low.shape[2])
    known = np.isfinite(low).all(axis=(0, 1)) & np.isfinite(high).all(axis=(0, 1))
    low, high = (np.moveaxis(a[:, :, known], 2, 0) for a in (low, high))
    middle = 0.5 * (low + high)
    radius = np.maximum(high - middle, middle - low)
    inverse = np.linalg.pinv(middle)
    size = np.abs(inverse)
    off = np.abs(np.eye(low.shape[2]) - inverse @ middle) + size @ (
        radius + _ROUNDING * np.abs(middle)
    )
    norm = np.linalg.norm(off, axis=(1, 2)) * (1.0 + _ROUNDING)
    longest = np.linalg.norm(inverse, ord=2, axis=(1, 2)) * (1.0 + _ROUNDING)
    at_least = np.divide(1.0 - norm, longest, out=np.zeros(len(norm)), where=longest > 0.0)
    found[known] = np.where(at_least > 0.0, at_least, 0.0)  # false of NaN
    return found
