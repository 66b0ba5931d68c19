"""A kernel run on columns: rounded alike however many there are, and near the processor."""

from __future__ import annotations

import numpy as np

from parakin.arrays import FloatArray
from parakin.kernel.backends import Kernel

LANES = 8  # columns that machine code computes together: this many, or a divisor
SPREAD = 2048  # columns; smaller batches are not worth a second core
_WINDOW = 4096  # columns; more of them, row by row, lie too far apart to be written one by one
_MANY = 4 * _WINDOW


def run(
    kernel: Kernel, inputs: FloatArray, count: int, *, lanes: int, parallel: bool
) -> FloatArray:
    """`count` outputs (count, n) of inputs (rows, n). lanes: how many columns have to be computed
    together, as rounding would differ in those left over.
    """
    n = inputs.shape[1]
    padded = n + -n % lanes
    if padded > n:
        whole = np.empty((len(inputs), padded))
        whole[:, :n], whole[:, n:] = inputs, inputs[:, -1:]
        return run(kernel, whole, count, lanes=lanes, parallel=parallel)[:, :n]
    out = np.empty((count, n))
    if parallel and n >= SPREAD:
        kernel(inputs, out, True)
    elif n < _MANY:
        kernel(inputs, out, False)
    else:
        _run_in_windows(kernel, inputs, out)
    return out


def _run_in_windows(kernel: Kernel, inputs: FloatArray, out: FloatArray) -> None:
    """By way of arrays that stay near the processor."""
    given, found = np.empty((len(inputs), _WINDOW)), np.empty((len(out), _WINDOW))
    whole = inputs.shape[1] - inputs.shape[1] % _WINDOW
    for start in range(0, whole, _WINDOW):
        window = slice(start, start + _WINDOW)
        given[:] = inputs[:, window]
        kernel(given, found, False)
        out[:, window] = found
    if whole < inputs.shape[1]:
        rest = np.empty((len(out), inputs.shape[1] - whole))
        kernel(np.ascontiguousarray(inputs[:, whole:]), rest, False)
        out[:, whole:] = rest
