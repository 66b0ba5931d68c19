"""The least and the greatest of several curves, and when, accumulated over windows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from parakin.arrays import FloatArray


class Range(NamedTuple):
    """Of n curves, each array (n,): NaN where nothing is known. The arrays are changed in place."""

    low: FloatArray
    high: FloatArray
    low_time: FloatArray
    high_time: FloatArray

    @classmethod
    def of(cls, count: int) -> Range:
        """Of so many curves of which nothing is known yet."""
        return cls(*np.full((4, count), np.nan))

    def widen(self, time: FloatArray, values: FloatArray) -> None:
        """Take in samples (m, n) at times (m,)."""
        known = np.isfinite(values)
        for best, times, sign in (
            (self.low, self.low_time, 1.0),
            (self.high, self.high_time, -1.0),
        ):
            signed = np.where(known, sign * values, np.inf)
            i = signed.argmin(axis=0)
            here = signed.min(axis=0)
            better = np.isfinite(here) & ~(here >= sign * best)
            best[better] = sign * here[better]
            times[better] = time[i[better]]

    def peak(self, k: int) -> tuple[float, float]:
        """The value of curve k that is largest in magnitude, with its sign, and its time."""
        low, high = float(self.low[k]), float(self.high[k])
        if abs(low) > abs(high):
            return low, float(self.low_time[k])
        return high, float(self.high_time[k])
