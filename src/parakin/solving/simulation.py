"""Simulation: the motion that forces make.

What forward dynamics says (`solving.forward`) is integrated. Where the rows that the plan has
chosen lose their grip, another plan takes over (see `solving.charts`); where the driven
coordinates do, others can. The driven coordinates' motion is then solved like any other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from parakin.arrays import FloatArray, IndexArray
from parakin.caching import cached_property
from parakin.errors import InputError
from parakin.kinematics.assembly import CLOSED, close
from parakin.kinematics.configuration import Configuration, configure, coordinate_scales
from parakin.kinematics.free_motions import free_motions
from parakin.motion.motion import Motion, Samples
from parakin.planning.plan import Plan
from parakin.solving.applied import Applied
from parakin.solving.charts import Chart
from parakin.solving.forward import Forward, names_of
from parakin.solving.integration import Integrated, by_taylor, integrated
from parakin.solving.status import Status

GRIP = 0.1  # of what a block's rows determined at first: where less is left, another plan is made
_LAST = 1e-4  # of it: with less, if no other plan is found, rates are not known
_SINGULAR = 1e-3  # regularity, home's being 1: closer to a singularity no plan is better
_NOISE = 10.0  # of rtol: what integrated values differ by from a smooth motion
_BETTER = 3.0  # times as independent: driven coordinates that take over


class Segment(NamedTuple):
    """A part of a simulation in one plan: from `start` [s] on."""

    start: float
    forward: Forward
    found: Integrated


class Told(NamedTuple):
    """Of n moments: efforts and power of the actuated coordinates (m, n); kinetic and potential
    energy [J], power lost and applied [W]; energy beyond the work done [J]; how far the states are
    from closed loops [m]; and positions of what was integrated beside the driven coordinates, by
    name, NaN where it was not.
    """

    effort: FloatArray
    power: FloatArray
    energies: FloatArray
    balance: FloatArray
    closure_drift: FloatArray
    positions: dict[str, FloatArray]


class Left(NamedTuple):
    """Where others are to take over from the driven coordinates: these, all coordinates and theirs
    rates (N,), and the work done [J].
    """

    driven: tuple[int, ...]
    q: FloatArray
    rates: FloatArray
    work: float


class Simulated(NamedTuple):
    """A simulation: its driven coordinates as a motion, what else is told of its samples; when it
    `ended`, why (CONVERGED if at its end), in words too; how many steps and evaluations it took;
    and where others are to go on.
    """

    motion: Motion
    told: Told
    ended: float
    why: Status
    because: str
    steps: int
    evaluations: int
    left: Left | None = None


@dataclass(frozen=True, eq=False)
class Simulation:
    """Forward dynamics with what acts, on `actuated` coordinates and elsewhere.

    given: what payloads or wrenches take throughout, by name, instead of what the file says. rest:
    as of `ForwardRows`. step: the longest [s] for which what changes goes unseen. project: after
    how long loops are closed again [s]. method: dop853, radau, or taylor, of what is constant.
    """

    home: Chart
    actuated: tuple[int, ...]
    acting: Applied
    given: Mapping[str, ArrayLike]
    rest: float
    rtol: float
    step: float
    project: float = np.inf
    method: str = "dop853"

    def forward(self, chart: Chart) -> Forward:
        """That of a chart, which tells all that there is, so that it need be compiled once."""
        acting = self.acting
        lean = Forward.of(chart, self.rest, self.actuated, servos=acting.servos, asks=acting.asks)
        return lean.telling

    def run(
        self,
        at: Configuration,
        rates: FloatArray,
        begin: float,
        times: FloatArray,
        work: float = 0.0,
    ) -> Simulated:
        """From a configuration of home's graph at `begin` [s], with these rates of the driven
        coordinates, to the last of the times (n,), or until a singularity is met.
        """
        forward = self.forward(self.home)
        self.home.mechanics.check_histories(np.array([begin, times[-1]]), self.given)
        forward.check_masses(at, self._at(begin))
        if not self.acting.asks:
            self.acting.of(float(times[-1]), None)  # refuses what ends earlier
        state = forward.state(at, rates, work)
        if not np.isfinite(self._rates(forward, begin, state)).all():
            raise InputError("start", "a pose at which rates are not known", "one that is regular")
        segments: list[Segment] = []
        left, why = self._go(segments, forward, state, begin, float(times[-1]))
        ended = segments[-1].found.end
        sampled = times[times <= ended] if why else times
        samples, told = self._sampled(segments, sampled)
        knots = [segments[0].start, *np.concatenate([s.found.knots[1:] for s in segments]).tolist()]
        motion = Motion(
            "simulation",
            tuple(names_of(self.home.plan.graph, self.home.plan.driven)),
            len(sampled),
            samples.cropped,
            "of the simulation",
            partial(_between, len(self.home.plan.driven), segments),
            tuple(knots),
            noise=_NOISE * self.rtol,
        )
        because = (
            segments[-1].found.failed or "no other choice of rows or driven coordinates is better"
        )
        sides = sum(segment.found.evaluations for segment in segments)
        return Simulated(motion, told, ended, why, because, len(knots) - 1, sides, left)

    def _go(
        self,
        segments: list[Segment],
        forward: Forward,
        state: FloatArray,
        time: float,
        end: float,
    ) -> tuple[Left | None, Status]:
        """Add segments to the end, or until no plan for the driven coordinates is left."""
        reference, least = self._figures(forward, state, time), GRIP
        while time < end:
            left = partial(self._left, forward, reference, least)
            found = self._integrated(forward, left, state, (time, min(end, time + self.project)))
            segments.append(Segment(time, forward, found))
            stuck, time, state = found.end == time, found.end, found.last
            if found.failed and least == GRIP:
                return None, Status.NOT_SMOOTH
            if found.failed or stuck:
                return None, Status.SINGULAR
            at = forward.configuration(state)
            if not found.lost:
                state = self._closed(forward, at, state) if time < end else state
                continue
            others = _others(forward, at, state)
            if others is not None:
                return others, Status.SINGULAR
            taken = self._taken_over(forward, at, state)
            if taken is None or least < _LAST:
                return None, Status.SINGULAR
            least *= GRIP
            if taken[0] is not forward:
                forward, state = taken
                reference, least = self._figures(forward, state, time), GRIP
        return None, Status.CONVERGED

    def _integrated(
        self,
        forward: Forward,
        left: Callable[[float, FloatArray], float],
        state: FloatArray,
        span: tuple[float, float],
    ) -> Integrated:
        if self.method == "taylor":
            given = np.concatenate([self.acting.of(span[0], None), self._steady])
            return by_taylor(forward.taylor(self.rtol), given, left, state, span)
        constant = np.isinf(self.acting.step) and not self.changing
        return integrated(
            partial(self._rates, forward),
            left,
            state,
            span,
            rtol=self.rtol,
            scales=forward.scales(),
            step=np.inf if constant else min(self.step, self.acting.step),
            stiff=self.method == "radau",
        )

    def _figures(self, forward: Forward, state: FloatArray, time: float) -> FloatArray:
        """How well each block's rows determine its unknowns."""
        nothing = np.zeros(forward.rows.efforts)
        return forward.figures(forward.run(state, nothing, self._at(time)))

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

    def _closed(self, forward: Forward, at: Configuration, state: FloatArray) -> FloatArray:
        """A state with its loops closed again, the driven coordinates held."""
        plan = forward.chart.plan
        closed, gap = close(plan.graph, plan.tree, at.q, held=plan.driven)
        if not gap <= CLOSED:
            raise InputError("project", f"loops open by {gap:.2g}", "a smaller rtol")
        return forward.state(closed, forward.parts(state)[3], float(state[-1]))

    def _taken_over(
        self, forward: Forward, at: Configuration, state: FloatArray
    ) -> tuple[Forward, FloatArray] | None:
        """By a plan made where another one has lost its grip, or by that itself where no other rows
        are better; None at a singularity.
        """
        if not forward.chart.regularity(at) > _SINGULAR:
            return None
        chart = forward.chart.replanned_at(at, at)
        if chart is None:
            return None
        if _rows(chart.plan) == _rows(forward.chart.plan):
            return forward, state
        after = self.forward(chart)
        return after, after.state(at, forward.parts(state)[3], float(state[-1]))

    def _efforts(self, forward: Forward, time: float, state: FloatArray) -> FloatArray:
        if not self.acting.asks:
            return self.acting.of(time, None)
        return self.acting.of(time, forward.seen(time, state, self._at(time)))

    def _sampled(self, segments: list[Segment], times: FloatArray) -> tuple[Samples, Told]:
        """The driven coordinates' motion, and what else is known, at times (n,)."""
        m, n = len(self.actuated), len(times)
        motion = np.empty((3, len(self.home.plan.driven), n))
        effort, power, rest = np.empty((m, n)), np.empty((m, n)), np.empty((5, n))
        work = np.empty(n)
        positions: dict[str, FloatArray] = {}
        for segment, inside in _sorted(segments, times):
            forward, states = segment.forward, segment.found.states(times[inside])
            pairs = zip(times[inside].tolist(), states.T, strict=True)
            efforts = np.array([self._efforts(forward, t, x) for t, x in pairs]).T
            out = forward.run(states, efforts, self.loads(times[inside]))
            driven, unknowns, _, rates = forward.parts(states)
            accelerations = forward.parts(out[: forward.rows.state])[3]
            if self.method == "radau":  # of what is stiff, these magnify the last digits
                accelerations = forward.parts(segment.found.slopes(times[inside]))[3]
            motion[:, :, inside] = driven, rates, accelerations
            for name, values in zip(
                names_of(forward.chart.plan.graph, forward.chart.plan.unknowns),
                unknowns,
                strict=True,
            ):
                positions.setdefault(name, np.full(n, np.nan))[inside] = values
            told = forward.told(out)
            effort[:, inside], power[:, inside] = told[:m], told[:m] * told[m : 2 * m]
            rest[:, inside], work[inside] = told[2 * m :], states[-1]
        balance = rest[0] + rest[1] - work
        told_of = Told(effort, power, rest[:4], balance, rest[4], positions)
        return Samples(np.array(times), *motion), told_of

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
        return bool(self.home.mechanics.changing(self.given))

    @cached_property
    def _steady(self) -> FloatArray:
        return self.loads(np.zeros(1))[:, 0]


def _between(count: int, segments: Sequence[Segment], times: FloatArray) -> Samples:
    """The motion of `count` driven coordinates as it was integrated, at any times (n,)."""
    found = np.empty((3, count, len(times)))
    for segment, inside in _sorted(segments, times):
        states = segment.found.states(times[inside])
        slopes = segment.found.slopes(times[inside])
        driven, _, _, rates = segment.forward.parts(states)
        found[:, :, inside] = driven, rates, segment.forward.parts(slopes)[3]
    return Samples(np.array(times), *found)


def _sorted(segments: Sequence[Segment], times: FloatArray) -> Iterator[tuple[Segment, IndexArray]]:
    """Segments, and which of the times (n,) lie in each."""
    of = np.searchsorted([segment.start for segment in segments], times, side="right") - 1
    for number in np.unique(of).tolist():
        yield segments[number], np.flatnonzero(of == number)


def _others(forward: Forward, at: Configuration, state: FloatArray) -> Left | None:
    """Other driven coordinates, if some move more independently at a configuration; None where its
    mobility is another.
    """
    plan, graph = forward.chart.plan, forward.chart.plan.graph.plain
    q = at.q[: len(graph.coordinates)]
    tree = graph.posed_tree()
    motions = free_motions(graph, tree, configure(graph, tree, q))
    driven = list(plan.driven)
    if motions.shape[1] != len(driven):
        return None
    known = [k for j in graph.joints if len(j.turns) < 3 for k in j.coordinates]
    scaled = motions / coordinate_scales(graph)[:, None]
    chosen = _independent(scaled, sorted({*known, *driven}))
    if not _least(scaled[chosen]) > _BETTER * _least(scaled[driven]):
        return None
    mix = np.linalg.lstsq(motions[driven], forward.parts(state)[3], rcond=None)[0]
    return Left(tuple(chosen), q, motions @ mix, float(state[-1]))


def _independent(motions: FloatArray, known: list[int]) -> list[int]:
    """As many of the known coordinates as there are motions (N, n), the most independent ones."""
    from scipy.linalg import qr

    order = qr(motions[known].T, mode="r", pivoting=True)[1]
    return [known[k] for k in order[: motions.shape[1]].tolist()]


def _least(matrix: FloatArray) -> float:
    return float(np.linalg.svd(matrix, compute_uv=False).min(initial=1.0))


def _rows(plan: Plan) -> list[tuple[Any, ...]]:
    return [(block.unknowns, block.rows) for block in plan.blocks]
