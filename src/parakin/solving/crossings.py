"""When a motion first goes beyond a limit: between samples, on the walk that they lie on."""

from __future__ import annotations

import numpy as np

from parakin.arrays import BoolArray, FloatArray
from parakin.solving.continuity import shortest_interval
from parakin.solving.stops import Stopped, Stops
from parakin.solving.tracking import Piece, Track

_PARTS = 16  # that an interval is divided into at once


class Crossings:
    """The times at which each end of each limit, and each loop that cannot be closed, is first met
    along a motion, window by window.

    first_at: below (0) and above (1), by number of the stop [s], NaN where it is not met; a loop is
    met above.
    """

    def __init__(self, stops: Stops, track: Track) -> None:
        self.first_at = np.full((2, len(stops.names)), np.nan)
        self._track, self._stops = track, stops
        self._last: float | None = None  # time of the last sample
        self._limited = any(stops.units)

    def of(self, stopped: Stopped) -> FloatArray:
        """When that which stopped each sample was first met [s], NaN where nothing did."""
        found: FloatArray = self.first_at[np.where(stopped.excess < 0.0, 0, 1), stopped.number]
        return found

    @property
    def words(self) -> str:
        """Every stop met so far, and when: "P6 > 0.6 m at t = 0.88 s, B.cone > 9° at t = 1.2 s"."""
        met = [(float(self.first_at[end, k]), end, k) for end, k in np.argwhere(self._met).tolist()]
        return ", ".join(
            f"{self._stops.limit_words(k, upper=bool(end))} at t = {at:.4g} s"
            for at, end, k in sorted(met)
        )

    @property
    def _met(self) -> BoolArray:
        met: BoolArray = np.isfinite(self.first_at)
        return met

    def note(self, time: FloatArray, pieces: list[Piece]) -> None:
        """Look at one more window: the times of its samples, and what is solved of it."""
        if not self._limited:
            return
        beyond = self._beyond(pieces, len(time))
        for end, number in np.argwhere(beyond.any(axis=2) & ~self._met).tolist():
            k = int(beyond[end, number].argmax())
            before = float(time[k - 1]) if k else self._last
            here = float(time[k])
            if before is not None:
                here = self._between(end, number, before, here)
            self.first_at[end, number] = here
        self._last = float(time[-1])

    def _between(self, end: int, number: int, before: float, beyond: float) -> float:
        """The moment at which a limit is first exceeded, after one when it is kept."""
        while beyond - before > shortest_interval(beyond):
            time = np.linspace(before, beyond, _PARTS + 1)
            exceeded = self._beyond(self._track.at(time), len(time))[end, number]
            exceeded[0], exceeded[-1] = False, True
            k = int(exceeded.argmax())
            if not time[k] - time[k - 1] < beyond - before:
                break
            before, beyond = float(time[k - 1]), float(time[k])
        return beyond

    def _beyond(self, pieces: list[Piece], n: int) -> BoolArray:
        """Which of n samples are below and above each limit, (2, stops, n)."""
        found = np.zeros((*self.first_at.shape, n), dtype=bool)
        for start, stop, chart, out in pieces:
            for end, beyond in zip(found, chart.limits.beyond(out), strict=True):
                end[chart.limits.numbers, start:stop] = beyond
        return found
