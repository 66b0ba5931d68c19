"""A simulation's result: its motion as `solve` has it, with what acted and how energy went."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from parakin.arrays import ORDERS, FloatArray
from parakin.errors import InputError, nearest
from parakin.kinematics.configuration import Configuration
from parakin.model.graph import Graph
from parakin.motion.checks import SLACK, refuse_unless_positive
from parakin.solving.force_variables import force_variables
from parakin.solving.forces import Asked, Forces, is_finite
from parakin.solving.motors import at_motors
from parakin.solving.simulation import Simulation, Told
from parakin.solving.status import SOLVED, Status
from parakin.solving.tick import Tick
from parakin.solving.windows import Windows

if TYPE_CHECKING:
    import xarray as xr

_MOST = 10**7  # samples: all are kept at once
_APART = 1e-4  # rad, or characteristic lengths: what was integrated and solved is another pose


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
    if status != Status.CONVERGED:
        raise InputError("start", f"a pose that is flagged: {status.words}", "one that is solved")
    return tick


def simulated(
    simulation: Simulation,
    start: tuple[Configuration, FloatArray],
    times: FloatArray,
    windows: Windows,
) -> xr.Dataset:
    """The result at all times (n,). start: the configuration, and driven rates (k,).
    Raises InputError.
    """
    refuse_unless_positive(simulation.rtol, "rtol")
    refuse_unless_positive(simulation.rest, "rest_speed")
    outputs = simulation.home.outputs
    if outputs.derivatives < 2 or not outputs.checks:
        lean, whole = "one compiled without accelerations or checks", "derivatives=2, checks=True"
        raise InputError("solver", lean, f"one with {whole}")
    found = simulation.run(*start, times)
    motion = found.motion
    (result,) = windows.solve(motion, motion.count, derivatives=2, parallel=False)
    told = simulation.told(found, result["time"].values)
    graph = simulation.home.plan.graph.plain
    result = checked(with_forces(result, told, graph), told)
    return ended_early(result, times, found.ended) if motion.count < len(times) else result


def with_forces(result: xr.Dataset, told: Told, graph: Graph) -> xr.Dataset:
    """A result with efforts, power, motors, energies and drifts at its samples."""
    known = result["coordinate"].values.tolist()
    nothing = np.full(result.sizes["time"], np.nan)
    velocity, acceleration = (
        np.array(
            [
                result[order].sel(coordinate=name).values if name in known else nothing
                for name in told.actuators
            ]
        ).reshape(len(told.actuators), -1)
        for order in ORDERS[1:3]
    )
    motors = [graph.dynamics.motors.get(graph.index(name, "")) for name in told.actuators]
    rest = np.zeros_like(told.effort)
    torque, band, speed, current = at_motors(motors, told.effort, rest, velocity, acceleration)
    none = np.zeros((0, 3, result.sizes["time"]))
    forces = Forces(
        told.actuators,
        told.units,
        (),
        (),
        tuple(n for n, motor in zip(told.actuators, motors, strict=True) if motor),
        told.effort,
        rest,
        told.power,
        nothing,
        torque,
        band,
        speed,
        torque * speed,
        current,
        none,
        none,
        nothing,
        none[:, 0],
        *told.energies,
    )
    variables, labels = force_variables(forces, Asked(energies=True))
    drifts = (
        ("energy_drift", told.energy_drift, "J", "energy beyond the first and the work since"),
        ("closure_drift", told.closure_drift, "m", "norm of closure rows of what was integrated"),
    )
    for name, values, unit, about in drifts:
        variables[name] = ("time", values, {"units": unit, "long_name": about})
    return result.assign(variables).assign_coords(labels)


def checked(result: xr.Dataset, told: Told) -> xr.Dataset:
    """A result with what was integrated compared: where a solved pose is another one, it is flagged
    as a change of branch. What is not solved is NaN throughout.
    """
    status = result["status"].values
    solved = [int(each) for each in SOLVED]
    wrong = np.zeros(len(status), dtype=bool)
    for name in set(told.positions).intersection(result["coordinate"].values.tolist()):
        off = result["position"].sel(coordinate=name).values - told.positions[name]
        if str(result["unit"].sel(coordinate=name).item()) == "rad":
            off = np.abs(np.angle(np.exp(1j * off)))
        else:
            off = np.abs(off) / result.attrs["characteristic_length"]
        wrong |= off > _APART
    status[wrong & np.isin(status, solved)] = Status.BRANCH_CHANGE
    unknown = ~np.isin(status, solved)
    if unknown.any():
        for variable, values in result.items():
            kept = values.dtype.kind != "f" or variable == "first_at"
            if values.dims[:1] == ("time",) and not kept:
                values.values[unknown] = np.nan
    return result


def ended_early(result: xr.Dataset, times: FloatArray, ended: float) -> xr.Dataset:
    """A result at all times (n,) of a simulation that met a singularity where it `ended`: after it
    NaN, the first sample flagged with why.
    """
    known = result.sizes["time"]
    blank = {
        "status": np.int8(Status.NOT_REACHED),
        "stopped_by": np.int16(0),
        **{name: np.nan for name, values in result.items() if values.dtype.kind == "f"},
    }
    attributes = dict(result["time"].attrs)
    longer = result.reindex(time=times, fill_value=blank)
    longer["time"].attrs = attributes
    if known < len(times):
        longer["status"].values[known] = Status.SINGULAR
        longer["first_at"].values[known] = ended
    return longer
