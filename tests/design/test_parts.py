"""Ends over steps, room within bounds, and the choice of coordinates, by hand."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin.design.bounds import Bounds, room, speed_bounds
from parakin.design.choice import driven_for
from parakin.design.ends import judged
from parakin.solving.stops import Stops

PLATFORM = tuple(f"platform.{name}" for name in ("x", "y", "z", "roll", "pitch", "yaw"))


def states(polynomial: np.polynomial.Polynomial, at: float) -> np.ndarray:
    orders = (polynomial, polynomial.deriv(), polynomial.deriv(2))
    return np.array([[[order(at)]] for order in orders])


@pytest.mark.parametrize(
    ("roots", "kept", "met"),
    [
        ([2.0], True, False),  # still below
        ([0.5], False, True),  # once through
        ([0.4, 0.6], False, False),  # above in between, and back
        ([0.4, 0.5, 0.6], False, False),  # through, back, and through again
    ],
)
def test_a_step_is_kept_met_once_or_looked_at_more_closely(
    roots: list[float], kept: bool, met: bool
) -> None:
    polynomial = np.polynomial.Polynomial.fromroots(roots)
    polynomial *= -np.sign(polynomial(0.0))
    before, after = states(polynomial, 0.0), states(polynomial, 1.0)
    found = judged(np.ones(1), before, after, np.full(1, 1e-12))
    assert (found.kept.item(), found.met.item()) == (kept, met)


def test_what_is_not_known_is_neither_kept_nor_met() -> None:
    unknown = np.full((3, 1, 1), np.nan)
    found = judged(np.ones(1), -np.ones((3, 1, 1)), unknown, np.zeros(1))
    assert not found.kept.any()
    assert not found.met.any()


def two(low: float, high: float) -> Bounds:
    stops = Stops(("", "A", "B"), ("", "m", "m"), (np.nan, low, low), (np.nan, high, high))
    return Bounds((0, 1), np.full(2, low), np.full(2, high), stops)


def test_room_is_what_the_first_bound_leaves() -> None:
    found = room(two(-1.0, 3.0), np.array([0.0, 1.0]), np.array([[1.0, 0.0], [2.0, -1.0]]))
    assert found.amount.tolist() == [[-1.0, 1.0], [-2.0, 2.0]]
    assert found.number.tolist() == [[0, 1], [1, 1]]
    assert found.upper.tolist() == [[False, True], [True, False]]


def test_there_is_no_room_beyond_a_bound_and_none_known_without_numbers() -> None:
    beyond = room(two(-1.0, 1.0), np.array([1.5, 0.0]), np.ones((2, 1)))
    assert beyond.amount.tolist() == [[0.0, 0.0]]
    assert beyond.number.tolist() == [[0, 0]]
    assert beyond.upper.tolist() == [[True, True]]
    assert np.isnan(room(two(-1.0, 1.0), np.array([np.nan, 0.0]), np.ones((2, 1))).amount).all()


def test_what_does_not_grow_is_not_bounded() -> None:
    found = room(two(-1.0, 1.0), np.zeros(2), np.array([[0.0], [1e-20]]))
    assert np.isfinite(found.amount).all()  # by the only slope that there is
    assert np.isinf(room(two(-1.0, 1.0), np.zeros(2), np.zeros((2, 1))).amount).all()


def test_speeds_are_bounded_by_limits_and_drives() -> None:
    hexapod = parakin.compile("gough-stewart")
    found = speed_bounds(hexapod.graph)
    assert found.high.tolist() == [0.8] * 6
    assert found.words(0, upper=True) == "P1.velocity > 0.8 m/s"
    assert found.words(-1, upper=True) == ""


def test_the_platform_is_moved_where_the_file_drives_legs() -> None:
    given = parakin.load("gough-stewart").model_dump(exclude_unset=True)
    legs = parakin.Mechanism(**given | {"driven": tuple(f"P{k}" for k in range(1, 7))})
    assert driven_for(legs) == PLATFORM
    own = parakin.load("flight-simulator")
    assert driven_for(own) == own.driven
    assert driven_for(parakin.load("slider-crank")) == ("A",)


def test_independent_ones_of_the_platform_are_chosen() -> None:
    given = parakin.load("3-rps").model_dump(exclude_unset=True)
    legs = [joint["name"] for joint in given["joints"] if joint.get("actuated")]
    chosen = driven_for(parakin.Mechanism(**given | {"driven": tuple(legs)}))
    assert set(chosen) == {"platform.z", "platform.roll", "platform.pitch"}
