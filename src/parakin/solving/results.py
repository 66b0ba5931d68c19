"""Results as labelled arrays: what the solver found, for the xarray Dataset users know."""

from __future__ import annotations

import functools
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from parakin.arrays import ORDERS, FloatArray, StatusArray
from parakin.caching import cached_property
from parakin.errors import InputError, NotSolvedError, nearest
from parakin.kernel.outputs import (
    ACCELERATION,
    ANGULAR_ACCELERATION,
    ANGULAR_VELOCITY,
    ORIENTATION,
    POINT,
    POSITION,
    VELOCITY,
    Outputs,
)
from parakin.labelled import Labelled, Variable
from parakin.solving.status import Status
from parakin.solving.stops import Stopped, Stops

if TYPE_CHECKING:
    import xarray as xr

    from parakin.labelled import Result
    from parakin.model.graph import Graph
    from parakin.motion.motion import Motion

_PER_TIME = ("", " s-1", " s-2", " s-3")  # as NetCDF's conventions write it


@dataclass(frozen=True)
class Labels:
    """What all results of a solver have in common: rows, names, home's values and the graph."""

    graph: Graph
    rows: Outputs
    coordinates: tuple[str, ...]
    driven: tuple[str, ...]
    home: Mapping[str, float]
    stops: Stops

    @cached_property
    def units(self) -> tuple[str, ...]:
        """For each coordinate, "m" or "rad"."""
        known = {c.name: c.unit for c in self.graph.coordinates}
        return tuple(known.get(name, "rad") for name in self.coordinates)  # the rest are cones

    @cached_property
    def names(self) -> dict[str, Variable]:
        """Names of coordinates and stops, their units and what drives."""
        graph = self.graph
        numbers = {c.name: k for k, c in enumerate(graph.coordinates)}
        actuated = [
            name in numbers and graph.coordinates[numbers[name]].actuated
            for name in self.coordinates
        ]
        return {
            "coordinate": Variable.of("coordinate", list(self.coordinates)),
            "unit": Variable.of("coordinate", list(self.units)),
            "actuated": Variable.of("coordinate", actuated),
            "driven": Variable.of("coordinate", [name in self.driven for name in self.coordinates]),
            "stop": Variable.of("stop", list(self.stops.names)),
            "stop_unit": Variable.of("stop", list(self.stops.units)),
        }

    @cached_property
    def common(self) -> tuple[dict[Hashable, xr.Variable], dict[Hashable, xr.Index]]:
        """The same as xarray has them, with their indexes."""
        import xarray as xr

        labels = xr.Coordinates(self.names)
        return dict(labels.variables), dict(labels.xindexes)

    def dataset(self, result: Labelled) -> xr.Dataset:
        """A result as users get it."""
        return result.dataset(self.common)

    @cached_property
    def fixed(self) -> dict[str, Variable]:
        """What is the same for every motion: home and the limits."""
        home = [self.home.get(name, np.nan) for name in self.coordinates]
        units = {"comment": "SI; see stop_unit"}
        return {
            "home": Variable.of("coordinate", home),
            "limit_low": Variable.of("stop", list(self.stops.low), units),
            "limit_high": Variable.of("stop", list(self.stops.high), units),
        }


class Verdict(NamedTuple):
    """What became of n samples: their status, what stopped each, and when that was first met [s],
    NaN where nothing did; met: in words, all stops met so far and when.
    """

    status: StatusArray
    stopped: Stopped
    first_at: FloatArray
    met: str = ""


def labelled(
    of: Labels,
    motion: Motion,
    time: FloatArray,
    out: FloatArray,
    verdict: Verdict,
    points: Sequence[str],
    figures: FloatArray | None,
    forces: tuple[Mapping[str, Any], Mapping[str, Any]] | None = None,
    before: Labelled | None = None,
) -> Labelled:
    """Kernel outputs (rows, n) as variables over time and coordinate (and point, axis).

    forces: variables and labels of `force_variables`. before: the window before this one.
    """
    rows, over = of.rows, ("time", "coordinate")
    unit = " or ".join(sorted(set(of.units)))
    variables: dict[str, Any] = {
        quantity: (over, out[rows.order(k)].T, {"units": unit + _PER_TIME[k]})
        for k, quantity in enumerate(ORDERS[: rows.derivatives + 1])
    }
    residual = {"long_name": "norm of all closure rows", "units": "m"}
    variables |= {
        "status": ("time", verdict.status, _status_attributes()),
        "residual": ("time", out[rows.residual], residual),
        "conditioning": ("time", out[rows.conditioning], {"units": "1"}),
    }
    variables |= _stopped(verdict) | of.fixed
    labels: dict[str, Any] = {**of.names, "time": ("time", time, {"units": "s"})}
    if figures is not None:
        last = None if before is None else before["body_orientation"].values[-1]
        variables |= _bodies(figures, len(points), len(time), last)
        known = {"body": list(points), "axis": list("xyz"), "quaternion": list("wxyz")}
        labels |= {name: (name, values) for name, values in known.items()}
    if forces is not None:
        variables |= forces[0]
        labels |= forces[1]
    attributes = {
        "mechanism": of.graph.mechanism.name,
        "motion": motion.name,
        "motion_derivatives": motion.derivatives,
        "characteristic_length": of.graph.length,
        "stops_met": verdict.met,
    }
    every = {name: Variable.of(*known) for name, known in (variables | labels).items()}
    return Labelled(every, tuple(labels), attributes)


def history(ds: xr.Dataset, coordinate: str) -> xr.Dataset:
    """One coordinate of a result over time, labelled with its own unit, for `.plot()`. (In the
    result itself lengths and angles share an array, with the unit "m or rad".)

    Raises InputError on a coordinate that is not in the result.
    """
    known = ds["coordinate"].values.tolist()
    if coordinate not in known:
        raise InputError("coordinate", repr(coordinate), nearest(coordinate, known))
    one = ds.sel(coordinate=coordinate)
    unit = str(one["unit"].item())
    for quantity, per_time in zip(ORDERS, _PER_TIME, strict=True):
        if quantity in one:
            one[quantity].attrs = {"long_name": f"{quantity} of {coordinate}"}
            one[quantity].attrs["units"] = unit + per_time
    return one.drop_vars(["unit", "actuated", "driven"])


def require_solved(ds: xr.Dataset) -> xr.Dataset:
    """The result itself, if every sample of it is solved.

    Raises NotSolvedError with how many are flagged, the first, and the worst residual.
    """
    status = ds["status"].values
    flagged = np.flatnonzero(status)
    if len(flagged):
        i = int(flagged[0])
        worst = np.fmax.reduce(ds["residual"].values, initial=0.0)
        raise NotSolvedError(
            f"{ds.attrs['mechanism']}, {ds.attrs['motion']}: {len(flagged)} of {len(status)} "
            f"samples are flagged; the first, {i} at t = {float(ds['time'][i]):.6g} s, is "
            f"{flag_words(ds, i)}; worst residual of the rest {worst:.1e}"
        )
    return ds


def _stopped(verdict: Verdict) -> dict[str, Any]:
    """What stopped each sample, as a place in `stop`, by how much, and since when."""
    number, excess = verdict.stopped
    place = {"long_name": "place in `stop` of what stopped the sample; 0 is nothing"}
    beyond = {
        "long_name": "how far above the upper limit or, if negative, below the lower one",
        "comment": "SI; see stop_unit",
    }
    first = {"long_name": "when that which stopped the sample was first met", "units": "s"}
    return {
        "stopped_by": ("time", number.astype(np.int16), place),
        "excess": ("time", excess, beyond),
        "first_at": ("time", verdict.first_at, first),
    }


def flag_words(ds: Result, sample: int) -> str:
    """A sample's status in words and what stopped it, by how much and when first, as far as that is
    known; "" where it converged. For example "limit exceeded: P6 at 1.262 m, limit 1.260 m, first
    at t = 0.88 s".
    """
    status, first = Status(int(ds["status"].values[sample])), float(ds["first_at"].values[sample])
    since = f"first at t = {first:.4g} s" if np.isfinite(first) else ""
    because = ", ".join(filter(None, (stop_words(ds, sample), since)))
    return "" if status == Status.CONVERGED else ": ".join(filter(None, (status.words, because)))


def stop_words(ds: Result, sample: int) -> str:
    """What stopped a sample of a result and by how much; "" if that is not known."""
    known = ("stop", "stop_unit", "limit_low", "limit_high")
    number, excess = int(ds["stopped_by"].values[sample]), float(ds["excess"].values[sample])
    return Stops(*(tuple(ds[name].values.tolist()) for name in known)).words(number, excess)


@functools.cache
def _status_attributes() -> dict[str, Any]:
    return {
        "flag_values": np.array([s.value for s in Status], dtype=np.int8),
        "flag_meanings": " ".join(s.name.lower() for s in Status),
    }


def _bodies(figures: FloatArray, points: int, n: int, last: FloatArray | None) -> dict[str, Any]:
    blocks = figures.reshape(points, POINT, n)
    over = ("time", "body", "axis")

    def vectors(rows: slice) -> FloatArray:
        return np.ascontiguousarray(blocks[:, rows].transpose(2, 0, 1))

    return {
        "body_position": (over, vectors(POSITION), {"units": "m"}),
        "body_orientation": (
            ("time", "body", "quaternion"),
            quaternions(blocks[:, ORIENTATION], last),
        ),
        "body_velocity": (over, vectors(VELOCITY), {"units": "m s-1"}),
        "body_angular_velocity": (over, vectors(ANGULAR_VELOCITY), {"units": "rad s-1"}),
        "body_acceleration": (over, vectors(ACCELERATION), {"units": "m s-2"}),
        "body_angular_acceleration": (over, vectors(ANGULAR_ACCELERATION), {"units": "rad s-2"}),
    }


def quaternions(rows: FloatArray, last: FloatArray | None) -> FloatArray:
    """Rotation matrices (points, 9, n) as quaternions wxyz (n, points, 4) without sign jumps,
    nor from the `last` ones of the window before.
    """
    from scipy.spatial.transform import Rotation

    points, _, n = rows.shape
    matrices = rows.transpose(2, 0, 1).reshape(-1, 3, 3)
    good = np.isfinite(matrices).all(axis=(1, 2))
    quaternions = np.full((len(matrices), 4), np.nan)
    if good.any():
        quaternions[good] = Rotation.from_matrix(matrices[good]).as_quat(scalar_first=True)
    turns = quaternions.reshape(n, points, 4)
    with np.errstate(invalid="ignore"):
        flips = np.where((turns[1:] * turns[:-1]).sum(axis=2) < 0, -1.0, 1.0)
    with np.errstate(invalid="ignore"):
        lead = turns[:1, :, 0] if last is None else (turns[:1] * last).sum(axis=2)
        first = np.where(lead < 0, -1.0, 1.0)
    signs = np.cumprod(np.concatenate([first, flips]), axis=0)
    return turns * signs[:, :, None]
