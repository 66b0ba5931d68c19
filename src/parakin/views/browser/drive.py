"""Driven by hand: the pose follows the values asked for, on its branch, and stops where it must.

Every step is short, and starts from the last good pose; one that is out of reach, singular, on
another branch or beyond a limit is not taken, and the joints to blame are named.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from parakin.analysis.freedom import freedom_at, outputs_of
from parakin.arrays import BoolArray, FloatArray
from parakin.errors import InputError, ParakinError
from parakin.model.mechanism import Mechanism
from parakin.solving.compiler import compile as compile_mechanism
from parakin.solving.solver import Solver
from parakin.solving.status import Status
from parakin.solving.tick import Tick

_SLIDE = 0.5  # of the characteristic length: how far slides are asked to go without limits
_TILT = math.radians(45)  # how far the platform is
_STEP = 0.04  # of a radian, or of the characteristic length
_EDGE = 1e-5  # of such a step: how near to where it stops a pose is taken
_WITHIN = 8.0  # times a step [rad or m]: how far an iterated coordinate may come
_FIRM = 0.2  # conditioning above which nothing goes free
_SAME = 1e-3  # radians and characteristic lengths between one pose, told twice
_MOVES = 0.5  # of what moves most: what is to blame


class Stop(NamedTuple):
    """Why a pose was not reached, in words, and the numbers of the joints to blame."""

    status: Status
    words: str
    joints: frozenset[int]


def choices(solver: Solver) -> dict[str, tuple[str, ...]]:
    """What of a mechanism can be driven: "inverse", the platform or what else the actuators move,
    and "forward", the actuators; one of them alone where there are not as many of both.
    """
    actuated = tuple(c.name for c in solver.graph.coordinates if c.actuated)
    try:
        outputs = tuple(outputs_of(solver))
    except InputError:
        if set(solver.driven) == set(actuated):
            return {"forward": solver.driven}
        as_many = len(actuated) == len(solver.driven)
        return {"inverse": solver.driven} | ({"forward": actuated} if as_many else {})
    if set(solver.driven) != set(actuated):  # the file's own choice, which may be mixed
        return {"inverse": solver.driven, "forward": actuated}
    return {"inverse": outputs, "forward": solver.driven}


@dataclass
class Drive:
    """A mechanism and where it stands: driven values `y` (k,) [m or rad] and what follows.

    The solver is one compiled with coordinates="all", so that all limits are seen.
    """

    solver: Solver
    y: FloatArray = field(init=False)
    tick: Tick = field(init=False)

    def __post_init__(self) -> None:
        limits = [self.solver.graph.limits(name) for name in self.solver.coordinates]
        self._low, self._high = np.array(limits).reshape(-1, 2).T
        self.home()

    def home(self) -> None:
        """Back to home."""
        rows = self.solver.coordinates
        self.y = np.array([self.solver.home[name] for name in self.solver.driven])
        self.tick = self.solver.at(self.y, guess=np.array([self.solver.home[c] for c in rows]))

    def from_pose(self, values: Mapping[str, float]) -> bool:
        """Take over a pose, given as all coordinates, as it is. Returns whether it holds here."""
        guess = np.array([values[name] for name in self.solver.coordinates])
        y = np.array([values[name] for name in self.solver.driven])
        tick = self.solver.at(y, guess=guess, within=self._scale(_STEP))
        if tick.status or np.abs(tick.position - guess).max() > self._scale(_STEP):
            return False
        self.y, self.tick = y, tick
        return True

    @property
    def values(self) -> dict[str, float]:
        """Position of every coordinate [m or rad]."""
        return dict(zip(self.solver.coordinates, self.tick.position.tolist(), strict=True))

    @property
    def beyond(self) -> dict[str, int]:
        """Coordinates and cone angles outside their limits, with the numbers of their joints."""
        at = self.tick.position
        return self._held((at < self._low) | (at > self._high))

    def nearest(self, assemblies: Sequence[Mapping[str, float]], by: Sequence[str]) -> int | None:
        """Which of some assemblies it stands in, to the eye, told apart by some coordinates."""
        values, angles, units = self.values, self._are_angles(by), self._units_of(by)
        here = np.array([values[name] for name in by])
        for k, assembly in enumerate(assemblies):
            away = (np.array([assembly[name] for name in by]) - here) / units
            away[angles] = np.remainder(away[angles] + math.pi, 2 * math.pi) - math.pi
            if np.abs(away).max(initial=0.0) < _SAME:
                return k
        return None

    def to(self, goal: Sequence[float] | FloatArray) -> Stop | None:
        """Go straight to other driven values; None, or why it stopped on the way.

        Where the conditioning falls, steps are kept too short to pass a singularity unseen.
        """
        end = np.array(goal, dtype=float)
        start, way = self.y, end - self.y
        length = float(np.abs(way / self._units_of(self.solver.driven)).max(initial=0.0))
        if length == 0.0:
            return None
        if not np.isfinite(length):
            return Stop(Status.OUT_OF_REACH, "a value that is no number", frozenset())
        done, step, slope = 0.0, _STEP, 0.0
        stop: Stop | None = None
        status = Status.CONVERGED
        while True:
            last = float(self.tick.conditioning)
            if slope < 0:  # it would be singular at last / -slope
                step = min(step, -0.5 * last / slope)
            ahead = min(done + step, length)
            y = end if ahead == length else start + way * (ahead / length)
            tick = self.solver.at(y, guess=self.tick.position, within=self._scale(_WITHIN * _STEP))
            limit = self._limit(tick)
            status = Status(int(tick.status)) or status
            stop = limit or stop
            leaps = float(tick.conditioning) < 0.5 * last
            if step < _EDGE * _STEP:
                return stop or self.blame(status or Status.SINGULAR)
            if tick.status or limit is not None or leaps:
                step = 0.25 * (ahead - done)
                continue
            slope = (float(tick.conditioning) - last) / (ahead - done)
            done, self.y, self.tick = ahead, y, tick
            if done >= length:
                return None
            step = min(2 * step, _STEP)

    def span(self, name: str) -> tuple[float, float]:
        """Between which values a driven coordinate is worth asking for [m or rad]: its limits, or
        some way around home.
        """
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
        """Where the platform's point is, (3,) [m], and its orientation wxyz, (4,), if it is driven
        and so can be led by hand.
        """
        numbers = self._pose()
        if not any(self.solver.graph.coordinates[k].name in self.solver.driven for k in numbers):
            return None
        graph = self.solver.graph
        body = graph.joints[graph.coordinates[numbers[0]].joint].child
        values = self.values
        point = np.array([values[graph.coordinates[k].name] for k in numbers[:3]])
        offset = np.array([self.solver.plan.offset(k) for k in numbers[:3]])
        return point + offset, self.solver.poses(self.y, self.tick)[1][body - 1]

    def led(self, point: FloatArray, wxyz: FloatArray) -> FloatArray:
        """The driven values (k,) that bring the platform to a pose, as far as they are its own."""
        from scipy.spatial.transform import Rotation

        graph, plan, numbers = self.solver.graph, self.solver.plan, self._pose()
        joint = graph.joints[graph.coordinates[numbers[0]].joint]
        axes = "".join("XYZ"[pair.axis] for pair in joint.pairs[3:])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # gimbal lock: the first of many solutions will do
            angles = Rotation.from_quat(wxyz, scalar_first=True).as_euler(axes)
        goal = self.y.copy()
        for k, value in zip(numbers, [*point, *angles], strict=True):
            name = graph.coordinates[k].name
            if name in self.solver.driven:
                i = self.solver.driven.index(name)
                ahead = float(value) - plan.offset(k) - goal[i]
                turns = round(ahead / (2 * math.pi)) if graph.coordinates[k].angle else 0
                goal[i] += ahead - 2 * math.pi * turns
        return goal

    def _pose(self) -> range:
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
        """At which limit a solved pose is not to be taken, if it is not."""
        if tick.status:
            return None
        at, last = tick.position, self.tick.position
        held = self._held(((at < self._low) & (at < last)) | ((at > self._high) & (at > last)))
        if not held:
            return None
        words = "; ".join(f"{name} is at its limit" for name in held)
        return Stop(Status.LIMIT_EXCEEDED, words, frozenset(held.values()))

    def _held(self, which: BoolArray) -> dict[str, int]:
        """Some of the reported coordinates, and the numbers of their joints."""
        names = [self.solver.coordinates[k] for k in np.flatnonzero(which)]
        return {name: self.solver.graph.holder(name) for name in names}

    def blame(self, status: Status) -> Stop:
        """What would go free at the pose where it stands, were it any nearer to where it stops."""
        if float(self.tick.conditioning) > _FIRM:
            return Stop(status, status.words, frozenset())
        graph, plan = self.solver.plan.graph, self.solver.plan
        q = np.array(plan.home, dtype=float)
        for name, value in self.values.items():
            if name not in graph.cones:
                k = graph.index(name, "coordinates")
                q[k] = value + plan.offset(k)
        try:
            freedom = freedom_at(self.solver, q)
        except (ParakinError, np.linalg.LinAlgError):
            return Stop(status, status.words, frozenset())
        free = np.abs(freedom.rates)
        pose = () if graph.platform is None else graph.joints[graph.platform].coordinates
        passive = [k for k in range(len(free)) if k not in pose and k not in plan.driven]
        passive = passive or [k for k in range(len(free)) if k not in plan.driven]
        most = max(free[k] for k in passive)
        joints = {graph.coordinates[k].joint for k in passive if free[k] > _MOVES * most}
        return Stop(status, freedom.said, frozenset(joints))


def driven_by(
    mechanism: Mechanism, driven: Sequence[str], near: Mapping[str, float] | None = None
) -> Drive:
    """A mechanism at home, to be driven by these coordinates. near: all coordinates of an assembly
    to stand in, on whose branch it then stays.

    Raises InputError, AssemblyError, DrivenError.
    """
    return Drive(compile_mechanism(mechanism, driven, coordinates="all", near=near))
