"""A kernel run on columns: rounded alike however many there are, at full speed."""

from __future__ import annotations

import numpy as np

from parakin.arrays import FloatArray
from parakin.kernel.backends import Kernel

LANES = 8  # columns that machine code computes together: this many, or a divisor
SPREAD = 512  # columns; smaller batches are not worth a second core
_ALIKE = 512  # columns: rows that are a multiple of these apart share their place in a cache


def run(
    kernel: Kernel, inputs: FloatArray, count: int, *, lanes: int = 1, parallel: bool = False
) -> FloatArray:
    """`count` outputs (count, n) of inputs (rows, n). lanes: how many columns have to be computed
    together, as rounding would differ in those left over.
    """
    n = inputs.shape[1]
    whole = n + -n % lanes
    if whole and whole % _ALIKE == 0:  # rows that evict one another take twice as long to write
        whole += LANES
    if whole > n:
        inputs = np.concatenate([inputs, inputs[:, -1:].repeat(whole - n, axis=1)], axis=1)
    out = np.empty((count, whole))
    kernel(inputs, out, parallel and n >= SPREAD)
    return out[:, :n]
