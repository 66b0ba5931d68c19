"""Springs, dampers, friction and armature of a coordinate."""

from __future__ import annotations

import math

import pytest

from parakin.algebra.dual import dual, dual_functions, rate_of
from parakin.algebra.spatial import ARRAYS, FLOATS, Functions
from parakin.mechanics.resistance import AT_REST, direction, resistance, smooth_direction
from parakin.model.dynamics import Passive

ALL = Passive(100.0, 0.2, 5.0, 0.1, 3.0, 4.0, 0.5)


def test_each_part_resists_in_its_way() -> None:
    found = resistance(ALL, 0.5, 2.0, 3.0, 1.0, FLOATS)
    assert found.effort == pytest.approx(100 * 0.3 + 5 * 1.9 + 3 * 2.0 + 4.0 + 0.5 * 3.0)
    assert found.band == 0.0
    assert found.stored == pytest.approx(0.5 * 100 * 0.3**2)
    assert found.lost == pytest.approx((5 * 1.9 + 3 * 2.0 + 4.0) * 2.0)


def test_friction_turns_with_the_motion_and_is_a_band_at_rest() -> None:
    friction = Passive(coulomb=4.0)
    assert resistance(friction, 0.0, -1.0, 0.0, direction(-1.0, FLOATS), FLOATS).effort == -4.0
    resting = resistance(friction, 0.0, 0.0, 0.0, direction(0.0, FLOATS), FLOATS)
    assert (resting.effort, resting.band) == (0.0, 4.0)


@pytest.mark.parametrize("rate", [-math.inf, -1.0, -AT_REST, 0.0, 0.5 * AT_REST, AT_REST, 1e9])
def test_direction_is_the_sign_but_at_rest(rate: float) -> None:
    assert direction(rate, FLOATS) == pytest.approx(max(-1.0, min(1.0, rate / AT_REST)), rel=1e-15)


@pytest.mark.parametrize("rate", [-3.0, -0.1, 0.0, 0.1, 1e6])
def test_a_smooth_direction_is_the_sine_of_an_angle(rate: float) -> None:
    found = smooth_direction(rate, 0.1, FLOATS)
    assert found == pytest.approx(math.sin(math.atan2(rate, 0.1)), rel=1e-14)


def test_both_together_add_up() -> None:
    one = resistance(ALL, 0.5, 2.0, 3.0, 1.0, FLOATS)
    assert one.plus(one) == pytest.approx(tuple(2 * part for part in one))


STOP = Passive(stop=1e4, dissipation=2.0, low=-0.1, high=0.3)


@pytest.mark.parametrize("functions", [FLOATS, ARRAYS, dual_functions(FLOATS)])
@pytest.mark.parametrize(
    ("value", "rate", "effort"),
    [
        (0.0, 5.0, 0.0),
        (0.3, 5.0, 0.0),
        (0.31, 0.0, 100.0),
        (0.31, 0.25, 150.0),
        (0.31, -0.25, 50.0),
        (0.31, -3.0, 0.0),  # it comes back faster than the stop, which does not pull
        (-0.12, 0.0, -200.0),
        (-0.12, -0.25, -300.0),
        (-0.12, 0.25, -100.0),
        (-0.12, 3.0, 0.0),
        (math.nan, 1.0, math.nan),
        (0.31, math.nan, math.nan),
    ],
)
def test_a_stop_pushes_beyond_the_limits(
    functions: Functions, value: float, rate: float, effort: float
) -> None:
    found = resistance(STOP, value, rate, 0.0, 0.0, functions)
    assert found.effort == pytest.approx(effort, nan_ok=True)
    if math.isfinite(value) and math.isfinite(rate):
        depth = max(value - 0.3, -0.1 - value, 0.0)
        assert found.stored == pytest.approx(0.5e4 * depth**2)
        kept = math.copysign(1e4 * depth, value)
        assert found.lost == pytest.approx((effort - kept) * rate)


def test_a_stop_at_one_end_alone() -> None:
    found = resistance(Passive(stop=1e4, high=0.3), -5.0, 0.0, 0.0, 0.0, FLOATS)
    assert found == (0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(("value", "stiffness"), [(0.0, 0.0), (0.31, 1e4), (-0.2, 1e4)])
def test_the_stiffness_of_a_stop_by_dual_numbers(value: float, stiffness: float) -> None:
    found = resistance(STOP, dual(value, 1.0), 0.0, 0.0, 0.0, dual_functions(FLOATS))
    assert rate_of(found.effort) == pytest.approx(stiffness)
