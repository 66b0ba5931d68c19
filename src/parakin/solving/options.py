"""What a simulation is asked for, checked: what acts, from where, how long and how exactly."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from parakin.arrays import FloatArray
from parakin.errors import InputError, nearest
from parakin.kernel.backends import has_machine_code
from parakin.kinematics.configuration import Configuration
from parakin.model.graph import Graph
from parakin.motion.checks import SLACK, refuse_unless_positive
from parakin.solving.applied import Efforts, applied
from parakin.solving.charts import Chart
from parakin.solving.forces import Mechanics, is_finite
from parakin.solving.forward import actuated_of
from parakin.solving.inputs import refuse_lean
from parakin.solving.simulation import Simulation
from parakin.solving.status import Status
from parakin.solving.tick import Tick

_FINEST = {"dop853": 3e-14, "taylor": 2.3e-16, "radau": 3e-14}  # rtol, by method
_ROUGHEST = 1e-3
_MOST = 10**7  # samples: all are kept at once
BEGINS = (Status.CONVERGED, Status.LIMIT_EXCEEDED)
"""Poses from which a simulation may begin."""


class Simulable(Protocol):
    """What a simulation needs of a solver."""

    chart: Chart
    driven: tuple[str, ...]
    home: Mapping[str, float]

    @property
    def mechanics(self) -> Mechanics: ...
    def at(self, y: ArrayLike, *, forces: bool = ..., loads: Any = ...) -> Tick: ...
    def configuration(self, y: FloatArray, tick: Tick) -> Configuration: ...


class Options(NamedTuple):
    """What `Solver.simulate` takes."""

    duration: float
    efforts: Efforts
    start: Mapping[str, float] | None
    velocity: Mapping[str, float] | None
    hold: bool
    rate: float
    times: ArrayLike | None
    method: str
    rtol: float
    rest_speed: float
    end_at_limits: bool
    project: float
    loads: Mapping[str, ArrayLike] | None

    def simulation(self, solver: Simulable, y: FloatArray) -> Simulation:
        """From driven positions (k,). Raises InputError."""
        if self.method not in _FINEST:
            raise InputError("method", repr(self.method), nearest(str(self.method), _FINEST))
        refuse_unless_positive(self.rest_speed, "rest_speed")
        if self.project != math.inf:
            refuse_unless_positive(self.project, "project")
        least = _FINEST[self.method]
        if not (is_finite(self.rtol) and least <= self.rtol <= _ROUGHEST):
            raise InputError("rtol", repr(self.rtol), f"{least:g} to {_ROUGHEST:g}")
        chart, sample = solver.chart, 1.0 / self.rate
        refuse_lean(chart.outputs)
        graph, actuated = chart.plan.graph.plain, actuated_of(chart.plan)
        held = _held(solver, y) if self.hold else {}
        acting = applied(graph, actuated, self.efforts, solver.home, sample, held)
        loads = _constant(graph, self.loads)
        how = self.rest_speed, self.rtol, sample, self.project, self.method
        found = Simulation(chart, actuated, acting, loads, *how)
        if self.method == "taylor":
            _refuse_changing(found)
        return found


def _held(solver: Simulable, y: FloatArray) -> dict[str, float]:
    """By name, the efforts that hold a pose (k,) at rest under the file's own loads, those that
    change with time as they begin. Raises InputError.
    """
    actuators = len(solver.mechanics.actuated)
    if actuators > len(solver.driven):
        found = (
            f"{actuators} actuators for {len(solver.driven)} freedoms, which leave open who holds"
        )
        raise InputError("hold", found, "efforts of all, by name, instead of it")
    histories = solver.mechanics.histories.items()
    now = {name: history(np.zeros(1))[:, 0] for name, history in histories}
    forces = solver.at(y, forces=True, loads=now).forces
    assert forces is not None
    return dict(zip(forces.actuators, forces.effort.tolist(), strict=True))


def _constant(graph: Graph, loads: Mapping[str, ArrayLike] | None) -> Mapping[str, ArrayLike]:
    """Loads throughout. Raises InputError on others."""
    if loads is not None and not isinstance(loads, Mapping):
        raise InputError("loads", type(loads).__name__, "numbers by payload or wrench")
    sizes = {wrench.name: wrench.inputs for wrench in graph.dynamics.wrenches}
    for name, value in (loads or {}).items():
        size = sizes.get(name, 1)
        if np.shape(value) not in ((), (size,)):
            one = "one number" if size == 1 else f"({size},)"
            expected = f"{one}, the same throughout"
            raise InputError(f"loads of {name}", f"shape {np.shape(value)}", expected)
    return loads or {}


def _refuse_changing(simulation: Simulation) -> None:
    """Raises InputError on what Taylor series cannot have."""
    expected = "constant efforts, or servos of fixed targets; or method 'dop853'"
    if simulation.acting.asks:
        found = "a Python function, of which there is no Taylor series"
        raise InputError("efforts", found, expected)
    if simulation.changing or math.isfinite(simulation.acting.step):
        raise InputError("method", "'taylor', with what changes over time", expected)
    passive = simulation.home.plan.graph.dynamics.passive.values()
    if simulation.acting.bounded or any(each.stop for each in passive):
        found = "'taylor', with stops or servos' bounds"
        raise InputError("method", found, "what has no kinks; or method 'dop853'")
    if not (simulation.home.machine_code and has_machine_code()):
        found = "'taylor', without machine code"
        raise InputError("method", found, "heyoka installed; or method 'dop853'")


def at_times(options: Options) -> FloatArray:
    """The times (n,) [s] that are asked for. Raises InputError."""
    regular = sampled(options.duration, options.rate)
    if options.times is None:
        return regular
    try:
        times = np.array(options.times, dtype=float)
    except (TypeError, ValueError):
        raise InputError("times", repr(options.times)[:80], "numbers [s]") from None
    inside = times.ndim == 1 and len(times) and times[0] >= 0.0 and times[-1] <= options.duration
    if not (inside and (np.diff(times) > 0.0).all()):
        expected = f"increasing times from 0 to {options.duration:g} s"
        raise InputError("times", repr(options.times)[:80], expected)
    return times


def sampled(duration: float, rate: float) -> FloatArray:
    """The times (n,) [s] of a simulation, its end included. Raises InputError."""
    for name, value in (("duration", duration), ("rate", rate)):
        refuse_unless_positive(value, name)
    count = duration * rate
    if not count < _MOST:
        raise InputError("rate", f"{count:.3g} samples", f"fewer than {_MOST}")
    whole = np.arange(math.floor(count * (1 + SLACK)) + 1) / rate
    if whole[-1] < duration * (1 - SLACK):
        return np.append(whole, duration)
    whole[-1] = duration
    return whole


def beginning(
    driven: Sequence[str],
    home: Mapping[str, float],
    start: Mapping[str, float] | None,
    velocity: Mapping[str, float] | None,
) -> tuple[FloatArray, FloatArray]:
    """Positions and rates (k,) of the driven coordinates. Raises InputError."""
    found = []
    for place, given in (("start", start), ("velocity", velocity)):
        values = {name: home[name] if place == "start" else 0.0 for name in driven}
        if given is not None and not isinstance(given, Mapping):
            raise InputError(place, repr(given)[:80], "numbers by driven coordinate")
        for name, value in (given or {}).items():
            if name not in values:
                raise InputError(place, f"{name!r}, not driven", nearest(str(name), driven))
            if not is_finite(value):
                raise InputError(f"{place} of {name}", repr(value), "a finite number")
            values[name] = float(value)
        found.append(np.array(list(values.values())))
    return found[0], found[1]


def required(tick: Tick) -> Tick:
    """A pose to start from. Raises InputError if it is none."""
    status = Status(int(tick.status))
    if status not in BEGINS:
        raise InputError("start", f"a pose that is flagged: {status.words}", "one that is solved")
    return tick
