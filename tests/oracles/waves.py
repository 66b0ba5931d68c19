"""Samples of sines, for tests of motions."""

from __future__ import annotations

import numpy as np

from parakin.arrays import FloatArray
from parakin.motion import laws


def wave(t: FloatArray) -> tuple[FloatArray, ...]:
    """Two coordinates: amplitude 1 m at 1 Hz, and 0.5 rad at 0.3 Hz; (2, n) each."""
    one, other = laws.sine(0.2, 1.0, 1.0, 0.3)(t), laws.sine(-0.1, 0.5, 0.3)(t)
    return tuple(np.stack(pair) for pair in zip(one, other, strict=True))


def uneven(n: int, seed: int = 1) -> FloatArray:
    """Steps that vary sevenfold about the mean, over 3 s."""
    steps = np.random.default_rng(seed).uniform(0.25, 1.75, n - 1)
    return np.append(0.0, np.cumsum(steps)) * 3 / float(steps.sum())
