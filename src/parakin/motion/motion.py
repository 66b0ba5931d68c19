"""Motions: what drives a mechanism over time, as position, velocity, acceleration and jerk.

A motion is made from laws of time, whose derivatives are exact, or from samples, whose
derivatives are given with them or follow from a quintic spline. SI: seconds, metres, radians.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from parakin.arrays import FloatArray
from parakin.errors import InputError, nearest
from parakin.model.validation import refuse_control
from parakin.motion.checks import refuse_repeated

MAX_SAMPLES = 10**9


class Samples(NamedTuple):
    """Consecutive samples; each array is C-contiguous, and the caller may change it."""

    time: FloatArray  # (n,) [s]
    position: FloatArray  # (k, n) [m or rad], a row per driven coordinate
    velocity: FloatArray  # (k, n) [per s]
    acceleration: FloatArray  # (k, n) [per s²]
    jerk: FloatArray | None = None  # (k, n) [per s³], where it is known

    @property
    def orders(self) -> tuple[FloatArray, ...]:
        """Position and the known derivatives."""
        known = (self.position, self.velocity, self.acceleration)
        return known if self.jerk is None else (*known, self.jerk)

    def cropped(self, start: int, stop: int) -> Samples:
        """The samples from `start` to before `stop`, as views."""
        return Samples(self.time[start:stop], *(order[:, start:stop] for order in self.orders))


@dataclass(frozen=True)
class Motion:
    """`count` samples of the driven `coordinates`. It can be pickled if its functions can.

    window: gives the samples from start to before stop, computed on demand, so that a long
    motion takes no memory. derivatives: where velocity and acceleration come from. between:
    gives the motion at any times (n,) [s], if known; otherwise it is the quintic from sample to
    sample that keeps their derivatives. knots: [s] between which it is smooth, from first to
    last. period: the shortest time [s] in which it changes. noise: what of its values may be that
    of an integration, and so no motion. Raises InputError on control characters in its name.
    """

    name: str
    coordinates: tuple[str, ...]
    count: int
    window: Callable[[int, int], Samples]
    derivatives: str
    between: Callable[[FloatArray], Samples] | None = None
    knots: tuple[float, ...] = ()
    period: float = np.inf
    noise: float = 0.0

    def __post_init__(self) -> None:
        refuse_control(self.name, "motion")

    def samples(self) -> Samples:
        """All samples at once."""
        return self.window(0, self.count)

    def reordered(self, coordinates: Sequence[str]) -> Motion:
        """The motion with its rows in the order of `coordinates`.

        Raises InputError unless these are its own coordinates, each once.
        """
        place = f"motion {self.name!r}"
        for name in coordinates:
            if name not in self.coordinates:
                raise InputError(place, f"no {name!r}", nearest(name, self.coordinates))
        for name in self.coordinates:
            if name not in coordinates:
                raise InputError(place, f"{name!r}, not driven", nearest(name, coordinates))
        refuse_repeated(coordinates, place)
        rows = [self.coordinates.index(name) for name in coordinates]
        if rows == list(range(len(rows))):
            return self
        return replace(
            self,
            coordinates=tuple(coordinates),
            window=partial(_reordered, self.window, rows),
            between=None if self.between is None else partial(_reordered, self.between, rows),
        )


def _reordered(given: Callable[..., Samples], rows: Sequence[int], *at: Any) -> Samples:
    """The samples given at a window or times, their rows in another order."""
    samples = given(*at)
    return Samples(samples.time, *(order[rows] for order in samples.orders))
