"""Homes of other designs: each found by walking from the file's own, parameters changing together.

What the file gives for home drives it, as far as it is independent; what it leaves open stays where
it is in the file's own design. The walk is straight, in steps that are halved until what moves goes
as its rates at both ends of a step say.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from parakin.algebra.angles import nearest_angle
from parakin.algebra.spatial import ARRAYS
from parakin.arrays import BoolArray, FloatArray, IndexArray, StatusArray
from parakin.caching import cached_property
from parakin.kernel.backends import Kernel, compiled
from parakin.kernel.designs import HomeRows, limits_at
from parakin.kernel.outputs import Outputs
from parakin.kinematics.configuration import Configuration, coordinate_scales
from parakin.kinematics.free_motions import free_motions
from parakin.model.designs import Designs
from parakin.model.graph import Graph
from parakin.planning.ordering import plan_of, with_twins
from parakin.planning.plan import Plan
from parakin.solving import columns
from parakin.solving.columns import LANES
from parakin.solving.continuity import POSITION
from parakin.solving.status import RESIDUAL, SINGULAR, Status

_STEPS = 3  # of Newton's method in a run of a kernel
_AT_ONCE = 2048  # designs, whose numbers stay in the cache
_RUNS = 12  # of a kernel, before giving up
_CLOSED = 0.01 * RESIDUAL  # what is aimed at by the first runs
_HALVINGS = 30
_ATTEMPTS = 400  # steps of all sizes before giving up
_FIRST = 0.25  # of the way: no step is longer
_ROUGH = 1e-9  # of a unit, over the conditioning: less is nothing
_HELD = 1e-9  # of a unit: by how much what home gives may be missed
_INDEPENDENT = (0.1, 1e-6)  # of a coordinate's motion: what others leave free of it


class Stood(NamedTuple):
    """Homes of n designs: coordinates (q, n), as their joints count, and a status each."""

    coordinates: FloatArray
    status: StatusArray


@dataclass(frozen=True, eq=False)
class Homes:
    """What finds home in other designs. plan: driven by what home gives; told: the coordinates that
    are told.
    """

    plan: Plan
    told: tuple[int, ...]
    machine_code: bool

    @staticmethod
    def of(
        designs: Designs,
        graph: Graph,
        home: Configuration,
        others: Sequence[Configuration],
        told: Sequence[int],
        *,
        machine_code: bool,
    ) -> Homes:
        """graph: the mechanism's; home: its own; others: configurations of other designs; told:
        coordinates. Raises DrivenError.
        """
        driven = _independent(graph, home)
        plain = replace(graph, from_home=frozenset())
        plan = replace(plan_of(plain, driven, home, others=others), designs=designs)
        return Homes(plan, tuple(told), machine_code)

    @cached_property
    def rows(self) -> HomeRows:
        also = [k for k in self.plan.graph.home if k not in self.plan.driven]
        watched = [k for k in self.plan.unknowns if k not in self.told]
        return HomeRows(self.plan, (*self.told, *watched), tuple(also))

    @cached_property
    def _kernel(self) -> Kernel:
        traced = partial(self.rows.at, _STEPS)
        return compiled(traced, self.rows.inputs, machine_code=self.machine_code)

    def at(self, parameters: FloatArray) -> Stood:
        """Homes of designs (m, n)."""
        assert self.plan.designs is not None
        own, n = self.plan.designs.own[:, None], parameters.shape[1]
        with np.errstate(all="ignore"):  # what overflows on the way is flagged
            found = [
                self._walked(own, parameters[:, start : start + _AT_ONCE] - own)
                for start in range(0, n, _AT_ONCE)
            ]
        return Stood(
            np.concatenate([stood.coordinates for stood in found], axis=1),
            np.concatenate([stood.status for stood in found]),
        )

    def changes(
        self, parameters: FloatArray, home: Mapping[int, FloatArray], coordinates: Sequence[int]
    ) -> FloatArray:
        """How coordinates change at home by each parameter, (q, m, n), in designs (m, n) whose
        homes are given by coordinate (n,).
        """
        m, n = parameters.shape
        rows = [self.rows.coordinates.index(k) for k in coordinates]
        found = np.empty((len(rows), m, n))
        if not rows or not n:
            return found
        guess = np.array([home[k] for k in self.plan.iterated]).reshape(len(self.plan.iterated), n)
        for k in range(m):
            way = np.zeros((m, n))
            way[k] = 1.0
            found[:, k] = self._run(parameters, way, guess)[self._moving][rows]
        return found

    def _walked(self, own: FloatArray, way: FloatArray) -> Stood:
        n = way.shape[1]
        begin = np.array([self.plan.home[k] for k in self.plan.iterated]).reshape(-1, 1)
        out = self._run(own.repeat(n, axis=1), way, begin.repeat(n, axis=1))
        status, part, size = self._verdict(out), np.zeros(n), np.full(n, _FIRST)
        size[~way.any(axis=0)] = 1.0
        going = np.flatnonzero(status == Status.CONVERGED)
        for _ in range(_ATTEMPTS):
            if not len(going):
                break
            before = out if len(going) == n else out[:, going]
            target = np.minimum(part[going] + size[going], 1.0)
            h = target - part[going]
            guess = before[self._iterated] + h * before[self._moving][self._iterated]
            found = self._run(own + target * way[:, going], way[:, going], guess)
            self._unwind(found, before, h)
            verdict = self._verdict(found)
            smooth = self._smooth(h, before, found)
            verdict[(verdict == Status.CONVERGED) & ~smooth] = Status.BRANCH_CHANGE
            good = verdict == Status.CONVERGED
            size[going] = np.where(good, np.minimum(2.0 * size[going], _FIRST), 0.5 * size[going])
            stuck = ~good & (size[going] < _FIRST * 0.5**_HALVINGS)
            unclear = (verdict == Status.ITERATION_LIMIT) | (verdict == Status.BRANCH_CHANGE)
            verdict[stuck & unclear] = Status.NOT_REACHED
            status[going[stuck]] = verdict[stuck]
            part[going] = np.where(good, target, part[going])
            if len(going) == n and good.all():
                out = found
            else:
                out[:, going[good]] = found[:, good]
            going = going[~(stuck | (good & (target == 1.0)))]
        status[going] = Status.NOT_REACHED
        return Stood(out[self._positions], status)

    def _run(self, parameters: FloatArray, way: FloatArray, guess: FloatArray) -> FloatArray:
        """A kernel's outputs, repeated from where it got to as long as that may help."""
        inputs = np.concatenate([parameters, way, guess])
        out = self._once(inputs)
        if not len(guess):
            return out
        known = len(inputs) - len(guess)
        for run in range(_RUNS):
            wanted = _CLOSED if run < 2 else RESIDUAL
            open_ = ~(out[self._outputs.residual] <= wanted * out[self._outputs.size])
            open_ &= np.isfinite(out[self._iterated]).all(axis=0)
            if not open_.any():
                break
            again = inputs[:, open_]
            again[known:] = out[self._iterated][:, open_]
            out[:, open_] = self._once(again)
        return out

    def _once(self, inputs: FloatArray) -> FloatArray:
        """Outputs (rows, n), in whole vectors: a column is rounded as it is in any batch."""
        count = self._outputs.count + len(self.rows.also)
        return columns.run(self._kernel, inputs, count, lanes=LANES)

    def _unwind(self, out: FloatArray, before: FloatArray, h: FloatArray) -> None:
        """Count the full turns of angles on from a step before; a kernel knows none."""
        rows = self._angles
        out[rows] = nearest_angle(out[rows], to=before[rows] + h * before[self._moving][rows])

    def _verdict(self, out: FloatArray) -> StatusArray:
        residual, conditioning = out[self._outputs.residual], out[self._outputs.conditioning]
        status = np.zeros(out.shape[1], dtype=np.int8)
        status[~(conditioning >= SINGULAR)] = Status.SINGULAR
        status[conditioning < -SINGULAR] = Status.BRANCH_CHANGE
        status[~(residual <= RESIDUAL * out[self._outputs.size])] = Status.ITERATION_LIMIT
        held = np.abs(out[self._outputs.count :]) <= _HELD * self._units_of(self.rows.also)
        status[np.isnan(residual) | ~held.all(axis=0)] = Status.OUT_OF_REACH
        status[np.isnan(out[self._positions]).any(axis=0)] = Status.OUT_OF_REACH
        return status

    def _smooth(self, h: FloatArray, before: FloatArray, after: FloatArray) -> BoolArray:
        """Whether steps go as the rates at both ends say, but for a part that falls with h²."""
        slow, fast = before[self._moving], after[self._moving]
        off = after[self._positions] - before[self._positions] - 0.5 * h * (slow + fast)
        size = h * np.maximum(np.abs(slow), np.abs(fast))
        rough = _ROUGH * self._units_of(self.rows.coordinates) / after[self._outputs.conditioning]
        smooth: BoolArray = (np.abs(off) <= POSITION * size + rough).all(axis=0)
        return smooth

    def _units_of(self, coordinates: Sequence[int]) -> FloatArray:
        units: FloatArray = coordinate_scales(self.plan.graph)[list(coordinates)][:, None]
        return units

    @cached_property
    def _angles(self) -> IndexArray:
        known, iterated = self.plan.graph.coordinates, self.plan.iterated
        rows = [
            row
            for row, k in enumerate(self.rows.coordinates)
            if known[k].angle and k not in (*iterated, *self.plan.driven)
        ]
        return np.array(rows, dtype=np.intp)

    @cached_property
    def _outputs(self) -> Outputs:
        return self.rows.outputs

    @cached_property
    def _positions(self) -> slice:
        return self._outputs.order(0)

    @cached_property
    def _moving(self) -> slice:
        return self._outputs.order(1)

    @cached_property
    def _iterated(self) -> IndexArray:
        place = {k: row for row, k in enumerate(self.rows.coordinates)}
        return np.array([place[k] for k in self.plan.iterated], dtype=np.intp)


def _independent(graph: Graph, home: Configuration) -> list[int]:
    """Coordinates that drive home: of those that it gives as many as are independent, then others,
    held where they are in the file's own design.
    """
    count = len(graph.coordinates)
    whole, there = with_twins(graph, home, list(graph.home))  # three angles may be undefined
    motions = free_motions(whole, whole.posed_tree(), there)
    motions = (motions / coordinate_scales(whole)[:, None])[:count]
    actuated = [k for k, c in enumerate(graph.coordinates) if c.actuated]
    order = dict.fromkeys([*graph.home, *actuated, *range(len(graph.coordinates))])
    chosen: list[int] = []
    basis = np.zeros((0, motions.shape[1]))
    for firmly in _INDEPENDENT:
        for k in order:
            if len(chosen) == motions.shape[1]:
                return chosen
            left = motions[k] - (motions[k] @ basis.T) @ basis
            size = float(np.linalg.norm(left))
            if k not in chosen and size > firmly * float(np.linalg.norm(motions[k])) > 0.0:
                chosen.append(k)
                basis = np.vstack([basis, left / size])
    return chosen


@dataclass(frozen=True, eq=False)
class Ends:
    """Limits in other designs, and whether a design is one at all."""

    designs: Designs
    limits: int
    machine_code: bool

    @cached_property
    def _kernel(self) -> Kernel:
        traced = partial(limits_at, self.designs)
        return compiled(traced, self.designs.count, machine_code=self.machine_code)

    @cached_property
    def _decisions(self) -> tuple[BoolArray, BoolArray, BoolArray]:
        """Of each decision, whether it is strict, what it is in the file's own design, and whether
        it is only about being finite.
        """
        own = [np.array([a]) for a in self.designs.own]
        with np.errstate(all="ignore"):
            conditions = self.designs.opened(own, ARRAYS).conditions
        columns = np.array([(c.strict, c.holds, c.finite) for c in conditions], dtype=bool)
        strict, holds, finite = columns.reshape(-1, 3).T[:, :, None]
        return strict, holds, finite

    def at(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray, BoolArray]:
        """Lower and upper limits (limits, n) in designs (m, n), and which of these (n,) take all
        decisions as the file's own does.
        """
        strict, holds, finite = self._decisions
        out = np.empty((2 * self.limits + len(holds), parameters.shape[1]))
        if len(out):
            self._kernel(np.ascontiguousarray(parameters), out, False)
        margins = out[2 * self.limits :]
        alike = np.where(strict, margins > 0.0, margins >= 0.0) == holds
        sound = np.where(finite, np.isfinite(margins), alike & ~np.isnan(margins))
        good: BoolArray = np.logical_and.reduce(sound)
        return out[: self.limits], out[self.limits : 2 * self.limits], good
