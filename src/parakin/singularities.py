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
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from parakin import closure
from parakin.assembly import FloatArray, circuits_at, configure, coordinate_scales, freedoms
from parakin.connectivity import jacobian
from parakin.errors import InputError
from parakin.graph import Graph
from parakin.kernel import CHECKS, Outputs
from parakin.machine import make_kernel, output_count
from parakin.plan import Block, Plan
from parakin.tracking import RESIDUAL, Status, hermite
from parakin.words import moving, names, platform_axes, platform_motion

if TYPE_CHECKING:
    import xarray as xr

    from parakin.motion import Motion
    from parakin.solver import Solver

Kind = Literal["type 1", "type 2", "constraint", "passive", "driven", "angles"]

_LOCATED = 1e-10  # [s]
_STEPS = 8  # Newton steps where a plan iterates, from the sample before
_RANK = 1e-8
_LOST = 1e-3  # of its best value along the motion: a rank that is lost
_STILL = 1e-3  # of what moves most: what rests


@dataclass(frozen=True)
class Crossing:
    """A singularity at a time [s] between two samples, its kind, and what goes free or is lost.

    "type 1", "type 2"; "constraint": all rows together lose rank; "passive": joints that are
    neither actuated nor outputs go free; "driven": the driven coordinates, being neither the
    actuated ones nor the outputs, determine the rest no longer; "angles": it is only the three
    angles of the platform that are not defined there. `ends`: the motion stops there.
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


def outputs_of(solver: Solver) -> list[str]:
    """The coordinates that the actuated ones move: those of the platform that the file drives,
    or that move most freely, or without a platform what leaves the last links at the base.

    Raises InputError where there are not as many actuated coordinates, or outputs, as driven ones.
    """
    return [solver.graph.coordinates[k].name for k in _sets(solver).outputs]


class _Sets(NamedTuple):
    """Numbers of coordinates: actuated, outputs, and the platform's six."""

    actuated: list[int]
    outputs: list[int]
    pose: list[int]

    @property
    def turned(self) -> list[int]:
        """Where the platform's angles stand among actuated coordinates and outputs, all or none."""
        whole = set(self.pose[3:]) <= set(self.outputs)
        return [len(self.actuated) + self.outputs.index(k) for k in self.pose[3:]] if whole else []


def closeness(solver: Solver, result: xr.Dataset, motion: Motion | None = None) -> Closeness:
    """How near a solved motion comes to each kind of singularity.

    result: what `solver.solve` gave; flagged samples come out as NaN. motion: what was solved;
    with it the place where it stopped, if it did, is looked into too. Raises InputError where the
    mechanism has no actuated coordinates, or not as many as are driven, or no other outputs.
    """
    sets = _sets(solver)
    good = np.isin(result["status"].values, (Status.CONVERGED, Status.LIMIT_EXCEEDED))
    time = result["time"].values
    type1, type2, whole, signs = (np.full(len(time), np.nan) for _ in range(4))
    crossings: list[Crossing] = []
    if good.any():
        path = _Path.of(solver, result, motion)
        rates, q = path.rates(path.driven[0][:, good], path.found[0][:, good], sets)
        type1[good], type2[good], signs[good] = _figures(rates, sets)
        values = _whole(solver.plan, q)
        rank = int((values > _RANK * values[:, :1]).sum(axis=1).max())
        whole[good] = values[:, rank - 1] / values[:, 0]
        crossings = [
            _crossing(path, sets, i) for i in np.flatnonzero(signs[1:] * signs[:-1] < 0).tolist()
        ]
        first_bad = int(np.argmin(good))
        if motion is not None and first_bad > 0 and not good[first_bad]:
            best = float(np.nanmax(whole))
            crossings += _ending(path, sets, first_bad - 1, rank, best)
    passive = np.where(good, result["conditioning"].values, np.nan)
    return Closeness(time, type1, type2, passive, whole, tuple(crossings))


def _sets(solver: Solver) -> _Sets:
    """The actuated coordinates, and the outputs: those of the platform that the file drives, or
    that move most freely, or without a platform what leaves the last links at the base.
    """
    graph, count = solver.graph, len(solver.driven)
    actuated = [k for k, c in enumerate(graph.coordinates) if c.actuated]
    pose = [] if graph.platform is None else list(graph.joints[graph.platform].coordinates)
    where = solver.mechanism.where
    if len(actuated) != count:
        raise InputError(
            where,
            f"{len(actuated)} actuated coordinates and {count} driven",
            "as many motors (actuated = true) as the mobility, to tell singularities apart",
        )
    by_file = [graph.index(n, "driven") for n in solver.mechanism.driven]
    outputs = [k for k in by_file if k not in actuated]
    if len(outputs) != count and pose:
        outputs = _freest(solver, pose, count)
    elif len(outputs) != count:
        named = [graph.index(n, "coordinates") for n in solver.coordinates if n not in graph.cones]
        grounded = [k for k in named if graph.joints[graph.coordinates[k].joint].parent == 0]
        outputs = [k for k in grounded if k not in actuated][-count:]
    if len(outputs) != count:
        raise InputError(
            where,
            f"{len(outputs)} outputs beside {count} actuated coordinates",
            "a [platform], or as many passive coordinates at the base",
        )
    return _Sets(actuated, outputs, pose)


def _freest(solver: Solver, among: list[int], count: int) -> list[int]:
    """As many coordinates as are driven that move most independently at home."""
    graph, plan = solver.graph, solver.plan
    at = configure(graph, plan.tree, plan.home)
    motions = freedoms(graph, plan.tree, at) / coordinate_scales(graph)[:, None]
    left = motions[among]
    chosen: list[int] = []
    for _ in range(count):
        sizes = np.linalg.norm(left, axis=1)
        k = int(np.argmax(sizes))
        if sizes[k] > _RANK:
            chosen.append(among[k])
            left = left - np.outer(left @ left[k], left[k]) / sizes[k] ** 2
    return sorted(chosen)


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
        found = [result[order].sel(coordinate=list(rows)).values.T for order in orders]
        names = list(solver.driven)
        if motion is not None:
            if motion.count != result.sizes["time"]:
                said = f"{motion.count} samples, of the result {result.sizes['time']}"
                raise InputError(f"motion {motion.name}", said, "the motion that was solved")
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

    def rates(self, y: FloatArray, guess: FloatArray, sets: _Sets) -> tuple[FloatArray, FloatArray]:
        """Rates of actuated coordinates, outputs and pose for a unit rate of each driven one,
        scaled, (n, coordinates, driven); and the positions of all coordinates, (coordinates, n).
        """
        graph, plan = self.solver.graph, self.solver.plan
        every, scales = range(len(graph.coordinates)), coordinate_scales(graph)
        rows = [*sets.actuated, *sets.outputs, *sets.pose]
        outputs = Outputs(tuple(every), derivatives=1, checks=False)
        kernel = make_kernel(plan, outputs, machine_code=False, steps=_STEPS)
        columns = []
        for k, number in enumerate(plan.driven):
            unit = np.zeros_like(y)
            unit[k] = scales[number]
            out = np.empty((output_count(outputs), y.shape[1]))
            kernel(np.concatenate([y, unit, guess]), out, False)
            columns.append(out[len(every) :][rows].T / scales[rows])
        offsets = np.array([plan.offset(k) for k in every])
        found, q = np.stack(columns, axis=2), out[: len(every)] + offsets[:, None]
        angles = sets.turned
        if angles:  # angular velocities, which are defined where angles are not
            found[:, angles] = platform_axes(graph, q)[0] @ found[:, angles]
        return found, q

    def conditioning(self, i: int, time: float) -> float:
        """That of what is solved, NaN out of reach."""
        plan = self.solver.plan
        outputs = Outputs((), derivatives=0)
        out = np.empty((CHECKS, 1))
        y, guess = self.at(i, time)
        make_kernel(plan, outputs, machine_code=False, steps=_STEPS)(
            np.concatenate([y, guess]), out, False
        )
        closed = out[0, 0] <= RESIDUAL * plan.graph.length
        return float(out[1, 0]) if closed else np.nan


def _figures(rates: FloatArray, sets: _Sets) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Figures of type 1 and 2, and the sign of the determinant between the two sets."""
    count = len(sets.actuated)
    basis, _ = np.linalg.qr(rates[:, : 2 * count])
    ours, theirs = basis[:, :count], basis[:, count:]
    type2 = np.linalg.svd(ours, compute_uv=False)[:, -1]
    type1 = np.linalg.svd(theirs, compute_uv=False)[:, -1]
    return type1, type2, np.sign(np.linalg.det(ours) * np.linalg.det(theirs))


def _whole(plan: Plan, q: FloatArray) -> FloatArray:
    """Singular values of all closure rows by all coordinates of the tree, (n, values)."""
    graph, tree = plan.graph, plan.tree
    inside, rows = graph.inside(tree), closure.all_rows(graph, tree)
    if not rows:
        return np.ones((q.shape[1], 1))
    slopes = jacobian(circuits_at(graph, tree, q), Block(tuple(inside), tuple(rows)))
    matrix = np.empty((q.shape[1], len(rows), len(inside)))
    scales = coordinate_scales(graph)
    for i, row in enumerate(rows):
        for j, k in enumerate(inside):
            matrix[:, i, j] = (
                closure.per_length(graph, row) / graph.length * scales[k] * slopes[i][j]
            )
    values: FloatArray = np.asarray(np.linalg.svd(matrix, compute_uv=False), dtype=np.float64)
    return values


def _wide(low: float, high: float) -> bool:
    """Whether an interval is wider than times need to be known, or can be."""
    return high - low > max(_LOCATED, 4 * float(np.spacing(abs(high))))


def _bisected(low: float, high: float, same: Callable[[float], bool]) -> float:
    while _wide(low, high):
        middle = (low + high) / 2
        low, high = (middle, high) if same(middle) else (low, middle)
    return (low + high) / 2


def _crossing(path: _Path, sets: _Sets, i: int) -> Crossing:
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
    graph, count = path.solver.graph, len(sets.actuated)
    free = 2 if type2[0] < type1[0] else 1
    rows = slice(count) if free == 2 else slice(count, 2 * count)
    mix = np.linalg.svd(rates[0, rows])[2][-1]
    every = np.zeros(len(graph.coordinates))
    every[[*sets.actuated, *sets.outputs, *sets.pose]] = rates[0] @ mix
    if free == 2:
        many = _freedoms(np.linalg.qr(rates[0, : 2 * count])[0][:count])
        return Crossing(time, "type 2", _free(graph, sets, every, q[:, 0]) + many)
    lost = np.zeros(len(graph.coordinates))
    lost[sets.outputs] = np.linalg.svd(rates[0, rows])[0][:, -1]
    if sets.turned:
        turns = sets.pose[3:]
        lost[turns] = np.linalg.solve(platform_axes(graph, q)[0][0], lost[turns])
    cannot = platform_motion(graph, lost, q[:, 0], sets.outputs, "cannot")
    words = _idle(graph, sets, every)
    return Crossing(time, "type 1", f"{words}: {cannot}" if cannot else words)


def _freedoms(part: FloatArray) -> str:
    count = int((np.linalg.svd(part, compute_uv=False) < _LOST).sum())
    return f"; {count} freedoms in all" if count > 1 else ""


def _ending(path: _Path, sets: _Sets, i: int, rank: int, best: float) -> list[Crossing]:
    """What stopped the motion between samples i and i + 1, if it was a singularity."""
    low, high = path.time[i : i + 2].tolist()
    figure = {time: path.conditioning(i, time) for time in (low, high)}
    if not np.isfinite(figure[low]):
        return []
    if np.isnan(figure[high]):
        time = _bisected(low, high, lambda t: bool(np.isfinite(path.conditioning(i, t))))
    elif figure[low] * figure[high] < 0:
        time = _bisected(low, high, lambda t: path.conditioning(i, t) * figure[low] > 0)
    else:  # a closed form keeps its sign: its figure is a V, at the tip of which it goes astray
        tips = [_tip(path, j) for j in (i, i + 1) if j + 1 < len(path.time)]
        _, time, i = min(tips)
        low = float(path.time[i])
    before = max(low, time - _LOCATED)
    if not abs(path.conditioning(i, before)) < _LOST:
        return []
    y, guess = path.at(i, before)
    _, q = path.rates(y, guess, sets)
    freedom = _freedom(path.solver, sets, q[:, 0], rank, best)
    if freedom.held > _LOST:
        return []  # the rows that are solved fail, and not the mechanism
    return [Crossing(time, freedom.kind, freedom.words, ends=True)]


class Freedom(NamedTuple):
    """What moves most easily at a pose while the driven coordinates are held: the kind of
    singularity that it makes, in words; rates of all coordinates, slides in characteristic
    lengths; and how firmly it is `held`, 0 where it is free.
    """

    kind: Kind
    words: str
    rates: FloatArray
    held: float

    @property
    def said(self) -> str:
        """As what a motion stops at."""
        if self.kind == "angles":
            return self.words
        kind = {"driven": "", "passive": "passive-joint "}.get(self.kind, f"{self.kind} ")
        return f"a {kind}singularity, where {self.words}"


def freedom_at(solver: Solver, q: FloatArray) -> Freedom:
    """What a pose near a singularity is near to; home tells which rank the rows have.

    q: all coordinates, as the joints count. Where kinds cannot be told apart, as `closeness` says,
    it is told by the driven coordinates alone. Raises LinAlgError.
    """
    try:
        sets = _sets(solver)
    except InputError:
        sets = None
    (values,) = _whole(solver.plan, np.asarray(solver.plan.home)[:, None])
    rank = int((values > _RANK * values[0]).sum())
    return _freedom(solver, sets, q, rank, float(values[rank - 1] / values[0]))


def _freedom(solver: Solver, sets: _Sets | None, q: FloatArray, rank: int, best: float) -> Freedom:
    """rank, best: of all closure rows where nothing is singular, and their least singular value
    over the largest.
    """
    graph, plan = solver.graph, solver.plan
    if graph.platform is not None and abs(_spread(graph, q)) < _LOST:
        words = "the platform's three angles are not defined there; angles about other axes may be"
        return Freedom("angles", words, np.zeros(len(q)), 0.0)
    (values,) = _whole(plan, q[:, None])
    lost_rank = bool(values[rank - 1] < _LOST * best * values[0])
    at = configure(graph, plan.tree, q)
    motions = freedoms(graph, plan.tree, at, rank=rank - lost_rank)
    motions = motions / coordinate_scales(graph)[:, None]
    _, held, right = np.linalg.svd(motions[[*plan.driven, *plan.idle]])
    free = motions @ right[-1]
    firm = float(held[-1]) if motions.shape[1] == len(held) else 0.0
    free[list(plan.driven)] = 0.0  # or nearly so
    if sets is None:
        words = f"{moving(graph, free, range(len(free)))} with the driven coordinates locked"
        return Freedom("driven", words, free, firm)
    return Freedom(*_judged(graph, sets, free, q, constraint=lost_rank), free, firm)


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


def _spread(graph: Graph, q: FloatArray) -> float:
    """The volume that the axes of the platform's three angles span, 0 in gimbal lock."""
    return float(np.linalg.det(platform_axes(graph, q[:, None])[0][0]))


def _judged(
    graph: Graph, sets: _Sets, free: FloatArray, q: FloatArray, *, constraint: bool
) -> tuple[Kind, str]:
    """Which kind: by what moves while the driven coordinates rest."""
    still = _STILL * float(np.abs(free).max())
    rest = [bool((np.abs(free[part]) < still).all()) for part in (sets.actuated, sets.outputs)]
    kind: Kind = "constraint"
    if not constraint:
        kinds: dict[tuple[bool, bool], Kind] = {
            (True, True): "passive",
            (True, False): "type 2",
            (False, True): "type 1",
            (False, False): "driven",
        }
        kind = kinds[rest[0], rest[1]]
    every = range(len(graph.coordinates))
    whole = sets._replace(outputs=sets.pose or sets.outputs)
    carried = bool((np.abs(free[whole.outputs]) > still).any())
    loose = _outputs(graph, whole, free, q) if carried else moving(graph, free, every)
    words = {
        "constraint": lambda: f"{loose}, whatever is driven",
        "passive": lambda: f"{moving(graph, free, every)} while all else rests",
        "type 2": lambda: _free(graph, sets, free, q),
        "type 1": lambda: _idle(graph, sets, free),
        "driven": lambda: f"{moving(graph, free, every)} with the driven coordinates locked",
    }
    return kind, words[kind]()


def _outputs(graph: Graph, sets: _Sets, rates: FloatArray, q: FloatArray) -> str:
    return platform_motion(graph, rates, q, sets.outputs) or moving(graph, rates, sets.outputs)


def _free(graph: Graph, sets: _Sets, rates: FloatArray, q: FloatArray) -> str:
    """Type 2 in words."""
    actuators = names(graph, sets.actuated)
    return f"{_outputs(graph, sets, rates, q)} with the actuators locked ({actuators})"


def _idle(graph: Graph, sets: _Sets, rates: FloatArray) -> str:
    """Type 1 in words."""
    rests = "the platform" if set(sets.outputs) <= set(sets.pose) else names(graph, sets.outputs)
    return f"{moving(graph, rates, sets.actuated)} while {rests} rests"
