"""What `at` answers."""

from __future__ import annotations

from typing import NamedTuple

from parakin.arrays import FloatArray, StatusArray


class Tick(NamedTuple):
    """One pose, or a batch: rows are `solver.coordinates`, SI; `status` is a `Status` (array).

    Derivatives that the solver was not compiled for are arrays of no rows. `found` is what a next
    call needs in addition to `position` to start from here: iterated coordinates, where `position`
    does not have them.

    Not a Dataset because a control loop cannot wait for one.
    """

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    status: int | StatusArray
    residual: float | FloatArray
    conditioning: float | FloatArray
    jerk: FloatArray
    found: FloatArray
