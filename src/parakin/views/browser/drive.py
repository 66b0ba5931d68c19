"""Driving by hand: the pose follows the requested values on its branch, and stops where it must.

Every step is short and starts from the last good pose. A step that would be out of reach,
singular, on another branch or beyond a limit is not taken, and the joints at fault are named.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from parakin.algebra.angles import nearest_angle
from parakin.analysis.freedom import freedom_at, outputs_of
from parakin.arrays import BoolArray, FloatArray
from parakin.design.range import range as how_far
from parakin.errors import InputError, ParakinError
from parakin.mechanics.reactions import JointAt
from parakin.model.mechanism import Mechanism
from parakin.solving.compiler import compile as compile_mechanism
from parakin.solving.forces import Forces
from parakin.solving.solver import Solver
from parakin.solving.status import Status
from parakin.solving.stops import beyond_limits, exceeded
from parakin.solving.tick import Tick

if TYPE_CHECKING:
    import xarray as xr

_SLIDE = 0.5  # of the characteristic length: range of a slide without limits, either way
_TILT = math.radians(45)  # range of the platform's angles, either way
_STEP = 0.04  # of a radian, or of the characteristic length
_EDGE = 1e-5  # of a step: how close to the stop the last pose comes
_WITHIN = 8.0  # steps: how far an iterated coordinate may move in one
_REGULAR = 0.2  # conditioning above which the pose is far from singular
_SAME = 1e-3  # [rad, or characteristic lengths]: poses that look the same
_POSED = (Status.CONVERGED, Status.LIMIT_EXCEEDED)  # all coordinates are known
_MOVES = 0.5  # of the fastest joint: the slowest that is still named


class Stop(NamedTuple):
    """Why a pose was not reached: status, text, and the numbers of the joints at fault."""

    status: Status
    words: str
    joints: frozenset[int]


def choices(solver: Solver) -> dict[str, tuple[str, ...]]:
    """The coordinates that can be driven: "inverse", those of the platform or other output, and
    "forward", the actuators. Only one of them if their numbers differ.
    """
    actuated = tuple(c.name for c in solver.graph.coordinates if c.actuated)
    try:
        outputs = tuple(outputs_of(solver))
    except InputError:
        if set(solver.driven) == set(actuated):
            return {"forward": solver.driven}
        as_many = len(actuated) == len(solver.driven)
        return {"inverse": solver.driven} | ({"forward": actuated} if as_many else {})
    if set(solver.driven) != set(actuated):  # the file's choice, which may be mixed
        return {"inverse": solver.driven, "forward": actuated}
    return {"inverse": outputs, "forward": solver.driven}


@dataclass
class Drive:
    """A mechanism at a pose: driven values `y` (k,) [m or rad], and the solver's answer `tick`.

    The solver must be compiled with coordinates="all", so that all limits are checked.
    """

    solver: Solver
    y: FloatArray = field(init=False)
    tick: Tick = field(init=False)

    def __post_init__(self) -> None:
        self.home()

    def home(self) -> None:
        """Return to home."""
        rows = self.solver.coordinates
        self.y = np.array([self.solver.home[name] for name in self.solver.driven])
        self.tick = self.solver.at(self.y, guess=np.array([self.solver.home[c] for c in rows]))

    def start_from(self, values: Mapping[str, float]) -> bool:
        """Start from a pose, all coordinates of it, if it is on this branch. Returns whether."""
        guess = np.array([values[name] for name in self.solver.coordinates])
        y = np.array([values[name] for name in self.solver.driven])
        tick = self.solver.at(y, guess=guess, within=self._scale(_STEP))
        if tick.status not in _POSED or np.abs(tick.position - guess).max() > self._scale(_STEP):
            return False
        self.y, self.tick = y, tick
        return True

    def forces(self, loads: Mapping[str, float], *, reactions: bool = False) -> Forces | None:
        """What holds the pose at rest, without wrenches that change with time; None if there are
        no forces. loads: masses of payloads [kg]; reactions: forces in joints too.
        """
        if self.solver.no_forces:
            return None
        wrenches = self.solver.graph.dynamics.wrenches
        none = {w.name: np.zeros(w.inputs) for w in wrenches if w.inputs}
        guess = self.tick.position
        given: dict[str, FloatArray | float] = {**none, **loads}
        tick = self.solver.at(self.y, guess=guess, forces=True, reactions=reactions, loads=given)
        return tick.forces

    def left(self) -> xr.Dataset | None:
        """How far each driven coordinate still goes alone; None where no position is limited, and
        most of the answer would be that nothing stops it.
        """
        if all(limit.order for limit in self.solver.graph.limited):
            return None
        pose = dict(zip(self.solver.driven, self.y.tolist(), strict=True))
        found = how_far(self.solver, pose)
        return None if found.attrs["stopped"] else found

    @property
    def joints(self) -> tuple[JointAt, ...]:
        """Where forces in joints act."""
        return tuple(self.solver.mechanics.joints.values())

    @property
    def values(self) -> dict[str, float]:
        """Position of every coordinate [m or rad]."""
        return dict(zip(self.solver.coordinates, self.tick.position.tolist(), strict=True))

    @property
    def beyond_limits(self) -> dict[str, int]:
        """Coordinates and cone angles that exceed their limits, with their joints' numbers."""
        graph = self.solver.graph
        return {name: graph.holder(name) for name in beyond_limits(graph, self.values)}

    def nearest(self, assemblies: Sequence[Mapping[str, float]], by: Sequence[str]) -> int | None:
        """The index of the assembly that looks like this pose, compared by some coordinates."""
        values, angles, units = self.values, self._are_angles(by), self._units_of(by)
        here = np.array([values[name] for name in by])
        for k, assembly in enumerate(assemblies):
            away = (np.array([assembly[name] for name in by]) - here) / units
            away[angles] = nearest_angle(away[angles])
            if np.abs(away).max(initial=0.0) < _SAME:
                return k
        return None

    def to(self, goal: Sequence[float] | FloatArray) -> Stop | None:
        """Move straight to other driven values. Returns why it stopped on the way, if it did.

        Where the conditioning falls, steps are short enough not to jump over a singularity.
        """
        end = np.array(goal, dtype=float)
        start, way = self.y, end - self.y
        length = float(np.abs(way / self._units_of(self.solver.driven)).max(initial=0.0))
        if length == 0.0:
            return None
        if not np.isfinite(length):
            return Stop(Status.OUT_OF_REACH, "a value that is not a number", frozenset())
        done, step, slope = 0.0, _STEP, 0.0
        stop: Stop | None = None
        status, because = Status.CONVERGED, ""
        while True:
            last = float(self.tick.conditioning)
            if slope < 0:  # it would be singular at last / -slope
                step = min(step, -0.5 * last / slope)
            ahead = min(done + step, length)
            y = end if ahead == length else start + way * (ahead / length)
            tick = self.solver.at(y, guess=self.tick.position, within=self._scale(_WITHIN * _STEP))
            limit = self._limit(tick)
            if tick.status not in _POSED:
                status, because = Status(int(tick.status)), _unreached(tick)
            stop = limit or stop
            leaps = float(tick.conditioning) < 0.5 * last
            if step < _EDGE * _STEP:
                return stop or self.explain(status or Status.SINGULAR, because)
            if tick.status not in _POSED or limit is not None or leaps:
                step = 0.25 * (ahead - done)
                continue
            slope = (float(tick.conditioning) - last) / (ahead - done)
            done, self.y, self.tick = ahead, y, tick
            if done >= length:
                return None
            step = min(2 * step, _STEP)

    def span(self, name: str) -> tuple[float, float]:
        """The useful range of a driven coordinate [m or rad]: its limits, or some around home."""
        graph = self.solver.graph
        number = graph.index(name, "driven")
        low, high = graph.limits(name)
        reach, home = _SLIDE * graph.length, self.solver.home[name]
        if graph.coordinates[number].angle:
            joint = graph.coordinates[number].joint
            reach = _TILT if joint == graph.platform else math.pi
        return (
            low if math.isfinite(low) else home - reach,
            high if math.isfinite(high) else home + reach,
        )

    def platform(self) -> tuple[FloatArray, FloatArray] | None:
        """The platform's point (3,) [m] and orientation wxyz (4,), if the platform is driven."""
        numbers = self._pose_numbers()
        if not any(self.solver.graph.coordinates[k].name in self.solver.driven for k in numbers):
            return None
        graph = self.solver.graph
        body = graph.joints[graph.coordinates[numbers[0]].joint].child
        values = self.values
        point = np.array([values[graph.coordinates[k].name] for k in numbers[:3]])
        offset = np.array([self.solver.plan.offset(k) for k in numbers[:3]])
        return point + offset, self.solver.poses(self.y, self.tick)[1][body - 1]

    def values_for_pose(self, point: FloatArray, wxyz: FloatArray) -> FloatArray:
        """Driven values (k,) with those of the platform replaced by a pose."""
        from scipy.spatial.transform import Rotation

        graph, plan, numbers = self.solver.graph, self.solver.plan, self._pose_numbers()
        joint = graph.joints[graph.coordinates[numbers[0]].joint]
        axes = "".join("XYZ"[pair.axis] for pair in joint.pairs[3:])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # in gimbal lock any solution will do
            angles = Rotation.from_quat(wxyz, scalar_first=True).as_euler(axes)
        goal = self.y.copy()
        for k, value in zip(numbers, [*point, *angles], strict=True):
            name = graph.coordinates[k].name
            if name in self.solver.driven:
                i = self.solver.driven.index(name)
                there = float(value) - plan.offset(k)
                turns = graph.coordinates[k].angle
                goal[i] = nearest_angle(there, to=goal[i]) if turns else there
        return goal

    def _pose_numbers(self) -> range:
        graph = self.solver.graph
        return range(0) if graph.platform is None else graph.joints[graph.platform].coordinates

    def _scale(self, part: float) -> float:
        return part * max(1.0, self.solver.graph.length)

    def _are_angles(self, names: Sequence[str]) -> BoolArray:
        graph = self.solver.graph
        return np.array([graph.coordinates[graph.index(n, "driven")].angle for n in names])

    def _units_of(self, names: Sequence[str]) -> FloatArray:
        return np.where(self._are_angles(names), 1.0, self.solver.graph.length)

    def _limit(self, tick: Tick) -> Stop | None:
        """The limit that a solved pose exceeds, if it moves further beyond it."""
        if tick.status != Status.LIMIT_EXCEEDED:
            return None
        graph, last = self.solver.graph, self.values
        now = dict(zip(self.solver.coordinates, tick.position.tolist(), strict=True))
        names = [
            limit.name
            for limit in exceeded(graph, now)
            if limit.excess(now[limit.coordinate]) > limit.excess(last[limit.coordinate])
        ]
        if not names:
            return None
        words = "; ".join(f"{name} is at its limit" for name in names)
        return Stop(Status.LIMIT_EXCEEDED, words, frozenset(map(graph.holder, names)))

    def explain(self, status: Status, because: str = "") -> Stop:
        """Why it stops here: the joints that would move freely at the singularity nearby. because:
        what is known already, in words.
        """
        words = because or status.words
        if float(self.tick.conditioning) > _REGULAR:
            return Stop(status, words, frozenset())
        graph, plan = self.solver.plan.graph, self.solver.plan
        q = np.array(plan.home, dtype=float)
        for name, value in self.values.items():
            if name not in graph.cones:
                k = graph.index(name, "coordinates")
                q[k] = value + plan.offset(k)
        try:
            freedom = freedom_at(self.solver, q)
        except (ParakinError, np.linalg.LinAlgError):
            return Stop(status, words, frozenset())
        free = np.abs(freedom.rates)
        pose = () if graph.platform is None else graph.joints[graph.platform].coordinates
        passive = [k for k in range(len(free)) if k not in pose and k not in plan.driven]
        passive = passive or [k for k in range(len(free)) if k not in plan.driven]
        most = max(free[k] for k in passive)
        joints = {graph.coordinates[k].joint for k in passive if free[k] > _MOVES * most}
        words = ": ".join(filter(None, (because, freedom.description)))
        return Stop(status, words, frozenset(joints))


def _unreached(tick: Tick) -> str:
    """Which limb cannot reach a pose, in words; "" if it is none."""
    words = tick.why()
    return words if words.startswith("limb") else ""


def driven_by(
    mechanism: Mechanism, driven: Sequence[str], near: Mapping[str, float] | None = None
) -> Drive:
    """A mechanism at home, driven by these coordinates. near: all coordinates of another assembly
    to start from, and on whose branch to stay.

    Raises InputError, AssemblyError, DrivenError.
    """
    return Drive(compile_mechanism(mechanism, driven, coordinates="all", near=near))
