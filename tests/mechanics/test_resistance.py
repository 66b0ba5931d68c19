"""Springs, dampers, friction and armature of a coordinate."""

from __future__ import annotations

import math

import pytest

from parakin.algebra.spatial import FLOATS
from parakin.mechanics.resistance import AT_REST, direction, resistance, smooth_direction
from parakin.model.dynamics import Passive

ALL = Passive(100.0, 0.2, 5.0, 0.1, 3.0, 4.0, 0.5)


def test_each_part_resists_in_its_way() -> None:
    found = resistance(ALL, 0.5, 2.0, 3.0, 1.0)
    assert found.effort == pytest.approx(100 * 0.3 + 5 * 1.9 + 3 * 2.0 + 4.0 + 0.5 * 3.0)
    assert found.band == 0.0
    assert found.stored == pytest.approx(0.5 * 100 * 0.3**2)
    assert found.lost == pytest.approx((5 * 1.9 + 3 * 2.0 + 4.0) * 2.0)


def test_friction_turns_with_the_motion_and_is_a_band_at_rest() -> None:
    friction = Passive(coulomb=4.0)
    assert resistance(friction, 0.0, -1.0, 0.0, direction(-1.0, FLOATS)).effort == -4.0
    resting = resistance(friction, 0.0, 0.0, 0.0, direction(0.0, FLOATS))
    assert (resting.effort, resting.band) == (0.0, 4.0)


@pytest.mark.parametrize("rate", [-math.inf, -1.0, -AT_REST, 0.0, 0.5 * AT_REST, AT_REST, 1e9])
def test_direction_is_the_sign_but_at_rest(rate: float) -> None:
    assert direction(rate, FLOATS) == pytest.approx(max(-1.0, min(1.0, rate / AT_REST)), rel=1e-15)


@pytest.mark.parametrize("rate", [-3.0, -0.1, 0.0, 0.1, 1e6])
def test_a_smooth_direction_is_the_sine_of_an_angle(rate: float) -> None:
    found = smooth_direction(rate, 0.1, FLOATS)
    assert found == pytest.approx(math.sin(math.atan2(rate, 0.1)), rel=1e-14)


def test_both_together_add_up() -> None:
    one = resistance(ALL, 0.5, 2.0, 3.0, 1.0)
    assert one.plus(one) == pytest.approx(tuple(2 * part for part in one))
