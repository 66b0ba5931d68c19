"""Simulations in batches: many starts, payloads and efforts at once, in steps of a fixed length.

All runs go together through the compiled right-hand side, several in each instruction. None of them
is planned anew on its way: where its plan's rows lose their grip a run ends, flagged.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from parakin.arrays import ORDERS, PER_TIME, FloatArray, StatusArray
from parakin.caching import cached_property
from parakin.errors import InputError, nearest
from parakin.model.graph import Graph
from parakin.motion.checks import refuse_unless_positive
from parakin.solving.applied import Applied, Efforts, applied
from parakin.solving.forward import Forward, actuated_of, names_of
from parakin.solving.inputs import refuse_lean
from parakin.solving.integration import runge_kutta
from parakin.solving.options import BEGINS, sampled
from parakin.solving.simulated import apart
from parakin.solving.simulation import GRIP
from parakin.solving.solver import Solver
from parakin.solving.status import SOLVED, Status, are
from parakin.solving.tick import Tick

if TYPE_CHECKING:
    import xarray as xr


def simulate_batch(
    solver: Solver,
    duration: float,
    efforts: Efforts = None,
    *,
    start: Mapping[str, ArrayLike] | None = None,
    velocity: Mapping[str, ArrayLike] | None = None,
    loads: Mapping[str, ArrayLike] | None = None,
    step: float = 1e-3,
    rate: float = 100.0,
    rest_speed: float = 1e-3,
    parallel: bool = False,
) -> xr.Dataset:
    """The motions that forces make of n starts, payloads or efforts at once, over run and time.

    start, velocity, loads, efforts: as of `Solver.simulate`, but each number may be n of them, one
    for each run; a function of a `State` gets arrays (n,), and returns such. step: the longest step
    [s] of the classical Runge-Kutta method; `energy_drift` tells whether it is short enough. rate:
    samples a second. parallel: use all cores. A run is flagged, and NaN from there on, where it
    cannot start, where it meets a singularity, and where nine tenths of the grip are lost that the
    plan's rows had at its start: `simulate` goes on there. Raises InputError.
    """
    for name, value in (("step", step), ("rest_speed", rest_speed)):
        refuse_unless_positive(value, name)
    times = sampled(duration, rate)
    refuse_lean(solver.reported)
    unknown = [name for name in solver.iterated if name not in solver.coordinates]
    if unknown:
        found = f"one that does not report {', '.join(unknown)}"
        raise InputError("solver", found, "one that reports what it iterates")
    runs = _Runs.of(solver, efforts, start, velocity, dict(loads or {}), 1.0 / rate)
    servos, asks = runs.acting.servos, runs.acting.asks
    forward = Forward.of(solver.chart, rest_speed, servos=servos, asks=asks)
    return _Batch(solver, forward, runs, parallel=parallel).run(times, step)


class _Runs(NamedTuple):
    """What n runs begin with and what acts in them: y, yd (k, n); extra efforts (m, n)."""

    y: FloatArray
    yd: FloatArray
    acting: Applied
    extra: FloatArray
    loads: Mapping[str, ArrayLike]

    @classmethod
    def of(
        cls,
        solver: Solver,
        efforts: Efforts,
        start: Mapping[str, ArrayLike] | None,
        velocity: Mapping[str, ArrayLike] | None,
        loads: Mapping[str, ArrayLike],
        sample: float,
    ) -> _Runs:
        """Raises InputError."""
        graph, actuated = solver.graph, actuated_of(solver.plan)
        names = names_of(graph, actuated)
        each: dict[str, ArrayLike] = {}
        if isinstance(efforts, Mapping):
            each = {name: value for name, value in efforts.items() if _is_array(value)}
            efforts = {name: value for name, value in efforts.items() if name not in each}
        given = {f"start of {name}": value for name, value in (start or {}).items()}
        given |= {f"velocity of {name}": value for name, value in (velocity or {}).items()}
        given |= {f"efforts of {name}": value for name, value in each.items()}
        given |= {f"loads of {n}": each for n, each in _each_run(graph, loads).items()}
        count = _count(given)
        home = {name: solver.home[name] for name in solver.driven}
        return cls(
            _rows("start", start, home, count),
            _rows("velocity", velocity, dict.fromkeys(solver.driven, 0.0), count),
            applied(graph, actuated, efforts, solver.home, sample, {}),
            _rows("efforts", each, dict.fromkeys(names, 0.0), count, "actuated"),
            loads,
        )


def _each_run(graph: Graph, loads: Mapping[str, ArrayLike]) -> dict[str, ArrayLike]:
    """Of loads by name, what there is one of for each run. Raises InputError."""
    sizes = {wrench.name: wrench.inputs for wrench in graph.dynamics.wrenches}
    found: dict[str, ArrayLike] = {}
    for name, value in loads.items():
        size, shape = sizes.get(name, 1), np.shape(value)
        if size > 1 and shape != (size,):
            if len(shape) != 2 or shape[0] != size:
                expected = f"({size},), or ({size}, n) for n runs"
                raise InputError(f"loads of {name}", f"shape {shape}", expected)
            found[name] = np.zeros(shape[1])
        elif size == 1 and shape:
            found[name] = value
    return found


def _is_array(value: Any) -> bool:
    return isinstance(value, (np.ndarray, list, tuple))


def _count(given: Mapping[str, ArrayLike]) -> int:
    """How many runs there are. Raises InputError on arrays of different lengths."""
    sizes = {place: np.shape(value) for place, value in given.items() if np.ndim(value)}
    for place, shape in sizes.items():
        first = next(iter(sizes))
        if len(shape) != 1 or not shape[0] or shape != sizes[first]:
            expected = f"one number, or as many as {first}"
            raise InputError(place, f"shape {shape}", expected if place != first else "(n,)")
    return int(next(iter(sizes.values()), (1,))[0])


def _rows(
    what: str,
    given: Mapping[str, ArrayLike] | None,
    otherwise: Mapping[str, float],
    count: int,
    kind: str = "driven",
) -> FloatArray:
    """(k, n) of what is given by name, or otherwise. Raises InputError."""
    found = np.repeat(np.array(list(otherwise.values()), dtype=float)[:, None], count, axis=1)
    places = list(otherwise)
    for name, value in (given or {}).items():
        if name not in otherwise:
            raise InputError(what, f"{name!r}, not {kind}", nearest(str(name), places))
        numbers = np.asarray(value)
        if numbers.dtype.kind not in "fiu" or np.ma.isMaskedArray(value):
            raise InputError(f"{what} of {name}", repr(value)[:80], "numbers")
        if not np.isfinite(numbers).all():
            raise InputError(f"{what} of {name}", repr(value)[:80], "finite numbers")
        found[places.index(name)] = numbers
    return found


@dataclass(frozen=True, eq=False)
class _Batch:
    """All runs of a solver's forward dynamics."""

    solver: Solver
    forward: Forward
    runs: _Runs
    parallel: bool

    def run(self, times: FloatArray, step: float) -> xr.Dataset:
        """At times (n,) [s], in steps of at most `step` [s]."""
        self.solver.mechanics.check_histories(times[[0, -1]], self.runs.loads)
        states, status = self._begin()
        forward = self.forward
        reference = forward.figures(forward.run(states, self._nothing, self._loads(0.0)))
        told = [self._told(float(times[0]), states, reference, status)]
        for begin, end in zip(times[:-1].tolist(), times[1:].tolist(), strict=True):
            count = max(1, math.ceil((end - begin) / step * (1.0 - 1e-9)))
            with np.errstate(all="ignore"):  # what runs away becomes NaN, and is flagged
                states = runge_kutta(self._rates, states, (begin, end), count)
            told.append(self._told(end, states, reference, told[-1].status))
        return self._dataset(times, told)

    @property
    def _lean(self) -> int:
        return self.forward.rows.state

    @cached_property
    def _nothing(self) -> FloatArray:
        return np.zeros((self.forward.rows.efforts, self.runs.y.shape[1]))

    def _begin(self) -> tuple[FloatArray, StatusArray]:
        """States (s, n), and why some cannot start."""
        solver, (y, yd) = self.solver, self.runs[:2]
        places, which = np.unique(y, axis=1, return_inverse=True)
        which = which.ravel()
        tick = solver.at(places)
        status = np.asarray(tick.status, dtype=np.int8)[which]
        positions = np.full((self._lean, places.shape[1]), np.nan)
        for column in np.flatnonzero(are(BEGINS, np.asarray(tick.status))).tolist():
            alone = solver.at(places[:, column])
            at = solver.configuration(places[:, column], alone)
            if column == which[0]:
                self.forward.check_masses(at, self._loads(0.0)[:, 0])
            positions[:, column] = self.forward.state(at, yd[:, 0])
        states = positions[:, which]
        states[-1 - len(yd) : -1] = yd
        return states, status

    def _loads(self, time: float) -> FloatArray:
        """(inputs, n) of all runs."""
        if self._steady is not None:
            return self._steady
        n = self.runs.y.shape[1]
        return self.solver.mechanics.loads(np.full(n, time), n, self.runs.loads)

    @cached_property
    def _steady(self) -> FloatArray | None:
        """Loads throughout, if none changes with time."""
        if self.solver.mechanics.changing(self.runs.loads):
            return None
        return self.solver.mechanics.loads(None, self.runs.y.shape[1], self.runs.loads)

    def _efforts(self, time: float, states: FloatArray) -> FloatArray:
        """(e, n) of all runs."""
        acting, state = self.runs.acting, None
        if np.isinf(acting.step):
            return self._constant
        if acting.asks:
            state = self.forward.seen(time, states, self._loads(time))
        return self._spread(acting.of(time, state))

    @cached_property
    def _constant(self) -> FloatArray:
        """Efforts throughout, if they do not change."""
        return self._spread(self.runs.acting.of(0.0, None))

    def _spread(self, found: FloatArray) -> FloatArray:
        """Efforts (e,) or (e, n) as those of all runs."""
        efforts = self._nothing + (found if found.ndim == 2 else found[:, None])
        efforts[: len(self.runs.extra)] += self.runs.extra
        return efforts

    def _rates(self, time: float, states: FloatArray) -> FloatArray:
        efforts, loads = self._efforts(time, states), self._loads(time)
        return self.forward.run(states, efforts, loads, parallel=self.parallel)[: self._lean]

    def _told(
        self, time: float, states: FloatArray, reference: FloatArray, before: StatusArray
    ) -> _Told:
        """Of a moment: before, the status of runs until then."""
        telling = self.forward.telling
        out = telling.run(states, self._efforts(time, states), self._loads(time))
        driven, unknowns, _, rates = self.forward.parts(states)
        tick = self._solved(driven, unknowns, rates, self.forward.parts(out[: self._lean])[3])
        status = np.array(tick.status, dtype=np.int8)
        plan = self.forward.chart.plan
        for name, values in zip(names_of(plan.graph, plan.unknowns), unknowns, strict=True):
            if name in self.solver.coordinates:
                other = apart(self.solver.graph, name, np.asarray(tick.value(name)) - values)
                status[other & are(SOLVED, status)] = Status.BRANCH_CHANGE
        with np.errstate(all="ignore"):
            figures = telling.figures(out) / reference
        status[~(figures.min(axis=0, initial=1.0) >= GRIP)] = Status.SINGULAR
        status[~np.isfinite(states).all(axis=0)] = Status.NOT_SMOOTH
        gone = ~are(SOLVED if time else BEGINS, before)
        status[gone] = Status.NOT_REACHED if time else before[gone]
        told = telling.told(out)
        kinetic, potential, _, _, gap = told[-5:]
        return _Told(
            tick,
            status,
            told[: len(telling.rows.actuated)],
            np.array([kinetic + potential - states[-1], gap]),
        )

    def _solved(self, y: FloatArray, unknowns: FloatArray, yd: FloatArray, ydd: FloatArray) -> Tick:
        """What `at` says of a moment's poses, near what was integrated."""
        solver, plan = self.solver, self.forward.chart.plan
        known = dict(zip(names_of(plan.graph, plan.unknowns), unknowns, strict=True))
        guess = np.array(
            [known.get(n, np.full(y.shape[1], solver.home.get(n, 0.0))) for n in solver.coordinates]
        )
        return solver.at(y, yd, ydd, np.nan_to_num(guess))

    def _dataset(self, times: FloatArray, told: list[_Told]) -> xr.Dataset:
        import xarray as xr

        solver = self.solver
        status = np.array([each.status for each in told]).T
        known = are(SOLVED, status.ravel()).reshape(status.shape)
        over, of = ("run", "time"), ("run", "time", "coordinate")
        units = ["rad" if solver.graph.is_angle(n) else "m" for n in solver.coordinates]
        variables: dict[str, Any] = {}
        for k, order in enumerate(ORDERS[:3]):
            values = np.array([getattr(each.tick, order) for each in told]).transpose(2, 0, 1)
            unit = " or ".join(sorted(set(units))) + PER_TIME[k]
            variables[order] = (of, values, {"units": unit})
        effort = np.array([each.effort for each in told]).transpose(2, 0, 1)
        variables["effort"] = ("run", "time", "actuator"), effort, {"units": "N or N m"}
        drift, closure = np.array([each.drifts for each in told]).transpose(1, 2, 0)
        variables["energy_drift"] = over, drift - drift[:, :1], {"units": "J"}
        variables["closure_drift"] = over, closure, {"units": "m"}
        for name, (dims, values, attributes) in variables.items():
            values[~known] = np.nan
            variables[name] = dims, values, attributes
        variables["status"] = over, status
        labels = {
            "time": ("time", times, {"units": "s"}),
            "coordinate": list(solver.coordinates),
            "unit": ("coordinate", units),
            "actuator": names_of(solver.graph, self.forward.rows.actuated),
        }
        attributes = {"mechanism": solver.mechanism.name, "motion": "simulation"}
        return xr.Dataset(variables, labels, attributes)


class _Told(NamedTuple):
    """Of all runs at a moment: what `at` says, their status, efforts (m, n), and energy beyond the
    work done with how far the loops are open (2, n).
    """

    tick: Tick
    status: StatusArray
    effort: FloatArray
    drifts: FloatArray
