"""A tape plays what was traced, on arrays and on plain numbers alike."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import parakin
from parakin.algebra.spatial import ARRAYS, Functions, Scalar
from parakin.kernel.backends import compiled
from parakin.kernel.tape import Tape, program

WILD = [0.0, -0.0, 1.0, -1.0, math.inf, -math.inf, math.nan, 1e308, -1e308, 5e-324, 1e-200]
COUNT = 4


def traced(steps: Sequence[tuple[int, int, int]], results: Sequence[int]):  # type: ignore[no-untyped-def]
    """A program of random steps: what is done, to which of the values so far."""

    def run(inputs: Sequence[Scalar], functions: Functions) -> list[Scalar]:
        values: list[Scalar] = [*inputs, 0.5, -2.0]
        for does, i, j in steps:
            a, b = values[i % len(values)], values[j % len(values)]
            if isinstance(a, float) and isinstance(b, float):
                values.append(a)  # arithmetic of plain numbers is Python's own
                continue
            values.append(
                [
                    lambda a=a, b=b: a + b,
                    lambda a=a, b=b: a - b,
                    lambda a=a, b=b: a * b,
                    lambda a=a, b=b: functions.sqrt(a * a),
                    lambda a=a, b=b: -(a + b),
                    lambda a=a, b=b: functions.sin(a - b),
                    lambda a=a, b=b: functions.cos(a * b),
                    lambda a=a, b=b: functions.atan2(a, b),
                    lambda a=a, b=b: functions.minimum(a, b),
                    lambda a=a, b=b: functions.copysign(a, b),
                    lambda a=a, b=b: functions.inverse(a + b),
                    lambda a=a, b=b: (a + b) / (a * b),
                ][does]()
            )
        return [values[k % len(values)] for k in results]

    return run


STEPS = st.lists(st.tuples(st.integers(0, 11), st.integers(0, 99), st.integers(0, 99)), max_size=30)
RESULTS = st.lists(st.integers(0, 99), min_size=1, max_size=6)


@given(STEPS, RESULTS, st.integers(0, 2**32 - 1))
def test_what_is_played_is_what_arrays_give(
    steps: list[tuple[int, int, int]], results: list[int], seed: int
) -> None:
    run = traced(steps, results)
    draw = np.random.default_rng(seed)
    inputs = draw.normal(size=(COUNT, 9))
    inputs[:, 5:] = draw.choice(WILD, size=(COUNT, 4))
    with np.errstate(all="ignore"):
        direct = [np.broadcast_to(np.asarray(r, dtype=float), 9) for r in run(list(inputs), ARRAYS)]
    kernel = compiled(run, COUNT, machine_code=False)
    out = np.empty((len(results), 9))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        kernel(inputs, out, False)
        alone = np.empty(len(results))
        for column in range(9):
            kernel(np.ascontiguousarray(inputs[:, column]), alone, False)
            assert np.array_equal(alone, out[:, column], equal_nan=True)
    assert np.array_equal(out, direct, equal_nan=True)


def test_nothing_is_done_twice_or_in_vain() -> None:
    tape = Tape(3)
    a, b, _ = tape.inputs
    twice = (a + b) * (a + b)
    _ = a / b  # which no result needs
    made = program(tape, [twice, twice - 0.5, a + b])
    assert [does.__name__ for does, *_ in made.operations] == ["add", "multiply", "subtract"]
    assert [row for row, _ in made.inputs] == [0, 1]
    assert len(made.constants) == 1


def test_registers_are_used_again() -> None:
    tape = Tape(1)
    (a,) = tape.inputs
    total = a
    for k in range(200):
        total = total * 1.5 + float(k % 3)
    made = program(tape, [total])
    assert len(made.operations) == 400
    assert made.registers <= 6


def test_zeros_of_either_sign_are_two_constants() -> None:
    tape = Tape(1)
    (a,) = tape.inputs
    made = program(tape, [a * 0.0, a * -0.0, a * math.nan])
    out = np.empty(3)
    made.play_alone(np.array([2.0]), out)
    assert np.signbit(out[:2]).tolist() == [False, True]
    assert np.isnan(out[2])


@pytest.mark.parametrize("n", [1, 1023, 1024, 1025, 5000])
def test_pieces_of_a_batch_are_alike(n: int) -> None:
    solver = parakin.compile("flight-simulator", machine_code=False)
    draw = np.random.default_rng(n)
    home = np.array([[solver.home[name]] for name in solver.driven])
    y = home + 0.02 * draw.normal(size=(3, n))
    rates = draw.normal(size=(3, n))
    whole = solver.at(y, rates, rates)
    assert not np.asarray(whole.status).any()
    for k in (0, n // 2, n - 1):
        one = solver.at(y[:, k], rates[:, k], rates[:, k])
        assert np.array_equal(one.position, whole.position[:, k])
        assert np.array_equal(one.acceleration, whole.acceleration[:, k])
