"""Answers: from a kernel's outputs to a `Tick`, with a status for every pose."""

from __future__ import annotations

import numpy as np

from parakin.arrays import BoolArray, FloatArray, IndexArray, StatusArray
from parakin.caching import cached_property
from parakin.solving.atlas import Atlas
from parakin.solving.inputs import Guesses, Start
from parakin.solving.results import Labels
from parakin.solving.status import (
    RESIDUAL,
    SOLVED,
    UNREACHED,
    Status,
    are,
    blank_undefined,
    classify,
)
from parakin.solving.stops import LimitRows, Stopped
from parakin.solving.tick import Tick


class Answers:
    """The verdict on poses solved on the chart of home, and the `Tick` that reports it."""

    def __init__(self, atlas: Atlas, guesses: Guesses, labels: Labels) -> None:
        self.atlas, self.guesses, self.labels = atlas, guesses, labels
        self.outputs, self.layout = atlas.home.outputs, atlas.home.layout
        self.iterated = bool(atlas.home.plan.iterated)

    def judged(
        self,
        out: FloatArray,
        inputs: FloatArray,
        start: Start | None,
        walked: StatusArray | int,
        within: float | None,
        *,
        plain: bool,
        limits: LimitRows | None = None,
    ) -> Tick:
        """A status for each column, and NaN where it is one of failure. limits: those of each
        column's own design, if they are of other designs.
        """
        rows, columns = self.outputs, out[:, None] if out.ndim == 1 else out
        sound = None if plain else self.guesses.sound(inputs, start)
        found: FloatArray | None = None
        if rows.checks:
            status, found = self._checked(
                columns, inputs, start, walked, within, sound, elsewhere=limits is None
            )
        else:
            status = np.zeros(columns.shape[1], dtype=np.int8)
            status[np.isnan(columns[rows.motion]).any(axis=0)] = Status.OUT_OF_REACH
            if not isinstance(walked, int):
                status = np.where(walked, walked, status).astype(np.int8)
            if sound is not None:
                status[~sound] = Status.OUT_OF_REACH
        numbers = columns[rows.motion]
        if not plain or not rows.checks:
            known = np.delete(numbers, self._cone_rows, axis=0)
            beyond, open_ = np.isinf(known).any(axis=0), np.isnan(known).any(axis=0)
            open_ &= status == Status.CONVERGED
            status[open_ | (beyond & are(SOLVED, status))] = Status.OUT_OF_REACH
        undefined = status == Status.ANGLES_UNDEFINED
        stopped = self._stopped(columns, inputs, status, sound, limits) if rows.checks else None
        if status.any():
            numbers[:, ~are(SOLVED, status)] = np.nan
        residual: float | FloatArray = np.nan
        conditioning: float | FloatArray = np.nan
        verdict: int | StatusArray = int(status[0]) if out.ndim == 1 else status
        if rows.checks:
            residual, conditioning = out[rows.residual], out[rows.conditioning]
            if out.ndim == 1:
                residual, conditioning = float(residual), float(conditioning)
        tick = self.tick(out, verdict, residual, conditioning, stopped)
        if found is not None and undefined.any():
            found[:, ~are(SOLVED, status)] = np.nan
            tick = tick._replace(iterated=found[:, 0] if out.ndim == 1 else found)
        return tick

    def _checked(
        self,
        columns: FloatArray,
        inputs: FloatArray,
        start: Start | None,
        walked: StatusArray | int,
        within: float | None,
        sound: BoolArray | None,
        *,
        elsewhere: bool,
    ) -> tuple[StatusArray, FloatArray | None]:
        """Verdicts by residual and conditioning, and iterated coordinates (m, n) as they were
        before those that lock became NaN, where any may have. elsewhere: ask other charts, too.
        """
        found: FloatArray | None = None
        status = classify(columns, self.layout)
        singular = bool(status.any()) and bool((status == Status.SINGULAR).any())
        if self.iterated and (singular or self.layout.triples):
            found = columns[self.layout.iterated[0]]
        if not isinstance(walked, int) or walked:
            status = np.where(walked, walked, status).astype(np.int8)
        if sound is not None:
            status[~sound] = Status.OUT_OF_REACH
        if singular and elsewhere:
            self.atlas.exchange(columns, inputs, status)
        if within is not None and start is not None and self.iterated:
            begun = start.iterated if start.iterated.ndim == 2 else start.iterated[:, None]
            ended = columns[self.layout.iterated[0]] if found is None else found
            near = np.abs(ended - begun).max(axis=0) <= within
            status[are(SOLVED, status) & ~near] = Status.BRANCH_CHANGE
        if self.layout.undefined:
            undefined = blank_undefined(columns, self.layout)
            status[undefined & (status == Status.CONVERGED)] = Status.ANGLES_UNDEFINED
        return status, found

    def _stopped(
        self,
        columns: FloatArray,
        inputs: FloatArray,
        status: StatusArray,
        sound: BoolArray | None,
        limits: LimitRows | None,
    ) -> Stopped:
        """The limits exceeded, which flags a pose, and the limbs that cannot reach."""
        open_: BoolArray | None = None
        stopped = (limits or self.atlas.home.limits).stopped(columns)
        if status.any():
            solved = are(SOLVED, status)
            stopped.number[~solved], stopped.excess[~solved] = 0, np.nan
            rows = self.outputs
            closed = columns[rows.residual] <= RESIDUAL * columns[rows.size]
            open_ = are((*UNREACHED, Status.NOT_REACHED), status) & ~closed
        status[stopped.number > 0] = Status.LIMIT_EXCEEDED
        if open_ is None:
            return stopped
        if sound is not None:
            open_ &= sound
        # Which iterated block is open would be asked in the file's own design.
        if open_.any() and (limits is None or not self.iterated):
            chart = self.atlas.home
            driven = inputs.reshape(len(inputs), -1)[: len(chart.plan.driven), open_]
            stopped.number[open_] = self.atlas.loop_stops(chart, driven, columns[:, open_])
        return stopped

    def tick(
        self,
        out: FloatArray,
        status: int | StatusArray,
        residual: float | FloatArray,
        conditioning: float | FloatArray,
        stopped: Stopped | None = None,
    ) -> Tick:
        number: int | IndexArray = 0
        excess: float | FloatArray = np.nan
        if out.ndim == 2:
            number, excess = stopped or Stopped.by_nothing(out.shape[1])
        elif stopped is not None:
            number, excess = int(stopped.number[0]), float(stopped.excess[0])
        position, velocity, acceleration, jerk = self.reported_rows
        guesses, labels, none = self.guesses, self.labels, out[:0]
        return Tick._make(  # in the order of its fields: by name it takes twice as long
            (
                *(out[position], out[velocity], out[acceleration]),
                *(status, residual, conditioning, out[jerk] if jerk.stop else none),
                out[self.layout.iterated[0]] if guesses.hidden else none,
                *(labels.coordinates, labels.units, number, excess, labels.stops),
                out[guesses.turning] if len(guesses.turning) else none,
                *(None, None, False),
            )
        )

    @cached_property
    def reported_rows(self) -> list[slice]:
        """Rows of positions, and of each derivative, none where it is not known."""
        rows, count = self.outputs, self.layout.reported
        known = [rows.first(count, order) for order in range(1 + self.outputs.derivatives)]
        return known + [slice(0, 0)] * (4 - len(known))

    @cached_property
    def last_rows(self) -> slice:
        """Rows of the last derivative, which is no number where the others are none."""
        return self.reported_rows[self.outputs.derivatives]

    @cached_property
    def _cone_rows(self) -> list[int]:
        """Where cone angles are, whose rates are none where an angle is exactly zero."""
        at = [row for row, name in enumerate(self.outputs.coordinates) if isinstance(name, str)]
        orders = range(1, self.outputs.derivatives + 1)
        return [self.outputs.derivative(row, order) for order in orders for row in at]
