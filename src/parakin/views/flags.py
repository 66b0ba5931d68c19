"""When samples are flagged: the stretches of time that figures shade."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from parakin.solving.status import Status

if TYPE_CHECKING:
    from parakin.labelled import Result


def flagged_spans(ds: Result) -> list[tuple[float, float]]:
    """From the first to the last of each run of flagged samples [s]."""
    flagged = np.concatenate([[False], ds["status"].values != Status.CONVERGED, [False]])
    edges = np.flatnonzero(flagged[1:] != flagged[:-1]).reshape(-1, 2)
    time = ds["time"].values
    return [(float(time[start]), float(time[stop - 1])) for start, stop in edges.tolist()]
