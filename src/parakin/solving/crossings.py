"""When a motion first goes beyond a limit: between samples, on the walk that they lie on."""

from __future__ import annotations

import numpy as np

from parakin.arrays import BoolArray, FloatArray
from parakin.solving.continuity import shortest_interval
from parakin.solving.stops import Stops
from parakin.solving.tracking import Piece, Track

_PARTS = 16  # that an interval is divided into at once


class Crossings:
    """The times at which each stop of a solver is first met along a motion, window by window.

    first_at: by number of the stop [s], NaN where it is not met.
    """

    def __init__(self, stops: Stops, track: Track) -> None:
        self.first_at = np.full(len(stops.names), np.nan)
        self._track, self._names = track, stops.names
        self._last: float | None = None  # time of the last sample
        self._limited = any(stops.units)

    @property
    def words(self) -> str:
        """Every stop met so far, and when: "P6 at t = 0.88 s, S2.cone at t = 1.2 s"."""
        met = np.flatnonzero(np.isfinite(self.first_at)).tolist()
        met.sort(key=lambda number: float(self.first_at[number]))
        return ", ".join(f"{self._names[k]} at t = {self.first_at[k]:.4g} s" for k in met)

    def note(self, time: FloatArray, pieces: list[Piece]) -> None:
        """Look at one more window: the times of its samples, and what is solved of it."""
        if not self._limited:
            return
        beyond = _beyond(pieces, len(time), len(self.first_at))
        for number in np.flatnonzero(beyond.any(axis=1) & np.isnan(self.first_at)).tolist():
            k = int(beyond[number].argmax())
            before = float(time[k - 1]) if k else self._last
            here = float(time[k])
            self.first_at[number] = here if before is None else self._between(number, before, here)
        self._last = float(time[-1])

    def _between(self, number: int, before: float, beyond: float) -> float:
        """The moment at which a limit is first exceeded, after one when it is kept."""
        while beyond - before > shortest_interval(beyond):
            time = np.linspace(before, beyond, _PARTS + 1)
            pieces = self._track.at(time)
            exceeded = _beyond(pieces, len(time), len(self.first_at))[number]
            exceeded[0], exceeded[-1] = False, True
            k = int(exceeded.argmax())
            if not time[k] - time[k - 1] < beyond - before:
                break
            before, beyond = float(time[k - 1]), float(time[k])
        return beyond


def _beyond(pieces: list[Piece], n: int, count: int) -> BoolArray:
    """By number of the stop, which of n samples are beyond it."""
    found = np.zeros((count, n), dtype=bool)
    for start, stop, chart, out in pieces:
        found[chart.limits.numbers, start:stop] = chart.limits.beyond(out)
    return found
