"""Charts: a plan, compiled, and where it no longer serves another one made further on.

A plan is good around the configuration that it was made at. Far from there its rows may say the
same twice, or the three angles of a joint be undefined, though the mechanism is as regular as
ever: `least_singular_value` knows, which looks at all closure rows and at no plan.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from parakin.arrays import FloatArray
from parakin.caching import cached_property
from parakin.errors import ParakinError
from parakin.kernel.backends import Kernel, make_kernel
from parakin.kernel.outputs import Outputs
from parakin.kinematics.configuration import (
    Configuration,
    closure_system,
    configure,
    coordinate_scales,
    full_screws,
    loop_signs,
)
from parakin.model.graph import Tree
from parakin.model.joints import GraphJoint
from parakin.motion.motion import Samples
from parakin.planning.ordering import plan_of
from parakin.planning.plan import Plan
from parakin.solving.bodies import Figures, Points
from parakin.solving.status import Layout, Triple, Watched

_STEPS = 3  # Newton steps per run of a kernel: they reach round-off from 0.01 or 0.02 away
_LOOSE = 10.0  # a home held more firmly than one over this costs no digits
LANES = 8  # columns that machine code computes together: this many, or a divisor
_SPREAD = 8192  # columns; smaller batches are not worth a second core


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

    @cached_property
    def layout(self) -> Layout:
        return layout_of(self.plan, self.outputs, self.reported)

    @cached_property
    def kernel(self) -> Kernel:
        return make_kernel(self.plan, self.outputs, machine_code=self.machine_code, steps=_STEPS)

    def run(self, inputs: FloatArray, *, parallel: bool = False) -> FloatArray:
        """Outputs (rows,) or (rows, n) of inputs alike."""
        if self.lanes > 1 and (inputs.ndim == 1 or inputs.shape[1] % LANES):
            return self._run_in_lanes(inputs, parallel=parallel)
        out = np.empty((self.outputs.count, *inputs.shape[1:]))
        self.kernel(inputs, out, parallel and inputs.shape[-1] >= _SPREAD)
        return out

    @cached_property
    def lanes(self) -> int:
        """How many columns are computed together where their rounding matters."""
        return LANES if self.machine_code and self.plan.iterated else 1

    def _run_in_lanes(self, inputs: FloatArray, *, parallel: bool) -> FloatArray:
        """Run with columns filled up to whole vectors. Where Newton starts far off, the last digit
        may decide where it ends, and machine code rounds columns left over differently.
        """
        columns = inputs[:, None] if inputs.ndim == 1 else inputs
        n = columns.shape[1]
        whole = np.empty((len(inputs), n + -n % LANES))
        whole[:, :n], whole[:, n:] = columns, columns[:, -1:]
        out = np.empty((self.outputs.count, whole.shape[1]))
        self.kernel(whole, out, parallel and n >= _SPREAD)
        return out[:, 0] if inputs.ndim == 1 else out[:, :n]

    def alone(self, inputs: FloatArray, guess: FloatArray) -> FloatArray:
        """Outputs (rows,) of one pose, rounded as in a batch."""
        whole = np.empty((len(inputs) + len(guess), self.lanes))
        whole[: len(inputs)], whole[len(inputs) :] = inputs[:, None], guess[:, None]
        out = np.empty((self.outputs.count, self.lanes))
        self.kernel(whole, out, False)
        return out[:, 0]

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

    def configuration(self, driven: FloatArray, out: FloatArray) -> Configuration:
        """All coordinates at a pose: driven ones (k,), and a column of outputs (rows,)."""
        plan = self.plan
        q = np.array(plan.home, dtype=float)
        for row, k in enumerate(self.outputs.coordinates):
            if isinstance(k, int):
                q[k] = out[row] + plan.offset(k)
        counted = np.array([y + plan.offset(k) for k, y in zip(plan.driven, driven, strict=True)])
        for k, entry in plan.affine.items():
            q[k] = entry.constant
            for j, factor in entry.factors:
                q[k] += factor * counted[plan.driven.index(j)]
        return configure(plan.graph, plan.tree, q)

    def coordinates_at(self, at: Configuration) -> FloatArray:
        """All coordinates of this chart's graph at a configuration of another's."""
        graph = self.plan.graph
        count = len(graph.plain.coordinates)
        q = np.array(self.plan.home, dtype=float)
        q[:count] = at.q[:count]
        if not graph.twins:
            return q
        tree = graph.plain.posed_tree()
        read = Tree(tree.steps, (*tree.cuts, *graph.twins.values()))
        return configure(graph, read, q).q

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

    def replanned_at(self, at: Configuration) -> Chart | None:
        """A chart for the same outputs around another configuration, if there is one."""
        graph = self.plan.graph.plain
        q = at.q[: len(graph.coordinates)]
        try:
            there = configure(graph, graph.posed_tree(), q)
            plan = plan_of(graph, self.plan.driven, there, own_home=self.plan.own_home)
        except (ParakinError, np.linalg.LinAlgError):
            return None
        chosen = self.outputs.coordinates[: self.reported]
        watched = also_known(plan, chosen, plan.unknowns)
        outputs = replace(self.outputs, coordinates=(*chosen, *watched))
        relative_regularity = self.relative_regularity * min(1.0, self.regularity(at))
        return Chart(plan, outputs, self.reported, self.machine_code, relative_regularity)


def least_singular_value(plan: Plan, at: Configuration) -> float:
    """The least singular value of all closure rows by all coordinates that are not driven.

    `at` is a configuration in the plan's tree. Joints of three turns count by three axes at right
    angles, whatever their angles.
    """
    graph, tree = plan.graph, plan.tree
    held = {*plan.driven, *plan.idle}
    free = [k for k in graph.tree_coordinates(tree) if k not in held]
    if not free:
        return 1.0
    at = replace(at, screws=full_screws(graph, at, held))
    _, jacobian, _ = closure_system(graph, tree, at, loop_signs(graph, tree))
    matrix = jacobian[:, free] * coordinate_scales(graph)[free]
    values = np.linalg.svd(matrix, compute_uv=False)
    return float(values[-1]) if len(matrix) >= len(free) else 0.0


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
    """The angles of such joints, as far as any of them is reported."""
    place = {c: row for row, c in enumerate(outputs.coordinates)}
    for joint in _read_off(plan):
        rows = [place[k] for k in joint.turns if place.get(k, reported) < reported]
        second = joint.turns[1]
        if rows and second in place:
            yield Triple(np.array(rows, dtype=np.intp), place[second], joint.proper)


def also_known(plan: Plan, chosen: Sequence[int | str], solved: Sequence[int]) -> list[int]:
    """Coordinates that must be known besides those chosen: those `solved` for, and the second of
    three angles, which decides whether the others are defined.
    """
    found = [k for k in solved if k not in chosen]
    known = {*chosen, *found}
    seconds = [joint.turns[1] for joint in _read_off(plan) if known.intersection(joint.turns)]
    return [*found, *(k for k in seconds if k not in known)]
