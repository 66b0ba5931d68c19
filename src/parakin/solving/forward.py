"""Forward dynamics of a chart: from a state to its rates, compiled.

The state is the positions of the driven coordinates and of all that the plan solves for, the driven
coordinates' rates, and the work done: loops are closed in rates, and no position is solved for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from parakin.algebra.spatial import FLOATS, as_float
from parakin.arrays import FloatArray
from parakin.caching import cached_property
from parakin.errors import InputError
from parakin.kernel.backends import Kernel, Taylor, make_forward_kernel, make_taylor
from parakin.kernel.forward import ForwardRows, mass_matrix
from parakin.kernel.motion import motion_at, unit_motions
from parakin.kinematics.configuration import Configuration, configure, coordinate_scales
from parakin.model.graph import Graph
from parakin.planning.plan import Plan
from parakin.solving.applied import State
from parakin.solving.charts import Chart
from parakin.solving.forces import wound

_LIGHT = 1e-9  # of the largest mass that a freedom moves: less is none


@dataclass(frozen=True, eq=False)
class Forward:
    """Forward dynamics of a chart's plan, compiled."""

    chart: Chart
    rows: ForwardRows

    @classmethod
    def of(
        cls,
        chart: Chart,
        rest: float,
        actuated: Sequence[int] = (),
        *,
        servos: bool = False,
        asks: bool = False,
    ) -> Forward:
        """rest, servos: see `ForwardRows`. actuated: `actuated_of` its plan by default. asks:
        whether efforts may depend on all coordinates. Raises
        InputError where there is nothing that makes forces, friction that a simulation does not
        know, or an idle freedom, which would be held.
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
            idle, driven = (names_of(graph, numbers) for numbers in (plan.idle, plan.driven))
            found = f"{', '.join(idle)} idle, and so held"
            expected = f"them driven too: {', '.join([*driven, *idle])}"
            raise InputError(f"{where}: driven", found, expected)
        moved = tuple(actuated) or actuated_of(plan)
        turning = [k for k in moved if (servos or asks) and graph.coordinates[k].angle]
        counted = dict.fromkeys([*wound(plan), *turning])
        known = {*plan.driven, *plan.unknowns, *plan.affine}
        outside = tuple(k for k in counted if k not in known)
        seen = tuple(range(len(graph.plain.coordinates))) if asks else ()
        return cls(chart, ForwardRows(plan, moved, outside, rest, servos, seen=seen))

    @property
    def _key(self) -> tuple[object, ...]:
        rows = self.rows
        return rows.actuated, rows.wound, rows.rest, rows.servos, rows.told, rows.seen

    @cached_property
    def telling(self) -> Forward:
        """The same that also tells efforts, energies and how far loops are open."""
        return Forward(self.chart, replace(self.rows, told=True))

    def told(self, out: FloatArray) -> FloatArray:
        """Of what `telling` returned: efforts and rates of the actuated coordinates, kinetic and
        potential energy, power lost and applied, gap (2 m + 5,) or (2 m + 5, n).
        """
        after = self.rows.state + len(self.rows.plan.blocks)
        return out[after : after + 2 * len(self.rows.actuated) + 5]

    def figures(self, out: FloatArray) -> FloatArray:
        """Of what `run` returned, how well each block's rows determine its unknowns."""
        return out[self.rows.state : self.rows.state + len(self.rows.plan.blocks)]

    def seen(self, time: float, state: FloatArray, loads: FloatArray) -> State:
        """What a function of a state (s,) or (s, n) is told of it."""
        rows = self.rows
        nothing = np.zeros((rows.efforts, *state.shape[1:]))
        found = self.run(state, nothing, loads)[-2 * len(rows.seen) :]
        names = names_of(rows.plan.graph, rows.seen)
        values = found.tolist() if found.ndim == 1 else list(found)
        position = dict(zip(names, values[: len(names)], strict=True))
        return State(time, position, dict(zip(names, values[len(names) :], strict=True)))

    @cached_property
    def kernel(self) -> Kernel:
        make = partial(make_forward_kernel, self.rows, machine_code=self.chart.machine_code)
        return self.chart.kept(self._key, make)

    def taylor(self, rtol: float) -> Taylor:
        return self.chart.kept((*self._key, rtol), partial(make_taylor, self.rows, rtol))

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
            if values[0] > 0.0:
                part = values[0] / values[-1]
                found = f"{found} to speak of, {part:.1g} of what another one moves"
            expected = "masses, with inertia, of the bodies that it moves; or an armature"
            raise InputError(f"{plan.graph.mechanism.where}: bodies", found, expected)

    @cached_property
    def _ends(self) -> tuple[int, int, int, int]:
        """Where driven positions, unknowns, wound angles and driven rates end in a state."""
        n, m, w = len(self.rows.plan.driven), len(self.rows.plan.unknowns), len(self.rows.wound)
        return n, n + m, n + m + w, n + m + w + n

    def parts(self, state: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Driven positions, unknowns, wound angles, driven rates: of a state (s,) or (s, n)."""
        a, b, c, d = self._ends
        return state[:a], state[a:b], state[b:c], state[c:d]

    def state(self, at: Configuration, rates: FloatArray, work: float = 0.0) -> FloatArray:
        """A configuration, full turns counted, with the driven coordinates' rates and the work [J]
        done so far as a state.
        """
        plan, q = self.chart.plan, self.chart.coordinates_at(at)
        numbers = (*plan.driven, *plan.unknowns, *self.rows.wound)
        return np.array([*(q[k] - plan.offset(k) for k in numbers), *rates, work])

    def configuration(self, state: FloatArray) -> Configuration:
        """Of a state (s,), full turns counted."""
        plan = self.chart.plan
        q = np.array(plan.home, dtype=float)
        numbers = (*plan.driven, *plan.unknowns, *self.rows.wound)
        for k, value in zip(numbers, state, strict=False):
            q[k] = value + plan.offset(k)
        for k, rule in plan.affine.items():
            q[k] = rule.constant + sum(factor * q[j] for j, factor in rule.factors)
        return configure(plan.graph, plan.tree, q)

    def scales(self) -> FloatArray:
        """Of a state (s,): what is of the size of one radian, or a characteristic length."""
        plan = self.chart.plan
        numbers = [*plan.driven, *plan.unknowns, *self.rows.wound, *plan.driven]
        return np.array([*coordinate_scales(plan.graph)[numbers], 1.0])

    def run(
        self, state: FloatArray, efforts: FloatArray, loads: FloatArray, *, parallel: bool = False
    ) -> FloatArray:
        """The rates of a state, (s,) or (s, n), and below them the figures of its blocks."""
        out = np.empty((self.rows.count, *state.shape[1:]))
        inputs = np.ascontiguousarray(np.concatenate((state, efforts, loads)))
        self.kernel(inputs, out, parallel)
        return np.concatenate((state[self._ends[2] : self._ends[3]], out))


def actuated_of(plan: Plan) -> tuple[int, ...]:
    """The actuated coordinates or, if the file names none, those driven by joints."""
    graph = plan.graph.plain
    found = tuple(k for k, c in enumerate(graph.coordinates) if c.actuated)
    joints = (k for k in plan.driven if graph.coordinates[k].joint != graph.platform)
    return found or tuple(joints)


def names_of(graph: Graph, numbers: Sequence[int]) -> list[str]:
    """Of coordinates."""
    return [graph.coordinates[k].name for k in numbers]
