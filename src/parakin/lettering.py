"""Labels on a sheet: placed one after another where they cover least. Points throughout."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from parakin.shapes import FloatArray

_EVERY = 3.0  # along a line: how densely it stands in the way
_WAYS = 16
_FURTHER = (0.0, 4.0, 9.0, 16.0, 26.0)
_WIDE, _HIGH = 0.62, 1.15  # of a letter, of its size
_ON_LABEL, _ON_LINE, _FAR, _OUTSIDE = 3.0, 1.0, 0.16, 50.0


class Label(NamedTuple):
    """A text beside a place; `clear` of it by so much; `first` is placed before others."""

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
    """What is on the sheet already: places (n, 2) along its lines."""

    places: list[FloatArray] = field(default_factory=list)

    def line(self, points: FloatArray, *, closed: bool = False) -> None:
        """Let a chain of points stand in the way."""
        chain = np.concatenate([points, points[:1]]) if closed else points
        self.places += [_along(a, b) for a, b in pairwise(chain)]

    def crossed(self, ends: FloatArray) -> float:
        """How many places a line between two ends comes near."""
        away = np.concatenate([*self.places, np.empty((0, 2))]) - ends[0]
        along = ends[1] - ends[0]
        t = np.clip(away @ along / max(float(along @ along), 1e-9), 0, 1)
        near = np.abs(away - t[:, None] * along).max(axis=1) < 0.9 * _EVERY
        return float(near.sum())


def width_of(text: str, size: float) -> float:
    """About how wide a text is."""
    return _WIDE * size * len(text)


def placed(
    labels: Sequence[Label], taken: Obstacles, sheet: tuple[float, float]
) -> list[tuple[Label, FloatArray]]:
    """The middle of each label, chosen greedily among places around what it belongs to."""
    every = np.concatenate([*taken.places, np.empty((0, 2))])
    boxes: list[tuple[FloatArray, FloatArray]] = []
    found = []
    for label in sorted(labels, key=lambda label: not label.first):
        half = np.array([width_of(label.text, label.size), _HIGH * label.size]) / 2
        best: tuple[float, FloatArray] | None = None
        for at, far in _candidates(label, half):
            low, high = at - half, at + half
            covered = ((every > low) & (every < high)).all(axis=1).sum()
            cost = _ON_LINE * float(covered) + _FAR * far
            for other_low, other_high in boxes:
                common = np.minimum(high, other_high) - np.maximum(low, other_low)
                if (common > 0).all():
                    cost += _ON_LABEL * (1 + float(common.prod()) / _EVERY)
            cost += _OUTSIDE * bool((low < 2).any() or (high > np.array(sheet) - 2).any())
            if best is None or cost < best[0] - 1e-9:
                best = (cost, at)
        assert best is not None
        boxes.append((best[1] - half, best[1] + half))
        found.append((label, best[1]))
    return found


def _candidates(label: Label, half: FloatArray) -> list[tuple[FloatArray, float]]:
    """Places for a label's middle, and how far out each is: right above first, then around."""
    made = []
    for further in _FURTHER:
        reach = label.clear + further
        for k in range(_WAYS):
            turn = np.pi / 4 + 2 * np.pi * k / _WAYS
            way = np.array([np.cos(turn), np.sin(turn)])
            made.append((label.at + reach * way + half * _sides(way), further))
        if reach == 0:
            made.append((label.at, 0.0))
    return made


def _sides(way: FloatArray) -> FloatArray:
    """Where the middle of a box stands that touches a place in a direction: beside or above it."""
    return np.asarray(way / max(float(np.abs(way).max()), 1e-9))


def _along(a: FloatArray, b: FloatArray) -> FloatArray:
    count = max(2, int(np.linalg.norm(b - a) / _EVERY) + 1)
    return np.asarray(a + np.linspace(0, 1, count)[:, None] * (b - a))
