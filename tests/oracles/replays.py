"""What some coordinates of a result did, as a motion that drives them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from parakin.arrays import ORDERS
from parakin.motion.motion import Motion, Samples


def replayed(result: xr.Dataset, names: Sequence[str]) -> Motion:
    drives = result.sel(coordinate=list(names))
    orders = [drives[q].values.T for q in ORDERS if q in drives]
    time = result.time.values

    def window(start: int, stop: int) -> Samples:
        cut = (np.ascontiguousarray(order[:, start:stop]) for order in orders)
        return Samples(time[start:stop], *cut)

    return Motion("replayed", tuple(names), len(time), window, "given")
