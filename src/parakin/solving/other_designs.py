"""Poses of other designs: parameters that were left open are inputs of the kernel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from parakin.algebra.angles import nearest_angle
from parakin.algebra.spatial import ARRAYS
from parakin.arrays import FloatArray, StatusArray
from parakin.caching import cached_property
from parakin.errors import InputError, nearest
from parakin.kernel.outputs import Outputs
from parakin.kinematics.configuration import coordinate_scales
from parakin.model.designs import Designs
from parakin.model.expressions import Value
from parakin.planning.plan import Plan
from parakin.solving.answers import Answers
from parakin.solving.atlas import Atlas
from parakin.solving.charts import Chart
from parakin.solving.homes import Ends, Homes
from parakin.solving.inputs import Guesses, Start
from parakin.solving.results import Labels
from parakin.solving.status import Status, classify
from parakin.solving.stops import LimitRows
from parakin.solving.tick import Tick
from parakin.solving.walking import State, iterate, walk

_SAME = 1e-6  # radians and characteristic lengths between a home as walked to and as solved for


class Given(NamedTuple):
    """Designs, a column each: parameters (m, n), homes of coordinates by number (n,), a status each
    (n,), and lower and upper limits (limits, n).
    """

    parameters: FloatArray
    home: Mapping[int, FloatArray]
    status: StatusArray
    low: FloatArray
    high: FloatArray

    def rows(self, plan: Plan, coordinates: Sequence[int | str]) -> FloatArray:
        """What a kernel of these coordinates takes of them (g, n)."""
        standing = [self.home[k] for k in plan.standing(coordinates)]
        n = self.parameters.shape[1]
        return np.concatenate([self.parameters, np.array(standing).reshape(len(standing), n)])

    def spread(self, of: Any) -> Given:
        """These columns of it."""
        home = {k: value[of] for k, value in self.home.items()}
        return Given(
            self.parameters[:, of], home, self.status[of], self.low[:, of], self.high[:, of]
        )


@dataclass(frozen=True, eq=False)
class OtherDesigns:
    """How a solver answers for other designs than the file's own."""

    designs: Designs
    chart: Chart
    homes: Homes
    answers: Answers
    guesses: Guesses
    _last: list[tuple[bytes, Given]] = field(default_factory=list)

    @staticmethod
    def of(homes: Homes, chart: Chart, guesses: Guesses, labels: Labels) -> OtherDesigns:
        """chart: a solver's own."""
        designs = homes.plan.designs
        assert designs is not None
        opened = Chart(
            replace(chart.plan, designs=designs), chart.outputs, chart.reported, chart.machine_code
        )
        atlas = Atlas(opened, labels.rows)
        return OtherDesigns(designs, opened, homes, Answers(atlas, guesses, labels), guesses)

    def at(
        self,
        inputs: FloatArray,
        guess: ArrayLike | Tick | None,
        within: float | None,
        parameters: Mapping[str, Value | ArrayLike],
        *,
        parallel: bool,
    ) -> Tick:
        """As `Solver.at`, in the designs that these parameters make: inputs (orders k,) or
        (orders k, n), one design or n.
        """
        values = self.values(parameters)
        alone = inputs.ndim == 1 and values.ndim == 1
        columns = inputs[:, None] if inputs.ndim == 1 else inputs
        n = columns.shape[1]
        if values.ndim == 2 and values.shape[1] != n:
            if inputs.ndim == 2:
                found = f"{values.shape[1]} designs, {n} poses"
                raise InputError("parameters", found, "one design, or one for each pose")
            n = values.shape[1]
            columns = columns.repeat(n, axis=1)
        given = self.given(values, n)
        shape = () if alone else (n,)
        start = None if guess is None else self.guesses.start_of(guess, shape)
        out, status, rows = self._solved(columns, start, given, parallel=parallel)
        if start is None:
            self._turned_home(out, given)
        else:
            self.guesses.turned_to(out, start)
        if alone:
            out, rows = np.ascontiguousarray(out[:, 0]), rows[:, 0]
        tick = self.answers.judged(
            out, rows, start, status, within, plain=False, limits=self._limits(given)
        )
        low, high = self._ends(given.low), self._ends(given.high)
        if alone:
            no_design = bool(given.status[0])
            return tick._replace(ends=(low[:, 0], high[:, 0]), no_design=no_design)
        return tick._replace(ends=(low, high), no_design=given.status != 0)

    def _solved(
        self, columns: FloatArray, start: Start | None, given: Given, *, parallel: bool
    ) -> tuple[FloatArray, StatusArray, FloatArray]:
        """Outputs (rows, n), what became of designs and ways, and what the kernel was given."""
        chart, n = self.chart, columns.shape[1]
        told = given.rows(chart.plan, chart.outputs.coordinates)
        rows = np.ascontiguousarray(np.concatenate([columns, told]))
        if not chart.plan.iterated:
            return chart.run(rows, parallel=parallel), given.status, rows
        status = given.status
        if start is None:
            guess, walked = self._walked(columns[: len(chart.plan.driven)], given)
            status = np.where(status, status, walked).astype(np.int8)
        else:
            guess = start.iterated if start.iterated.ndim == 2 else start.iterated[:, None]
            guess = np.broadcast_to(guess, (len(guess), n))
        return iterate(chart, rows, guess), status, rows

    def _turned_home(self, out: FloatArray, given: Given) -> None:
        """Turn angles to within half a turn of where they are at their design's home."""
        plan, layout = self.chart.plan, self.chart.layout
        for row in layout.angles.tolist():
            k = self.chart.outputs.coordinates[row]
            if isinstance(k, int) and k in given.home and k not in plan.graph.from_home:
                out[row] = nearest_angle(out[row], to=given.home[k])

    def _walked(self, goal: FloatArray, given: Given) -> tuple[FloatArray, StatusArray]:
        """Iterated coordinates (m, n) from which poses (k, n) are found, each by a straight way
        from its design's home, and what became of the way.
        """
        walker, orders, n = self.chart.walker, 3, goal.shape[1]
        driven = np.zeros((orders, len(goal), n))
        iterated = np.zeros((orders, len(walker.plan.iterated), n))
        driven[0] = self._counted(walker.plan.driven, given)
        iterated[0] = self._counted(walker.plan.iterated, given)
        told = given.rows(walker.plan, walker.outputs.coordinates)
        begin = State(driven, iterated, told)
        out, status, _ = walk(walker, begin, goal, self.answers.atlas.units)
        return out[walker.layout.iterated[0]], status

    def _counted(self, coordinates: Sequence[int], given: Given) -> FloatArray:
        """Coordinates (q, n) at home, as they are counted."""
        plan, n = self.chart.plan, given.parameters.shape[1]
        found = np.zeros((len(coordinates), n))
        for row, k in enumerate(coordinates):
            if k not in plan.graph.from_home:
                found[row] = given.home.get(k, np.full(n, plan.home[k]))
        return found

    def values(self, parameters: Mapping[str, Value | ArrayLike]) -> FloatArray:
        """Parameters left open [SI], (m,) or (m, n); those not given follow from the others as the
        file says. Raises InputError on unknown names, and on values of the wrong shape.
        """
        if not isinstance(parameters, Mapping):
            raise InputError("parameters", repr(parameters), "values by the names of parameters")
        given: dict[str, FloatArray] = {}
        texts: dict[str, str] = {}
        for name, value in parameters.items():
            place = f"parameters.{name}"
            if name not in self.designs.names:
                expected = nearest(str(name), self.designs.names)
                raise InputError(place, "a parameter that is not left open", expected)
            if isinstance(value, str):
                texts[name] = value
                continue
            try:
                given[name] = np.asarray(value, dtype=float)
            except (TypeError, ValueError) as error:
                raise InputError(place, str(error), "numbers") from None
        shapes = {value.shape for value in given.values() if value.shape}
        if len(shapes) > 1 or any(len(shape) > 1 for shape in shapes):
            found = ", ".join(str(shape) for shape in sorted(shapes))
            raise InputError("parameters", f"shapes {found}", "numbers, or arrays of one length")
        shape = shapes.pop() if shapes else ()
        with np.errstate(all="ignore"):  # what has no value is NaN, and flagged
            followed = self.designs.followed(given, ARRAYS, texts)
        return np.array([np.broadcast_to(value, shape) for value in followed], dtype=float)

    def given(self, values: FloatArray, n: int) -> Given:
        """Everything about designs (m,), (m, 1) or (m, n), for n poses."""
        values = values if values.ndim == 2 else values[:, None]
        if not n:
            return self._kept(self.designs.own[:, None]).spread(np.zeros(0, dtype=np.intp))
        if values.shape[1] == 1:
            return self._kept(values).spread(np.zeros(n, dtype=np.intp))
        different, which = np.unique(values, axis=1, return_inverse=True)
        return self._kept(np.ascontiguousarray(different)).spread(which.reshape(-1))

    def _kept(self, values: FloatArray) -> Given:
        """Everything about designs (m, n), those asked for last being kept."""
        key = values.tobytes()
        for known, found in self._last:
            if known == key:
                return found
        found = self._found(values)
        self._last[:] = [(key, found)]
        return found

    def _found(self, values: FloatArray) -> Given:
        stood = self.homes.at(values)
        low, high, sound = self._bounds.at(values)
        status = stood.status.copy()
        status[~sound & (status == Status.CONVERGED)] = Status.OUT_OF_REACH
        home = dict(zip(self.homes.rows.coordinates, stood.coordinates, strict=True))
        given = Given(values, home, status, low, high)
        if {*self.homes.plan.driven} != {*self.chart.plan.driven}:
            self._check_branch(given)
        return given

    def _check_branch(self, given: Given) -> None:
        """Flag designs at whose home what is driven here determines another assembly, or none: on
        the way there, which something else drives, a singularity of this plan was passed.
        """
        chart, plan = self._at_home, self.chart.plan
        told = given.rows(plan, chart.outputs.coordinates)
        inputs = [self._counted(plan.driven, given), told, self._counted(plan.iterated, given)]
        with np.errstate(all="ignore"):
            out = chart.run(np.ascontiguousarray(np.concatenate(inputs)))
            found = classify(out, chart.layout)
            known = [k for k in chart.outputs.coordinates if isinstance(k, int)]
            units = coordinate_scales(plan.graph)[known][:, None]
            off = (out[: len(known)] - self._counted(known, given)) / units
            angles = np.array([plan.graph.coordinates[k].angle for k in known])[:, None]
            off = np.where(angles, nearest_angle(off), off)
        same = (np.abs(off) < _SAME).all(axis=0)
        found[(found == Status.CONVERGED) & ~same] = Status.BRANCH_CHANGE
        given.status[:] = np.where(given.status, given.status, found)

    @cached_property
    def _at_home(self) -> Chart:
        """A chart that tells whatever is solved for, at any design's home."""
        count = len(self.chart.plan.graph.plain.coordinates)
        solved: tuple[int | str, ...] = tuple(k for k in self.chart.plan.unknowns if k < count)
        outputs = Outputs(solved, derivatives=0)
        return Chart(self.chart.plan, outputs, len(solved), self.chart.machine_code)

    @cached_property
    def _bounds(self) -> Ends:
        limits = len(self.chart.plan.graph.limited)
        return Ends(self.designs, limits, self.chart.machine_code)

    def _limits(self, given: Given) -> LimitRows:
        limits = self.chart.limits
        place = limits.numbers - 1
        return replace(limits, low=given.low[place], high=given.high[place])

    def _ends(self, limits: FloatArray) -> FloatArray:
        """By number of the stop (stops, n), NaN where there is no limit."""
        count = len(self.answers.labels.stops.names)
        found = np.full((count, limits.shape[1]), np.nan)
        found[1 : 1 + len(limits)] = limits
        return found
