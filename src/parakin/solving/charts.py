"""Charts: a plan, compiled, and where it no longer serves another one made further on.

A plan is good around the configuration that it was made at. Far from there its rows may say the
same twice, or the three angles of a joint be undefined, though the mechanism is as regular as
ever: `least_singular_value` knows, which looks at all closure rows and at no plan.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, TypeVar

import numpy as np

from parakin.algebra.spatial import as_array
from parakin.arrays import BoolArray, FloatArray, IndexArray
from parakin.caching import cached_property
from parakin.errors import ParakinError
from parakin.kernel.backends import Kernel, make_kernel
from parakin.kernel.outputs import Outputs
from parakin.kinematics import loops
from parakin.kinematics.closure import Row
from parakin.kinematics.configuration import (
    Configuration,
    circuits_at,
    configure,
    coordinate_scales,
)
from parakin.model.graph import Graph
from parakin.model.joints import GraphJoint
from parakin.motion.motion import Samples
from parakin.planning.ordering import plan_of, with_twins_read
from parakin.planning.plan import Block, Plan
from parakin.solving import columns
from parakin.solving.bodies import Figures, Points
from parakin.solving.columns import LANES
from parakin.solving.forces import Asked, Mechanics, wound
from parakin.solving.grip import least_singular_value, weak_rows
from parakin.solving.status import Layout, Triple, Watched
from parakin.solving.stops import LimitRows

_STEPS = 3  # Newton steps per run of a kernel: they reach round-off from 0.01 or 0.02 away
_OPEN = 1e-9  # characteristic lengths: an iterated block farther from closed has not been solved
_LOOSE = 10.0  # a home held more firmly than one over this costs no digits

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Chart:
    """A plan compiled for what is to be reported, the first `reported` of `outputs.coordinates`.

    relative_regularity: how firmly the mechanism is held where the plan was made, home being 1.
    """

    plan: Plan
    outputs: Outputs
    reported: int
    machine_code: bool
    relative_regularity: float = 1.0
    _figures: dict[tuple[object, ...], Figures] = field(default_factory=dict)
    _kept: dict[tuple[object, ...], Any] = field(default_factory=dict)

    @cached_property
    def layout(self) -> Layout:
        return layout_of(self.plan, self.outputs, self.reported)

    @cached_property
    def places(self) -> Mapping[int | str, int]:
        """The rows of positions, by coordinate."""
        return {c: row for row, c in enumerate(self.outputs.coordinates)}

    @cached_property
    def limits(self) -> LimitRows:
        return LimitRows.of(self.plan.graph, self.outputs)

    @cached_property
    def kernel(self) -> Kernel:
        return make_kernel(self.plan, self.outputs, machine_code=self.machine_code, steps=_STEPS)

    def run(self, inputs: FloatArray, *, parallel: bool = False) -> FloatArray:
        """Outputs (rows,) or (rows, n) of inputs alike."""
        count = self.outputs.count
        if inputs.ndim == 2:
            return columns.run(self.kernel, inputs, count, lanes=self.lanes, parallel=parallel)
        if self.lanes == 1:
            out = np.empty(count)
            self.kernel(inputs, out, False)
            return out
        alone = inputs[:, None]
        return columns.run(self.kernel, alone, count, lanes=self.lanes)[:, 0]

    @cached_property
    def lanes(self) -> int:
        """How many columns are computed together where their rounding matters: where Newton starts
        far off, the last digit may decide where it ends.
        """
        return LANES if self.machine_code and self.plan.iterated else 1

    def alone(self, inputs: FloatArray, guess: FloatArray) -> FloatArray:
        """Outputs (rows,) of one pose, rounded as in a batch."""
        whole = np.empty((len(inputs) + len(guess), self.lanes))
        whole[: len(inputs)], whole[len(inputs) :] = inputs[:, None], guess[:, None]
        out = np.empty((self.outputs.count, self.lanes))
        self.kernel(whole, out, False)
        return out[:, 0]

    def at_rest(self, driven: FloatArray, found: FloatArray) -> FloatArray:
        """Outputs (rows,) or (rows, n) at driven values (k,) or (k, n) without rates, from the
        iterated coordinates, alike.
        """
        still = np.zeros((self.outputs.derivatives * len(driven), *driven.shape[1:]))
        return self.run(np.concatenate([driven, still, found]))

    @cached_property
    def walker(self) -> Chart:
        """The chart that walks from home, with only the iterated coordinates and their rates.
        (Those with closed forms stay on their roots.)
        """
        outputs = Outputs(tuple(self.plan.iterated), derivatives=2)
        return Chart(self.plan, outputs, len(outputs.coordinates), self.machine_code)

    def figures(
        self, points: Points, samples: Samples, found: FloatArray, parallel: bool
    ) -> FloatArray:
        """`POINT` figures a point, (rows, n); `found` are the iterated coordinates (m, n)."""
        key = tuple(points.items())
        if key not in self._figures:  # kept, since a kernel takes a while to compile
            self._figures[key] = Figures.of(self.plan, points, machine_code=self.machine_code)
        return self._figures[key].at(samples, found, parallel)

    @cached_property
    def mechanics(self) -> Mechanics:
        return Mechanics(self.plan)

    def forces(
        self,
        asked: Asked,
        reference: float,
        samples: Samples,
        found: FloatArray,
        loads: FloatArray,
        angles: FloatArray,
        parallel: bool,
    ) -> FloatArray:
        """Rows of `ForceRows` (rows, n). reference: as of `Mechanics.rows`; found: the iterated
        coordinates (m, n); loads: what payloads and wrenches take; angles: of
        springs, `wound`, full turns counted.
        """
        rows = self.mechanics.rows(asked, reference)
        outputs = Outputs((), derivatives=2, checks=False, forces=rows)
        make = partial(make_kernel, self.plan, outputs, machine_code=self.machine_code, steps=1)
        kernel = self.kept((asked, reference), make)
        driven = (samples.position, samples.velocity, samples.acceleration)
        inputs = np.concatenate([*driven, found, loads, angles])
        return columns.run(kernel, inputs, outputs.count, parallel=parallel)

    def kept(self, key: tuple[object, ...], make: Callable[[], T]) -> T:
        """What is made of this chart, once, since it takes a while to compile."""
        if key not in self._kept:
            self._kept[key] = make()
        found: T = self._kept[key]
        return found

    def configuration(self, driven: FloatArray, out: FloatArray) -> Configuration:
        """All coordinates at a pose: driven ones (k,), and a column of outputs (rows,)."""
        q = self._coordinates(driven[:, None], out[:, None])[:, 0]
        return configure(self.plan.graph, self.plan.tree, q)

    def _coordinates(self, driven: FloatArray, out: FloatArray) -> FloatArray:
        """All coordinates (N, n) at poses: driven ones (k, n), and outputs (rows, n)."""
        plan = self.plan
        q = np.repeat(np.array(plan.home, dtype=float)[:, None], out.shape[1], axis=1)
        for row, k in enumerate(self.outputs.coordinates):
            if isinstance(k, int):
                q[k] = out[row] + plan.offset(k)
        offsets = [[plan.offset(k)] for k in plan.driven]
        counted = driven + offsets
        for k, entry in plan.affine.items():
            q[k] = entry.constant
            for j, factor in entry.factors:
                q[k] += factor * counted[plan.driven.index(j)]
        return q

    def open_blocks(self, driven: FloatArray, out: FloatArray) -> IndexArray:
        """For poses (k, n) that are not reached, with their outputs (rows, n), the block of the
        plan that cannot be closed: the first whose form has no root or, where it follows from one
        iterated that is open, that one; or else the one of those iterated that is farthest from
        closed; -1 where there is none.
        """
        blocks, place = self.plan.blocks, self.places
        found = np.full(out.shape[1], -1, dtype=np.intp)
        for number in reversed(range(len(blocks))):
            known = [place[k] for k in blocks[number].unknowns if k in place]
            if known:
                found[np.isnan(out[known[0]])] = number
        if not all(k in place for k in self.plan.unknowns):
            found = np.where(self._sure[found], found, -1)
            return self._first_open(found, driven, out)
        found = self._first_open(found, driven, out)
        rest = np.flatnonzero(found < 0)
        iterated = [number for number, block in enumerate(blocks) if block.iterated]
        if len(iterated) == 1:
            found[rest] = iterated[0]
        elif iterated and len(rest):
            q = self._coordinates(driven[:, rest], out[:, rest])
            gaps = np.array([self._gap(blocks[number], q) for number in iterated])
            found[rest] = np.array(iterated)[gaps.argmax(axis=0)]
        return found

    def _first_open(self, found: IndexArray, driven: FloatArray, out: FloatArray) -> IndexArray:
        """Blocks that have no root or, where one that they follow from is open, that one."""
        first = found.copy()
        for number in np.unique(found[found >= 0]).tolist():
            columns = np.flatnonzero(found == number)
            before = [k for k in self.plan.blocks_before(number) if self.plan.blocks[k].iterated]
            for k in reversed(before):
                q = self._coordinates(driven[:, columns], out[:, columns])
                gap = self._gap(self.plan.blocks[k], q)
                first[columns[gap > (_OPEN * self.plan.graph.length) ** 2]] = k
        return first

    @cached_property
    def _sure(self) -> BoolArray:
        """For each block, whether all blocks that it needs are known, so that it is the first that
        fails where it fails; and for none.
        """
        places, home = self.places, {k: b for b in self.plan.blocks for k in b.unknowns}

        def known(block: Block) -> bool:
            return all(k in places and known(home[k]) for k in block.needs if k in home)

        return np.array([*(known(block) for block in self.plan.blocks), False])

    def _gap(self, block: Block, q: FloatArray) -> FloatArray:
        """How far a block's rows are from closed [m], squared, at coordinates (N, n)."""
        circuits = circuits_at(self.plan.graph, self.plan.tree, q)
        total = np.zeros(q.shape[1])
        for row in block.rows:
            value = as_array(row.value(circuits, loops.ends(circuits, row.cut)))
            total = total + (row.per_length(self.plan.graph) * value) ** 2
        return np.nan_to_num(total, nan=np.inf)

    def coordinates_at(self, at: Configuration) -> FloatArray:
        """All coordinates of this chart's graph at a configuration of another's."""
        graph = self.plan.graph
        count = len(graph.plain.coordinates)
        q = np.array(self.plan.home, dtype=float)
        q[:count] = at.q[:count]
        if not graph.twins:
            return q
        return with_twins_read(graph, q).q

    @cached_property
    def _regularity_at_home(self) -> float:
        plan = self.plan
        return least_singular_value(plan, configure(plan.graph, plan.tree, plan.home))

    @cached_property
    def digits_factor(self) -> float:
        """A factor that makes conditioning tell how many digits are right: 1, or less if home
        itself is nearly singular.
        """
        return min(1.0, _LOOSE * self._regularity_at_home)

    def regularity(self, at: Configuration) -> float:
        """How firmly the loops hold a pose, driven coordinates given: 0 if singular, or if it is
        no pose at all, 1 at home.
        """
        if not np.isfinite(at.q).all():
            return 0.0
        return least_singular_value(self.plan, at) / self._regularity_at_home

    def replanned_at(self, at: Configuration, end: Configuration) -> Chart | None:
        """A chart for the same outputs around another configuration, if there is one; without the
        rows that lose their grip at `end`, where this one does not serve, if that can be.
        """
        graph = self.plan.graph.plain
        q = at.q[: len(graph.coordinates)]
        there = configure(graph, graph.posed_tree(), q)
        plan = self._planned(there, weak_rows(self.plan, end)) or self._planned(there, ())
        if plan is None:
            return None
        chosen = self.outputs.coordinates[: self.reported]
        watched = also_known(plan, chosen, plan.unknowns)
        outputs = replace(self.outputs, coordinates=(*chosen, *watched))
        relative_regularity = self.relative_regularity * min(1.0, self.regularity(at))
        return Chart(plan, outputs, self.reported, self.machine_code, relative_regularity)

    def _planned(self, there: Configuration, avoid: Collection[Row]) -> Plan | None:
        """A plan around a configuration that does without some rows, if there is one."""
        driven, graph = self.plan.driven, self.plan.graph.plain
        try:
            return plan_of(graph, driven, there, own_home=self.plan.own_home, avoid=avoid)
        except (ParakinError, np.linalg.LinAlgError):
            return None


def layout_of(plan: Plan, outputs: Outputs, reported: int) -> Layout:
    place = {c: row for row, c in enumerate(outputs.coordinates)}
    iterated = plan.iterated
    unknowns = [k for k in plan.unknowns if k in place]
    units = coordinate_scales(plan.graph)[unknowns]
    found = np.array([place[k] for k in iterated], dtype=np.intp)
    angles = [
        row
        for c, row in place.items()
        if isinstance(c, int)
        and plan.graph.coordinates[c].angle
        and c not in {*plan.affine, *iterated}
    ]
    orders = range(1 + outputs.derivatives)
    return Layout(
        outputs,
        reported,
        np.array([outputs.derivative(found, order) for order in orders]),
        np.array([place[k] for k in unknowns], dtype=np.intp),
        units,
        np.array(angles, dtype=np.intp),
        plan.unsigned,
        tuple(_triples(plan, outputs, reported)),
        tuple(row for c, row in place.items() if isinstance(c, str)),
        _watched(
            plan, outputs, {place[k]: u for k, u in zip(unknowns, units, strict=True)}, angles
        ),
    )


def _watched(
    plan: Plan, outputs: Outputs, units: Mapping[int, float], angles: Sequence[int]
) -> Watched:
    """units: by row, of what is solved for."""
    rows = sorted({*units, *angles})
    turning = [outputs.coordinates[row] for row in angles]
    return Watched(
        np.array(rows, dtype=np.intp),
        np.array([units.get(row, 1.0) for row in rows]),
        np.array([row in units for row in rows], dtype=bool),
        np.array([row in angles for row in rows], dtype=bool),
        np.array([plan.home[k] - plan.offset(k) for k in turning if isinstance(k, int)]),
    )


def _read_off(plan: Plan) -> list[GraphJoint]:
    """Joints of three turns whose angles are read off, and so are not defined everywhere."""
    solved = {*plan.affine, *plan.unknowns}
    joints = [joint for joint in plan.graph.plain.joints if len(joint.turns) == 3]
    return [joint for joint in joints if not solved.issuperset(joint.turns)]


def _triples(plan: Plan, outputs: Outputs, reported: int) -> Iterator[Triple]:
    """The angles of such joints, as far as any of them is reported or limited."""
    place = {c: row for row, c in enumerate(outputs.coordinates)}
    asked = {*outputs.coordinates[:reported], *counted(plan)}
    for joint in _read_off(plan):
        rows = [place[k] for k in joint.turns if k in place and k in asked]
        second = joint.turns[1]
        if rows and second in place:
            yield Triple(np.array(rows, dtype=np.intp), place[second], joint.proper)


def also_known(plan: Plan, chosen: Sequence[int | str], solved: Sequence[int]) -> list[int | str]:
    """Coordinates that must be known besides those chosen: those `solved` for; those that are
    limited; and the second of three angles, which decides whether the others are defined.
    """
    found: list[int | str] = [k for k in (*solved, *counted(plan)) if k not in chosen]
    found = list(dict.fromkeys(found))
    known = {*chosen, *found}
    seconds = [joint.turns[1] for joint in _read_off(plan) if known.intersection(joint.turns)]
    return [*found, *(k for k in seconds if k not in known)]


def counted(plan: Plan) -> list[int | str]:
    """Those whose full turns matter: limited ones, and angles with springs."""
    return [*limited(plan.graph), *wound(plan)]


def limited(graph: Graph) -> list[int | str]:
    """Coordinates, by number, and cone angles, by name, that have limits."""
    numbers = {c.name: k for k, c in enumerate(graph.coordinates)}
    return [numbers.get(limit.coordinate, limit.coordinate) for limit in graph.limited]
