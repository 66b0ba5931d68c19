"""Where a mechanism can go: in a plane or in space, its boundary, and what limits it where."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from parakin.arrays import BoolArray, FloatArray
from parakin.design.asked import (
    check_conditioning,
    check_table,
    of_design,
    positions,
    two_ends,
)
from parakin.design.grids import Box, around, box_around, grid_over, widened
from parakin.design.moving import moving
from parakin.design.probing import Probe
from parakin.design.region import Region, region_of
from parakin.design.spaces import Space, no_workspace, told
from parakin.design.strength import Firmness, efforts_if_known, limited_efforts
from parakin.errors import InputError, nearest
from parakin.model.expressions import Value
from parakin.solving.forces import is_finite
from parakin.solving.inputs import refuse_lean
from parakin.solving.solver import Solver

if TYPE_CHECKING:
    import xarray as xr

POINTS = {2: 201, 3: 49}  # by default, along each side
_POINTS = {2: (9, 2001), 3: (9, 201)}
_FAR = 20.0  # characteristic lengths, or half a turn: farther is not looked
_AGAIN = 5  # times that a box is enlarged which turns out to be too small


def workspace(
    solver: Solver,
    pose: Mapping[str, Value] | None = None,
    *,
    over: Sequence[str] | None = None,
    kind: str | None = None,
    orientations: Sequence[Mapping[str, Value]] | None = None,
    within: Mapping[str, tuple[Value, Value]] | None = None,
    points: int | None = None,
    forces: bool = False,
    loads: Mapping[str, ArrayLike] | None = None,
    least_conditioning: float | None = None,
    proportions: Mapping[str, float] | None = None,
    parameters: Mapping[str, Value] | None = None,
) -> xr.Dataset:
    """Where two or three of the driven coordinates can go from a pose, the others held as there.

    pose: positions of driven coordinates, by name [m or rad, or text with a unit], home's where not
    given. over: those moved; by default all that the kind is about, and of no kind the platform's
    slides, or, if there are not two or three, all of it that is driven. kind:
    "constant-orientation", "orientation" and "mixed" move slides, angles, or both, of the pose, and
    need not be given; "reachable" and "dexterous" move slides in any, or in all, of `orientations`:
    angles by driven coordinate, as in `pose`, the pose's where not given.
    within: what to look at of coordinates, low and high, by default a box around what is connected
    to the pose. points: nodes of the grid along each side. forces: limits of efforts at rest count
    too; loads: as of `Solver.solve`. least_conditioning: how near to a singularity it may come, 1
    being as firm as home. proportions: of the box that is to fit, by coordinate; a cube by default,
    and those of the extents where slides and angles are mixed. parameters: of another design, as of
    `parakin.range`; without them it is the file's own, whatever was left `free`.

    A point belongs to the workspace if loops close there on home's branch within every declared
    limit of positions and cone angles, and with the conditioning and efforts asked for. It is
    reached if it is connected to the pose; an island beyond a gap is not. The boundary is located
    on the edges of the grid to 1e-9 of them, and areas and volumes are those inside of it.

    Result, over the coordinates moved: `inside`, `connected` (to the pose), `stopped_by` (a number
    among `stop`, which are words; 0 for nothing), `conditioning`, `stroke_left` (the least part of
    a stroke to its nearer end), `effort` (the greatest at rest, as a part of its drive's
    `max_effort`; attribute `not_known` says why it is not); NaN outside. Over `facet`, `corner` and
    `over`: `boundary`, lines or triangles, with `boundary_stopped_by` (by corner) and
    `boundary_connected`. Of what is connected: `size`, the area or volume; `size_uncertainty`, by
    the differences from grids of half and a quarter as many points; `extent` over `over` and `end`;
    `radius` of the largest circle or ball about the pose, NaN where slides and angles are mixed;
    `half_width` (over `over`) of the largest box; over two angles that tilt the platform to all
    sides `tilt` [rad], by less than which its z axis may tilt in every direction, else NaN. `holes`
    and `islands`: their sizes, largest first. Over `orientation` and `driven`: `poses`, in any or
    all of which points are to be reached. `over_unit` (over `over`). Attributes: `mechanism`,
    `kind`; `stopped`: what is wrong with the pose, all else then being left out.
    Raises InputError on unknown names, values that are not finite, a lean solver, and `forces`
    where efforts are not known or have no bounds.
    """
    solver = of_design(solver, parameters)
    refuse_lean(solver.reported)
    check_conditioning(least_conditioning)
    kind, moved = moving(solver, over, kind)
    home = np.array([solver.home[name] for name in solver.driven])
    y = positions(solver, pose, "pose", home)
    poses = _poses(solver, y, kind, orientations)
    numbers = tuple(solver.driven.index(name) for name in moved)
    middle = y[list(numbers)]
    most = _most(solver, moved, middle, {} if within is None else within)
    count, shape = _count(points, len(moved)), _proportions(moved, proportions)
    every = kind != "reachable"
    efforts, unknown = (
        (limited_efforts(solver, loads), "") if forces else efforts_if_known(solver, loads)
    )
    firmness = Firmness(solver)
    if least_conditioning is not None:
        firmness.check(solver)
    probe = Probe(
        *(solver, numbers, poses, every, *most),
        *(firmness, least_conditioning, efforts, bool(forces)),
    )
    space = Space(solver, kind, moved, y, middle, poses)
    (wrong,) = probe.wrong(middle[None])
    if wrong:
        return no_workspace(space, probe.words(int(wrong)))
    named = np.array([name in (within or {}) for name in moved])
    units = np.array([1.0 if solver.graph.is_angle(n) else solver.graph.length for n in moved])
    return told(space, probe, _looked_at(probe, middle, named, units, count), shape, unknown)


def _looked_at(
    probe: Probe, middle: FloatArray, named: BoolArray, units: FloatArray, count: int
) -> Region:
    """What is found in a box around all that is connected to the middle; along coordinates that
    are `named` as far as the probe looks.
    """
    most = Box(probe.low, probe.high)
    box = box_around(probe, middle, units)
    for _ in range(_AGAIN):
        box = Box(np.where(named, most.low, box.low), np.where(named, most.high, box.high))
        grid = grid_over(box, middle, count)
        region = region_of(replace(probe, low=box.low, high=box.high), grid)
        wider = widened(box, most, around(region.inside, grid), grid, 0.25)
        if wider is None:
            break
        box = wider
    return region


def _poses(
    solver: Solver, y: FloatArray, kind: str, orientations: Sequence[Mapping[str, Value]] | None
) -> FloatArray:
    """The poses (k, m) in which points may be, or must be. Raises InputError."""
    several = kind in ("reachable", "dexterous")
    if several != bool(orientations):
        what = "none" if several else f"some for a workspace of kind {kind}"
        raise InputError("orientations", what, "at least one" if several else "none")
    if not orientations:
        return y[:, None]
    if not isinstance(orientations, Sequence):
        raise InputError("orientations", repr(orientations), "a list of angles by name")
    found = []
    for number, each in enumerate(orientations, start=1):
        place = f"orientations, number {number}"
        check_table(each, place)
        for name in each:
            if name in solver.driven and not solver.graph.is_angle(name):
                raise InputError(place, f"{name!r}, a slide", "angles alone")
        found.append(positions(solver, each, place, y))
    return np.array(found).T


def _most(
    solver: Solver,
    moved: tuple[str, ...],
    middle: FloatArray,
    within: Mapping[str, tuple[Value, Value]],
) -> Box:
    """The largest box that is looked at. Raises InputError."""
    far = [np.pi if solver.graph.is_angle(n) else _FAR * solver.graph.length for n in moved]
    low, high = middle - far, middle + far
    check_table(within, "within")
    for name, ends in within.items():
        if name not in moved:
            raise InputError("within", f"{name!r}, which is not moved", nearest(str(name), moved))
        i = moved.index(name)
        low[i], high[i] = two_ends(solver, name, ends)
        if not low[i] < middle[i] < high[i]:
            raise InputError(
                f"within of {name}", f"{low[i]:g} to {high[i]:g}", "ends on both sides of the pose"
            )
    return Box(low, high)


def _count(points: int | None, d: int) -> int:
    least, most = _POINTS[d]
    if points is None:
        return POINTS[d]
    if not isinstance(points, (int, np.integer)) or not least <= points <= most:
        raise InputError(
            "points", repr(points), f"a whole number from {least} to {most} in {d} dimensions"
        )
    return int(points)


def _proportions(moved: tuple[str, ...], given: Mapping[str, float] | None) -> FloatArray | None:
    """One positive number for each coordinate moved (d,), if any is given. Raises InputError."""
    if given is None:
        return None
    check_table(given, "proportions")
    for name in (*given, *moved):
        if name not in moved:
            raise InputError("proportions", repr(name), nearest(str(name), moved))
        if name not in given:
            raise InputError("proportions", f"none of {name}", "one of each coordinate moved")
        if not (is_finite(given[name]) and given[name] > 0.0):
            raise InputError(f"proportions of {name}", repr(given[name]), "a number above zero")
    return np.array([given[name] for name in moved], dtype=float)
