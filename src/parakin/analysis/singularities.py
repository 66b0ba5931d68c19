"""Singularities along a motion: near which kind, where one is crossed, and which one ended it.

After Gosselin and Angeles (1990): with rates of the actuators q' and of the outputs x' tied by
A x' + B q' = 0, a type 1 singularity is one of B (the actuators move while the output rests), type
2 one of A (the output moves while the actuators are locked). Both are seen in the rates that one
set of driven coordinates gives to the other, which the kernel knows for every sample; their
orthonormal basis has a part in the actuators and a part in the outputs, with singular values
cosine and sine of the same angles: a figure for each type between 0 (singular) and 1.

After Zlatanov, Fenton and Benhabib (1995): where all closure rows together lose rank, the
mechanism gains a freedom whatever is driven (increased instantaneous mobility; a constraint
singularity where the platform moves by it). And the passive joints alone may go free.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from parakin.algebra.angles import nearest_angle
from parakin.analysis.freedom import (
    LOST,
    RANK,
    Kind,
    Sets,
    freed,
    freedom,
    sets_of,
    type1_words,
    whole_values,
)
from parakin.analysis.twists import platform_axes, platform_motion
from parakin.arrays import BoolArray, FloatArray
from parakin.errors import InputError
from parakin.kernel.backends import make_kernel
from parakin.kernel.outputs import Outputs
from parakin.kinematics.configuration import coordinate_scales
from parakin.motion.course import hermite
from parakin.solving.status import RESIDUAL, SOLVED

if TYPE_CHECKING:
    import xarray as xr

    from parakin.motion.motion import Motion
    from parakin.solving.solver import Solver

_LOCATED = 1e-10  # [s]
_SAME_POSE = (
    1e-6  # radians and characteristic lengths between a pose as reported and as found again
)
_STEPS = 8  # Newton steps where a plan iterates, from the sample before


@dataclass(frozen=True)
class Crossing:
    """A singularity at a time [s] between two samples, its kind, and what goes free or is lost.

    Kinds: "type 1" and "type 2"; "constraint": all rows together lose rank; "passive": joints that
    are neither actuated nor outputs go free; "driven": the driven coordinates, being neither the
    actuated ones nor the outputs, no longer determine the rest; "angles": only the platform's three
    angles are undefined there. `ends`: the motion stops there.
    """

    time: float
    kind: Kind
    words: str
    ends: bool = False


@dataclass(frozen=True)
class Closeness:
    """Per sample, between 0 (singular) and 1: `type1`, `type2`, `passive` (the conditioning of
    what was solved) and `whole` (least over largest singular value of all closure rows by all
    coordinates, redundant rows left out); and the crossings.
    """

    time: FloatArray
    type1: FloatArray
    type2: FloatArray
    passive: FloatArray
    whole: FloatArray
    crossings: tuple[Crossing, ...]


def singularities(
    solver: Solver, result: xr.Dataset, motion: Motion | str | None = None
) -> Closeness:
    """How near a solved motion comes to singularities of each kind, and where it crosses one,
    between samples too.

    result: from `solver.solve`; flagged samples give NaN. motion: the one that was solved, so that
    what stopped it, if anything did, is reported too. Raises InputError if the mechanism has no
    actuated coordinates, or not as many as are driven, or no outputs besides them.
    """
    motion = solver.motion(motion) if isinstance(motion, str) else motion
    sets = sets_of(solver)
    solved = np.isin(result["status"].values, SOLVED)
    good = solved.copy()
    time = result["time"].values
    type1, type2, whole, signs = (np.full(len(time), np.nan) for _ in range(4))
    crossings: list[Crossing] = []
    if good.any():
        path = _Path.of(solver, result, motion)
        rates, q = path.rates(path.driven[0][:, good], path.found[0][:, good], sets)
        same = _same_poses(solver, result, good, q)
        good[good], rates, q = same, rates[same], q[:, same]
    if good.any():
        type1[good], type2[good], signs[good] = _figures(rates, sets)
        values = whole_values(solver.plan, q)
        rank = int((values > RANK * values[:, :1]).sum(axis=1).max())
        whole[good] = values[:, rank - 1] / values[:, 0]
        crossings = [
            _crossing(path, sets, i) for i in np.flatnonzero(signs[1:] * signs[:-1] < 0).tolist()
        ]
        first_bad = int(np.argmin(solved))
        if motion is not None and good[first_bad - 1] and not solved[first_bad]:
            best = float(np.nanmax(whole))
            crossings += _ending(path, sets, first_bad - 1, rank, best)
    passive = np.where(solved, result["conditioning"].values, np.nan)
    return Closeness(time, type1, type2, passive, whole, tuple(crossings))


def _same_poses(solver: Solver, result: xr.Dataset, good: BoolArray, q: FloatArray) -> BoolArray:
    """Which samples the solver's own plan reproduces. The others were solved on another chart, of
    which nothing is known here.
    """
    graph, plan = solver.plan.graph, solver.plan
    names = [n for n in result["coordinate"].values.tolist() if n not in graph.cones]
    numbers = [graph.index(name, "result") for name in names]
    offsets = np.array([plan.offset(k) for k in numbers])
    reported = result["position"].sel(coordinate=names).values.T[:, good]
    off = (q[numbers] - offsets[:, None] - reported) / coordinate_scales(graph)[numbers][:, None]
    turning = np.array([graph.coordinates[k].angle for k in numbers])
    off[turning] = nearest_angle(off[turning])
    undefined = np.isnan(reported)
    same: BoolArray = (undefined | (np.abs(off) < _SAME_POSE)).all(axis=0)
    return same


@dataclass(frozen=True)
class _Path:
    """A solved motion: driven values (3, k, n) and iterated coordinates (3, m, n) at its times."""

    solver: Solver
    time: FloatArray
    driven: FloatArray
    found: FloatArray

    @classmethod
    def of(cls, solver: Solver, result: xr.Dataset, motion: Motion | None) -> _Path:
        orders = ("position", "velocity", "acceleration")
        rows = solver.iterated
        if not set(rows) <= set(result["coordinate"].values.tolist()):
            lacking = f"not all of {', '.join(rows)}"
            raise InputError("result", lacking, "what is iterated among the coordinates")
        found = [result[order].sel(coordinate=list(rows)).values.T for order in orders]
        names = list(solver.driven)
        if motion is not None:
            if motion.count != result.sizes["time"]:
                counts = f"{motion.count} samples, of the result {result.sizes['time']}"
                raise InputError(f"motion {motion.name}", counts, "the motion that was solved")
            driven = list(motion.reordered(solver.driven).samples().orders[:3])
        else:
            if not set(names) <= set(result["coordinate"].values.tolist()):
                raise InputError("result", "not all driven coordinates", "them, or the motion too")
            driven = [result[order].sel(coordinate=names).values.T for order in orders]
        return cls(solver, result["time"].values, np.array(driven), np.array(found))

    def at(self, i: int, time: float) -> tuple[FloatArray, FloatArray]:
        """Driven values between samples i and i + 1, by a quintic, and a guess from sample i."""
        nodes, h = self.time[i : i + 2], time - self.time[i]
        x, v, a = self.found[:, :, i : i + 1]
        return hermite(
            nodes, self.driven[:, :, i : i + 2], np.array([time])
        ), x + h * v + h * h * a / 2

    def rates(self, y: FloatArray, guess: FloatArray, sets: Sets) -> tuple[FloatArray, FloatArray]:
        """Rates of actuated coordinates, outputs and pose for a unit rate of each driven one,
        scaled, (n, coordinates, driven); and the positions of all coordinates, (coordinates, n).
        """
        graph, plan = self.solver.plan.graph, self.solver.plan
        every, scales = range(len(graph.coordinates)), coordinate_scales(graph)
        rows = [*sets.actuated, *sets.outputs, *sets.pose]
        outputs = Outputs(tuple(every), derivatives=1, checks=False)
        kernel = make_kernel(plan, outputs, machine_code=False, steps=_STEPS)
        columns = []
        for k, number in enumerate(plan.driven):
            unit = np.zeros_like(y)
            unit[k] = scales[number]
            out = np.empty((outputs.count, y.shape[1]))
            kernel(np.concatenate([y, unit, guess]), out, False)
            columns.append(out[outputs.order(1)][rows].T / scales[rows])
        offsets = np.array([plan.offset(k) for k in every])
        found, q = np.stack(columns, axis=2), out[outputs.order(0)] + offsets[:, None]
        angles = sets.turned
        if angles:  # angular velocities, which are defined where angles are not
            found[:, angles] = platform_axes(graph, q)[0] @ found[:, angles]
        return found, q

    def conditioning(self, i: int, time: float) -> float:
        """The conditioning of what is solved; NaN out of reach."""
        plan = self.solver.plan
        outputs = Outputs((), derivatives=0)
        out = np.empty((outputs.count, 1))
        y, guess = self.at(i, time)
        make_kernel(plan, outputs, machine_code=False, steps=_STEPS)(
            np.concatenate([y, guess]), out, False
        )
        closed = out[outputs.residual, 0] <= RESIDUAL * out[outputs.size, 0]
        return float(out[outputs.conditioning, 0]) if closed else np.nan


def _figures(rates: FloatArray, sets: Sets) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Figures of type 1 and 2, and the sign of the determinant between the two sets."""
    count = len(sets.actuated)
    basis, _ = np.linalg.qr(rates[:, : 2 * count])
    ours, theirs = basis[:, :count], basis[:, count:]
    type2 = np.linalg.svd(ours, compute_uv=False)[:, -1]
    type1 = np.linalg.svd(theirs, compute_uv=False)[:, -1]
    return type1, type2, np.sign(np.linalg.det(ours) * np.linalg.det(theirs))


def _wide(low: float, high: float) -> bool:
    """Whether an interval is wider than the accuracy that times need, or can have."""
    return high - low > max(_LOCATED, 4 * float(np.spacing(abs(high))))


def _bisected(low: float, high: float, same: Callable[[float], bool]) -> float:
    while _wide(low, high):
        middle = (low + high) / 2
        low, high = (middle, high) if same(middle) else (low, middle)
    return (low + high) / 2


def _crossing(path: _Path, sets: Sets, i: int) -> Crossing:
    """The crossing of type 1 or 2 between samples i and i + 1, by bisection on the sign."""

    def at(time: float) -> tuple[FloatArray, FloatArray]:
        return path.rates(*path.at(i, time), sets)

    def sign(time: float) -> float:
        return float(_figures(at(time)[0], sets)[2][0])

    start = sign(float(path.time[i]))
    low, high = path.time[i : i + 2].tolist()
    time = _bisected(low, high, lambda t: sign(t) == start)
    rates, q = at(time)
    type1, type2, _ = _figures(rates, sets)
    graph, count = path.solver.plan.graph, len(sets.actuated)
    free = 2 if type2[0] < type1[0] else 1
    rows = slice(count) if free == 2 else slice(count, 2 * count)
    mix = np.linalg.svd(rates[0, rows])[2][-1]
    every = np.zeros(len(graph.coordinates))
    every[[*sets.actuated, *sets.outputs, *sets.pose]] = rates[0] @ mix
    if free == 2:
        many = _freedoms(np.linalg.qr(rates[0, : 2 * count])[0][:count])
        return Crossing(time, "type 2", freed(graph, sets, every, q[:, 0]) + many)
    lost = np.zeros(len(graph.coordinates))
    lost[sets.outputs] = np.linalg.svd(rates[0, rows])[0][:, -1]
    if sets.turned:
        turns = sets.pose[3:]
        lost[turns] = np.linalg.solve(platform_axes(graph, q)[0][0], lost[turns])
    cannot = platform_motion(graph, lost, q[:, 0], sets.outputs, "cannot")
    words = type1_words(graph, sets, every)
    return Crossing(time, "type 1", f"{words}: {cannot}" if cannot else words)


def _freedoms(part: FloatArray) -> str:
    count = int((np.linalg.svd(part, compute_uv=False) < LOST).sum())
    return f"; {count} freedoms in all" if count > 1 else ""


def _ending(path: _Path, sets: Sets, i: int, rank: int, best: float) -> list[Crossing]:
    """What stopped the motion between samples i and i + 1, if it was a singularity."""
    low, high = path.time[i : i + 2].tolist()
    figure = {time: path.conditioning(i, time) for time in (low, high)}
    if not np.isfinite(figure[low]):
        return []
    if np.isnan(figure[high]):
        time = _bisected(low, high, lambda t: bool(np.isfinite(path.conditioning(i, t))))
    elif figure[low] * figure[high] < 0:
        time = _bisected(low, high, lambda t: path.conditioning(i, t) * figure[low] > 0)
    else:  # a closed form keeps its sign: its figure is a V, and at the tip its branch is lost
        tips = [_tip(path, j) for j in (i, i + 1) if j + 1 < len(path.time)]
        _, time, i = min(tips)
        low = float(path.time[i])
    before = max(low, time - _LOCATED)
    if not abs(path.conditioning(i, before)) < LOST:
        return []
    y, guess = path.at(i, before)
    _, q = path.rates(y, guess, sets)
    found = freedom(path.solver, sets, q[:, 0], rank, best)
    if found.held > LOST:
        return []  # the rows that are solved fail, and not the mechanism
    return [Crossing(time, found.kind, found.words, ends=True)]


def _tip(path: _Path, i: int) -> tuple[float, float, int]:
    """The least figure between samples i and i + 1, its time, and i."""
    first, last = path.time[i : i + 2].tolist()
    while _wide(first, last):
        a, b = first + (last - first) / 3, last - (last - first) / 3
        if abs(path.conditioning(i, a)) < abs(path.conditioning(i, b)):
            last = b
        else:
            first = a
    time = (first + last) / 2
    return abs(path.conditioning(i, time)), time, i
