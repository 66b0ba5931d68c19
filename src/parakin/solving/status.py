"""The status of a sample, and which rows of a kernel's outputs decide it."""

from __future__ import annotations

import enum
import functools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from parakin.arrays import BoolArray, FloatArray, IndexArray, StatusArray
from parakin.caching import cached_property
from parakin.kernel.outputs import Outputs

RESIDUAL = 1e-12  # of the lengths subtracted in the loops: a residual that counts as closed
# Cosines of the second of three angles. Below the first the other two angles are undefined; below
# the rest so are their first, second and third derivatives, each of which magnifies rounding more.
# So do those of a cone angle, by its sine.
LOCKED = (1e-8, 1e-5, 3e-4, 2e-3)
_UPRIGHT = 1.5  # rad: angles smaller than this have no small cosine
_ASIDE = 3e-3  # rad: nor do angles farther than this from 0 and a half turn have a small sine
TURNS = 1e6  # of an angle: beyond them it is not known to 1e-9 rad
SINGULAR = 1e-6  # conditioning below this leaves no digits to trust in accelerations


class Status(enum.IntEnum):
    """Whether a sample was solved, and if not, why.

    CONVERGED, LIMIT_EXCEEDED and ANGLES_UNDEFINED are solved, the last with NaN in the undefined
    angles alone. Samples of any other status are NaN throughout.
    """

    CONVERGED = 0
    ITERATION_LIMIT = 1
    OUT_OF_REACH = 2
    SINGULAR = 3
    BRANCH_CHANGE = 4
    LIMIT_EXCEEDED = 5
    NOT_REACHED = 6
    NOT_SMOOTH = 7
    ANGLES_UNDEFINED = 8

    @property
    def words(self) -> str:
        return self.name.lower().replace("_", " ")


UNREACHED = (Status.ITERATION_LIMIT, Status.OUT_OF_REACH)
SOLVED = (Status.CONVERGED, Status.LIMIT_EXCEEDED, Status.ANGLES_UNDEFINED)


@functools.cache
def _table(chosen: tuple[Status, ...]) -> BoolArray:
    return np.array([status in chosen for status in Status])


def are(chosen: tuple[Status, ...], status: StatusArray) -> BoolArray:
    """Which of these (n,) are one of those chosen. (`np.isin` would take ten times as long.)"""
    found: BoolArray = _table(chosen)[status]
    return found


class Triple(NamedTuple):
    """Three angles that are read off: rows of those reported, and of the second, whose cosine (or,
    if first and last axis are the same, sine) tells whether they are defined.
    """

    rows: IndexArray
    second: int
    same: bool


@dataclass(frozen=True)
class Layout:
    """Where a kernel's outputs lie.

    `reported`: how many of the coordinates of `outputs` are; the rest of the unknowns come after
    these. `iterated` (orders, m): rows of iterated coordinates, of which a guess is needed.
    `unknowns`: rows of all that is solved for, and `units` of these, 1 for angles, else the
    characteristic length. `angles`: rows of angles that are found within half a turn of home.
    `unsigned`: whether some figure of conditioning is as large on either side of a singularity.
    `triples`: angles that are not defined everywhere. `cones`: rows of cone angles. `watched`: what
    continuity is asked of, unknowns and angles.
    """

    outputs: Outputs
    reported: int
    iterated: IndexArray
    unknowns: IndexArray
    units: FloatArray
    angles: IndexArray
    unsigned: bool
    triples: tuple[Triple, ...]
    cones: tuple[int, ...]
    watched: Watched

    @cached_property
    def undefined(self) -> bool:
        """Whether something in it is not defined everywhere."""
        return bool(self.triples or (self.cones and self.outputs.derivatives))

    def plainly_defined(self, out: FloatArray) -> bool:
        """Whether all in outputs (rows,) of one pose is defined, as a glance shows; what is near a
        lock, or NaN, it leaves to `blank_undefined`.
        """
        if not self.undefined:
            return True
        rows, least, most = self._definite
        sizes = map(abs, out[rows].tolist())
        return all(a <= x <= b for a, x, b in zip(least, sizes, most, strict=True))

    @cached_property
    def _definite(self) -> tuple[list[int], list[float], list[float]]:
        """Rows of angles that tell, and between which sizes they do: with a cosine or a sine that
        is not small.
        """
        found = [
            (t.second, _ASIDE, np.pi - _ASIDE) if t.same else (t.second, 0.0, _UPRIGHT)
            for t in self.triples
        ]
        if self.outputs.derivatives:
            found += [(row, _ASIDE, np.pi - _ASIDE) for row in self.cones]
        rows, least, most = zip(*found, strict=True)
        return list(rows), list(least), list(most)


class Watched(NamedTuple):
    """Rows of coordinates; their units; which are solved for, and which are angles known but for
    full turns (the rest are read off); and the values of those angles at home, within half a turn
    of which a kernel finds them.
    """

    rows: IndexArray
    units: FloatArray
    solved: BoolArray
    turning: BoolArray
    centres: FloatArray


def converged(out: FloatArray, layout: Layout) -> BoolArray:
    """Which samples are closed and well conditioned."""
    closed = out[layout.outputs.residual] <= RESIDUAL * out[layout.outputs.size]
    good: BoolArray = closed & (out[layout.outputs.conditioning] >= SINGULAR)
    return good


def classify(out: FloatArray, layout: Layout) -> StatusArray:
    """A status per sample from its residual and conditioning, which become NaN together."""
    status = np.zeros(out.shape[1], dtype=np.int8)
    if converged(out, layout).all():
        return status
    residual, conditioning = out[layout.outputs.residual], out[layout.outputs.conditioning]
    conditioning[np.isnan(residual)] = np.nan
    status[~(conditioning >= SINGULAR)] = Status.SINGULAR
    status[conditioning < -SINGULAR] = Status.BRANCH_CHANGE
    status[~(residual <= RESIDUAL * out[layout.outputs.size])] = Status.ITERATION_LIMIT
    status[np.isnan(residual)] = Status.OUT_OF_REACH
    return status


def blank_undefined(out: FloatArray, layout: Layout) -> BoolArray:
    """Make undefined angles and their rates NaN. Returns which samples (n,) have any.

    The rates of a cone angle near 0 or 180° are NaN too, but count for nothing: it has kinks there.
    """
    found = np.zeros(out.shape[1], dtype=bool)
    for rows, second, same in layout.triples:
        if not same and np.abs(out[second]).max(initial=0.0) < _UPRIGHT:
            continue
        with np.errstate(invalid="ignore"):
            figure = np.sin(out[second]) if same else np.cos(out[second])
        for order in range(len(layout.iterated)):
            undefined = np.abs(figure) < LOCKED[order]
            if undefined.any():
                found |= undefined
                out[np.ix_(layout.outputs.derivative(rows, order), undefined)] = np.nan
    for row in layout.cones:
        with np.errstate(invalid="ignore"):
            sine = np.abs(np.sin(out[row]))
        for order in range(1, 1 + layout.outputs.derivatives):
            out[layout.outputs.derivative(row, order), sine < LOCKED[order]] = np.nan
    return found
