"""Whether one smooth motion leads from one moment to another: the rule that all following obeys.

Positions, velocities and accelerations are known exactly at both moments. Of a motion that is
smooth between them the displacement is h/2 (v0 + v1) + h²/12 (a0 - a1), but for an error that
falls with h⁵, and the change of velocity h/2 (a0 + a1), with h³. A jump to another branch, a kink
where branches meet, or a turn that was lost leave a gap that does not fall so. What does not agree
is looked at more closely, down to `shortest_interval`.
"""

from __future__ import annotations

import numpy as np

from parakin.arrays import BoolArray, FloatArray

POSITION = 0.02  # of the step: how far a displacement may be off
VELOCITY = 0.08  # and the change of velocity, times the time between
ASIDE = 1e-3  # of the time between: where its slopes are taken
LOCATED = 1e-9  # [s] how well a singularity is located in time
_SLOW = 0.01  # of what is driven: coordinates slower than this are judged as if so fast
_ROUNDING = 1e-13  # of a coordinate, and of its unit
_WORSE = 1e-15  # the same, over the conditioning


def foretold(h: FloatArray, before: FloatArray, after: FloatArray) -> FloatArray:
    """The displacement (m, n) of a smooth motion: h (n,), orders (3, m, n) at both moments."""
    mean = 0.5 * h * (before[1] + after[1])
    displacement: FloatArray = mean + h * h / 12 * (before[2] - after[2])
    return displacement


def missing_turns(
    h: FloatArray, before: FloatArray, after: FloatArray, turning: BoolArray
) -> FloatArray:
    """The turns (m, n) by which positions have to be shifted to go on from those before.

    turning (m,): which coordinates are angles that are known but for full turns.
    """
    with np.errstate(invalid="ignore"):
        off = after[0] - before[0] - foretold(h, before, after)
        turns: FloatArray = np.rint(off * (-0.5 / np.pi)) * turning[:, None]
    return turns


def follows(
    h: FloatArray,
    before: FloatArray,
    after: FloatArray,
    pace: FloatArray,
    units: FloatArray,
    conditioning: FloatArray,
    bulk: FloatArray,
    noise: float = 0.0,
) -> BoolArray:
    """Which of these coordinates (m, n) go smoothly from one moment to the other; NaN does not.

    h (n,): time between. before, after: orders (3, m, n) at the two. pace (n,): how fast what is
    driven goes, in `units` (m,) a second. conditioning (n,): how many digits are right. bulk (n,):
    how large what is driven is, in units: its last digit is the first that is lost in all others.
    noise: as of `Motion`.
    """
    fast = np.maximum(np.abs(before[1]), np.abs(after[1]))
    size = h * np.maximum(fast, _SLOW * pace * units[:, None])
    part = _ROUNDING + _WORSE / conditioning
    if noise:
        part = part + noise * (1.0 + h) / conditioning
    rough = part * (units[:, None] * (1.0 + bulk) + np.abs(after[0]))
    off = after[0] - before[0] - foretold(h, before, after)
    turn = h * (after[1] - before[1] - 0.5 * h * (before[2] + after[2]))
    smooth: BoolArray = np.abs(off) <= POSITION * size + rough
    smooth &= np.abs(turn) <= VELOCITY * size + 4 * rough
    return smooth


def stays_clear(
    h: FloatArray, before: FloatArray, after: FloatArray, ahead: FloatArray, behind: FloatArray
) -> BoolArray:
    """Whether a figure of conditioning (n,) stays clear of zero between two moments.

    ahead, behind: what it is a little (`ASIDE`) after the first and before the second. A figure
    without a sign that passes zero is a V there, and its tangents meet at the tip.
    """
    down = (before - ahead) / (ASIDE * h)
    up = (after - behind) / (ASIDE * h)
    tip = (down * after + up * before - down * up * h) / (down + up)
    level: BoolArray = np.isfinite(down) & np.isfinite(up) & ~((down > 0.0) & (up > 0.0))
    return level | (tip > 0.5 * np.maximum(before, after))


def pace_of(before: FloatArray, after: FloatArray, step: FloatArray) -> FloatArray:
    """How fast what is driven goes, (n,): orders (3+, k, n) at two moments, in units of each row.

    step (n,): the motion's own, in which its accelerations matter.
    """
    rates = np.maximum(np.abs(before), np.abs(after)).max(axis=1, initial=0.0)
    pace: FloatArray = rates[1] + step * rates[2]
    return pace


def magnitude_of(driven: FloatArray, units: FloatArray) -> FloatArray:
    """How large what is driven is, (n,): positions (k, n), in units (k,) of each row."""
    bulk: FloatArray = np.abs(driven / units[:, None]).max(axis=0, initial=0.0)
    return bulk


def shortest_interval(time: float) -> float:
    """The shortest time between two moments that are distinguished."""
    return max(LOCATED, 16 * float(np.spacing(abs(time))))
