"""What a kernel returns, and in which row: whoever wants a row asks here for it by name."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

from parakin.algebra.spatial import Vector
from parakin.arrays import IndexArray
from parakin.caching import cached_property
from parakin.kernel.force_rows import ForceRows

Places = TypeVar("Places", int, IndexArray)

POINT = 24  # rows for each point, as follows
POSITION = slice(0, 3)  # p_WB [m]
ORIENTATION = slice(3, 12)  # R_WB, row by row
VELOCITY = slice(12, 15)  # v_WB
ANGULAR_VELOCITY = slice(15, 18)  # w_WB
ACCELERATION = slice(18, 21)  # a_WB
ANGULAR_ACCELERATION = slice(21, 24)  # alpha_WB


@dataclass(frozen=True)
class Outputs:
    """What a kernel returns, a scalar each: positions of `coordinates` (by number, or by name the
    cone angle of a spherical joint), then as many `derivatives` of them; with `checks` five
    figures: `residual`, `conditioning`, `step`, `size` and `unsigned`; then for every point of
    `points` (body, place on it) `POINT` more; then those of `forces`.
    """

    coordinates: tuple[int | str, ...]
    derivatives: int = 2
    checks: bool = True
    points: tuple[tuple[int, Vector], ...] = ()
    forces: ForceRows | None = None

    def order(self, order: int) -> slice:
        """Rows of all positions, or of their derivatives of an order."""
        return slice(order * len(self.coordinates), (order + 1) * len(self.coordinates))

    def first(self, count: int, order: int) -> slice:
        """Rows of the first coordinates in an order."""
        start = self.order(order).start
        return slice(start, start + count)

    def derivative(self, row: Places, order: int) -> Places:
        """The row, or rows, of the derivative of what has its position in `row`."""
        return row + order * len(self.coordinates)

    @cached_property
    def motion(self) -> slice:
        """Rows of positions and derivatives."""
        return slice(0, self.residual)

    @cached_property
    def residual(self) -> int:
        """The norm of all closure rows [m]."""
        return (1 + self.derivatives) * len(self.coordinates)

    @cached_property
    def conditioning(self) -> int:
        """Compared with home, signed: negative on another branch."""
        return self.residual + 1

    @cached_property
    def step(self) -> int:
        """The size of the last Newton step."""
        return self.residual + 2

    @cached_property
    def size(self) -> int:
        """What the closure rows subtract [m], by which the residual is measured."""
        return self.residual + 3

    @cached_property
    def unsigned(self) -> int:
        """The product of those figures of conditioning that keep no sign where they pass zero."""
        return self.residual + 4

    @cached_property
    def figures(self) -> slice:
        """Rows of the five figures, from residual to unsigned."""
        return slice(self.residual, self.residual + 5 * self.checks)

    @cached_property
    def count(self) -> int:
        """How many rows there are."""
        return self.force(slice(0, 0)).start + (0 if self.forces is None else self.forces.count)

    def force(self, rows: slice[int, int, None]) -> slice[int, int, None]:
        """Where these rows of `forces` are."""
        start = self.residual + 5 * self.checks + POINT * len(self.points)
        return slice(start + rows.start, start + rows.stop)
