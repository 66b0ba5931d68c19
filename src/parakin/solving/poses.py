"""Poses of the file's own design: solved, one for a control loop or a batch, and judged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from parakin.arrays import FloatArray, StatusArray
from parakin.solving.answers import Answers
from parakin.solving.from_home import from_guess
from parakin.solving.inputs import all_bounded
from parakin.solving.locks import Locks
from parakin.solving.status import RESIDUAL, SINGULAR
from parakin.solving.tick import Tick


@dataclass(frozen=True, slots=True)
class Poses:
    """How a solver answers for poses. A sound one alone takes the short way, without arrays of
    status.
    """

    answers: Answers
    locks: Locks

    def at(
        self,
        inputs: FloatArray,
        guess: ArrayLike | Tick | None,
        within: float | None,
        *,
        parallel: bool,
    ) -> Tick:
        """As `Solver.at`: inputs (orders k,) or (orders k, n)."""
        answers, guesses = self.answers, self.answers.guesses
        chart, outputs = answers.atlas.home, answers.outputs
        start = None if guess is None else guesses.start_of(guess, inputs.shape[1:])
        walked: StatusArray | int = 0
        if answers.iterated:
            known = None if start is None else start.iterated
            out, walked = from_guess(answers.atlas, self.locks, inputs, known)
        else:
            out = chart.run(inputs, parallel=parallel)
        plain = guesses.turned_to(out, start) if start is not None else True
        checked = outputs.checks
        plain = plain and (
            all_bounded(inputs) if checked else all_bounded(inputs, out[answers.last_rows])
        )
        if plain and not checked:
            good = 0 if out.ndim == 1 else np.zeros(out.shape[1], dtype=np.int8)
            return answers.tick(out, good, np.nan, np.nan)
        alone = out.ndim == 1 and within is None and not walked
        if plain and alone and answers.layout.plainly_defined(out):
            residual, conditioning, _, size, _ = out[outputs.figures].tolist()
            closed = residual <= RESIDUAL * size and conditioning >= SINGULAR
            if closed and chart.limits.kept(out):
                return answers.tick(out, 0, residual, conditioning)
        return answers.judged(out, inputs, start, walked, within, plain=plain)
