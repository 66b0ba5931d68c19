"""What stops a ray, in words, and what is demanded of it besides limits of positions."""

from __future__ import annotations

from typing import NamedTuple

from parakin.design.cuts import first_above
from parakin.design.rays import Met, Ray
from parakin.design.strength import Efforts, Firmness
from parakin.solving.solver import Solver
from parakin.solving.status import Status


class Demands(NamedTuple):
    """What ends a ray besides limits of positions: efforts at rest, and how firmly it is held."""

    efforts: Efforts | None
    firmness: Firmness | None
    least: float

    @property
    def any(self) -> bool:
        """Whether there is any."""
        return self.efforts is not None or self.firmness is not None


def words_of(solver: Solver, met: Met, ray: int) -> str:
    """What stopped a ray: "P6 > 1.26 m", "limb A1, B1 cannot reach", "singular"; "" for nothing."""
    status = Status(int(met.status[ray]))
    return reason(solver, int(met.number[ray]), status, upper=bool(met.upper[ray]))


def reason(solver: Solver, number: int, status: Status, *, upper: bool) -> str:
    """The same of a stop by its number, 0 for none, and a status."""
    if number and solver.stops.units[number]:
        return solver.stops.limit_words(number, upper=upper)
    if number:
        return solver.stops.words(number, 0.0)
    return _STATUS_WORDS.get(status, status.words) if status else ""


# Where a way ends for want of steps, or on another branch, the mechanism is singular in between.
_STATUS_WORDS = {
    Status.ITERATION_LIMIT: "singular",
    Status.OUT_OF_REACH: "out of reach",
    Status.BRANCH_CHANGE: "singular",
}


def cut_short(
    solver: Solver, ray: Ray, part: float, words: str, demands: Demands
) -> tuple[float, str]:
    """Where a ray that ends at a part of it ends with these demands, and what stops it there."""
    if demands.efforts is not None and demands.efforts.limited:
        cut = first_above(solver.atlas, ray, part, demands.efforts.beyond(ray))
        if cut.number >= 0:
            part, words = cut.part, demands.efforts.words(cut.number)
    if demands.firmness is not None:
        cut = first_above(solver.atlas, ray, part, demands.firmness.below(ray, demands.least))
        if cut.number >= 0:
            part, words = cut.part, f"conditioning < {demands.least:g}"
    return part, words
