"""The atlas of a solver: home's chart, and others made further on where that one does not serve."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from parakin.algebra.angles import nearest_angle
from parakin.arrays import FloatArray, IndexArray, StatusArray
from parakin.caching import cached_property
from parakin.kernel.outputs import POINT, Outputs
from parakin.kinematics.configuration import Configuration, coordinate_scales
from parakin.motion.motion import Samples
from parakin.solving.bodies import Points
from parakin.solving.charts import Chart, also_known
from parakin.solving.forces import Asked, Forces
from parakin.solving.status import Status, blank_undefined
from parakin.solving.stops import Stopped, stops_of
from parakin.solving.tracking import Piece
from parakin.solving.walking import REGULAR, carried_over, conditioning_beside, iterate


class Atlas:
    """`home`: the chart made at home. `outputs`: what any of them reports."""

    def __init__(self, home: Chart, outputs: Outputs) -> None:
        self.home, self.outputs = home, outputs
        self.stops = stops_of(home.plan)
        self._made: list[Chart] = []

    @cached_property
    def followed(self) -> Chart:
        """Home's chart, with all that a motion is followed by: whatever is solved for, and two
        derivatives. A solver of positions alone has it compiled when first it is needed.
        """
        home, solved = self.home, self.home.plan.unknowns
        known = home.outputs.coordinates
        if home.outputs.derivatives > 1 and home.outputs.checks and {*solved} <= {*known}:
            return home
        chosen = self.outputs.coordinates
        outputs = Outputs((*chosen, *also_known(home.plan, chosen, solved)), derivatives=2)
        return Chart(home.plan, outputs, len(chosen), home.machine_code)

    @cached_property
    def units(self) -> FloatArray:
        """Of driven coordinates: 1 for angles, else the characteristic length."""
        plan = self.home.plan
        return coordinate_scales(plan.graph.plain)[list(plan.driven)]

    @cached_property
    def angle_rows(self) -> list[int]:
        """Rows of what is reported that are angles."""
        known = self.home.plan.graph.plain.coordinates
        return [
            row
            for row, k in enumerate(self.outputs.coordinates)
            if isinstance(k, int) and k < len(known) and known[k].angle
        ]

    def others(self, chart: Chart, at: Configuration, end: Configuration) -> Iterator[Chart]:
        """Charts that may serve at a configuration; one does no more at `end`."""
        yield from [other for other in (self.followed, *self._made) if other is not chart]
        made = chart.replanned_at(at, end)
        if made is not None:
            self._made.append(made)
            yield made
            self._made.remove(made)  # it did not serve

    def reported(self, pieces: Sequence[Piece], n: int) -> FloatArray:
        """What is reported of n samples, all orders, then the checks; NaN where not solved."""
        outputs = self.outputs
        if len(pieces) == 1 and outputs == self.home.outputs:
            piece = pieces[0]
            if piece.chart is self.home and piece.stop - piece.start == n:
                return piece.out
        out = np.full((outputs.count, n), np.nan)
        for start, stop, chart, found in pieces:
            rows = chart.outputs
            for order in range(1 + outputs.derivatives):
                out[outputs.order(order), start:stop] = found[
                    rows.first(len(outputs.coordinates), order)
                ]
            out[outputs.figures, start:stop] = found[rows.figures]
            out[outputs.conditioning, start:stop] *= chart.relative_regularity
        return out

    def stopped(self, pieces: Sequence[Piece], n: int) -> Stopped:
        """The limits that n samples exceed."""
        if len(pieces) == 1 and pieces[0].stop - pieces[0].start == n:
            return pieces[0].chart.limits.stopped(pieces[0].out)
        found = Stopped.by_nothing(n)
        for start, stop, chart, out in pieces:
            inside = chart.limits.stopped(out)
            found.number[start:stop], found.excess[start:stop] = inside
        return found

    def loop_stops(self, chart: Chart, driven: FloatArray, out: FloatArray) -> IndexArray:
        """The numbers of the loops that poses (k, n) not reached cannot close, from a chart's
        outputs (rows, n) of them; 0 where that is not known.
        """
        numbers = self.stops.blocks
        if chart.plan is not self.home.plan:
            other = stops_of(chart.plan)
            numbers = tuple(self.stops.most_like(other.joints[k]) for k in other.blocks)
        open_ = chart.open_blocks(driven, out)  # -1 picks the last
        found: IndexArray = np.array([*numbers, 0], dtype=np.intp)[open_]
        return found

    def figures(
        self, points: Points, pieces: Sequence[Piece], samples: Samples, parallel: bool
    ) -> FloatArray:
        """`POINT` figures a point, (rows, n)."""
        figures = np.full((POINT * len(points), len(samples.time)), np.nan)
        for start, stop, chart, found in pieces:
            inside, guess = samples.cropped(start, stop), found[chart.layout.iterated[0]]
            figures[:, start:stop] = chart.figures(points, inside, guess, parallel)
        return figures

    def forces(
        self,
        asked: Asked,
        pieces: Sequence[Piece],
        samples: Samples,
        loads: FloatArray,
        parallel: bool,
    ) -> Forces:
        """The forces behind n samples; NaN where not solved."""
        mechanics = self.home.mechanics
        rows = mechanics.rows(asked, mechanics.reference)
        out = np.full((rows.count, len(samples.time)), np.nan)
        for start, stop, chart, found in pieces:
            inside, guess = samples.cropped(start, stop), found[chart.layout.iterated[0]]
            angles = found[[chart.places[k] for k in rows.wound]]
            out[:, start:stop] = chart.forces(
                asked, mechanics.reference, inside, guess, loads[:, start:stop], angles, parallel
            )
        return mechanics.forces(asked, rows, out)

    def exchange(self, out: FloatArray, inputs: FloatArray, status: StatusArray) -> None:
        """Write what other charts say of closed poses (columns) where only home's is singular."""
        chart, orders = self.followed, len(self.followed.layout.iterated)
        given = inputs.reshape(1 + self.outputs.derivatives, len(chart.plan.driven), -1)
        for column in np.flatnonzero(status == Status.SINGULAR).tolist():
            here = np.zeros((orders, given.shape[1], 1))
            here[: len(given), :, 0] = given[:, :, column]
            known = out[:, [column]]
            if chart is not self.home:
                known = iterate(chart, here.reshape(-1, 1), known[self.home.layout.iterated[0]])
            at = chart.configuration(here[0, :, 0], known[:, 0])
            regularity = chart.regularity(at)
            if not regularity > REGULAR:
                continue
            for other in self.others(chart, at, at):
                found = carried_over(other, here, at)
                if found is None:
                    continue
                figure = conditioning_beside(chart, other, here, found, self.units)
                if figure > 0.0:
                    found[other.outputs.conditioning] = min(1.0, regularity)
                    status[column] = self._transfer(out, column, other, found)
                elif figure < 0.0:
                    status[column] = Status.BRANCH_CHANGE
                break

    def _transfer(self, out: FloatArray, column: int, chart: Chart, found: FloatArray) -> Status:
        """Write what another chart found, angles by full turns nearest to what stands there."""
        undefined = bool(blank_undefined(found, chart.layout)[0])
        rows, place = self.home.outputs, chart.places
        shared = [(row, place[c]) for row, c in enumerate(rows.coordinates) if c in place]
        mine, theirs = np.array(shared, dtype=np.intp).reshape(-1, 2).T
        before = out[self.angle_rows, column]
        for order in range(1 + rows.derivatives):
            out[rows.derivative(mine, order), column] = found[
                chart.outputs.derivative(theirs, order), 0
            ]
        out[rows.figures, column] = found[chart.outputs.figures, 0]
        out[self.angle_rows, column] = nearest_angle(out[self.angle_rows, column], to=before)
        return Status.ANGLES_UNDEFINED if undefined else Status.CONVERGED
