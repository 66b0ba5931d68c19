"""The solver: a mechanism compiled for a choice of driven coordinates.

It never changes once made. `at` answers one pose for a control loop, or a batch of them, as bare
arrays; `solve` a motion, as a labelled Dataset; `stream` a motion of any length, window by window.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from parakin.algebra.spatial import FLOATS
from parakin.arrays import BoolArray, FloatArray, IndexArray, StatusArray
from parakin.errors import InputError
from parakin.files.reading import load_motion
from parakin.kernel.pose import newton_unknowns
from parakin.kernel.rows import ORIENTATION, POINT, POSITION, Outputs
from parakin.kinematics import closure
from parakin.kinematics.assembly import Configuration, circuits_at, coordinate_scales
from parakin.model.graph import Graph
from parakin.motion.course import Course
from parakin.motion.laws import from_laws, polynomial345
from parakin.motion.motion import Motion, Samples
from parakin.planning.plan import Plan
from parakin.solving.bodies import Points, points_of
from parakin.solving.charts import Chart
from parakin.solving.results import Labels, dataset, quaternions
from parakin.solving.status import (
    RESIDUAL,
    SINGULAR,
    SOLVED,
    TURNS,
    Status,
    blank_undefined,
    classify,
)
from parakin.solving.tracking import Piece, Track
from parakin.solving.walking import (
    CLOSED,
    FIRM,
    State,
    conditioning_beside,
    iterate,
    taken_over,
    walk,
)

if TYPE_CHECKING:
    import xarray as xr

_BESIDE = 1e-3  # rad: how near to where angles lock no iteration begins
_NEAR = 0.2  # rad: from how near Newton's steps may meet a lock
_POOR = 2e-3  # figure of a plan whose sign is about to change; at an end of reach it is left sooner
_CALM = 30.0  # times what is driven: what goes no faster is not at an end of reach
_WILD = 1e100  # numbers beyond this may overflow on the way to accelerations


class Tick(NamedTuple):
    """One pose, or a batch: rows are `solver.coordinates`, SI; `status` is a `Status` (array).

    Derivatives that the solver was not compiled for are arrays of no rows. `found` is what a next
    call needs beside `position` to start from here: iterated coordinates, where `position` does not
    tell them.

    Not a Dataset because a control loop cannot wait for one.
    """

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    status: int | StatusArray
    residual: float | FloatArray
    conditioning: float | FloatArray
    jerk: FloatArray
    found: FloatArray


class Solver:
    """A compiled mechanism; made by `parakin.compile`, and sent to other processes by pickling.

    `driven`, `coordinates`: names, in the order of rows. `derivatives`: how many. `home`:
    position of every coordinate and cone angle at home, by name [m, rad]. `iterated`: coordinates
    that are found by iteration and not in closed form, reported or not.
    """

    def __init__(
        self,
        plan: Plan,
        outputs: Outputs,
        reported: int,
        *,
        machine_code: bool,
        again: tuple[Callable[[bytes], Solver], tuple[bytes]],
    ) -> None:
        self._again = again
        self.graph = graph = plan.graph.plain
        self.plan = plan
        self.mechanism = graph.mechanism
        self.machine_code = machine_code
        self._chart = Chart(plan, outputs, reported, machine_code)
        self._charts = [self._chart]
        self.driven = tuple(graph.coordinates[k].name for k in plan.driven)
        self.coordinates = tuple(self._name(c) for c in outputs.coordinates[:reported])
        self.derivatives = outputs.derivatives
        self.home: Mapping[str, float] = home_values(graph, plan)
        self._outputs = outputs
        self.told = replace(outputs, coordinates=outputs.coordinates[:reported])
        self.layout = self._chart.layout
        self._labels = Labels(graph, self.told, self.coordinates, self.driven, self.home)
        self._iterated = newton_unknowns(plan)
        self.iterated = tuple(self._name(c) for c in self._iterated)
        self._hidden = tuple(n for n in self.iterated if n not in self.coordinates)
        self._run = self._chart.run
        _ = self._chart.kernel  # compiled now and not at the first pose

    def __reduce__(self) -> tuple[Callable[[bytes], Solver], tuple[bytes]]:
        return self._again

    def _name(self, coordinate: int | str) -> str:
        if isinstance(coordinate, str):
            return coordinate
        return self.plan.graph.coordinates[coordinate].name

    def __repr__(self) -> str:
        how = "machine code" if self.machine_code else "NumPy"
        return f"<Solver {self.mechanism.name}, driven by {', '.join(self.driven)}, {how}>"

    def _home_state(self) -> State:
        k, m = len(self.driven), len(self._iterated)
        orders = 1 + self.derivatives
        driven, found = np.zeros((orders, k)), np.zeros((orders, m))
        driven[0] = [self.home[name] for name in self.driven]
        found[0] = [self.plan.home[c] - self.plan.offset(c) for c in self._iterated]
        return State(driven, found)

    def at(
        self,
        y: ArrayLike,
        yd: ArrayLike | None = None,
        ydd: ArrayLike | None = None,
        guess: ArrayLike | Tick | None = None,
        *,
        yddd: ArrayLike | None = None,
        within: float | None = None,
        parallel: bool = False,
    ) -> Tick:
        """One pose, or a batch of unrelated ones, each answered as if it were alone.

        y, yd, ydd, yddd: driven positions, velocities, accelerations and jerks, (k,) or (k, n),
        SI; zero where not given. guess: an earlier `Tick`, or positions as it has them, rows
        `coordinates`, one column for all or one each; angles come out within half a turn of it,
        and coordinates that are iterated start from it. Without a guess, angles come out within
        half a turn of home, on home's branch where all has a closed form; where a solver iterates
        the whole batch walks from home, each pose straight and in its own steps, to the assembly
        that a slow hand would reach so, or to a flag. within: how far from the guess an iterated
        coordinate may come out [m or rad]; what lies further off is flagged as a branch change.
        parallel: use all cores.
        Samples that fail have a status other than CONVERGED and NaN throughout (or in the angles
        alone, where it is only three of them that are not defined). So have those with a number in
        y, rates or guess that is none, or a guess of an angle so large that its turns have lost
        their digits. Raises InputError on arrays of the wrong shape.
        """
        inputs = self._inputs_of(y, yd, ydd, yddd)
        start = None if guess is None else self._start_of(guess, inputs.shape[1:])
        walked: StatusArray | int = 0
        if self._iterated:
            out, walked = self._iterate(inputs, None if start is None else start.found)
        else:
            out = self._run(inputs, parallel=parallel)
        plain = self._turned_to(out, start) if start is not None else True
        checked = self._outputs.checks
        plain = plain and (_tame(inputs) if checked else _tame(inputs, out[self._last_rows]))
        if plain and not checked:
            good = 0 if out.ndim == 1 else np.zeros(out.shape[1], dtype=np.int8)
            return self._tick(out, good, np.nan, np.nan)
        if plain and out.ndim == 1 and within is None and not walked and not self.layout.triples:
            residual, conditioning, _, size, _ = out[self._outputs.figures].tolist()
            if residual <= RESIDUAL * size and conditioning >= SINGULAR:
                return self._tick(out, 0, residual, conditioning)
        return self._judged(out, inputs, start, walked, within, plain=plain)

    def _judged(
        self,
        out: FloatArray,
        inputs: FloatArray,
        start: _Start | None,
        walked: StatusArray | int,
        within: float | None,
        *,
        plain: bool,
    ) -> Tick:
        """A status for each column, and NaN where it is one of failure."""
        rows, columns = self._outputs, out[:, None] if out.ndim == 1 else out
        numbers = columns[rows.motion]
        found: FloatArray | None = None
        told: BoolArray | None = None
        if not plain:
            told = self._sound(inputs, start)
        if self._outputs.checks:
            status = classify(columns, self.layout)
            singular = bool(status.any()) and bool((status == Status.SINGULAR).any())
            if self._iterated and (singular or self.layout.triples):
                found = columns[self.layout.found[0]]  # before angles that lock become NaN
            if not isinstance(walked, int) or walked:
                status = np.where(walked, walked, status).astype(np.int8)
            if told is not None:
                bad = np.isin(status, (Status.CONVERGED, Status.SINGULAR)) & ~told
                status[bad] = Status.OUT_OF_REACH
            if singular:
                self._exchanged(columns, inputs, status)
        else:
            status = np.zeros(columns.shape[1], dtype=np.int8)
            if told is not None:
                status[~told] = Status.OUT_OF_REACH
            if np.isnan(numbers.sum()):
                status[np.isnan(numbers).any(axis=0)] = Status.OUT_OF_REACH
        if within is not None and start is not None and self._iterated:
            begun = start.found if start.found.ndim == 2 else start.found[:, None]
            ended = columns[self.layout.found[0]] if found is None else found
            near = np.abs(ended - begun).max(axis=0) <= within
            status[np.isin(status, SOLVED) & ~near] = Status.BRANCH_CHANGE
        if self._outputs.checks and self.layout.triples:
            undefined = blank_undefined(columns, self.layout)
            status[undefined & (status == Status.CONVERGED)] = Status.ANGLES_UNDEFINED
        if not plain or not self._outputs.checks:
            known = np.delete(numbers, self._cone_rows, axis=0)
            beyond, open_ = np.isinf(known).any(axis=0), np.isnan(known).any(axis=0)
            open_ &= status == Status.CONVERGED
            status[open_ | (beyond & np.isin(status, SOLVED))] = Status.OUT_OF_REACH
        if status.any():
            numbers[:, ~np.isin(status, SOLVED)] = np.nan
        verdict: int | StatusArray = int(status[0]) if out.ndim == 1 else status
        tick = self._tick(out, verdict, np.nan, np.nan)
        if self._outputs.checks:
            residual, conditioning = out[rows.residual], out[rows.conditioning]
            if out.ndim == 1:
                residual, conditioning = float(residual), float(conditioning)
            tick = tick._replace(residual=residual, conditioning=conditioning)
        if found is not None and (status == Status.ANGLES_UNDEFINED).any():
            found[:, ~np.isin(status, SOLVED)] = np.nan
            tick = tick._replace(found=found[:, 0] if out.ndim == 1 else found)
        return tick

    def _exchanged(self, out: FloatArray, inputs: FloatArray, status: StatusArray) -> None:
        """Other charts for closed poses (columns) where a plan is singular and no mechanism."""
        chart, orders = self._chart, 1 + self.derivatives
        driven = inputs.reshape(orders, len(self.driven), -1)
        for column in np.flatnonzero(status == Status.SINGULAR).tolist():
            here = driven[:, :, [column]]
            at = chart.configuration(here[0, :, 0], out[:, column])
            firm = chart.firm(at) if np.isfinite(at.q).all() else 0.0
            if not firm > FIRM:
                continue
            for other in self._others(chart, at):
                found = taken_over(other, here, at)
                if found is None:
                    continue
                beside = conditioning_beside(chart, other, here, found, self._units)
                if beside > 0.0:
                    found[other.outputs.conditioning] = min(1.0, firm)
                    status[column] = self._transferred(out, column, other, found)
                elif beside < 0.0:
                    status[column] = Status.BRANCH_CHANGE
                break

    def _transferred(self, out: FloatArray, column: int, chart: Chart, found: FloatArray) -> Status:
        """Write what another chart found, angles by full turns nearest to what stands there."""
        undefined = bool(blank_undefined(found, chart.layout)[0])
        told = self._told([Piece(0, 1, chart, found)], 1)[:, 0]
        before = out[self.angle_rows, column]
        for order, rows in enumerate(self._told_rows[: 1 + self.derivatives]):
            out[rows, column] = told[self.told.order(order)]
        out[self._outputs.figures, column] = found[chart.outputs.figures, 0]
        turns = np.round((before - out[self.angle_rows, column]) / (2 * np.pi))
        out[self.angle_rows, column] += 2 * np.pi * turns
        return Status.ANGLES_UNDEFINED if undefined else Status.CONVERGED

    @cached_property
    def angle_rows(self) -> list[int]:
        """Rows of `coordinates` that are angles."""
        angles = {c.name for c in self.graph.coordinates if c.angle}
        return [row for row, name in enumerate(self.coordinates) if name in angles]

    def _tick(
        self,
        out: FloatArray,
        status: int | StatusArray,
        residual: float | FloatArray,
        conditioning: float | FloatArray,
    ) -> Tick:
        position, velocity, acceleration, jerk = self._told_rows
        return Tick(
            out[position],
            out[velocity],
            out[acceleration],
            status,
            residual,
            conditioning,
            out[jerk],
            out[self.layout.found[0]] if self._hidden else out[:0],
        )

    @cached_property
    def _told_rows(self) -> list[slice]:
        """Rows of positions, and of each derivative, none where it is not known."""
        starts = [self._outputs.order(order).start for order in range(1 + self.derivatives)]
        known = [slice(start, start + self.layout.reported) for start in starts]
        return known + [slice(0, 0)] * (4 - len(known))

    @cached_property
    def _last_rows(self) -> slice:
        """Rows of the last derivative, which is no number where the others are none."""
        return self._told_rows[self.derivatives]

    def _inputs_of(
        self,
        y: ArrayLike,
        yd: ArrayLike | None,
        ydd: ArrayLike | None,
        yddd: ArrayLike | None,
    ) -> FloatArray:
        k = len(self.driven)
        first = _numbers(y, "y")
        if first.ndim not in (1, 2) or first.shape[0] != k:
            raise InputError("y", f"shape {first.shape}", f"({k},) or ({k}, n): one row per driven")
        parts = [first]
        rates = (("yd", yd), ("ydd", ydd), ("yddd", yddd))
        for name, given in rates[: self.derivatives]:
            part = np.zeros_like(first) if given is None else _numbers(given, name)
            if part.shape != first.shape:
                raise InputError(name, f"shape {part.shape}", f"{first.shape}, that of y")
            parts.append(part)
        return np.ascontiguousarray(np.concatenate(parts) if len(parts) > 1 else first)

    def _start_of(self, guess: ArrayLike | Tick, shape: tuple[int, ...]) -> _Start:
        """A guess in parts. Raises InputError where it does not fit poses of this shape."""
        tick = guess if isinstance(guess, Tick) else None
        n = self.layout.reported
        if isinstance(guess, np.ndarray) and guess.shape == (n, *shape) and not self._hidden:
            return _Start(guess, guess[self.layout.found[0]])
        position = _numbers(guess, "guess") if tick is None else self._defined(tick)  # type: ignore[arg-type]
        if position.shape not in ((n,), (n, *shape)):
            each = f" or ({n}, {shape[0]})" if shape else ""
            expected = f"({n},){each}: one row per coordinate"
            raise InputError("guess", f"shape {position.shape}", expected)
        if self._hidden and tick is None:
            names = ", ".join(self._hidden)
            expected = f"a Tick, since {names} are iterated and not among the coordinates"
            raise InputError("guess", "positions alone", expected)
        if tick is None or not (self._hidden or len(tick.found)):
            return _Start(position, position[self.layout.found[0]])
        if tick.found.shape != (len(self._iterated), *position.shape[1:]):
            raise InputError("guess", "a Tick of another solver", "one of this solver's own")
        return _Start(position, tick.found)

    def _defined(self, tick: Tick) -> FloatArray:
        """Positions of a tick, those angles at home that are not defined there."""
        undefined = np.asarray(tick.status) == Status.ANGLES_UNDEFINED
        if not undefined.any():
            return tick.position
        home = np.array([self.home[name] for name in self.coordinates])
        home = home if tick.position.ndim == 1 else home[:, None]
        return np.where(undefined & np.isnan(tick.position), home, tick.position)

    def _turned_to(self, out: FloatArray, start: _Start) -> bool:
        """Turn angles to within half a turn of the guess. Returns whether all guesses are sound,
        as far as can be told at a glance.
        """
        rows, guess, alone = self._told_angles, start.position, out.ndim == 1
        if alone and not self._hidden and _distance(guess, out[: len(guess)]) <= 3.0:
            return True  # which is false of NaN
        if len(rows):
            near = guess[:, None] if guess.ndim < out.ndim else guess
            drift = (near[rows] - out[rows]) * (0.5 / np.pi)
            if not np.abs(drift).max(initial=0.0) <= 0.5:  # true of NaN, in whatever column
                out[rows] += 2 * np.pi * np.round(drift)
                return False
        return _tame(guess, start.found) if self._hidden else _tame(guess)

    def _sound(self, inputs: FloatArray, start: _Start | None) -> BoolArray:
        """Which columns are numbers, and in a guess have not lost the digits of their turns."""
        told: BoolArray = np.logical_and.reduce(np.isfinite(inputs.reshape(len(inputs), -1)))
        if start is None:
            return told
        guess, found = (a if a.ndim == 2 else a[:, None] for a in start)
        numbers = np.concatenate([guess, found])
        angles = np.abs(guess[self._told_angles])
        sound: BoolArray = np.isfinite(numbers).all(axis=0)
        return told & sound & (angles < 2 * np.pi * TURNS).all(axis=0)

    @cached_property
    def _told_angles(self) -> IndexArray:
        rows: IndexArray = self.layout.angles[self.layout.angles < self.layout.reported]
        return rows

    @cached_property
    def _cone_rows(self) -> list[int]:
        """Where cone angles are, whose rates are none where an angle is exactly zero."""
        at = [row for row, name in enumerate(self.coordinates) if name in self.graph.cones]
        orders = range(1, self.derivatives + 1)
        return [self._outputs.derivative(row, order) for order in orders for row in at]

    def _iterate(
        self, inputs: FloatArray, guess: FloatArray | None
    ) -> tuple[FloatArray, StatusArray | int]:
        """Outputs, and where there is no guess what became of the walk from home."""
        guess = None if guess is None else self._off_the_lock(guess)
        if inputs.ndim == 1 and guess is not None:
            alone = self._chart.alone(inputs, guess)
            if alone[self._outputs.residual] <= CLOSED * alone[self._outputs.size]:
                return alone, 0
        columns = inputs[:, None] if inputs.ndim == 1 else inputs
        walked: StatusArray | None = None
        if guess is None:
            walker = self._chart.walker
            goal = columns[: len(self.driven)]
            steps, walked = walk(walker, self._home_state(), goal, self._units)
            start = steps[walker.layout.found[0]]
            if walked.any():
                for column in self._held_up(walker, steps, walked, goal):
                    found = self._tracked(goal[:, column])
                    if found is not None:
                        start[:, column], walked[column] = found, Status.CONVERGED
        else:
            start = guess[:, None] if guess.ndim == 1 else guess
            if start.shape[1] != columns.shape[1]:
                start = np.broadcast_to(start, (len(start), columns.shape[1]))
        out = iterate(self._chart, columns, start)
        if self._locks:
            self._tried_again(out, columns, start)
        if inputs.ndim == 1:
            return out[:, 0], 0 if walked is None else int(walked[0])
        return out, 0 if walked is None else walked

    def _held_up(
        self, walker: Chart, steps: FloatArray, walked: StatusArray, goal: FloatArray
    ) -> IndexArray:
        """Columns in which the walk from home may have ended where only the plan is singular: near
        a lock, or at a figure near zero while nothing goes as fast as at an end of reach.
        """
        layout, start = walker.layout, self._home_state().driven[0][:, None]
        pace = np.abs((goal - start) / self._units[:, None]).max(axis=0)
        rates = np.abs(steps[layout.found[1]] / layout.units[:, None]).max(axis=0)
        slow = (np.abs(steps[layout.outputs.conditioning]) < _POOR) & (rates < _CALM * pace)
        near = slow | self._near_lock(steps[layout.found[0]])
        return np.flatnonzero((walked != 0) & near & (pace < TURNS))

    def _near_lock(self, found: FloatArray) -> BoolArray:
        """Which columns of iterated coordinates (m, n) are near where three angles lock."""
        near = np.zeros(found.shape[1], dtype=bool)
        for row, lock in self._locks:
            near |= np.abs(_beyond(found[row], lock)) < _NEAR
        return near

    def _tracked(self, y: FloatArray) -> FloatArray | None:
        """Iterated coordinates (m,) at a pose that the walk from home did not reach, by the same
        way as a motion, which goes on with other charts; none if that does not arrive either.
        """
        home = self._home_state()
        laws = {
            name: polynomial345(begin, by, 1.0)
            for name, begin, by in zip(self.driven, home.driven[0], y - home.driven[0], strict=True)
        }
        straight = from_laws("straight", laws, 1.0, 1.0)
        track = Track(self._chart, Course(straight), home, self._units, self._others)
        pieces, status = track.solve(straight.samples(), parallel=False)
        if status[-1] != Status.CONVERGED:
            return None
        chart = pieces[-1].chart
        q = self._chart.coordinates_at(chart.configuration(y, pieces[-1].out[:, -1]))
        return np.array([q[k] - self.plan.offset(k) for k in self._iterated])

    def _tried_again(self, out: FloatArray, inputs: FloatArray, start: FloatArray) -> None:
        """Where Newton's steps came from near a lock to no number they may have met it exactly, and
        begun a little further off will not.
        """
        if not np.isnan(out[self._outputs.residual]).any():
            return
        near = self._near_lock(start)
        for times in (1, 2, 3):
            lost = np.flatnonzero(near & np.isnan(out[self._outputs.residual]))
            if not len(lost):
                return
            begun = start[:, lost]
            for row, _ in self._locks:
                begun[row] += times * _BESIDE
            out[:, lost] = iterate(self._chart, inputs[:, lost], begun)

    def _off_the_lock(self, found: FloatArray) -> FloatArray:
        """Iterated coordinates (m,) or (m, n), a little to the side of where three angles lock:
        Newton's steps find back from there, and lead nowhere from the lock itself.
        """
        for row, lock in self._locks:
            angle = found[row]
            most = abs(float(angle)) if angle.ndim == 0 else np.abs(angle).max(initial=0.0)
            if most < lock - 0.1:
                continue  # all well clear, as nearly always
            off = _beyond(angle, lock)
            near = np.abs(off) < _BESIDE
            if near.any():
                found = found.copy()
                found[row] += np.where(near, np.copysign(_BESIDE, off), 0.0)
        return found

    @cached_property
    def _locks(self) -> list[tuple[int, float]]:
        """Of joints whose three angles are iterated, where the second is found and where it locks,
        but for half turns.
        """
        joints = [joint for joint in self.plan.graph.joints if len(joint.turns) == 3]
        return [
            (self._iterated.index(joint.turns[1]), 0.0 if joint.proper else 0.5 * np.pi)
            for joint in joints
            if set(joint.turns) <= set(self._iterated)
        ]

    @cached_property
    def _units(self) -> FloatArray:
        """Of driven coordinates: 1 for angles, else the characteristic length."""
        return coordinate_scales(self.graph)[list(self.plan.driven)]

    def poses(self, y: ArrayLike, tick: Tick) -> tuple[FloatArray, FloatArray]:
        """Where every body stands at a pose that `at` gave for `y`, (k,).

        Position of its origin [m], (bodies, 3), and orientation, a quaternion wxyz, (bodies, 4):
        rows are the bodies of the file but the base, as in what `solve` gives with `bodies=True`.
        """
        zero = np.zeros((len(self.driven), 1))
        place = np.asarray(y, dtype=float)[:, None]
        points = points_of(self.graph, True)
        samples = Samples(np.zeros(1), place, zero, zero)
        known = tick.found if len(tick.found) else tick.position[self.layout.found[0]]
        found = self._off_the_lock(known)[:, None]
        blocks = self._chart.figures(points, samples, found, False).reshape(len(points), POINT, 1)
        return blocks[:, POSITION, 0], quaternions(blocks[:, ORIENTATION], None)[0]

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

    def stream(
        self,
        motion: Motion,
        size: int = 65536,
        *,
        bodies: bool | Sequence[str] = False,
        parallel: bool = False,
    ) -> Iterator[xr.Dataset]:
        """As `solve`, in windows of at most `size` samples, so that any length fits in memory."""
        motion = self._driving(motion)
        points = points_of(self.graph, bodies)
        course = Course(motion)
        track = Track(self._chart, course, self._home_state(), self._units, self._others)
        last: xr.Dataset | None = None
        for start in range(0, motion.count, size):
            samples = motion.window(start, min(start + size, motion.count))
            if samples.jerk is None and self.derivatives > 2:
                known = "position, velocity and acceleration"
                raise InputError(f"motion {motion.name}", known, "jerk too, or position alone")
            pieces, status = track.solve(samples, parallel=parallel)
            for start_, stop, chart, found in pieces:
                undefined = blank_undefined(found, chart.layout)
                status[start_:stop][undefined] = Status.ANGLES_UNDEFINED
            out = self._told(pieces, len(status))
            self._limit(out, status)
            figures = self._figures(points, pieces, samples, parallel) if points else None
            ds = dataset(
                self._labels, motion, samples.time, out, status, list(points), figures, last
            )
            last = ds
            yield ds

    def schema(self, motion: Motion | str, *, bodies: bool | Sequence[str] = False) -> xr.Dataset:
        """What `solve` gives for a motion, with NaN for every value and nothing solved: its
        variables, coordinates, types and attributes. Raises InputError, as `solve` does.
        """
        motion = self._driving(self.motion(motion) if isinstance(motion, str) else motion)
        points, n = points_of(self.graph, bodies), motion.count
        out = np.broadcast_to(np.nan, (self.told.count, n))
        status = np.broadcast_to(np.int8(Status.NOT_REACHED), n)
        figures = np.broadcast_to(np.nan, (POINT * len(points), n)) if points else None
        time = motion.window(0, n).time
        return dataset(self._labels, motion, time, out, status, list(points), figures)

    def _driving(self, motion: Motion) -> Motion:
        """The motion, its rows in the order of the driven coordinates, if it can be solved."""
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
        return motion.reordered(self.driven)

    def _others(self, chart: Chart, at: Configuration) -> Iterator[Chart]:
        """Charts that may serve at a configuration where one does no more."""
        yield from [other for other in self._charts if other is not chart]
        made = chart.another(at)
        if made is not None:
            self._charts.append(made)
            yield made
            self._charts.remove(made)  # it did not serve

    def _told(self, pieces: Sequence[Piece], n: int) -> FloatArray:
        """What is reported of samples, all orders, then the checks; NaN where not solved."""
        told = self.told
        if len(pieces) == 1 and told == self._outputs:
            piece = pieces[0]
            if piece.chart is self._chart and piece.stop - piece.start == n:
                return piece.out
        out = np.full((told.count, n), np.nan)
        for start, stop, chart, found in pieces:
            rows = chart.outputs
            for order in range(1 + told.derivatives):
                known = found[rows.order(order)]
                out[told.order(order), start:stop] = known[: len(told.coordinates)]
            out[told.figures, start:stop] = found[rows.figures]
            out[told.conditioning, start:stop] *= chart.share
        return out

    def _figures(
        self, points: Points, pieces: Sequence[Piece], samples: Samples, parallel: bool
    ) -> FloatArray:
        figures = np.full((POINT * len(points), len(samples.time)), np.nan)
        for start, stop, chart, found in pieces:
            inside, guess = samples.cropped(start, stop), found[chart.layout.found[0]]
            figures[:, start:stop] = chart.figures(points, inside, guess, parallel)
        return figures

    def _limit(self, out: FloatArray, status: StatusArray) -> None:
        rows, low, high = self._limited
        outside = ((out[rows] < low) | (out[rows] > high)).any(axis=0)
        if outside.any():
            status[outside & np.isin(status, SOLVED)] = Status.LIMIT_EXCEEDED

    @cached_property
    def _limited(self) -> tuple[IndexArray, FloatArray, FloatArray]:
        """Rows of coordinates that have a limit, and the limits, a column each."""
        limits = np.array([self.graph.limits(name) for name in self.coordinates]).reshape(-1, 2)
        rows = np.flatnonzero(np.isfinite(limits).any(axis=1))
        return rows, limits[rows, :1], limits[rows, 1:]


def _tame(*numbers: FloatArray) -> bool:
    """Whether all are numbers, and none so large that accelerations might overflow."""
    if numbers[0].ndim == 1:
        return all(math.hypot(*some.tolist()) < _WILD for some in numbers)  # false of NaN
    with np.errstate(over="ignore", invalid="ignore"):
        for some in numbers:
            flat = some.ravel()
            if not flat.dot(flat) < _WILD * _WILD:
                return False
    return True


def _beyond(angle: FloatArray, lock: float) -> FloatArray:
    """How far angles are beyond the nearest of the places, half a turn apart, where they lock."""
    with np.errstate(invalid="ignore"):
        off: FloatArray = np.remainder(angle - lock + 0.5 * np.pi, np.pi) - 0.5 * np.pi
    return off


def _distance(one: FloatArray, other: FloatArray) -> float:
    return math.dist(one.tolist(), other.tolist())


class _Start(NamedTuple):
    """A guess: positions as reported, and iterated coordinates."""

    position: FloatArray
    found: FloatArray


def _numbers(values: ArrayLike, name: str) -> FloatArray:
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(name, str(error), "numbers") from None


def home_values(graph: Graph, plan: Plan) -> dict[str, float]:
    """Position of every coordinate at home, as it is counted, and every cone angle."""
    home = {c.name: float(plan.home[k]) - plan.offset(k) for k, c in enumerate(graph.coordinates)}
    circuits = circuits_at(plan.graph, plan.tree, plan.home)
    for name, (joint, _) in plan.graph.cones.items():
        end = closure.ends(circuits, joint)
        home[name] = float(closure.cone(circuits, joint, end, FLOATS, derivatives=0)[0])
    return home
