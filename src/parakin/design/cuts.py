"""Where figures without rates first go above zero on a ray: sampled in parts of its steps and at
every peak between, and located by Brent's method.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from parakin.arrays import FloatArray
from parakin.design.rays import Measure, Ray, along
from parakin.solving.atlas import Atlas

_PARTS = 4  # that each step of a ray is divided into
_LOCATED = 4 * np.finfo(float).eps  # of a ray: what Brent's method can tell apart
_ALMOST = 1e-12  # of a figure's scale, 1: above zero by less is rounding


class Cut(NamedTuple):
    """Where the first figure goes above zero, as a part of a ray, and which; infinity and -1 where
    none does.
    """

    part: float
    number: int


def sampled(ray: Ray, until: float) -> FloatArray:
    """Parts (n,) of a ray up to one, by which it is looked at."""
    nodes = np.unique([node.part for node in ray.nodes if node.part < until] + [0.0, until])
    within = np.arange(_PARTS) / _PARTS
    steps = nodes[:-1, None] + np.diff(nodes)[:, None] * within
    return np.append(steps.ravel(), until)


def first_above(atlas: Atlas, ray: Ray, until: float, measure: Measure) -> Cut:
    """The first of some figures of a ray to go above zero before a part of it; one that is not
    known counts as above.
    """

    def figures(parts: FloatArray) -> FloatArray:
        return np.nan_to_num(along(atlas, ray, parts, measure), nan=1.0) - _ALMOST

    parts = sampled(ray, until)
    values = figures(parts)
    peaks = _peaks(parts, values)
    if len(peaks):
        order = np.argsort(np.append(parts, peaks), kind="stable")
        parts = np.append(parts, peaks)[order]
        values = np.concatenate([values, figures(peaks)], axis=1)[:, order]
    cut, above = Cut(np.inf, -1), values > 0.0
    if not above.any():
        return cut
    k = int(np.argmax(above.any(axis=0)))  # no other figure is above before
    for number in np.flatnonzero(above[:, k]).tolist():
        if k == 0:
            return Cut(0.0, number)
        at = brentq(
            lambda part, row=number: float(figures(np.array([part]))[row, 0]),
            *(parts[k - 1], parts[k]),
            xtol=_LOCATED,
            rtol=_LOCATED,
        )
        if at < cut.part:
            cut = Cut(float(at), number)
    return cut


def _peaks(parts: FloatArray, values: FloatArray) -> FloatArray:
    """Where parabolas through neighbours peak, of figures that are below zero there."""
    low, mid, high = values[:, :-2], values[:, 1:-1], values[:, 2:]
    rows, k = np.nonzero((mid <= 0.0) & (mid >= low) & (mid >= high))
    if not len(k):
        return np.empty(0)
    a, b, c = parts[k], parts[k + 1], parts[k + 2]
    down, up = (
        (values[rows, k + 1] - values[rows, k]) / (b - a),
        (values[rows, k + 2] - values[rows, k + 1]) / (c - b),
    )
    bend = (up - down) / (c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        peak = 0.5 * (a + b) - 0.5 * down / bend
    return np.unique(peak[(peak > a) & (peak < c)])
