"""A simulation's result: its motion as `solve` has it, with what acted and how energy went."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from parakin.arrays import ORDERS, BoolArray, FloatArray
from parakin.errors import ParakinError
from parakin.kinematics.configuration import configure
from parakin.model.graph import Graph
from parakin.solving.charts import Chart
from parakin.solving.continuity import missing_turns
from parakin.solving.force_variables import force_variables
from parakin.solving.forces import Asked, Forces
from parakin.solving.forward import names_of
from parakin.solving.motors import at_motors
from parakin.solving.options import Options, Simulable, at_times, beginning, required
from parakin.solving.simulation import Left, Simulated, Simulation
from parakin.solving.status import SOLVED, Status, are
from parakin.solving.windows import Windows

if TYPE_CHECKING:
    import xarray as xr

_APART = 1e-4  # rad, or characteristic lengths: what was integrated and solved is another pose
_DRIFTS = 100.0  # of rtol: as far as what is integrated may drift


class Part(NamedTuple):
    """Of a simulation: what solves it."""

    chart: Chart
    windows: Windows


def simulated(
    solver: Simulable, part: Callable[[Left | None], Part], options: Options
) -> xr.Dataset:
    """What `Solver.simulate` returns. part: what solves the first part, or the one that goes on
    where driven coordinates have left it. Raises InputError.
    """
    asked = at_times(options)
    times = asked if asked[0] == 0.0 else np.concatenate([[0.0], asked])
    y, yd = beginning(solver.driven, solver.home, options.start, options.velocity)
    at = solver.configuration(y, required(solver.at(y)))
    there, simulation = part(None), options.simulation(solver, y)
    graph = simulation.home.plan.graph.plain
    found = simulation.run(at, yd, 0.0, times)
    parts, solved = [found], [_solved(graph, there.windows, found, options.rtol)]
    while found.left is not None and found.ended < times[-1]:
        try:
            there = part(found.left)
        except (ParakinError, np.linalg.LinAlgError):
            break
        simulation = replace(simulation, home=there.chart)
        plan, left = there.chart.plan, found.left
        at = configure(graph, graph.posed_tree(), left.q)
        at = configure(plan.graph, plan.tree, there.chart.coordinates_at(at))
        rest = times[times > found.ended]
        rates = left.rates[list(plan.driven)]
        found = simulation.run(at, rates, found.ended, rest, left.work)
        if found.motion.count:
            parts.append(found)
            solved.append(_solved(graph, there.windows, found, options.rtol))
    result = _joined(solved)
    if result.sizes["time"] < len(times):
        result = _ended_early(result, times, found)
    result = _with_forces(result, simulation, parts)
    result.attrs |= {"method": options.method, "rtol": options.rtol}
    result.attrs["steps"] = sum(each.steps for each in parts)
    result.attrs["evaluations"] = sum(each.evaluations for each in parts)
    if found.why and found.ended < times[-1]:
        result.attrs["ended"] = f"at {found.ended:.6g} s: {found.because}"
    elif not are(SOLVED, result["status"].values).all():
        first = int(np.argmin(are(SOLVED, result["status"].values)))
        result.attrs["ended"] = f"before {times[first]:.6g} s: what was integrated is not followed"
    if options.end_at_limits:
        result = ended_at_limits(result)
    return result if len(asked) == len(times) else result.isel(time=slice(1, None))


def _solved(graph: Graph, windows: Windows, found: Simulated, rtol: float) -> xr.Dataset:
    """The motion of a part, solved. Where a solved pose is another one than was integrated, it is
    flagged as a change of branch.
    """
    (plain,) = windows.solve(found.motion, found.motion.count, derivatives=2, parallel=False)
    result = windows.labels.dataset(plain)
    status = result["status"].values
    wrong = np.zeros(len(status), dtype=bool)
    for name in set(found.told.positions).intersection(result["coordinate"].values.tolist()):
        off = result["position"].sel(coordinate=name).values - found.told.positions[name]
        wrong |= apart(graph, name, off, rtol)
    status[wrong & np.isin(status, [int(each) for each in SOLVED])] = Status.BRANCH_CHANGE
    return result


def apart(graph: Graph, name: str, off: FloatArray, rtol: float = 0.0) -> BoolArray:
    """Whether a coordinate that is so far off (n,) belongs to another pose, and has not drifted
    there by a rough tolerance; NaN is nothing.
    """
    most = max(_APART, _DRIFTS * rtol)
    if graph.is_angle(name):
        return np.asarray(np.abs(np.angle(np.exp(1j * off))) > most)
    return np.asarray(np.abs(off) > most * graph.length)


def _joined(parts: Sequence[xr.Dataset]) -> xr.Dataset:
    """Parts that follow one another as one, which is labelled as the first is."""
    import xarray as xr

    first = parts[0]
    if len(parts) == 1:
        return first
    limits = np.isfinite(first["limit_low"].values) | np.isfinite(first["limit_high"].values)
    known = np.array([0, *np.flatnonzero(limits)])
    over: dict[Any, Any] = {name: [] for name, v in first.items() if v.dims[:1] == ("time",)}
    last = first
    for part in parts:
        if part is not first:
            _go_on(last, part, known)
        for name, values in over.items():
            values.append(part[name].values)
        last = part
    data = {
        name: (first[name].dims, np.concatenate(values), first[name].attrs)
        for name, values in over.items()
    }
    fixed = first.drop_dims("time")
    time = np.concatenate([part["time"].values for part in parts])
    labels = {"time": xr.Variable("time", time, first["time"].attrs)}
    met = "; ".join(dict.fromkeys(p.attrs["stops_met"] for p in parts if p.attrs["stops_met"]))
    return fixed.assign_coords(labels).assign(data).assign_attrs(stops_met=met)


def _go_on(last: xr.Dataset, part: xr.Dataset, limits: FloatArray) -> None:
    """Make a part follow the last one: its angles by full turns, quaternions by their sign; what is
    no limit stops it under another number, and so under none.
    """
    number = part["stopped_by"].values
    number[~np.isin(number, limits)] = 0
    step = np.array([float(part["time"][0]) - float(last["time"][-1])])
    orders = ORDERS[:3]
    before = np.array([last[order].values[-1] for order in orders])[:, :, None]
    after = np.array([part[order].values[0] for order in orders])[:, :, None]
    turns = missing_turns(step, before, after, part["unit"].values == "rad")[:, 0]
    part["position"].values[:] += 2 * math.pi * np.nan_to_num(turns)
    if "body_orientation" in part:
        facing = last["body_orientation"].values[-1], part["body_orientation"].values[0]
        way = np.sign((facing[0] * facing[1]).sum(axis=-1))
        part["body_orientation"].values[:] *= np.where(way < 0.0, -1.0, 1.0)[..., None]


def _ended_early(result: xr.Dataset, times: FloatArray, found: Simulated) -> xr.Dataset:
    """A result at all times (n,) of a simulation that ended before the last: after it NaN, the
    first sample flagged with why.
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
    longer["status"].values[known] = found.why
    longer["first_at"].values[known] = found.ended
    return longer


def _with_forces(
    result: xr.Dataset, simulation: Simulation, parts: Sequence[Simulated]
) -> xr.Dataset:
    """A result with efforts, power, motors, energies and drifts at its samples; what is not solved
    is NaN throughout.
    """
    n = result.sizes["time"]
    told = [part.told for part in parts]

    def whole(arrays: Sequence[FloatArray]) -> FloatArray:
        known = np.concatenate(arrays, axis=-1)
        found = np.full((*known.shape[:-1], n), np.nan)
        found[..., : known.shape[-1]] = known
        return found

    forces = _forces(
        result,
        simulation.home.plan.graph.plain,
        simulation.actuated,
        whole([each.effort for each in told]),
        whole([each.power for each in told]),
        whole([each.energies for each in told]),
    )
    variables, labels = force_variables(forces, Asked(energies=True))
    balance = whole([each.balance for each in told])
    closure = whole([each.closure_drift for each in told])
    with np.errstate(invalid="ignore"):  # where energies are infinite
        drift = balance - balance[0]
    drifts = (
        ("energy_drift", drift, "J", "energy beyond the first and the work since"),
        ("closure_drift", closure, "m", "norm of closure rows of what was integrated"),
    )
    for name, values, unit, about in drifts:
        variables[name] = ("time", values, {"units": unit, "long_name": about})
    result = result.assign(variables).assign_coords(labels)
    return blanked(result, ~np.isin(result["status"].values, [int(each) for each in SOLVED]))


def _forces(
    result: xr.Dataset,
    graph: Graph,
    actuated: Sequence[int],
    effort: FloatArray,
    power: FloatArray,
    energies: FloatArray,
) -> Forces:
    """Efforts and power of the actuated coordinates (m, n), with their motors, and energies."""
    known = result["coordinate"].values.tolist()
    names = names_of(graph, actuated)
    nothing = np.full(result.sizes["time"], np.nan)
    velocity, acceleration = (
        np.array(
            [
                result[order].sel(coordinate=name).values if name in known else nothing
                for name in names
            ]
        ).reshape(effort.shape)
        for order in ORDERS[1:3]
    )
    motors = [graph.dynamics.motors.get(k) for k in actuated]
    rest = np.zeros_like(effort)
    torque, band, speed, current = at_motors(motors, effort, rest, velocity, acceleration)
    none = np.zeros((0, 3, result.sizes["time"]))
    return Forces(
        tuple(names),
        tuple("N m" if graph.coordinates[k].angle else "N" for k in actuated),
        (),
        (),
        tuple(name for name, motor in zip(names, motors, strict=True) if motor),
        effort,
        rest,
        power,
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
        *energies,
    )


def blanked(result: xr.Dataset, unknown: BoolArray) -> xr.Dataset:
    """A result whose samples are NaN where they are unknown (n,), but for when that began."""
    if unknown.any():
        for variable, values in result.items():
            kept = values.dtype.kind != "f" or variable == "first_at"
            if values.dims[:1] == ("time",) and not kept:
                values.values[unknown] = np.nan
    return result


def ended_at_limits(result: xr.Dataset) -> xr.Dataset:
    """A result that is known up to the first sample beyond a limit."""
    status = result["status"].values
    beyond = np.flatnonzero(status == Status.LIMIT_EXCEEDED)
    if not len(beyond):
        return result
    after = np.arange(len(status)) > beyond[0]
    status[after] = Status.NOT_REACHED
    result["stopped_by"].values[after] = 0
    result["first_at"].values[after] = np.nan
    result["excess"].values[after] = np.nan
    return blanked(result, after)
