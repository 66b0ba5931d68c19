"""Fewer samples that look the same, or are evenly spaced, of a result or of its windows."""

from __future__ import annotations

import numpy as np

from parakin.arrays import FloatArray, IntArray
from parakin.labelled import Labelled


def thinned(values: FloatArray, buckets: int) -> IntArray:
    """The samples of curves (m, n) to draw: of each bucket the least and the greatest of each
    curve, and one of a bucket of NaN, so that gaps remain. All samples if they are few.
    """
    count = values.shape[1]
    if count <= 4 * buckets:
        return np.arange(count)
    edges = np.linspace(0, count, buckets + 1).astype(np.int64)
    starts, ends = edges[:-1, None], edges[1:, None]
    samples = np.minimum(starts + np.arange(int((ends - starts).max())), ends - 1)
    kept = [np.array([0, count - 1])]
    for curve in values:
        part = curve[samples]
        nan = np.isnan(part)
        for extreme in (
            np.where(nan, np.inf, part).argmin(1),
            np.where(nan, -np.inf, part).argmax(1),
        ):
            kept.append(samples[np.arange(buckets), extreme])
    return np.unique(np.concatenate(kept))


def every(stride: int, window: Labelled, start: int) -> Labelled:
    """Every stride-th sample of a motion, out of a window that begins with sample `start`."""
    return window.isel(time=slice(-start % stride, None, stride)).copy()
