"""Singularities along a motion: near which kind, and where one is crossed.

After Gosselin and Angeles (1990): with rates of the actuators q' and of the outputs x' tied by
A x' + B q' = 0, a type 1 singularity is one of B (the actuators move while the output rests), type
2 one of A (the output moves while the actuators are locked). Both are seen in the rates that one
set of driven coordinates gives to the other, which the kernel knows for every sample; their
orthonormal basis has a part in the actuators and a part in the outputs, with singular values
cosine and sine of the same angles: a figure for each type between 0 (singular) and 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from parakin.assembly import FloatArray, coordinate_scales
from parakin.errors import InputError
from parakin.tracking import Status

if TYPE_CHECKING:
    import xarray as xr

    from parakin.solver import Solver

_LOCATED = 1e-10  # [s]


@dataclass(frozen=True)
class Crossing:
    """A singularity between two samples: its time [s], its type, and what goes free or is lost."""

    time: float
    type: Literal[1, 2]
    words: str


@dataclass(frozen=True)
class Closeness:
    """Per sample, `type1` and `type2` between 0 (singular) and 1; and the crossings."""

    time: FloatArray
    type1: FloatArray
    type2: FloatArray
    crossings: tuple[Crossing, ...]


def closeness(solver: Solver, result: xr.Dataset) -> Closeness:
    """How near a solved motion comes to the two types of singularity.

    result: what `solver.solve` gave; flagged samples come out as NaN. Raises InputError where the
    mechanism has no actuated coordinates, or not as many as are driven, or no other outputs.
    """
    actuated, outputs = _sets(solver)
    y = result["position"].sel(coordinate=list(solver.driven)).values.T
    guess = result["position"].sel(coordinate=list(solver.coordinates)).values.T
    good = result["status"].values == Status.CONVERGED
    time = result["time"].values
    type1, type2, signs = (np.full(len(time), np.nan) for _ in range(3))
    if good.any():
        rates = _rates(solver, y[:, good], guess[:, good], [*actuated, *outputs])
        type1[good], type2[good], signs[good] = _figures(rates, len(actuated))
    crossings = [
        _located(solver, result, i, actuated, outputs)
        for i in np.flatnonzero(signs[1:] * signs[:-1] < 0).tolist()
    ]
    return Closeness(time, type1, type2, tuple(crossings))


def _sets(solver: Solver) -> tuple[list[str], list[str]]:
    """The actuated coordinates, and the outputs: those driven by the file, or at the base."""
    where = solver.mechanism.where
    actuated = [c.name for c in solver.graph.coordinates if c.actuated]
    by_file = [n for n in solver.mechanism.driven if n not in actuated]
    outputs = by_file or [n for n in solver.driven if n not in actuated]
    if not outputs and actuated:  # a linkage without a platform: what leaves it at the base
        grounded = {
            c.name
            for c in solver.graph.coordinates
            if solver.graph.joints[c.joint].parent == 0 and not c.actuated
        }
        others = [n for n in solver.coordinates if n in grounded]
        outputs = others[-len(actuated) :]
    count = len(solver.driven)
    if len(actuated) != count or len(outputs) != count:
        raise InputError(
            where,
            f"{len(actuated)} actuated coordinates and {len(outputs)} outputs",
            f"{count} of each to tell singularities apart",
        )
    return actuated, outputs


def _rates(solver: Solver, y: FloatArray, guess: FloatArray, names: Sequence[str]) -> FloatArray:
    """Rates of coordinates for unit rates of each driven one: (samples, names, driven), scaled."""
    rows = [solver.coordinates.index(name) for name in names]
    graph = solver.graph
    every = coordinate_scales(graph)
    scales = np.array([every[graph.index(n, "singularities")] for n in (*names, *solver.driven)])
    columns = []
    for k in range(len(solver.driven)):
        unit = np.zeros_like(y)
        unit[k] = scales[len(names) + k]
        tick = solver.at(y, unit, guess=guess)
        columns.append(tick.velocity[rows].T / scales[: len(names)])
    return np.stack(columns, axis=2)


def _figures(rates: FloatArray, actuated: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Figures of type 1 and 2, and the sign of the determinant between the two sets."""
    basis, _ = np.linalg.qr(rates)
    ours, theirs = basis[:, :actuated], basis[:, actuated:]
    type2 = np.linalg.svd(ours, compute_uv=False)[:, -1]
    type1 = np.linalg.svd(theirs, compute_uv=False)[:, -1]
    signs = np.sign(np.linalg.det(ours) * np.linalg.det(theirs))
    return type1, type2, signs


def _located(
    solver: Solver, result: xr.Dataset, i: int, actuated: list[str], outputs: list[str]
) -> Crossing:
    """The crossing between samples i and i+1, by bisection in time on the sign."""
    from parakin.tracking import hermite

    names = list(solver.driven)
    nodes = result["time"].values[i : i + 2]
    driven = np.stack(
        [
            result[q].sel(coordinate=names).values[i : i + 2].T
            for q in ("position", "velocity", "acceleration")
        ]
    )
    guess = result["position"].sel(coordinate=list(solver.coordinates)).values[i][:, None]

    def at(t: float) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        y = hermite(nodes, driven, np.array([t]))
        rates = _rates(solver, y, guess, [*actuated, *outputs])
        type1, type2, sign = _figures(rates, len(actuated))
        return rates[0], type1, type2, sign

    low, high = float(nodes[0]), float(nodes[1])
    start = at(low)[3]
    while high - low > _LOCATED:
        middle = (low + high) / 2
        if at(middle)[3] == start:
            low = middle
        else:
            high = middle
    time = (low + high) / 2
    rates, type1, type2, _ = at(time)
    kind: Literal[1, 2] = 2 if type2[0] < type1[0] else 1
    count = len(actuated)
    locked = rates[:count] if kind == 2 else rates[count:]
    mix = np.linalg.svd(locked)[2][-1]
    moving = dict(zip([*actuated, *outputs], rates @ mix, strict=True))
    return Crossing(time, kind, _words(kind, moving, actuated, outputs))


def _words(
    kind: int, moving: dict[str, float], actuated: Sequence[str], outputs: Sequence[str]
) -> str:
    free, locked = (outputs, actuated) if kind == 2 else (actuated, outputs)
    sizes = {name: abs(moving[name]) for name in free}
    largest = max(sizes.values())
    chosen = sorted((n for n in free if sizes[n] > 0.2 * largest), key=lambda n: -sizes[n])
    return f"{' with '.join(chosen)} can move while {', '.join(locked)} are locked"
