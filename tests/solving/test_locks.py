"""Where three iterated angles lock."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin.solving.locks import locks_of, near_lock, off_the_lock

LEGS = tuple(f"P{i}" for i in range(1, 7))


def test_only_joints_whose_three_angles_are_iterated_have_one() -> None:
    assert locks_of(parakin.compile("gough-stewart", machine_code=False).plan) == ()
    solver = parakin.compile("gough-stewart", LEGS, machine_code=False)
    ((row, lock),) = locks_of(solver.plan)
    assert solver.iterated[row] == "platform.pitch"
    assert lock == pytest.approx(np.pi / 2)


@pytest.mark.parametrize("turns", [-1.5, -0.5, 0.5, 1.5, 2.5])
def test_it_is_found_again_every_half_turn(turns: float) -> None:
    locks = ((1, np.pi / 2),)
    at = turns * np.pi
    found = np.array([[0.0, 0.0, 0.0], [at, at + 0.1, at + 0.3]])
    assert near_lock(locks, found).tolist() == [True, True, False]
    off = off_the_lock(locks, found)
    assert abs(off[1, 0] - at) == pytest.approx(1e-3, rel=1e-6)
    np.testing.assert_array_equal(off[:, 1:], found[:, 1:])
    assert found[1, 0] == at  # what was given is not changed


def test_a_number_that_is_none_stays_so() -> None:
    locks = ((0, np.pi / 2),)
    found = np.array([[np.nan, np.inf]])
    assert not near_lock(locks, found).any()
    np.testing.assert_array_equal(off_the_lock(locks, found), found)


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2])
def test_a_pose_is_found_from_the_lock_itself(pitch: float) -> None:
    solver = parakin.compile("gough-stewart", LEGS, machine_code=False)
    y = [solver.home[name] for name in LEGS]
    guess = np.array([solver.home[name] for name in solver.coordinates])
    guess[solver.coordinates.index("platform.pitch")] = pitch
    tick = solver.at(y, guess=guess)
    assert np.isfinite(tick.residual) or tick.status != 0
