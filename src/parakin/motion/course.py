"""The course of a motion: the steps in which it is followed, and its values at any time.

The steps follow from the motion itself (its laws, their knots, its duration, or its samples), and
never from the times at which it is evaluated.
"""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Sequence

import numpy as np

from parakin.arrays import FloatArray
from parakin.motion.motion import Motion, Samples

_A_PERIOD = 16  # steps in the shortest time in which a law changes
_A_MOTION = 64  # in the whole motion
_A_KNOT = 4  # between one knot and the next
_STRIDE = 16  # samples in a step, where only samples are known
_BLOCK = 256 * _STRIDE  # samples read at once
_APART = 1e-9  # of the duration: closer knots count as one

_START = np.array([[1, 0, 0, -10, 15, -6], [0, 1, 0, -6, 8, -3], [0, 0, 0.5, -1.5, 1.5, -0.5]])
_END = np.array([[0, 0, 0, 10, -15, 6], [0, 0, 0, -4, 7, -3], [0, 0, 0, 0.5, -1, 0.5]])


def hermite(nodes: FloatArray, values: FloatArray, at: FloatArray, order: int = 0) -> FloatArray:
    """Quintic Hermite interpolation: nodes (K,), values with two derivatives or more (3+, m, K).

    Returns (m, len(at)), or its derivative of the given order.
    """
    left = np.clip(np.searchsorted(nodes, at, side="right") - 1, 0, len(nodes) - 2)
    h = nodes[left + 1] - nodes[left]
    x = (at - nodes[left]) / h
    total = np.zeros((values.shape[1], len(at)))
    for k in range(3):
        for table, node in ((_START[k], left), (_END[k], left + 1)):
            poly = np.polynomial.polynomial.polyder(table, order) if order else table
            weight = np.polynomial.polynomial.polyval(x, poly) * h ** (k - order)
            total += values[k][:, node] * weight
    return total


class Course:
    """A motion's own steps, and its values at any time."""

    def __init__(self, motion: Motion) -> None:
        self._motion = motion
        self._starts: list[float] = []  # when each block of samples begins
        self._known: dict[int, Samples] = {}
        if motion.between is not None:
            self._pieces = _pieces(motion.knots, motion.period)

    @property
    def noise(self) -> float:
        """As of `Motion`."""
        return self._motion.noise

    def steps(self, after: float, until: float, most: int = 10**9) -> FloatArray:
        """The ends (n,) of steps [s] after `after`, up to the first at or beyond `until`; at most
        `most`. The motion's start counts as one.
        """
        if self._motion.between is None:
            return self._sample_steps(after, until, most)
        ends = [np.array(self._motion.knots[:1])] if after < self._motion.knots[0] else []
        found = len(ends)
        for begin, end, count in self._pieces:
            if end > after and (begin < until or not ends):
                width = (end - begin) / count
                first = max(1, math.floor((after - begin) / width)) if after > begin else 1
                last = min(count, math.ceil(min((until - begin) / width, 2.0 * count)) + 1)
                numbers = np.arange(first, min(max(first, last), first + most) + 1)
                inner = begin + width * numbers
                inner[numbers >= count] = end
                ends.append(inner[inner <= end])
                found += len(ends[-1])
                if found > most:
                    break
        if not ends:  # `after` is the motion's end, or later
            return np.zeros(0)
        return _between(np.concatenate(ends), after, until)[:most]

    def at(self, time: FloatArray, orders: int) -> FloatArray:
        """Driven positions and derivatives (orders, k, n) at any times (n,) [s]."""
        known: Sequence[FloatArray]
        if self._motion.between is not None:
            known = self._motion.between(time).orders
        else:
            known = self._interpolated(time, orders)
        values = np.zeros((orders, *known[0].shape))
        for order, rows in enumerate(known[:orders]):
            values[order] = rows
        return values

    def _sample_steps(self, after: float, until: float, most: int) -> FloatArray:
        first, last = self._block_of(after), self._block_of(until)
        found: list[FloatArray] = []
        total = (self._motion.count - 1) // _BLOCK + 1
        for number in range(max(first, 0), min(last + 2, total)):
            time = self._block(number).time
            ends = time[::_STRIDE]
            if number == total - 1:
                ends = np.append(ends, time[-1])
            found.append(ends)
            if sum(map(len, found)) > most + _BLOCK // _STRIDE:
                break
        return _between(np.concatenate(found), after, until)[:most]

    def _block(self, number: int) -> Samples:
        """A block of samples, and the first sample after it."""
        if number not in self._known:
            begin = number * _BLOCK
            if len(self._known) > 2:
                self._known.pop(min(self._known))
            self._known[number] = self._motion.window(begin, begin + _BLOCK + 1)
            if number == len(self._starts):
                self._starts.append(float(self._known[number].time[0]))
        return self._known[number]

    def _block_of(self, time: float) -> int:
        total = max(1, -(-(self._motion.count - 1) // _BLOCK))
        while len(self._starts) < total and (not self._starts or self._starts[-1] <= time):
            self._block(len(self._starts))
        return max(0, bisect.bisect_right(self._starts[:total], time) - 1)

    def _interpolated(self, time: FloatArray, orders: int) -> Sequence[FloatArray]:
        numbers = np.array([self._block_of(t) for t in time.tolist()])
        k = len(self._motion.coordinates)
        rows = np.zeros((orders, k, len(time)))
        for number in np.unique(numbers).tolist():
            here = numbers == number
            block = self._block(number)
            if len(block.time) < 2:
                for order, known in enumerate(block.orders[:orders]):
                    rows[order][:, here] = known[:, :1]
                continue
            values = np.array(block.orders[:3])
            for order in range(orders):
                rows[order][:, here] = hermite(block.time, values, time[here], order)
        return list(rows)


def _pieces(knots: Sequence[float], period: float) -> list[tuple[float, float, int]]:
    """Begin and end of each smooth piece [s], and how many steps it takes."""
    span = knots[-1] - knots[0]
    apart = [knots[0]]
    for knot in knots[1:]:
        if knot - apart[-1] > _APART * span:
            apart.append(knot)
    apart[-1] = knots[-1]
    pieces = []
    for begin, end in itertools.pairwise(apart):
        parts = (_A_PERIOD * (end - begin) / period, _A_MOTION * (end - begin) / span, _A_KNOT)
        pieces.append((begin, end, math.ceil(max(parts) - 1e-6)))
    return pieces


def _between(ends: FloatArray, after: float, until: float) -> FloatArray:
    ends = ends[ends > after]
    fresh = np.ones(len(ends), dtype=bool)
    fresh[1:] = ends[1:] > ends[:-1]
    ends = ends[fresh]
    return ends[: int(np.searchsorted(ends, until)) + 1]
