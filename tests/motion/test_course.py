"""The course of a motion: its interpolation is exact for quintics, its steps its own."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial
from numpy.testing import assert_allclose, assert_array_equal

from parakin.motion import laws
from parakin.motion.course import Course, hermite
from parakin.motion.laws import from_laws
from parakin.motion.motion import Motion
from parakin.motion.sampled import from_arrays

QUINTIC = Polynomial([0.3, -1.0, 2.0, 0.5, -0.7, 0.2])


@pytest.mark.parametrize("order", range(4))
def test_a_quintic_is_met_with_its_derivatives_between_and_beyond_the_nodes(order: int) -> None:
    nodes = np.array([-1.0, -0.2, 0.0, 0.7, 1.5])
    values = np.array([[QUINTIC.deriv(k)(nodes)] for k in range(3)])
    at = np.linspace(-1.2, 1.7, 60)
    expected = QUINTIC.deriv(order)(at)
    assert_allclose(hermite(nodes, values, at, order)[0], expected, rtol=0, atol=1e-10)


def by_law() -> Motion:
    moves = {"x": laws.polynomial345(0.0, 1.0, 1.2, 0.4), "y": laws.sine(0.0, 0.1, 2.0)}
    return from_laws("law", moves, 2.0, 50.0)


def by_samples() -> Motion:
    samples = by_law().samples()
    return from_arrays("samples", ["x", "y"], samples.time, *samples.orders)


@pytest.mark.parametrize("motion", [by_law(), by_samples()], ids=["law", "samples"])
def test_steps_are_the_motions_own(motion: Motion) -> None:
    """However they are asked for, piece by piece or at once, they are the same."""
    everything = Course(motion).steps(-1.0, 2.0)
    assert everything[0] == 0.0
    assert everything[-1] == 2.0
    assert (np.diff(everything) > 0).all()

    @settings(deadline=None)
    @given(st.floats(-0.5, 2.0), st.floats(0.0, 1.0), st.integers(1, 5))
    def check(after: float, span: float, most: int) -> None:
        until = min(after + span, 2.0)
        found = Course(motion).steps(after, until, most)
        rest = everything[everything > after]
        last = int(np.searchsorted(rest, until)) + 1
        assert_array_equal(found, rest[:last][:most])

    check()


def test_steps_end_at_every_knot() -> None:
    """Where the law begins and ends to move, at 0.4 s and 1.6 s, the motion is not smooth."""
    steps = Course(by_law()).steps(-1.0, 2.0)
    for knot in (0.4, 1.6):
        assert np.abs(steps - knot).min() < 1e-12


def test_values_between_samples_are_those_of_the_law_they_came_from() -> None:
    """h⁶/720 of the sixth derivative (4π rad/s)⁶ 0.1, where h = 20 ms: below 1e-9."""
    time = np.linspace(0.0, 2.0, 777)
    exact = Course(by_law()).at(time, 3)
    known = Course(by_samples()).at(time, 3)
    assert_allclose(known[0][1], exact[0][1], rtol=0, atol=1e-9)
    assert_array_equal(exact[0][1], 0.1 * np.sin(2 * np.pi * 2.0 * time))
