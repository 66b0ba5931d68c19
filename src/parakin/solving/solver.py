"""The solver: a mechanism compiled for a choice of driven coordinates.

It never changes once made. `at` solves one pose for a control loop, or a batch, into plain arrays;
`solve` a motion, into a labelled Dataset; `stream` a motion of any length, window by window.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from parakin.arrays import FloatArray
from parakin.errors import InputError
from parakin.files.reading import load_motion
from parakin.kernel.backends import Kernel
from parakin.kernel.outputs import ORIENTATION, POINT, POSITION, Outputs
from parakin.kinematics.configuration import Configuration
from parakin.labelled import Labelled
from parakin.model.expressions import Value
from parakin.motion.motion import Motion, Samples
from parakin.planning.plan import Plan
from parakin.solving.answers import Answers
from parakin.solving.applied import Efforts
from parakin.solving.atlas import Atlas
from parakin.solving.behind import forces_behind
from parakin.solving.bodies import points_of
from parakin.solving.bound import Bound
from parakin.solving.charts import Chart, counted
from parakin.solving.forces import Mechanics
from parakin.solving.from_home import home_values
from parakin.solving.homes import Homes
from parakin.solving.inputs import Guesses, refuse_lean, stacked, turning_rows
from parakin.solving.locks import begun_at, locks_of
from parakin.solving.options import Options
from parakin.solving.other_designs import OtherDesigns
from parakin.solving.poses import Poses
from parakin.solving.results import Labels, quaternions
from parakin.solving.simulated import Part, simulated
from parakin.solving.simulation import Left
from parakin.solving.tables import solver_html
from parakin.solving.tick import Tick
from parakin.solving.windows import Windows, windows_of

if TYPE_CHECKING:
    import xarray as xr


class Solver:
    """A compiled mechanism, made by `parakin.compile`. It can be pickled.

    `driven`, `coordinates`: names, in the order of rows. `derivatives`: how many are computed.
    `home`: position of every coordinate and cone angle at home, by name [m, rad]. `iterated`:
    coordinates found by iteration and not in closed form, reported or not. `stops`: what can stop
    it, by the numbers in results: declared limits, and loops that cannot be closed. `free`: the
    parameters that are left open; `opened`: the chart that knows them.
    """

    def __init__(
        self,
        plan: Plan,
        outputs: Outputs,
        reported: int,
        *,
        machine_code: bool,
        again: tuple[Callable[[bytes], Solver], tuple[bytes]],
        elsewhere: Callable[[tuple[str, ...], FloatArray], Solver],
        other: Callable[[Mapping[str, Value]], Solver],
        homes: Homes | None = None,
        compiled: Kernel | None = None,
    ) -> None:
        self._again, self._elsewhere, self._other = again, elsewhere, other
        self.graph = graph = plan.graph.plain
        self.plan = plan
        self.mechanism = graph.mechanism
        self.machine_code = machine_code
        self.chart = Chart(plan, outputs, reported, machine_code)
        if compiled is not None:
            vars(self.chart)["kernel"] = compiled
        self.driven = tuple(graph.coordinates[k].name for k in plan.driven)
        self.coordinates = tuple(self._name(c) for c in outputs.coordinates[:reported])
        self.derivatives = outputs.derivatives
        self.home: Mapping[str, float] = home_values(graph, plan)
        self.reported = replace(outputs, coordinates=outputs.coordinates[:reported])
        self.layout = self.chart.layout
        self.atlas = Atlas(self.chart, self.reported)
        self.stops = self.atlas.stops
        self._labels = Labels(
            graph, self.reported, self.coordinates, self.driven, self.home, self.stops
        )
        self._windows = partial(windows_of, self.atlas, self._labels)
        self._locks = locks_of(plan)
        self.iterated = tuple(self._name(c) for c in plan.iterated)
        hidden = tuple(n for n in self.iterated if n not in self.coordinates)
        at_home = np.array([self.home.get(name, np.nan) for name in self.coordinates])
        turning = turning_rows(self.layout, outputs, reported, counted(plan))
        self._guesses = Guesses(self.layout, at_home, self.iterated, hidden, turning)
        self._poses = Poses(Answers(self.atlas, self._guesses, self._labels), self._locks)
        self._designs, self.opened = None, self.chart
        self.free: tuple[str, ...] = ()
        if homes is not None:
            self._designs = OtherDesigns.of(homes, self.chart, self._guesses, self._labels)
            self.free, self.opened = self._designs.designs.names, self._designs.chart
        _ = self.chart.kernel  # compiled now and not at the first pose

    def __reduce__(self) -> tuple[Callable[[bytes], Solver], tuple[bytes]]:
        return self._again

    def _name(self, coordinate: int | str) -> str:
        if isinstance(coordinate, str):
            return coordinate
        return self.plan.graph.coordinates[coordinate].name

    def __repr__(self) -> str:
        how = "machine code" if self.machine_code else "NumPy"
        return f"<Solver {self.mechanism.name}, driven by {', '.join(self.driven)}, {how}>"

    def at(
        self,
        y: ArrayLike,
        yd: ArrayLike | None = None,
        ydd: ArrayLike | None = None,
        guess: ArrayLike | Tick | None = None,
        *,
        yddd: ArrayLike | None = None,
        within: float | None = None,
        forces: bool = False,
        reactions: bool | Sequence[str] = False,
        energies: bool = False,
        preload: Mapping[str, float] | None = None,
        indeterminate: str = "nan",
        loads: Mapping[str, ArrayLike] | None = None,
        parameters: Mapping[str, Value | ArrayLike] | None = None,
        parallel: bool = False,
    ) -> Tick:
        """Solve one pose, or a batch of unrelated ones, each as if it were alone.

        y, yd, ydd, yddd: driven positions, velocities, accelerations and jerks, (k,) or (k, n),
        SI; rates are zero by default.
        guess: an earlier `Tick`, or positions in rows like `coordinates`, one column for all poses
        or one each. Iterated coordinates start from it, and angles are returned within half a turn
        of it; so are, for their limits, angles that are not reported, if it is a Tick. Without a
        guess, angles are returned within half a turn of home. A solver with closed forms alone then
        stays on home's branch; one that iterates walks straight from home to each pose, in small
        steps, and returns the assembly that it reaches, or a flag.
        within: how far from the guess an iterated coordinate may be [m or rad]; anything farther
        is flagged as a branch change.
        forces, reactions, energies, preload, indeterminate, loads: as of `solve`; the forces behind
        the poses are `Tick.forces`. What wrenches take that change with time must be in `loads`.
        parameters: of another design, of those that were left `free`, a value each or one for each
        pose; a number is in SI. Not together with forces.
        parallel: use all cores.
        A pose that is not solved has a status that says why and NaN throughout; where only angles
        are undefined, only they are NaN. A pose beyond a declared limit is flagged and keeps its
        values, whether what is limited is reported or not; `stopped_by` and `excess` say which
        limit and by how much, and which limb cannot reach a pose out of reach. Poses with NaN or
        infinity in y, rates or guess are flagged too, and so are those with a guess of an angle
        beyond a million turns. Raises InputError on arrays of the wrong shape.
        """
        inputs = stacked(len(self.driven), self.derivatives, y, (yd, ydd, yddd))
        if parameters is not None:
            if forces or reactions or energies:
                raise InputError(
                    "parameters", "forces of another design", "a solver compiled for it"
                )
            return self.designs.at(inputs, guess, within, parameters, parallel=parallel)
        tick = self._poses.at(inputs, guess, within, parallel=parallel)
        if not (forces or reactions or energies):
            return tick
        asked = self.mechanics.asked(
            reactions=reactions, energies=energies, preload=preload, indeterminate=indeterminate
        )
        turning = self._guesses.turning
        found = forces_behind(
            self.chart, self._locks, asked, inputs, tick, loads, turning, parallel=parallel
        )
        return tick._replace(forces=found)

    def bound(self) -> Bound:
        """The solver with arrays of its own, for one control loop: faster than `at`."""
        return Bound(self._poses)

    def _repr_html_(self) -> str:
        return solver_html(self, self._labels.units)

    @property
    def designs(self) -> OtherDesigns:
        """What answers for other designs. Raises InputError where no parameters are left open."""
        if self._designs is None:
            raise InputError("parameters", "a solver of one design", "one compiled with free=[...]")
        return self._designs

    def with_design(self, parameters: Mapping[str, Value]) -> Solver:
        """The solver of another design: a compilation with these parameters, open or not, as if
        the file said so. The last few are kept. Raises InputError, AssemblyError, DrivenError.
        """
        return self._other(parameters) if parameters else self

    @property
    def no_forces(self) -> str:
        """Why `solve` can give no forces, unless more is asked for; "" if it can."""
        return self.mechanics.refusal

    def configuration(self, y: FloatArray, tick: Tick) -> Configuration:
        """All joints and bodies in numbers, given driven values `y`, (k,), and what `at` returned
        for them.
        """
        chart = self.atlas.followed  # which knows whatever is solved for
        known = begun_at(self._locks, self.layout, tick)
        return chart.configuration(y, chart.at_rest(y, known))

    @property
    def mechanics(self) -> Mechanics:
        """What forces need to know of the plan."""
        return self.chart.mechanics

    @property
    def angle_rows(self) -> list[int]:
        """Rows of `coordinates` that are angles."""
        return self.atlas.angle_rows

    def poses(self, y: ArrayLike, tick: Tick) -> tuple[FloatArray, FloatArray]:
        """The pose of every body, given driven values `y`, (k,), and what `at` returned for them.

        Positions of origins [m], (bodies, 3), and orientations, quaternions wxyz, (bodies, 4). The
        rows are the file's bodies without the base, as in the result of `solve(bodies=True)`.
        """
        zero = np.zeros((len(self.driven), 1))
        place = np.asarray(y, dtype=float)[:, None]
        points = points_of(self.graph, True)
        samples = Samples(np.zeros(1), place, zero, zero)
        found = begun_at(self._locks, self.layout, tick)[:, None]
        blocks = self.chart.figures(points, samples, found, False).reshape(len(points), POINT, 1)
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

        rate: samples per second, if laws give the motion. smoothing: standard deviation of the
        noise in recorded positions, SI. max_gap: longest step allowed in recorded data [s].
        Raises InputError.
        """
        driven = {name: self.home[name] for name in self.driven}
        return load_motion(motion, self.graph, driven, rate, smoothing, max_gap)

    def solve(
        self,
        motion: Motion | str | Path,
        *,
        bodies: bool | Sequence[str] = False,
        forces: bool = False,
        reactions: bool | Sequence[str] = False,
        energies: bool = False,
        preload: Mapping[str, float] | None = None,
        indeterminate: str = "nan",
        loads: Mapping[str, ArrayLike] | None = None,
        parallel: bool = False,
    ) -> xr.Dataset:
        """Solve a whole motion, from home along home's branch.

        motion: a `Motion` of the driven coordinates, or a name or file as for `motion`. bodies:
        True adds position, orientation, velocities and accelerations of every body at its own
        origin; a list names bodies or points on them ("platform.B4"). parallel: use all cores.
        Where the motion cannot go on, the first sample after says why, and later ones are flagged
        `not reached`; all these are NaN. A sample beyond a declared limit is flagged and keeps its
        values, whether what is limited is reported or not. `stopped_by` names the limit or the limb
        that cannot reach, `excess` says how far beyond the limit it is, and `first_at` when that
        was first met, which may be between two samples.

        forces: adds the actuators' `effort` and `power`, and torque, speed and current of motors
        where drives are given. reactions: True, or a list of joints, adds the force and moment on
        each joint's child, at its origin on the child along its axes on the parent. energies: adds
        kinetic and potential energy, and the powers lost and applied. What is indeterminate for
        rigid bodies is NaN, or with indeterminate="minimum-norm" of minimum norm. preload: efforts
        by actuated coordinate that actuators are to be nearest to where there are more of them
        than freedoms; {} is none. loads: masses of payloads [kg], or what wrenches take, by name,
        instead of the file's.
        Raises InputError on a motion of other coordinates, and where forces cannot be had: without
        masses, with too few actuators, or, without a preload, with too many.
        """
        motion = self._driving(motion)
        asked = self._windows(bodies, forces, reactions, energies, preload, indeterminate, loads)
        size = max(motion.count, 1)
        (result,) = asked.solve(motion, size, derivatives=self.derivatives, parallel=parallel)
        return self._labels.dataset(result)

    def stream(
        self,
        motion: Motion | str | Path,
        size: int = 65536,
        *,
        bodies: bool | Sequence[str] = False,
        forces: bool = False,
        reactions: bool | Sequence[str] = False,
        energies: bool = False,
        preload: Mapping[str, float] | None = None,
        indeterminate: str = "nan",
        loads: Mapping[str, ArrayLike] | None = None,
        parallel: bool = False,
    ) -> Iterator[xr.Dataset]:
        """Solve as `solve` does, but in windows of at most `size` samples, each a Dataset, so that
        a motion of any length fits in memory.
        """
        asked = self._windows(bodies, forces, reactions, energies, preload, indeterminate, loads)
        return map(self._labels.dataset, self._stream(motion, size, asked, parallel))

    def windows(
        self, motion: Motion | str | Path, size: int, *, parallel: bool = False, **asked: Any
    ) -> Iterator[Labelled]:
        """As `stream` with the same arguments, but without xarray, which takes long to import."""
        return self._stream(motion, size, self._windows(**asked), parallel)

    def _stream(
        self, motion: Motion | str | Path, size: int, asked: Windows, parallel: bool
    ) -> Iterator[Labelled]:
        if not isinstance(size, (int, np.integer)) or size < 1:
            raise InputError("size", repr(size), "a whole number of samples, 1 or more")
        motion = self._driving(motion)
        return asked.solve(motion, size, derivatives=self.derivatives, parallel=parallel)

    def simulate(
        self,
        duration: float,
        efforts: Efforts = None,
        *,
        start: Mapping[str, float] | None = None,
        velocity: Mapping[str, float] | None = None,
        hold: bool = False,
        rate: float = 1000.0,
        times: ArrayLike | None = None,
        rtol: float = 1e-9,
        method: str = "dop853",
        rest_speed: float = 1e-3,
        end_at_limits: bool = False,
        project: float = np.inf,
        bodies: bool | Sequence[str] = False,
        loads: Mapping[str, ArrayLike] | None = None,
    ) -> xr.Dataset:
        """The motion that forces make in `duration` seconds, as `solve` gives motions, at `rate`
        samples a second or at these times (n,) [s].

        efforts: of actuated coordinates, by name: numbers [N or N m], tables of laws, or servos; a
        file; or a function of a `State`. start, velocity: positions (home) and rates (0) of driven
        coordinates. hold: actuators that are not told otherwise keep the efforts that hold the
        start under the file's own loads. method: "radau" is for what is stiff, "taylor" exact to
        rounding, of constant efforts. rest_speed: [m/s or rad/s] around which Coulomb friction
        changes its direction. end_at_limits: nothing is told beyond the first. project: how often
        loops are closed [s].
        Adds `effort`, `power`, energies, and how these and closed loops drift. Raises InputError.
        """
        acts = efforts, start, velocity, hold, rate, times
        how = Options(duration, *acts, method, rtol, rest_speed, end_at_limits, project, loads)
        return simulated(self, partial(self._part, bodies), how)

    def _part(self, bodies: bool | Sequence[str], left: Left | None = None) -> Part:
        """Of a simulation: by this solver or, where it was left, by one that others drive."""
        if left is not None:
            names = tuple(self._name(k) for k in left.driven)
            return self._elsewhere(names, left.q)._part(bodies)
        return Part(self.chart, self._windows(bodies))

    def schema(
        self,
        motion: Motion | str | Path,
        *,
        bodies: bool | Sequence[str] = False,
        forces: bool = False,
        reactions: bool | Sequence[str] = False,
        energies: bool = False,
        preload: Mapping[str, float] | None = None,
        indeterminate: str = "nan",
    ) -> xr.Dataset:
        """The Dataset that `solve` would return for a motion, with the same variables, coordinates,
        types and attributes, but NaN for every value: nothing is solved. Raises InputError.
        """
        motion = self._driving(motion)
        windows = self._windows(bodies, forces, reactions, energies, preload, indeterminate)
        return self._labels.dataset(windows.schema(motion, self.reported.count))

    def _driving(self, motion: Motion | str | Path) -> Motion:
        """The motion, its rows in the order of the driven coordinates, if it can be solved."""
        motion = motion if isinstance(motion, Motion) else self.motion(motion)
        refuse_lean(self.chart.outputs)
        if set(motion.coordinates) != set(self.driven):
            found = f"coordinates {', '.join(motion.coordinates)}"
            expected = f"the driven coordinates {', '.join(self.driven)}"
            raise InputError(f"motion {motion.name}", found, expected)
        return motion.reordered(self.driven)
