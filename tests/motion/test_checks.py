"""Checks of motions: what they let through and what they refuse."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from parakin.errors import InputError
from parakin.motion.checks import (
    checked_array,
    increasing,
    refuse_non_finite,
    refuse_repeated,
    refuse_unless_positive,
)

ROWS = np.array([[[0.0, 1.0, 1.0, 2.0]]])  # (quantities, k, n)


def test_repeats_are_left_out_and_nothing_else() -> None:
    kept = increasing(np.array([0.0, 0.1, 0.1, 0.2]), ROWS, "here")
    assert_array_equal(kept, [True, True, False, True])


@pytest.mark.parametrize(
    ("time", "message"),
    [
        ([0.0, 0.1, 0.05, 0.2], "here, time of sample 2: found 0.05 s after 0.1 s"),
        ([0.0, 0.0, 0.1, 0.2], "here, time of sample 1: found 0 s after 0 s; expected a later"),
    ],
)
def test_times_that_do_not_increase_are_refused(time: list[float], message: str) -> None:
    with pytest.raises(InputError) as error:
        increasing(np.array(time), ROWS, "here")
    assert message in str(error.value)


def test_an_array_is_a_copy_of_the_shape_asked_for() -> None:
    given = np.arange(6.0)
    array = checked_array(given, "here", (-1,))
    array[:] = 7.0
    assert_array_equal(given, np.arange(6.0))
    assert checked_array([[1, 2]], "here", (1, 2)).dtype == np.float64
    refused: list[tuple[Any, tuple[int, ...], str]] = [
        ([1, 2], (3,), r"an array of shape \(2,\); expected \(3,\)"),
        ([[1], [2]], (-1,), r"an array of shape \(2, 1\); expected \(n,\)"),
        ("a", (-1,), "expected numbers"),
    ]
    for values, shape, message in refused:
        with pytest.raises(InputError, match=message):
            checked_array(values, "here", shape)


def test_the_first_value_that_is_not_finite_is_named() -> None:
    with pytest.raises(InputError, match="here, time of sample 1: found nan"):
        refuse_non_finite(np.array([0.0, np.nan]), ROWS[..., :2], ["x"], "here")
    rows = np.zeros((3, 2, 4))
    rows[1, 1, 2] = -np.inf
    with pytest.raises(InputError, match=r"velocity of 'y': found -inf at t = 0\.2 s \(sample 2"):
        refuse_non_finite(np.arange(4) / 10, rows, ["x", "y"], "here")
    refuse_non_finite(np.arange(4) / 10, np.zeros((3, 2, 4)), ["x", "y"], "here")


@pytest.mark.parametrize("coordinates", [[], ["x", "x"]])
def test_coordinates_are_one_or_more_each_once(coordinates: list[str]) -> None:
    with pytest.raises(InputError, match="one or more, each once"):
        refuse_repeated(coordinates, "here")


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_only_positive_numbers_are_positive(value: float) -> None:
    with pytest.raises(InputError, match="expected a positive number"):
        refuse_unless_positive(value, "here")
