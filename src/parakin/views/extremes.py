"""The extremes of a result, accumulated over its windows, as a long motion is never held whole."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from parakin.arrays import ORDERS, FloatArray, IntArray
from parakin.solving.results import flag_words
from parakin.solving.status import Status
from parakin.views.force_extremes import ForceExtremes, force_extremes
from parakin.views.ranges import Range

if TYPE_CHECKING:
    from parakin.labelled import Result


class Flag(NamedTuple):
    """A flagged sample: its number, time [s], status, and both in words."""

    sample: int
    time: float
    status: Status
    words: str


@dataclass
class Extremes:
    """The least and greatest position, velocity, acceleration and, if the result has it, jerk of
    each coordinate (orders, n) [SI], with their times [s]; NaN if nothing is solved.

    `counts`: samples by status; `first_flag`: the first flagged sample; `met`: all
    limits and loops that stopped it, and when first, in words; `forces`, if the result has them.
    """

    coordinates: Sequence[str]
    low: FloatArray
    high: FloatArray
    low_time: FloatArray
    high_time: FloatArray
    counts: IntArray
    residual: float = 0.0
    conditioning: float = 1.0
    samples: int = 0
    first_flag: Flag | None = None
    met: str = ""
    forces: ForceExtremes | None = None

    def peak(self, order: int, k: int) -> tuple[float, float]:
        """The largest magnitude of a derivative of coordinate k, and its time."""
        low, high = float(self.low[order, k]), float(self.high[order, k])
        if abs(low) > abs(high):
            return abs(low), float(self.low_time[order, k])
        return abs(high), float(self.high_time[order, k])


def extremes(ds: Result, before: Extremes | None = None) -> Extremes:
    """The extremes of a result, or of one more window. `before` is updated."""
    orders = [order for order in ORDERS if order in ds]
    low, high, low_time, high_time = np.full((4, len(orders), ds.sizes["coordinate"]), np.nan)
    counts = np.zeros(len(Status), np.int64)
    names = ds["coordinate"].values.tolist()
    found = before or Extremes(names, low, high, low_time, high_time, counts)
    time, status = ds["time"].values, ds["status"].values
    for k, order in enumerate(orders):
        ranges = Range(found.low[k], found.high[k], found.low_time[k], found.high_time[k])
        ranges.widen(time, ds[order].values)
    found.forces = force_extremes(ds, found.forces)
    found.residual = float(np.fmax(found.residual, np.fmax.reduce(ds["residual"].values)))
    found.conditioning = float(
        np.fmin(found.conditioning, np.fmin.reduce(ds["conditioning"].values))
    )
    found.counts += np.bincount(status, minlength=len(Status))
    if found.first_flag is None and status.any():
        i = int(np.argmax(status != 0))
        found.first_flag = Flag(
            found.samples + i, float(time[i]), Status(int(status[i])), flag_words(ds, i)
        )
    found.met = ds.attrs["stops_met"]
    found.samples += len(status)
    return found
