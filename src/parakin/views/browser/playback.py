"""A motion, solved and thinned, ready to be played on a page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from parakin.arrays import ORDERS, BoolArray, FloatArray, IntArray
from parakin.errors import InputError
from parakin.labelled import joined
from parakin.mechanics.reactions import JointAt
from parakin.model.limits import Limit
from parakin.solving.results import stop_words
from parakin.solving.solver import Solver
from parakin.solving.status import SOLVED, Status
from parakin.solving.stops import Stops
from parakin.views.browser.drive import Drive, Stop
from parakin.views.thinning import every

if TYPE_CHECKING:
    import xarray as xr

_SAMPLES = 36_000  # ten minutes at sixty a second: more than a page shows
_WINDOW = 100_000


@dataclass(frozen=True)
class PlayedForces:
    """Of actuators, by name, with "N" or "N m" of each: effort and power (n, actuators). Of joints,
    if they are asked for: forces (n, joints, 3) on their children, along their axes.
    """

    actuators: tuple[str, ...]
    units: tuple[str, ...]
    effort: FloatArray
    power: FloatArray
    joints: tuple[JointAt, ...] = ()
    reactions: FloatArray | None = None


@dataclass(frozen=True)
class Playback:
    """The solved part of a motion.

    `time` (n,); `coordinates`: names, with their positions `q` (n, coordinates); `position`
    (n, bodies, 3) and `wxyz` (n, bodies, 4) of all bodies but the base; `point` (n, 3): the
    platform's point, if there is a platform; `actuators`: names, with `units` and `histories`
    (3, n, actuators) of position, velocity and acceleration; `beyond_limits`: by coordinate or cone
    angle, when it or a derivative of it exceeds its limits (n,); `stop`: why the motion ended
    early; `note`: that it is thinned; `stops`, `stopped_by`, `excess`: what stopped each sample, as
    in results; `forces`, if the mechanism has any.
    """

    name: str
    time: FloatArray
    coordinates: tuple[str, ...]
    q: FloatArray
    position: FloatArray
    wxyz: FloatArray
    point: FloatArray | None
    actuators: tuple[str, ...]
    units: tuple[str, ...]
    histories: FloatArray
    conditioning: FloatArray
    residual: FloatArray
    beyond_limits: Mapping[str, BoolArray]
    stops: Stops
    stopped_by: IntArray
    excess: FloatArray
    stop: Stop | None = None
    note: str = ""
    forces: PlayedForces | None = None

    def within(self, at: float) -> float:
        """The time [s] of the motion that is nearest; its start for NaN."""
        return float(np.clip(np.nan_to_num(at, nan=-np.inf), self.time[0], self.time[-1]))

    def index(self, at: float) -> int:
        """The sample at a time [s], or the next one."""
        return min(int(np.searchsorted(self.time, at - 1e-9)), len(self.time) - 1)

    def why(self, k: int) -> str:
        """What stopped a sample, in words; "" where nothing did."""
        return self.stops.words(int(self.stopped_by[k]), float(self.excess[k]))

    def values(self, at: float) -> dict[str, float]:
        """Position of every coordinate at a time [s]."""
        return dict(zip(self.coordinates, self.q[self.index(at)].tolist(), strict=True))


def playback_of(
    solver: Solver,
    name: str,
    loads: Mapping[str, float] | None = None,
    *,
    reactions: bool = False,
) -> Playback:
    """Solve a motion up to the first sample that fails. loads: masses of payloads [kg] instead of
    the file's; reactions: whether forces in joints are asked for. Raises InputError.
    """
    motion = solver.motion(name)
    stride = max(1, -(-motion.count // _SAMPLES))
    forces = not solver.no_forces
    reactions &= forces
    streamed = solver.windows(
        motion, _WINDOW, bodies=True, forces=forces, reactions=reactions, loads=loads
    )
    windows = enumerate(streamed)
    ds = joined([every(stride, window, k * _WINDOW) for k, window in windows]).dataset()
    solved = np.isin(ds["status"].values, SOLVED)
    count = len(solved) if solved.all() else int(np.argmin(solved))
    if count == 0:
        raise InputError(
            f"motion {name}",
            f"its first sample is {Status(int(ds['status'].values[0])).words}",
            "a motion that starts within reach",
        )
    stop = None if count == len(solved) else _stop(solver, ds, count)
    ds = ds.isel(time=slice(count))
    names = ds["coordinate"].values.tolist()
    actuators = ds["coordinate"].values[ds["actuated"].values].tolist() or list(solver.driven)
    moved = ds.sel(coordinate=actuators)
    return Playback(
        name,
        ds["time"].values,
        tuple(names),
        ds["position"].values,
        ds["body_position"].values,
        ds["body_orientation"].values,
        _platform_point(solver, ds),
        tuple(actuators),
        tuple(moved["unit"].values.tolist()),
        np.array([moved[order].values for order in ORDERS[:3]]),
        ds["conditioning"].values,
        ds["residual"].values,
        _beyond_limits(solver.graph.limited, ds),
        solver.stops,
        ds["stopped_by"].values,
        ds["excess"].values,
        stop,
        f", one sample in {stride}" if stride > 1 else "",
        _forces(solver, ds) if forces else None,
    )


def _forces(solver: Solver, ds: xr.Dataset) -> PlayedForces:
    asked = "reaction_force" in ds
    return PlayedForces(
        tuple(ds["actuator"].values.tolist()),
        tuple(ds["effort_unit"].values.tolist()),
        ds["effort"].values,
        ds["power"].values,
        tuple(solver.mechanics.joints.values()) if asked else (),
        ds["reaction_force"].values if asked else None,
    )


def _beyond_limits(limits: Sequence[Limit], ds: xr.Dataset) -> dict[str, BoolArray]:
    found: dict[str, BoolArray] = {}
    flagged = ds["status"].values == Status.LIMIT_EXCEEDED  # what is beyond by more than rounding
    for limit in limits:
        name = limit.coordinate
        values = ds[ORDERS[limit.order]].sel(coordinate=name).values
        outside = ((values < limit.low) | (values > limit.high)) & flagged
        if outside.any():
            found[name] = found.get(name, False) | outside
    return found


def _platform_point(solver: Solver, ds: xr.Dataset) -> FloatArray | None:
    graph = solver.graph
    if graph.platform is None:
        return None
    numbers = graph.joints[graph.platform].coordinates[:3]
    place = ds["position"].sel(coordinate=[graph.coordinates[k].name for k in numbers]).values
    return np.asarray(place + [solver.plan.offset(k) for k in numbers])


def _stop(solver: Solver, ds: xr.Dataset, count: int) -> Stop:
    """Why a motion ended after `count` samples."""
    status = Status(int(ds["status"].values[count]))
    names, last = ds["coordinate"].values.tolist(), ds["position"].values[count - 1].tolist()
    drive = Drive(solver)
    because = stop_words(ds, count)
    because = because if because.startswith("limb") else ""
    stop = Stop(status, because or status.words, frozenset())
    if drive.start_from(dict(zip(names, last, strict=True))):
        stop = drive.explain(status, because)
    return stop._replace(
        words=f"ended at {float(ds['time'].values[count - 1]):.4g} s: {stop.words}"
    )
