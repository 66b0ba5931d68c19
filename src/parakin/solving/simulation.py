"""Simulation: the motion that forces make.

The state is the positions of the driven coordinates and of all that the plan solves for, and the
driven coordinates' rates: loops are closed in rates, and no position is solved for on the way.
Where the rows that the plan has chosen lose their grip, another plan takes over (see
`solving.charts`). The driven coordinates' motion is then solved like any other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from parakin.algebra.spatial import FLOATS, as_float
from parakin.arrays import FloatArray, IndexArray
from parakin.caching import cached_property
from parakin.errors import InputError
from parakin.kernel.backends import Kernel
from parakin.kernel.forward import ForwardRows, mass_matrix
from parakin.kernel.motion import motion_at, unit_motions
from parakin.kinematics.configuration import Configuration, configure, coordinate_scales
from parakin.motion.motion import Motion, Samples
from parakin.planning.plan import Plan
from parakin.solving.applied import Applied, Efforts, State, applied
from parakin.solving.charts import Chart
from parakin.solving.forces import wound

_LIGHT = 1e-9  # of the largest mass that a freedom moves: less is none
_GRIP = 0.1  # of what a block's rows determined at first: where less is left, another plan is made
_LAST = 1e-4  # of it: with less, if no other plan is found, rates are not known
_SINGULAR = 1e-3  # regularity, home's being 1: closer to a singularity no plan is better


@dataclass(frozen=True, eq=False)
class Forward:
    """Forward dynamics of a chart's plan, compiled."""

    chart: Chart
    rows: ForwardRows

    @classmethod
    def of(cls, chart: Chart, rest: float) -> Forward:
        """rest: see `ForwardRows`. Raises InputError where there is nothing that makes forces,
        friction that a simulation does not know, or an idle freedom, which would be held.
        """
        plan = chart.plan
        graph, where = plan.graph, plan.graph.mechanism.where
        if not graph.dynamics.any:
            raise InputError(f"{where}: bodies", "nothing that makes forces", "masses of bodies")
        if graph.dynamics.levers:
            names = ", ".join(graph.coordinates[k].name for k in graph.dynamics.levers)
            found = f"friction that grows with the load, in {names}"
            raise InputError(f"{where}: joints", found, "Coulomb and viscous friction alone")
        if plan.idle:
            idle, driven = (_names(graph, numbers) for numbers in (plan.idle, plan.driven))
            found = f"{', '.join(idle)} idle, and so held"
            expected = f"them driven too: {', '.join([*driven, *idle])}"
            raise InputError(f"{where}: driven", found, expected)
        outside = tuple(k for k in wound(plan) if k not in plan.unknowns and k not in plan.affine)
        return cls(chart, ForwardRows(plan, actuated_of(plan), outside, rest))

    @cached_property
    def kernel(self) -> Kernel:
        return self.chart.forward_kernel(self.rows)

    def mass_matrix(self, at: Configuration, loads: FloatArray) -> FloatArray:
        """That of the driven coordinates, (n, n)."""
        plan = self.chart.plan
        driven = [float(at.q[k]) - plan.offset(k) for k in plan.driven]
        unknowns = [float(at.q[k]) - plan.offset(k) for k in plan.unknowns]
        moved = motion_at(plan, driven, unknowns, [0.0] * len(driven), FLOATS)
        units = unit_motions(plan, moved, FLOATS)
        entries = mass_matrix(plan, moved, units, loads.tolist())
        return np.array([[as_float(x) for x in row] for row in entries])

    def check_masses(self, at: Configuration, loads: FloatArray) -> None:
        """Raises InputError where a freedom moves nothing that has mass."""
        plan = self.chart.plan
        scales = coordinate_scales(plan.graph)[list(plan.driven)]
        matrix = self.mass_matrix(at, loads) * np.outer(scales, scales)
        values, vectors = np.linalg.eigh(matrix)
        if not values[0] > _LIGHT * values[-1]:
            most = plan.driven[int(np.abs(vectors[:, 0]).argmax())]
            found = f"a freedom, mostly {plan.graph.coordinates[most].name}, that moves no mass"
            expected = "masses, with inertia, of the bodies that it moves; or an armature"
            raise InputError(f"{plan.graph.mechanism.where}: bodies", found, expected)

    def parts(self, state: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Driven positions, unknowns, wound angles, driven rates: of a state (s,) or (s, n)."""
        n, m, w = len(self.rows.plan.driven), len(self.rows.plan.unknowns), len(self.rows.wound)
        a, b = n + m, n + m + w
        return state[:n], state[n:a], state[a:b], state[b : b + n]

    def state(
        self, at: Configuration, rates: FloatArray, turned: Mapping[int, float], work: float
    ) -> FloatArray:
        """A configuration with the driven coordinates' rates as a state. turned: wound angles by
        coordinate, full turns counted; work [J] done so far.
        """
        plan, q = self.chart.plan, self.chart.coordinates_at(at)
        positions = [q[k] - plan.offset(k) for k in (*plan.driven, *plan.unknowns)]
        wound_up = [turned.get(k, q[k] - plan.offset(k)) for k in self.rows.wound]
        return np.array([*positions, *wound_up, *rates, work])

    def configuration(self, state: FloatArray) -> Configuration:
        plan = self.chart.plan
        q = np.array(plan.home, dtype=float)
        driven, unknowns, _, _ = self.parts(state)
        for k, value in zip(plan.unknowns, unknowns, strict=True):
            q[k] = value + plan.offset(k)
        counted = dict(zip(plan.driven, driven, strict=True))
        for k, rule in plan.affine.items():
            q[k] = rule.constant
            for j, factor in rule.factors:
                q[k] += factor * (counted[j] + plan.offset(j))
        return configure(plan.graph, plan.tree, q)

    def run(self, state: FloatArray, efforts: FloatArray, loads: FloatArray) -> FloatArray:
        """The rates of a state, (s,) or (s, n), and below them the figures of its blocks."""
        out = np.empty((self.rows.count, *state.shape[1:]))
        self.kernel(np.ascontiguousarray(np.concatenate([state, efforts, loads])), out, False)
        return np.concatenate([self.parts(state)[3], out])


def actuated_of(plan: Plan) -> tuple[int, ...]:
    """The actuated coordinates or, if the file names none, those driven by joints."""
    graph = plan.graph.plain
    found = tuple(k for k, c in enumerate(graph.coordinates) if c.actuated)
    joints = (k for k in plan.driven if graph.coordinates[k].joint != graph.platform)
    return found or tuple(joints)


class Told(NamedTuple):
    """Of n moments: efforts and power of the actuated coordinates (m, n) and their names; kinetic
    and potential energy [J], power lost and applied [W]; how far the energy is from what it was at
    first and the work done since [J]; how far the states have drifted from closed loops [m]; and
    positions of what was integrated beside the driven coordinates, by name, NaN where it was not.
    """

    actuators: tuple[str, ...]
    units: tuple[str, ...]
    effort: FloatArray
    power: FloatArray
    energies: FloatArray
    energy_drift: FloatArray
    closure_drift: FloatArray
    positions: dict[str, FloatArray]


class Segment(NamedTuple):
    """A part of a simulation in one plan: from `start` [s] on, and its states at any times."""

    start: float
    forward: Forward
    states: Callable[[FloatArray], FloatArray]


class Simulated(NamedTuple):
    """A simulation: its driven coordinates as a motion, from start to end, and its segments."""

    motion: Motion
    segments: list[Segment]
    ended: float


@dataclass(frozen=True, eq=False)
class Simulation:
    """Forward dynamics with what acts.

    home: the solver's chart. given: what payloads or wrenches take throughout, by name, instead of
    what the file says.
    """

    home: Chart
    efforts: Efforts
    given: Mapping[str, ArrayLike]
    rest: float
    rtol: float

    @cached_property
    def acting(self) -> Applied:
        """The efforts, read. Raises InputError."""
        return applied(self.home.plan.graph.plain, actuated_of(self.home.plan), self.efforts)

    def run(self, at: Configuration, rates: FloatArray, times: FloatArray) -> Simulated:
        """From a configuration of home's graph, with these rates of the driven coordinates, at the
        first of the times (n,) to the last, or until a singularity is met.
        """
        forward = Forward.of(self.home, self.rest)
        self.home.mechanics.check_histories(times[[0, -1]], self.given)
        forward.check_masses(at, self._at(times[0]))
        if not self.acting.asks:
            self.acting.of(float(times[-1]), None)  # refuses what ends earlier
        state, time, knots = forward.state(at, rates, {}, 0.0), float(times[0]), [float(times[0])]
        segments: list[Segment] = []
        reference, least = self._figures(forward, state, time), _GRIP
        if not np.isfinite(self._rates(forward, time, state)).all():
            raise InputError("start", "a pose at which rates are not known", "one that is regular")
        while np.isfinite(self._rates(forward, time, state)).all():
            left = partial(self._left, forward, reference, least)
            found = self._integrated(forward, state, (time, float(times[-1])), left)
            segments.append(Segment(time, forward, found.sol))
            knots += found.sol.ts.tolist()[1:]
            time = float(found.t[-1])
            if found.status != 1:
                break
            state = found.y[:, -1]
            taken = self._taken_over(forward, state)
            if taken is None or least < _LAST:
                break
            least *= _GRIP
            if taken[0] is not forward:
                forward, state = taken
                reference, least = self._figures(forward, state, time), _GRIP
        between = partial(self._samples, segments)
        sampled = times[times <= time]
        motion = Motion(
            "simulation",
            tuple(self.home.plan.graph.coordinates[k].name for k in self.home.plan.driven),
            len(sampled),
            lambda start, stop: between(sampled[start:stop]),
            "of the simulation",
            between,
            tuple(knots),
        )
        return Simulated(motion, segments, time)

    def _figures(self, forward: Forward, state: FloatArray, time: float) -> FloatArray:
        """How well each block's rows determine its unknowns."""
        nothing = np.zeros(len(forward.rows.actuated))
        return forward.run(state, nothing, self._at(time))[forward.rows.state :]

    def _rates(self, forward: Forward, time: float, state: FloatArray) -> FloatArray:
        efforts = self._efforts(forward, time, state)
        return forward.run(state, efforts, self._at(time))[: forward.rows.state]

    def _left(
        self,
        forward: Forward,
        reference: FloatArray,
        least: float,
        time: float,
        state: FloatArray,
    ) -> float:
        """By how much more than `least` of what it was at first the rows' grip is."""
        part = self._figures(forward, state, time) / reference
        return float(part.min(initial=1.0)) - least

    def _integrated(
        self,
        forward: Forward,
        state: FloatArray,
        span: tuple[float, float],
        left: Callable[[float, FloatArray], float],
    ) -> Any:
        """SciPy's solution from a state on, until nothing is left."""
        from scipy.integrate import solve_ivp

        left.terminal = True  # type: ignore[attr-defined]
        plan, rows = forward.chart.plan, forward.rows
        numbers = [*plan.driven, *plan.unknowns, *rows.wound, *plan.driven]
        scales = [*coordinate_scales(plan.graph)[numbers], 1.0]
        return solve_ivp(
            partial(self._rates, forward),
            span,
            state,
            method="DOP853",
            events=left,
            rtol=self.rtol,
            atol=self.rtol * np.array(scales),
            dense_output=True,
        )

    def _taken_over(self, forward: Forward, state: FloatArray) -> tuple[Forward, FloatArray] | None:
        """By a plan made where another one has lost its grip, or by that itself where no other rows
        are better; None at a singularity.
        """
        at = forward.configuration(state)
        if not forward.chart.regularity(at) > _SINGULAR:
            return None
        chart = forward.chart.replanned_at(at)
        if chart is None:
            return None
        if _rows(chart.plan) == _rows(forward.chart.plan):
            return forward, state
        known = dict(zip(forward.rows.wound, forward.parts(state)[2].tolist(), strict=True))
        after = Forward.of(chart, self.rest)
        return after, after.state(at, forward.parts(state)[3], known, float(state[-1]))

    def _efforts(self, forward: Forward, time: float, state: FloatArray) -> FloatArray:
        if not self.acting.asks:
            return self.acting.of(time, None)
        plan = forward.chart.plan
        driven, unknowns, _, _ = forward.parts(state)
        nothing = np.zeros(len(forward.rows.actuated))
        moving = forward.run(state, nothing, self._at(time))[: len(driven) + len(unknowns)]
        names = _names(plan.graph, [*plan.driven, *plan.unknowns])
        position = dict(zip(names, [*driven.tolist(), *unknowns.tolist()], strict=True))
        velocity = dict(zip(names, moving.tolist(), strict=True))
        return self.acting.of(time, State(time, position, velocity))

    def told(self, found: Simulated, times: FloatArray) -> Told:
        """What is known beside the motion, at times (n,)."""
        graph = self.home.plan.graph
        numbers = found.segments[0].forward.rows.actuated
        m = len(numbers)
        effort, rest = np.empty((m, len(times))), np.empty((m + 5, len(times)))
        work = np.empty(len(times))
        positions: dict[str, FloatArray] = {}
        for segment, inside in _sorted(found.segments, times):
            rows = replace(segment.forward.rows, told=True)
            states, efforts = self._acting(segment, times[inside])
            forward = Forward(segment.forward.chart, rows)
            names = _names(graph, rows.plan.unknowns)
            for name, values in zip(names, forward.parts(states)[1], strict=True):
                positions.setdefault(name, np.full(len(times), np.nan))[inside] = values
            effort[:, inside], work[inside] = efforts, states[-1]
            rest[:, inside] = forward.run(states, efforts, self.loads(times[inside]))[-m - 5 :]
        kinetic, potential = rest[m], rest[m + 1]
        drift = kinetic + potential - work
        return Told(
            tuple(_names(graph, numbers)),
            tuple("N m" if graph.coordinates[k].angle else "N" for k in numbers),
            effort,
            effort * rest[:m],
            rest[m : m + 4],
            drift - drift[:1],
            rest[m + 4],
            positions,
        )

    def _acting(self, segment: Segment, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """States (s, n) and efforts (m, n) at times within a segment."""
        states = segment.states(times)
        pairs = zip(times.tolist(), states.T, strict=True)
        efforts = [self._efforts(segment.forward, t, x) for t, x in pairs]
        return states, np.array(efforts).T

    def loads(self, times: FloatArray) -> FloatArray:
        """What payloads and wrenches take at times (n,) [s], (inputs, n)."""
        return self.home.mechanics.loads(times, len(times), self.given)

    def _at(self, time: float) -> FloatArray:
        if not self.changing:
            return self._steady
        return self.loads(np.array([time]))[:, 0]

    @cached_property
    def changing(self) -> bool:
        """Whether some wrench changes with time."""
        wrenches = self.home.plan.graph.dynamics.wrenches
        return any(each.inputs and each.name not in self.given for each in wrenches)

    @cached_property
    def _steady(self) -> FloatArray:
        return self.loads(np.zeros(1))[:, 0]

    def _samples(self, segments: Sequence[Segment], times: FloatArray) -> Samples:
        """The driven coordinates' motion at times (n,)."""
        found = np.empty((3, len(self.home.plan.driven), len(times)))
        for segment, inside in _sorted(segments, times):
            forward = segment.forward
            states, efforts = self._acting(segment, times[inside])
            out = forward.run(states, efforts, self.loads(times[inside]))
            driven, _, _, rates = forward.parts(states)
            accelerations = forward.parts(out[: forward.rows.state])[3]
            found[:, :, inside] = driven, rates, accelerations
        return Samples(np.array(times), *found)


def _sorted(segments: Sequence[Segment], times: FloatArray) -> Iterator[tuple[Segment, IndexArray]]:
    """Segments, and which of the times (n,) lie in each."""
    of = np.searchsorted([segment.start for segment in segments], times, side="right") - 1
    for number in np.unique(of).tolist():
        yield segments[number], np.flatnonzero(of == number)


def _rows(plan: Plan) -> list[tuple[Any, ...]]:
    return [(block.unknowns, block.rows) for block in plan.blocks]


def _names(graph: Any, numbers: Sequence[int]) -> list[str]:
    return [graph.coordinates[k].name for k in numbers]
