"""A proof that every pose of a box keeps what is required, or a pose that does not."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from parakin.arrays import BoolArray, FloatArray, IndexArray
from parakin.design.asked import (
    check_conditioning,
    check_driven,
    check_table,
    of_design,
    positions,
    two_ends,
)
from parakin.design.probing import Probe
from parakin.design.requirement import Requirement, requirement_of
from parakin.errors import InputError
from parakin.model.expressions import Value
from parakin.solving.inputs import refuse_lean
from parakin.solving.solver import Solver

if TYPE_CHECKING:
    import xarray as xr

BOXES = 200_000
_FAR = 1e100  # a number that is not meant
_CORNERS = 12  # sides, of whose corners all are looked at
_TOGETHER = 512  # boxes: as many as stay near the processor


def certify(
    solver: Solver,
    within: Mapping[str, tuple[Value, Value]],
    pose: Mapping[str, Value] | None = None,
    *,
    velocities: Mapping[str, Value] | None = None,
    least_conditioning: float | None = None,
    boxes: int = BOXES,
    parameters: Mapping[str, Value] | None = None,
) -> xr.Dataset:
    """Prove by interval arithmetic that every pose of a box keeps every limit.

    within: low and high of driven coordinates [m or rad, or text with units], the pose between
    them; the others stay as at the pose. pose: positions of driven coordinates, by name, home's
    where not given. velocities: of driven coordinates, either way, which they may have all at once
    [m/s or rad/s], for the limits of velocities to count too. least_conditioning: how near to a
    singularity a pose may be, 1 being as firm as home. boxes: as many parts of the box are looked
    at at most. parameters: of another design, for which `Solver.with_design` compiles.

    Proved is, of all poses of the box and not of samples of it: that loops close there on home's
    branch, within the declared limits of positions and cone angles (but for rounding, as
    everywhere), without a singularity of the loops or, if they determine it, of the actuators; and
    that limits of velocities are kept. Refuted it is by a pose that does not keep one.

    Result: `low` and `high` over `coordinate`, which enclose what limited coordinates and cone
    angles come to in the box; `limit_low` and `limit_high`. Over `driven`: `within_low`,
    `within_high`, `pose`, and `where`: the pose that refutes it, or near which it is undecided,
    else NaN. `proved`: the share of the box; `boxes`: how many parts were looked at. Attributes:
    `mechanism`; `outcome` ("proved", "refuted", "undecided"); `reason`: what is not kept, or not
    proved to be.
    Raises InputError on unknown names, values that are not finite, mechanisms with loops that are
    solved by iteration, and a lean solver.
    """
    solver = of_design(solver, parameters)
    refuse_lean(solver.reported)
    check_conditioning(least_conditioning)
    if not isinstance(boxes, (int, np.integer)) or boxes < 1:
        raise InputError("boxes", repr(boxes), "a whole number above zero")
    home = np.array([solver.home[name] for name in solver.driven])
    y = positions(solver, pose, "pose", home)
    speeds = _speeds(solver, velocities)
    box = _box(solver, within, y)
    requirement = requirement_of(solver, least_conditioning, speeds)
    every = tuple(np.arange(len(y)).tolist())
    probe = Probe(
        *(solver, every, y[:, None], True, *box),
        *(requirement.firmness, requirement.least, None, False),
    )
    return _told(solver, requirement, y, box, _proof(requirement, probe, box, int(boxes)))


class _Box(NamedTuple):
    """Two corners (k,) in the driven coordinates."""

    low: FloatArray
    high: FloatArray


def _box(solver: Solver, within: Mapping[str, tuple[Value, Value]], y: FloatArray) -> _Box:
    """Raises InputError."""
    check_table(within, "within")
    if not within:
        raise InputError("within", "no coordinate", "low and high of at least one")
    box = _Box(y.copy(), y.copy())
    for name, ends in within.items():
        check_driven(solver, name, "within")
        i = solver.driven.index(name)
        box.low[i], box.high[i] = two_ends(solver, name, ends)
        found = f"{box.low[i]:g} to {box.high[i]:g}"
        if not box.low[i] <= box.high[i]:
            raise InputError(f"within of {name}", found, "the lower end first")
        if not max(-box.low[i], box.high[i]) < _FAR:
            raise InputError(f"within of {name}", found, f"ends below {_FAR:g}")
        if not box.low[i] <= y[i] <= box.high[i]:
            raise InputError(
                f"within of {name}",
                f"{box.low[i]:.9g} to {box.high[i]:.9g}",
                f"the pose, at {y[i]:.9g}, in between",
            )
    return box


def _speeds(solver: Solver, velocities: Mapping[str, Value] | None) -> FloatArray | None:
    """Of the driven coordinates (k,), either way. Raises InputError."""
    if velocities is None:
        return None
    speeds = positions(solver, velocities, "velocities", np.zeros(len(solver.driven)), order=1)
    for name, speed in zip(solver.driven, speeds.tolist(), strict=True):
        if speed < 0.0:
            raise InputError(f"velocities of {name}", f"{speed:g}", "how fast, either way")
    return speeds


class _Proof(NamedTuple):
    """outcome and reason as of `certify`; where (k,); the share proved; how many parts were looked
    at; and what encloses each row over all of them.
    """

    outcome: str
    reason: str
    where: FloatArray
    share: float
    boxes: int
    hull: Hull


class Hull(NamedTuple):
    """From `low` to `high` (rows,)."""

    low: FloatArray
    high: FloatArray

    def with_boxes(self, low: FloatArray, high: FloatArray) -> Hull:
        """And of n more (rows, n)."""
        return Hull(
            np.minimum(self.low, low.min(axis=1, initial=np.inf)),
            np.maximum(self.high, high.max(axis=1, initial=-np.inf)),
        )


class _Parts(NamedTuple):
    """Boxes about driven values, both (k, n), and which part of the whole each is (n,)."""

    middle: FloatArray
    radius: FloatArray
    share: FloatArray

    def chosen(self, some: BoolArray | slice) -> _Parts:
        return _Parts(self.middle[:, some], self.radius[:, some], self.share[some])

    def halved(self, sides: IndexArray) -> _Parts:
        """Each in two, by one of its sides (n,)."""
        at = sides, np.arange(len(sides))
        radius, away = self.radius.copy(), np.zeros_like(self.radius)
        away[at] = 0.5 * radius[at]
        radius[at] = _widened(away[at], self.middle[at])
        middles = np.concatenate([self.middle - away, self.middle + away], axis=1)
        return _Parts(middles, np.tile(radius, 2), np.tile(0.5 * self.share, 2))


class _Looked(NamedTuple):
    """Of parts that were looked at: the share proved; those that were not; what encloses the
    former, and the latter; by which side those left are to be halved; and of the first of them
    what is not proved; and what no pose of some part keeps, in words, and the middle of that, if
    there is any.
    """

    share: float
    left: _Parts
    proved: Hull
    open: Hull
    sides: IndexArray
    reason: str
    refuted: tuple[str, FloatArray] | None


def _proof(requirement: Requirement, probe: Probe, box: _Box, most: int) -> _Proof:
    """By parts: what is not proved is looked at in its middle, which may refute it, and halved."""
    k, rows = len(box.low), len(requirement.positions.names)
    middle = 0.5 * (box.low + box.high)
    radius = _widened(0.5 * (box.high - box.low), middle)
    parts = [_Parts(middle[:, None], radius[:, None], np.ones(1))]
    nothing = Hull(np.full(rows, np.inf), np.full(rows, -np.inf))
    unknown, nowhere = Hull(*np.full((2, rows), np.nan)), np.full(k, np.nan)
    hull, share, looked = nothing, 0.0, 0
    refuted = _refuted(probe, _corners(box))
    while refuted is None:
        found = [_looked_at(requirement, some, radius, nothing) for some in parts]
        looked += sum(len(some.share) for some in parts)
        share += sum(each.share for each in found)
        hull = _joined(hull, *(each.proved for each in found))
        left = [each for each in found if len(each.left.share)]
        if not left:
            return _Proof("proved", "", nowhere, 1.0, looked, hull)
        for each in left:
            refuted = refuted or each.refuted or _refuted(probe, each.left.middle)
        if looked + 2 * sum(len(each.left.share) for each in left) > most:
            hull = _joined(hull, *(each.open for each in left))
            where = left[0].left.middle[:, 0]
            return _Proof("undecided", left[0].reason, where, share, looked, hull)
        parts = _divided([each.left.halved(each.sides) for each in left])
    return _Proof("refuted", *refuted, share, looked, unknown)


def _widened(radius: FloatArray, middle: FloatArray) -> FloatArray:
    """Half a side, with what a middle may be off by rounding, if it is a side at all."""
    found: FloatArray = np.where(
        radius > 0.0, radius + 2.0 * np.spacing(np.abs(middle) + radius), 0.0
    )
    return found


def _divided(parts: list[_Parts]) -> list[_Parts]:
    """The same in pieces of as many as are looked at together."""
    whole = _Parts(
        np.concatenate([each.middle for each in parts], axis=1),
        np.concatenate([each.radius for each in parts], axis=1),
        np.concatenate([each.share for each in parts]),
    )
    starts = np.arange(0, len(whole.share), _TOGETHER).tolist()
    return [whole.chosen(slice(start, start + _TOGETHER)) for start in starts]


def _joined(*hulls: Hull) -> Hull:
    low, high = zip(*hulls, strict=True)
    return Hull(np.min(low, axis=0), np.max(high, axis=0))  # NaN, if there is one


def _looked_at(
    requirement: Requirement, parts: _Parts, whole: FloatArray, nothing: Hull
) -> _Looked:
    """Of parts of a box, half of whose sides are `whole` (k,)."""
    found = requirement.enclosing.over(parts.middle, parts.radius)
    kept = requirement.kept(found)
    good = np.asarray(kept.all(axis=0), dtype=bool)
    rows = len(nothing.low)
    low, high = found.low[:rows], found.high[:rows]
    with np.errstate(invalid="ignore"):
        spread = requirement.spread(found, kept, parts.radius)
        size = np.divide(parts.radius, whole[:, None], out=0.0 * spread, where=whole[:, None] > 0.0)
    unclear = ~np.isfinite(spread).all(axis=0) | ~(spread.max(axis=0) > 0.0)
    sides = np.argmax(np.where(unclear, size, spread), axis=0)
    reason = ""
    if not good.all():
        first = int(np.argmin(good))
        reason = requirement.reason(found, kept, first)
    broken = requirement.too_fast(found)
    refuted = None if broken is None else (broken[0], parts.middle[:, broken[1]])
    return _Looked(
        float(parts.share[good].sum()),
        parts.chosen(~good),
        nothing.with_boxes(low[:, good], high[:, good]),
        nothing.with_boxes(low[:, ~good], high[:, ~good]),
        sides[~good],
        reason,
        refuted,
    )


def _corners(box: _Box) -> FloatArray:
    """Of the sides that are none, one end (k, n); of very many, two corners."""
    if (box.low < box.high).sum() > _CORNERS:
        return np.array(box).T
    ends = [sorted({low, high}) for low, high in zip(*map(np.ndarray.tolist, box), strict=True)]
    return np.array(list(itertools.product(*ends))).T


def _refuted(probe: Probe, poses: FloatArray) -> tuple[str, FloatArray] | None:
    """What is not kept at the first of the poses (k, n) that keeps not all, and there; None if all
    do.
    """
    codes = probe.wrong(poses.T)
    if not codes.any():
        return None
    first = int(np.argmax(codes != 0))
    return probe.words(int(codes[first])), poses[:, first]


def _told(
    solver: Solver, requirement: Requirement, y: FloatArray, box: _Box, found: _Proof
) -> xr.Dataset:
    import xarray as xr

    graph, limits = solver.graph, requirement.positions
    low, high = limits.angles(*found.hull)
    declared = {limit.name: limit.ends for limit in graph.limited}
    ends = np.array([declared[name] for name in limits.names]).reshape(-1, 2)
    units = ["rad" if graph.is_angle(name) else "m" for name in limits.names]
    return xr.Dataset(
        {
            "low": ("coordinate", low),
            "high": ("coordinate", high),
            "limit_low": ("coordinate", ends[:, 0]),
            "limit_high": ("coordinate", ends[:, 1]),
            "within_low": ("driven", box.low),
            "within_high": ("driven", box.high),
            "pose": ("driven", y),
            "where": ("driven", found.where),
            "proved": found.share,
            "boxes": found.boxes,
        },
        {
            "coordinate": list(limits.names),
            "unit": ("coordinate", units),
            "driven": list(solver.driven),
            "driven_unit": (
                "driven",
                ["rad" if graph.is_angle(name) else "m" for name in solver.driven],
            ),
        },
        {
            "mechanism": solver.mechanism.name,
            "outcome": found.outcome,
            "reason": found.reason,
        },
    )
