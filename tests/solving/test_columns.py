"""Columns give what they give alone: on all cores, and however many are left over."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin.arrays import FloatArray
from parakin.solving import columns


def squares(inputs: FloatArray, out: FloatArray, parallel: bool) -> None:
    assert inputs.flags.c_contiguous
    assert out.flags.c_contiguous
    out[0], out[1] = inputs[0] ** 2, inputs[0] - inputs[1]


@pytest.mark.parametrize("n", [0, 1, 7, 8, 511, 512, 513, 1024, 4096, 20480, 40001])
@pytest.mark.parametrize("lanes", [1, 8])
@pytest.mark.parametrize("parallel", [True, False])
def test_every_column_is_run_once(n: int, lanes: int, parallel: bool) -> None:
    inputs = np.random.default_rng(n).normal(size=(2, n))
    out = columns.run(squares, inputs, 2, lanes=lanes, parallel=parallel)
    assert out.shape == (2, n)
    assert np.array_equal(out, [inputs[0] ** 2, inputs[0] - inputs[1]])


@pytest.mark.parametrize("driven", [None, [f"P{k}" for k in range(1, 7)]])
def test_a_long_batch_gives_what_parts_of_it_give(driven: list[str] | None) -> None:
    pytest.importorskip("heyoka")
    solver = parakin.compile("gough-stewart", driven)
    home = np.array([solver.home[name] for name in solver.driven])
    n = 20_480
    y = home[:, None] + 0.01 * np.random.default_rng(0).normal(size=(len(home), n))
    rates = np.random.default_rng(1).normal(size=y.shape)
    guess = solver.at(home)
    whole = solver.at(y, rates, rates, guess)
    spread = solver.at(y, rates, rates, guess, parallel=True)
    some = slice(16_380, 16_400)
    part = solver.at(y[:, some], rates[:, some], rates[:, some], guess)
    for name in ("position", "velocity", "acceleration", "status", "residual", "conditioning"):
        found = getattr(whole, name)
        assert np.array_equal(found, getattr(spread, name), equal_nan=True)
        assert np.array_equal(found[..., some], getattr(part, name), equal_nan=True)
