"""Where the three angles of an iterated joint lock, and how Newton's steps keep out of the way."""

from __future__ import annotations

import numpy as np

from parakin.arrays import BoolArray, FloatArray
from parakin.planning.plan import Plan
from parakin.solving.charts import Chart
from parakin.solving.status import Layout
from parakin.solving.tick import Tick
from parakin.solving.walking import iterate

_BESIDE = 1e-3  # rad: how near to where angles lock no iteration begins
_NEAR = 0.2  # rad: from how near Newton's steps may meet a lock

Locks = tuple[tuple[int, float], ...]
"""For each joint whose three angles are iterated: the row of the second angle among the iterated
coordinates, and the value at which it locks, but for half turns.
"""


def locks_of(plan: Plan) -> Locks:
    iterated = plan.iterated
    joints = [joint for joint in plan.graph.joints if len(joint.turns) == 3]
    return tuple(
        (iterated.index(joint.turns[1]), 0.0 if joint.proper else 0.5 * np.pi)
        for joint in joints
        if set(joint.turns) <= set(iterated)
    )


def near_lock(locks: Locks, found: FloatArray) -> BoolArray:
    """Which columns of iterated coordinates (m, n) are near where three angles lock."""
    near = np.zeros(found.shape[1], dtype=bool)
    for row, lock in locks:
        near |= np.abs(_beyond(found[row], lock)) < _NEAR
    return near


def off_the_lock(locks: Locks, found: FloatArray) -> FloatArray:
    """Iterated coordinates (m,) or (m, n), moved a little to the side where three angles lock:
    Newton's steps find their way from there, but not from the lock itself.
    """
    for row, lock in locks:
        angle = found[row]
        most = abs(float(angle)) if angle.ndim == 0 else np.abs(angle).max(initial=0.0)
        if most < lock - 0.1:
            continue  # all well clear, as nearly always
        off = _beyond(angle, lock)
        near = np.abs(off) < _BESIDE
        if near.any():
            found = found.copy()
            found[row] += np.where(near, np.copysign(_BESIDE, off), 0.0)
    return found


def begun_at(locks: Locks, layout: Layout, tick: Tick) -> FloatArray:
    """A tick's iterated coordinates, (m,) or (m, n), for Newton's steps to begin from."""
    known = tick.iterated if len(tick.iterated) else tick.position[layout.iterated[0]]
    return off_the_lock(locks, known)


def try_again(
    chart: Chart, locks: Locks, out: FloatArray, inputs: FloatArray, start: FloatArray
) -> None:
    """Solve again what became NaN although it began near a lock: Newton's steps may have met the
    lock exactly, and will not if they begin a little farther off.
    """
    residual = chart.outputs.residual
    if not np.isnan(out[residual]).any():
        return
    near = near_lock(locks, start)
    for times in (1, 2, 3):
        lost = np.flatnonzero(near & np.isnan(out[residual]))
        if not len(lost):
            return
        begun = start[:, lost]
        for row, _ in locks:
            begun[row] += times * _BESIDE
        out[:, lost] = iterate(chart, inputs[:, lost], begun)


def _beyond(angle: FloatArray, lock: float) -> FloatArray:
    """How far angles are beyond the nearest of the places, half a turn apart, where they lock."""
    with np.errstate(invalid="ignore"):
        off: FloatArray = np.remainder(angle - lock + 0.5 * np.pi, np.pi) - 0.5 * np.pi
    return off
