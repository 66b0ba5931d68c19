"""The solver: a mechanism compiled for a choice of driven coordinates.

It never changes once made. `at` answers one pose for a control loop, or a batch of them, as bare
arrays; `solve` a motion, as a labelled Dataset; `stream` a motion of any length, window by window.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from parakin import closure
from parakin.assembly import circuits_at, configure
from parakin.bodies import Figures, Points, points_of
from parakin.branches import Search, branches
from parakin.errors import InputError, nearest
from parakin.files import load_motion
from parakin.graph import Graph
from parakin.kernel import Outputs, newton_unknowns
from parakin.machine import make_kernel, output_count
from parakin.motion import Motion, Samples
from parakin.ordering import plan_of
from parakin.plan import Plan
from parakin.results import dataset, quaternions
from parakin.singularities import Closeness, closeness
from parakin.spatial import FLOATS
from parakin.tracking import (
    RESIDUAL,
    SINGULAR,
    Ending,
    FloatArray,
    Layout,
    Run,
    State,
    Status,
    StatusArray,
    Tracker,
    classify,
    iterate,
    solve_all,
    unwrap,
    walk,
)

if TYPE_CHECKING:
    import xarray as xr

_STEPS = 3  # Newton steps per run of a kernel: round-off from one or two hundredths away
_WILD = 1e100
_SPREAD = 8192  # batches smaller than this are not worth a second core


class Tick(NamedTuple):
    """One pose, or a batch: rows are `solver.coordinates`, SI; `status` is a `Status` (array).

    Derivatives that the solver was not compiled for are arrays of no rows.

    Not a Dataset because a control loop cannot wait for one.
    """

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    status: int | StatusArray
    residual: float | FloatArray
    conditioning: float | FloatArray
    jerk: FloatArray


class Solver:
    """A compiled mechanism; made by `parakin.compile`.

    `driven`, `coordinates`: names, in the order of rows. `derivatives`: how many. `home`:
    position of every coordinate and cone angle at home, by name [m, rad]. `iterated`: coordinates
    that are found by iteration and not in closed form.
    """

    def __init__(
        self,
        plan: Plan,
        outputs: Outputs,
        *,
        machine_code: bool,
    ) -> None:
        self.graph = graph = plan.graph
        self.plan = plan
        self.mechanism = graph.mechanism
        self.machine_code = machine_code
        self.driven = tuple(graph.coordinates[k].name for k in plan.driven)
        self.coordinates = tuple(self._name(c) for c in outputs.coordinates)
        self.derivatives = outputs.derivatives
        self.home: Mapping[str, float] = home_values(graph, plan)
        self._outputs = outputs
        self.layout = _layout(plan, outputs)
        self._iterated = newton_unknowns(plan)
        self.iterated = tuple(self._name(c) for c in self._iterated)
        self._kernel = make_kernel(plan, outputs, machine_code=machine_code, steps=_STEPS)
        self._body_figures: dict[tuple[object, ...], Figures] = {}
        self._results = output_count(outputs)

    def _name(self, coordinate: int | str) -> str:
        if isinstance(coordinate, str):
            return coordinate
        return self.graph.coordinates[coordinate].name

    def __repr__(self) -> str:
        how = "machine code" if self.machine_code else "NumPy"
        return f"<Solver {self.mechanism.name}, driven by {', '.join(self.driven)}, {how}>"

    def _home_state(self) -> State:
        k, m = len(self.driven), len(self._iterated)
        orders = 1 + self.derivatives
        driven, found = np.zeros((orders, k)), np.zeros((orders, m))
        driven[0] = [self.home[name] for name in self.driven]
        found[0] = [self.home[self._name(c)] for c in self._iterated]
        return State(np.nan, driven, found)  # of no time: the first step is a jump

    def _run(self, inputs: FloatArray, *, parallel: bool = False) -> FloatArray:
        out = np.empty((self._results, *inputs.shape[1:]))
        self._kernel(inputs, out, parallel and inputs.shape[-1] >= _SPREAD)
        return out

    def at(
        self,
        y: ArrayLike,
        yd: ArrayLike | None = None,
        ydd: ArrayLike | None = None,
        guess: FloatArray | None = None,
        *,
        yddd: ArrayLike | None = None,
        within: float | None = None,
        parallel: bool = False,
    ) -> Tick:
        """One pose, or a batch of unrelated ones.

        y, yd, ydd, yddd: driven positions, velocities, accelerations and jerks, (k,) or (k, n),
        SI; zero where not given. guess: positions as an earlier `Tick` gave them, rows
        `coordinates`; angles come out within half a turn of it, and coordinates that are
        iterated start from it (without it, the whole batch walks there from home, each pose
        straight and in its own steps). within: how far from the guess an iterated coordinate may
        come out [m or rad]; what lies further off is flagged as a branch change. parallel: use
        all cores.
        Samples that fail have a status other than CONVERGED and NaN throughout.
        Raises InputError on arrays of the wrong shape.
        """
        inputs = self._inputs_of(y, yd, ydd, yddd)
        if guess is not None and len(guess) != len(self.coordinates):
            found = f"{len(guess)} rows"
            raise InputError("guess", found, f"{len(self.coordinates)}: one per coordinate")
        moving = not (yd is None and ydd is None and yddd is None)
        wild = moving and not _tame(inputs)  # rates that are no numbers, or too large for one
        walked: StatusArray | int = 0
        if self._iterated:
            out, walked = self._iterate(inputs, guess)
        else:
            out = self._run(inputs, parallel=parallel)
        n, checks = len(self.coordinates), self.layout.checks
        position = out[:n]
        if guess is not None and len(self.layout.angles):
            rows = self.layout.angles
            drift = (guess[rows] - position[rows]) * (0.5 / np.pi)
            if np.abs(drift).max(initial=0.0) > 0.5:
                position[rows] += 2 * np.pi * np.round(drift)
        end = n + n * self.derivatives  # what lies beyond is no derivative
        velocity, acceleration = out[n : min(2 * n, end)], out[2 * n : min(3 * n, end)]
        jerk = out[3 * n : end]
        if not self._outputs.checks:
            return self._unchecked(position, velocity, acceleration, jerk)
        far = np.zeros(out.shape[1:], dtype=bool)
        if within is not None and guess is not None and self._iterated:
            found = self.layout.found[0]
            far = ~(np.abs(out[found] - np.asarray(guess)[found]).max(axis=0) <= within)
        if out.ndim == 1:
            residual, conditioning = float(out[checks]), float(out[checks + 1])
            good = residual <= self.layout.tolerance and conditioning >= SINGULAR
            if wild and not math.isfinite(out[:checks].sum()):
                good, walked = False, walked or Status.OUT_OF_REACH
            if good and not far and not walked:
                return Tick(position, velocity, acceleration, 0, residual, conditioning, jerk)
            verdict = int(classify(out[:, None], self.layout)[0]) or int(Status.BRANCH_CHANGE)
            verdict = int(walked) or verdict
            out[:checks] = np.nan
            conditioning = float(out[checks + 1])
            return Tick(position, velocity, acceleration, verdict, residual, conditioning, jerk)
        status = np.where(walked, walked, classify(out, self.layout)).astype(np.int8)
        status[(status == Status.CONVERGED) & far] = Status.BRANCH_CHANGE
        if wild:
            beyond = ~np.isfinite(out[:checks].sum(axis=0))
            status[(status == Status.CONVERGED) & beyond] = Status.OUT_OF_REACH
        if status.any():
            out[:checks, status > 0] = np.nan
        residual, conditioning = out[checks], out[checks + 1]
        return Tick(position, velocity, acceleration, status, residual, conditioning, jerk)

    def _unchecked(
        self,
        position: FloatArray,
        velocity: FloatArray,
        acceleration: FloatArray,
        jerk: FloatArray,
    ) -> Tick:
        status = np.zeros(position.shape[1:], dtype=np.int8)
        if np.isnan(position.sum()):
            status = np.where(np.isnan(position).any(axis=0), Status.OUT_OF_REACH, status)
        return Tick(position, velocity, acceleration, status, np.nan, np.nan, jerk)

    def _inputs_of(
        self,
        y: ArrayLike,
        yd: ArrayLike | None,
        ydd: ArrayLike | None,
        yddd: ArrayLike | None,
    ) -> FloatArray:
        k = len(self.driven)
        first = np.asarray(y, dtype=float)
        if first.ndim not in (1, 2) or first.shape[0] != k:
            raise InputError("y", f"shape {first.shape}", f"({k},) or ({k}, n): one row per driven")
        parts = [first]
        rates = (("yd", yd), ("ydd", ydd), ("yddd", yddd))
        for name, given in rates[: self.derivatives]:
            part = np.zeros_like(first) if given is None else np.asarray(given, dtype=float)
            if part.shape != first.shape:
                raise InputError(name, f"shape {part.shape}", f"{first.shape}, that of y")
            parts.append(part)
        return np.ascontiguousarray(np.concatenate(parts) if len(parts) > 1 else first)

    def _iterate(
        self, inputs: FloatArray, guess: FloatArray | None
    ) -> tuple[FloatArray, StatusArray | int]:
        """Outputs, and where there is no guess what became of the walk from home."""
        columns = inputs[:, None] if inputs.ndim == 1 else inputs
        walked: StatusArray | None = None
        if guess is None:
            run, layout = self._walker
            goal = columns[: len(self.driven)]
            steps, walked = walk(run, layout, self._home_state(), goal)
            start = steps[layout.found[0]]
        else:
            start = np.asarray(guess, dtype=float)[self.layout.found[0]]
            start = start[:, None] if start.ndim == 1 else start
            if start.shape[1] != columns.shape[1]:
                start = np.broadcast_to(start, (len(start), columns.shape[1]))
        out = iterate(self._run, self.layout, columns, start)
        if inputs.ndim == 1:
            return out[:, 0], 0 if walked is None else int(walked[0])
        return out, 0 if walked is None else walked

    @cached_property
    def _walker(self) -> tuple[Run, Layout]:
        """What walks from home: the iterated coordinates and their rates alone."""
        outputs = Outputs(tuple(self._iterated), derivatives=1)
        kernel = make_kernel(self.plan, outputs, machine_code=self.machine_code, steps=_STEPS)
        rows = output_count(outputs)

        def run(inputs: FloatArray) -> FloatArray:
            out = np.empty((rows, inputs.shape[1]))
            kernel(inputs, out, False)
            return out

        return run, _layout(self.plan, outputs)

    def poses(self, y: ArrayLike, tick: Tick) -> tuple[FloatArray, FloatArray]:
        """Where every body stands at a pose that `at` gave for `y`, (k,).

        Position of its origin [m], (bodies, 3), and orientation, a quaternion wxyz, (bodies, 4):
        rows are the bodies of the file but the base, as in what `solve` gives with `bodies=True`.
        """
        zero = np.zeros((len(self.driven), 1))
        place = np.asarray(y, dtype=float)[:, None]
        points = points_of(self.graph, True)
        samples = Samples(np.zeros(1), place, zero, zero)
        found = tick.position[self.layout.found[0]][:, None]
        blocks = self._figures(points).at(samples, found, False).reshape(len(points), 24, 1)
        return blocks[:, :3, 0], quaternions(blocks[:, 3:12], None)[0]

    def motion(
        self,
        motion: str | Path,
        *,
        rate: float | None = None,
        smoothing: float | Mapping[str, float] | None = None,
        max_gap: float | None = None,
    ) -> Motion:
        """One of the mechanism's own motions by name, or one from a TOML or CSV file.

        rate: samples per second, where laws give the motion. smoothing: standard deviation of the
        noise in recorded positions, SI. max_gap: longest step allowed in recorded data [s].
        Raises InputError.
        """
        driven = {name: self.home[name] for name in self.driven}
        return load_motion(motion, self.graph, driven, rate, smoothing, max_gap)

    def solve(
        self,
        motion: Motion | str,
        *,
        bodies: bool | Sequence[str] = False,
        parallel: bool = False,
    ) -> xr.Dataset:
        """The whole motion, from home along the branch of home.

        motion: one whose coordinates are the driven ones, or what `motion` takes. bodies: True
        adds position, orientation, velocities and accelerations of every body at its own origin;
        a list names bodies or points on them ("platform.B4"). parallel: use all cores.
        Samples after the first that fails are NaN and flagged `not reached`; a limit exceeded is
        flagged and its values kept. Raises InputError where the motion's coordinates are others.
        """
        motion = self.motion(motion) if isinstance(motion, str) else motion
        (result,) = self.stream(motion, max(motion.count, 1), bodies=bodies, parallel=parallel)
        return result

    def branches(self, values: Mapping[str, float] | None = None, starts: int = 8192) -> Search:
        """The real assemblies for driven values (home's where not given), by many random starts.

        With the platform driven these are the working modes, with the actuators driven the
        assembly modes. A search, not a proof: `unseen` of the answer says how sure it is. A
        solver for another branch: `compile(..., near=branch.coordinates)`.
        Raises InputError on names that are not driven.
        """
        for name in values or {}:
            if name not in self.driven:
                raise InputError("values", f"{name!r}", nearest(name, self.driven))
        home = configure(self.graph, self.plan.tree, self.plan.home)
        plan = plan_of(self.graph, self.plan.driven, home, zero=self.plan.zero, everywhere=True)
        return branches(plan, values, starts)

    def singularities(self, result: xr.Dataset, motion: Motion | str | None = None) -> Closeness:
        """How near a solved motion comes to singularities of each kind, where it crosses one,
        between samples too, and, with the `motion` that was solved, which one ended it
        (Gosselin and Angeles 1990, Zlatanov et al. 1995). Raises InputError.
        """
        motion = self.motion(motion) if isinstance(motion, str) else motion
        return closeness(self, result, motion)

    def stream(
        self,
        motion: Motion,
        size: int = 65536,
        *,
        bodies: bool | Sequence[str] = False,
        parallel: bool = False,
    ) -> Iterator[xr.Dataset]:
        """As `solve`, in windows of at most `size` samples, so that any length fits in memory."""
        if self.derivatives < 2 or not self._outputs.checks:
            raise InputError(
                "solver", "one compiled without accelerations or checks", "a full one; or use `at`"
            )
        if set(motion.coordinates) != set(self.driven):
            raise InputError(
                f"motion {motion.name}",
                f"coordinates {', '.join(motion.coordinates)}",
                f"the driven coordinates {', '.join(self.driven)}",
            )
        motion = motion.reordered(self.driven)
        points = points_of(self.graph, bodies)
        tracker = Tracker(self._run, self.layout, self._home_state())
        ending: Ending | None = None
        last: xr.Dataset | None = None
        lost = False
        for start in range(0, motion.count, size):
            stop = min(start + size, motion.count)
            first, until = start, stop
            if not self._iterated:  # two samples on either side of a crossing show it
                first, until = max(start - 2, 0), min(stop + 1, motion.count)
            samples = motion.window(first, until)
            if samples.jerk is None and self.derivatives > 2:
                known = "position, velocity and acceleration"
                raise InputError(f"motion {motion.name}", known, "jerk too, or position alone")
            inner = slice(start - first, stop - first)
            out, status, ending, lost = self._window(
                samples, inner, tracker, ending, lost, parallel
            )
            samples = samples.cropped(inner.start, inner.stop)
            figures = None
            if points:
                found = out[self.layout.found[0]]
                figures = self._figures(points).at(samples, found, parallel)
                figures[:, np.isnan(out[self.layout.checks])] = np.nan
            ds = dataset(self, motion, samples.time, out, status, list(points), figures, last)
            last = ds
            yield ds

    def _window(
        self,
        samples: Samples,
        inner: slice,
        tracker: Tracker,
        ending: Ending | None,
        lost: bool,
        parallel: bool,
    ) -> tuple[FloatArray, StatusArray, Ending | None, bool]:
        n = inner.stop - inner.start
        if lost:
            out = np.full((self._results, n), np.nan)
            return out, np.full(n, Status.NOT_REACHED, dtype=np.int8), ending, True
        if self._iterated:
            out, status = tracker.follow(samples)
        else:
            out, status = solve_all(
                lambda inputs: self._run(inputs, parallel=parallel), samples, self.layout
            )
            out, status = out[:, inner], status[inner]
        bad = status != Status.CONVERGED
        if bad.any():
            first = int(np.argmax(bad))
            status[first + 1 :] = Status.NOT_REACHED
            out[: self.layout.checks + 2, first:] = np.nan
            lost = True
        ending = unwrap(out, self.layout, samples.time[inner], ending)
        self._limit(out, status)
        return out, status, ending, lost

    def _limit(self, out: FloatArray, status: StatusArray) -> None:
        for row, name in enumerate(self.coordinates):
            low, high = self.graph.limits(name)
            if not (np.isinf(low) and np.isinf(high)):
                outside = (out[row] < low) | (out[row] > high)
                status[outside & (status == Status.CONVERGED)] = Status.LIMIT_EXCEEDED

    def _figures(self, points: Points) -> Figures:
        """Kept, since a kernel takes a while to compile."""
        key = tuple(points.items())
        if key not in self._body_figures:
            self._body_figures[key] = Figures.of(self.plan, points, machine_code=self.machine_code)
        return self._body_figures[key]


def _tame(inputs: FloatArray) -> bool:
    """Whether all are numbers, and none so large that accelerations might overflow."""
    if inputs.ndim == 1:
        return all(-_WILD < value < _WILD for value in inputs.tolist())
    return bool(np.abs(inputs).max(initial=0.0) < _WILD)


def home_values(graph: Graph, plan: Plan) -> dict[str, float]:
    """Position of every coordinate at home, as it is counted, and every cone angle."""
    home = {c.name: float(plan.home[k]) - plan.offset(k) for k, c in enumerate(graph.coordinates)}
    circuits = circuits_at(plan.graph, plan.tree, plan.home)
    for name, (joint, _) in plan.graph.cones.items():
        end = closure.ends(circuits, joint)
        home[name] = float(closure.cone(circuits, joint, end, FLOATS, derivatives=0)[0])
    return home


def _layout(plan: Plan, outputs: Outputs) -> Layout:
    n = len(outputs.coordinates)
    place = {c: row for row, c in enumerate(outputs.coordinates)}
    found = np.array([place[k] for k in newton_unknowns(plan)], dtype=np.intp)
    given = {*plan.affine, *newton_unknowns(plan)}
    angles = [
        row
        for c, row in place.items()
        if isinstance(c, int) and plan.graph.coordinates[c].angle and c not in given
    ]
    return Layout(
        np.array([found + n * order for order in range(outputs.derivatives + 1)]),
        np.array(angles, dtype=np.intp),
        n,
        n * (outputs.derivatives + 1),
        RESIDUAL * plan.graph.length,
    )
