"""The answer as a labelled Dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from parakin.arrays import FloatArray
from parakin.design.envelopes import Envelopes, Words, nothing_known
from parakin.solving.solver import Solver

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

ENDS = ("down", "up")


class Alone(NamedTuple):
    """Of each driven coordinate, down and up: how far (k, 2), what stops it in words (k, 2), and
    what is reported there (k, 2, coordinates).
    """

    travel: FloatArray
    words: Words
    position: FloatArray


class Pair(NamedTuple):
    """The boundary (rays, 2) around a pose in two driven coordinates, and what stops each ray."""

    first: str
    second: str
    boundary: FloatArray
    words: list[str]


class Amplitudes(NamedTuple):
    """The largest sines (k,) at a frequency [Hz], and what limits each in words."""

    frequency: float
    most: FloatArray
    words: Words


def answer(
    solver: Solver,
    y: FloatArray,
    alone: Alone,
    pairs: list[Pair] | None,
    most: Envelopes,
    sines: Amplitudes | None,
    *,
    reached: float = 1.0,
    stopped: str = "",
) -> xr.Dataset:
    """All that was found, as described at `parakin.range`."""
    import xarray as xr

    sides = ("driven", "end")
    data: dict[str, Any] = {
        "pose": ("driven", y),
        "travel": (sides, alone.travel),
        "stopped_by": (sides, _texts(alone.words)),
        "position": ((*sides, "coordinate"), alone.position),
    }
    for name, found in zip(("velocity", "acceleration", "load"), most, strict=True):
        why = {"not_known": found.why} if found.why else {}
        data[f"max_{name}"] = (sides, found.most, why)
        data[f"{name}_limited_by"] = (sides, _texts(found.words))
    if sines is not None:
        data["amplitude"] = ("driven", sines.most, {"frequency": sines.frequency})
        data["amplitude_limited_by"] = ("driven", _texts(sines.words))
    known: dict[str, Any] = {
        "driven": list(solver.driven),
        "end": list(ENDS),
        "coordinate": list(solver.coordinates),
        "unit": ("driven", _units(solver, solver.driven)),
        "coordinate_unit": ("coordinate", _units(solver, solver.coordinates)),
    }
    if pairs:
        data["boundary"] = (("pair", "ray", "side"), np.array([p.boundary for p in pairs]))
        data["boundary_stopped_by"] = (("pair", "ray"), _texts(np.array([p.words for p in pairs])))
        known["side"] = ["first", "second"]
        known["first"] = ("pair", [pair.first for pair in pairs])
        known["second"] = ("pair", [pair.second for pair in pairs])
    attrs = {"mechanism": solver.mechanism.name, "reached": reached, "stopped": stopped}
    return xr.Dataset(data, known, attrs)


def blocked(solver: Solver, y: FloatArray, reached: float, stopped: str) -> xr.Dataset:
    """Where there is nothing to count from: NaN throughout, and why."""
    k = len(y)
    nothing = nothing_known(k, stopped)
    alone = Alone(nothing.most, nothing.words, np.full((k, 2, len(solver.coordinates)), np.nan))
    most = Envelopes(nothing, nothing, nothing)
    return answer(solver, y, alone, None, most, None, reached=reached, stopped=stopped)


def _units(solver: Solver, names: tuple[str, ...]) -> list[str]:
    return ["rad" if solver.graph.is_angle(name) else "m" for name in names]


def _texts(words: Words) -> NDArray[np.str_]:
    return words.astype(str)
