"""A workspace as a labelled Dataset."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from parakin.arrays import FloatArray, IndexArray
from parakin.design.clearance import half_width, radius
from parakin.design.probing import Probe
from parakin.design.region import Region
from parakin.design.tilts import largest_tilt
from parakin.solving.solver import Solver

if TYPE_CHECKING:
    import xarray as xr


class Space(NamedTuple):
    """What was asked: the coordinates moved, all driven values of the pose (k,), of these those
    moved (d,), and the poses (k, m) in whose orientations points are to be reached.
    """

    solver: Solver
    kind: str
    moved: tuple[str, ...]
    pose: FloatArray
    middle: FloatArray
    poses: FloatArray


def told(
    space: Space, probe: Probe, region: Region, proportions: FloatArray | None, unknown: str
) -> xr.Dataset:
    """All that was found, as described at `parakin.workspace`. unknown: why efforts are, or ""."""
    import xarray as xr

    inside, moved = region.inside, space.moved
    left = np.full((3, inside.size), np.nan)
    left[:, inside.ravel()] = probe.left(region.grid.points[inside.ravel()])
    own = region.facets[region.own]
    known, numbers = np.unique(
        np.concatenate([[0], region.codes.ravel(), region.stops.ravel()]), return_inverse=True
    )
    words, of_word = _words(probe, known)
    numbers = of_word[numbers][1:]
    ends = np.array([own.min(axis=(0, 1)), own.max(axis=(0, 1))]).T
    relative, mixed = own - space.middle, len(set(_units(space.solver, moved))) > 1
    if proportions is None:
        proportions = ends[:, 1] - ends[:, 0] if mixed else np.ones(len(moved))
    data: dict[str, Any] = {
        "inside": (moved, inside),
        "connected": (moved, region.labels == region.home),
        "stopped_by": (moved, numbers[: inside.size].reshape(inside.shape)),
        "conditioning": (moved, left[0].reshape(inside.shape)),
        "stroke_left": (moved, left[1].reshape(inside.shape)),
        "effort": (moved, left[2].reshape(inside.shape), {"not_known": unknown}),
        "boundary": (("facet", "corner", "over"), region.facets),
        "boundary_stopped_by": (
            ("facet", "corner"),
            numbers[inside.size :].reshape(region.stops.shape),
        ),
        "boundary_connected": ("facet", region.own),
        "size": region.size,
        "size_uncertainty": _unsure(region.size, *region.coarse),
        "extent": (("over", "end"), ends),
        "radius": np.nan if mixed else radius(relative),  # of metres and radians there is none
        "tilt": largest_tilt(space.solver, moved, space.pose, region.facets),
        "half_width": ("over", half_width(relative / proportions) * proportions),
        "islands": ("island", region.islands),
        "holes": ("hole", region.holes),
        **_asked(space),
    }
    axes = {name: (name, axis) for name, axis in zip(moved, region.grid.axes, strict=True)}
    return xr.Dataset(data, _coordinates(space) | axes | {"stop": words}, _attrs(space, ""))


def _unsure(size: float, half: float, quarter: float) -> float:
    """How far a size may be off, given those on every second and every fourth node: errors fall
    with the square of the step, so a quarter of what made a difference before may be left.
    """
    return max(abs(size - half), abs(half - quarter) / 4.0)


def no_workspace(space: Space, stopped: str) -> xr.Dataset:
    """Where the pose itself is none to count from: what was asked, and why."""
    import xarray as xr

    return xr.Dataset(_asked(space), _coordinates(space), _attrs(space, stopped))


def _asked(space: Space) -> dict[str, Any]:
    return {
        "pose": ("driven", space.pose),
        "middle": ("over", space.middle),
        "poses": (("orientation", "driven"), space.poses.T),
    }


def _coordinates(space: Space) -> dict[str, Any]:
    solver = space.solver
    return {
        "over": list(space.moved),
        "over_unit": ("over", _units(solver, space.moved)),
        "end": ["low", "high"],
        "driven": list(solver.driven),
        "driven_unit": ("driven", _units(solver, solver.driven)),
    }


def _units(solver: Solver, names: Sequence[str]) -> list[str]:
    return ["rad" if solver.graph.is_angle(name) else "m" for name in names]


def _attrs(space: Space, stopped: str) -> dict[str, str]:
    return {"mechanism": space.solver.mechanism.name, "kind": space.kind, "stopped": stopped}


def _words(probe: Probe, codes: IndexArray) -> tuple[list[str], IndexArray]:
    """What stops something, "" first, and the number among these words of each code."""
    each = [probe.words(code) for code in codes.tolist()]
    words = list(dict.fromkeys(["", *each]))
    return words, np.array([words.index(word) for word in each], dtype=np.intp)
