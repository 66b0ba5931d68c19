"""Verdicts on what `at` worked out."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin import Status

LEGS = tuple(f"P{i}" for i in range(1, 7))


@pytest.mark.parametrize("machine_code", [False, None])
def test_failures_are_nan_and_leave_their_neighbours_alone(machine_code: bool | None) -> None:
    solver = parakin.compile("four-bar", ["D"], coordinates="all", machine_code=machine_code)
    home = solver.home["D"]
    y = np.array([[home, home + 3.0, np.nan, home, np.inf, 1e150]])
    tick = solver.at(y)
    status = np.asarray(tick.status)
    good = status == Status.CONVERGED
    assert good.tolist() == [True, False, False, True, False, False]
    for part in (tick.position, tick.velocity, tick.acceleration):
        assert np.isfinite(part[:, good]).all()
        assert np.isnan(part[:, ~good]).all()
    assert (status[2:5:2] == Status.OUT_OF_REACH).all()
    for k in range(y.shape[1]):
        alone = solver.at(y[:, k])
        assert alone.status == status[k]
        np.testing.assert_array_equal(alone.position, tick.position[:, k])


@pytest.mark.parametrize("order", [1, 2])
def test_rates_that_are_no_numbers_are_flagged(order: int) -> None:
    solver = parakin.compile("flight-simulator", machine_code=False)
    y = np.array([solver.home[name] for name in solver.driven])[:, None].repeat(3, axis=1)
    given = [y, np.zeros_like(y), np.zeros_like(y)]
    given[order][1, 1] = np.nan
    status = np.asarray(solver.at(*given).status)
    assert status.tolist() == [0, Status.OUT_OF_REACH, 0]


def test_without_checks_only_nan_is_flagged() -> None:
    solver = parakin.compile("four-bar", ["D"], checks=False, machine_code=False)
    home = solver.home["D"]
    tick = solver.at([[home, home + 3.0]])
    assert np.asarray(tick.status).tolist() == [0, Status.OUT_OF_REACH]
    assert np.isnan(tick.residual).all()
    assert np.isnan(tick.conditioning).all()


def test_what_comes_out_too_far_from_the_guess_is_another_branch() -> None:
    solver = parakin.compile("gough-stewart", LEGS, coordinates="all", machine_code=False)
    y = np.array([solver.home[name] for name in LEGS])
    guess = np.array([solver.home[name] for name in solver.coordinates])
    moved = y + 0.05
    assert solver.at(moved, guess=guess).status == Status.CONVERGED
    assert solver.at(moved, guess=guess, within=1e-3).status == Status.BRANCH_CHANGE
    assert solver.at(moved, guess=guess, within=1.0).status == Status.CONVERGED


def test_a_cone_angle_of_exactly_zero_has_no_rate_and_is_still_solved() -> None:
    solver = parakin.compile("3-rps", coordinates="all", machine_code=False)
    tick = solver.at([solver.home[name] for name in solver.driven])
    assert tick.status == Status.CONVERGED
