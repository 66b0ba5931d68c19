"""A solver bound to arrays of its own, for control loops in which every microsecond counts."""

from __future__ import annotations

import math

import numpy as np

from parakin.solving.inputs import WILD
from parakin.solving.poses import Poses
from parakin.solving.status import RESIDUAL, SINGULAR, SOLVED
from parakin.solving.tick import Tick


class Bound:
    """A solver and its arrays, made by `Solver.bound`: write driven values into `y`, `yd` and
    `ydd` (k,), call `solve`, read `position`, `velocity` and `acceleration` (rows of
    `Solver.coordinates`, SI), which the next call overwrites. Derivatives that the solver was not
    compiled for have no rows.
    """

    def __init__(self, poses: Poses) -> None:
        answers = poses.answers
        chart, outputs = answers.atlas.home, answers.outputs
        k, orders = len(chart.plan.driven), 1 + outputs.derivatives
        self._inputs, self._out = np.zeros(orders * k), np.full(outputs.count, np.nan)
        given = [self._inputs[k * order : k * (order + 1)] for order in range(orders)]
        self.y, self.yd, self.ydd = (*given, *[self._inputs[:0]] * 2)[:3]
        self.position, self.velocity, self.acceleration, _ = (
            self._out[rows] for rows in answers.reported_rows
        )
        self._poses, self._iterated = poses, answers.iterated
        self._start: Tick | None = None
        self._short = outputs.checks and not answers.iterated
        self._kernel, self._figures = chart.kernel, outputs.figures
        self._defined = answers.layout.plainly_defined
        self._kept, self._why = chart.limits.kept, ""

    def solve(self) -> int:
        """Solve for what stands in `y`, `yd` and `ydd`. Returns the status.

        All is as of `Solver.at` without a guess, but that what is iterated starts from the last
        pose that was solved: angles are within half a turn of home, and a pose that is not solved
        is NaN throughout.
        """
        if self._short:
            self._kernel(self._inputs, self._out, False)
            residual, conditioning, _, size, _ = self._out[self._figures].tolist()
            closed = residual <= RESIDUAL * size and conditioning >= SINGULAR
            bounded = math.hypot(*self._inputs.tolist()) < WILD  # false of NaN
            if closed and bounded and self._defined(self._out) and self._kept(self._out):
                self._why = ""
                return 0
        return self._at_length()

    @property
    def why(self) -> str:
        """What stopped the last pose, as `Tick.why`; "" where nothing did."""
        return self._why

    def _at_length(self) -> int:
        tick = self._poses.at(self._inputs.copy(), self._start, None, parallel=False)
        self.position[:] = tick.position
        self.velocity[:] = tick.velocity
        self.acceleration[:] = tick.acceleration
        status = int(tick.status)
        if self._iterated and status in SOLVED:
            self._start = tick
        self._why = tick.why()
        return status
