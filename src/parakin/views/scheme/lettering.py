"""Labels on a sheet, placed one after another where they cover least. All lengths in points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from parakin.arrays import FloatArray

_EVERY = 3.0  # between the places along a line
_WAYS = 16
_FURTHER = (0.0, 4.0, 9.0, 16.0, 26.0)
_WIDE, _HIGH = 0.62, 1.15  # of a letter, of its size
_ON_LABEL, _ON_LINE, _FAR, _OUTSIDE = 3.0, 1.0, 0.16, 50.0


class Label(NamedTuple):
    """A text next to a place, at a distance `clear`; those with `first` are placed first."""

    text: str
    at: FloatArray
    clear: float
    colour: str
    size: float = 0.0
    weight: str = "normal"
    slant: bool = False
    first: bool = False


@dataclass
class Obstacles:
    """What is already on the sheet: places (n, 2) along its lines."""

    places: list[FloatArray] = field(default_factory=list)

    def line(self, points: FloatArray, *, closed: bool = False) -> None:
        """Add a chain of points."""
        chain = np.concatenate([points, points[:1]]) if closed else points
        self.places += [_along(a, b) for a, b in pairwise(chain)]

    def crossed(self, ends: FloatArray) -> float:
        """The number of places near a line between two ends."""
        away = np.concatenate([*self.places, np.empty((0, 2))]) - ends[0]
        along = ends[1] - ends[0]
        t = np.clip(away @ along / max(float(along @ along), 1e-9), 0, 1)
        near = np.abs(away - t[:, None] * along).max(axis=1) < 0.9 * _EVERY
        return float(near.sum())


def width_of(text: str, size: float) -> float:
    """The approximate width of a text."""
    return _WIDE * size * len(text)


def placed(
    labels: Sequence[Label], taken: Obstacles, sheet: tuple[float, float]
) -> list[tuple[Label, FloatArray]]:
    """The centre of each label, chosen greedily among places around what it labels."""
    every = np.concatenate([*taken.places, np.empty((0, 2))])
    lows, highs = np.empty((0, 2)), np.empty((0, 2))  # of the labels placed so far
    found = []
    for label in sorted(labels, key=lambda label: not label.first):
        half = np.array([width_of(label.text, label.size), _HIGH * label.size]) / 2
        spots, far = _candidates(label, half)
        low, high = spots - half, spots + half
        near = every[((every > low.min(axis=0)) & (every < high.max(axis=0))).all(axis=1)]
        covered = ((near > low[:, None]) & (near < high[:, None])).all(axis=2).sum(axis=1)
        common = np.minimum(high[:, None], highs) - np.maximum(low[:, None], lows)
        shared = np.where((common > 0).all(axis=2), 1 + common.prod(axis=2) / _EVERY, 0.0)
        outside = (low < 2).any(axis=1) | (high > np.array(sheet) - 2).any(axis=1)
        cost = _ON_LINE * covered + _ON_LABEL * shared.sum(axis=1) + _FAR * far + _OUTSIDE * outside
        best = int(np.argmin(np.round(cost, 9)))
        lows, highs = np.vstack([lows, low[best]]), np.vstack([highs, high[best]])
        found.append((label, spots[best]))
    return found


def _candidates(label: Label, half: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Places (n, 2) for a label's centre, all around, and how far out each is."""
    turns = np.pi / 4 + 2 * np.pi * np.arange(_WAYS) / _WAYS
    ways = np.column_stack([np.cos(turns), np.sin(turns)])
    sides = ways / np.abs(ways).max(axis=1)[:, None]  # where a box touches
    reaches = label.clear + np.array(_FURTHER)
    spots = label.at + (reaches[:, None, None] * ways + half * sides).reshape(-1, 2)
    far = np.repeat(_FURTHER, _WAYS)
    if label.clear == 0:  # it may also cover its place
        return np.vstack([label.at, spots]), np.concatenate([[0.0], far])
    return spots, far


def _along(a: FloatArray, b: FloatArray) -> FloatArray:
    count = max(2, int(np.linalg.norm(b - a) / _EVERY) + 1)
    return np.asarray(a + np.linspace(0, 1, count)[:, None] * (b - a))
