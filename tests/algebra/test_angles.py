"""Angles by whole turns."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from parakin.algebra.angles import nearest_angle


@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3))
def test_it_is_the_same_direction_and_no_further_than_half_a_turn(angle: float, to: float) -> None:
    near = nearest_angle(angle, to)
    assert abs(near - to) <= math.pi * (1 + 1e-12) + 1e-12
    assert math.isclose(math.cos(near - angle), 1.0, abs_tol=1e-12)


def test_arrays_go_element_by_element() -> None:
    angles = np.array([0.0, 3.5, -3.5, 7.0, np.nan])
    expected = [0.0, 3.5 - 2 * np.pi, 2 * np.pi - 3.5, 7.0 - 2 * np.pi, np.nan]
    np.testing.assert_allclose(nearest_angle(angles), expected, atol=1e-15)
    assert nearest_angle(7.0, 7.5) == 7.0
