"""What `at` is given: shapes, soundness, and guesses in parts."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin import InputError
from parakin.solving.inputs import all_bounded, stacked

LEGS = tuple(f"P{i}" for i in range(1, 7))


def test_orders_are_stacked_and_zero_where_not_given() -> None:
    found = stacked(2, 2, [1.0, 2.0], (None, [5.0, 6.0], None))
    np.testing.assert_array_equal(found, [1, 2, 0, 0, 5, 6])
    batch = stacked(1, 1, [[1.0, 2.0, 3.0]], (None,))
    np.testing.assert_array_equal(batch, [[1, 2, 3], [0, 0, 0]])
    np.testing.assert_array_equal(stacked(2, 0, [1.0, 2.0], ()), [1, 2])


@pytest.mark.parametrize(
    ("y", "yd", "said"),
    [
        ([1.0, 2.0, 3.0], None, "y: found shape (3,); expected (2,) or (2, n)"),
        (1.0, None, "y: found shape ()"),
        ([[[1.0]], [[2.0]]], None, "y: found shape (2, 1, 1)"),
        ([1.0, 2.0], [1.0], "yd: found shape (1,); expected (2,), that of y"),
        ([1.0, "b"], None, "y: found could not convert string"),
    ],
)
def test_other_shapes_are_refused(y: object, yd: object, said: str) -> None:
    with pytest.raises(InputError) as error:
        stacked(2, 1, y, (yd,))  # type: ignore[arg-type]
    assert said in str(error.value)


@pytest.mark.parametrize("shape", [(4,), (4, 3)])
@pytest.mark.parametrize("wild", [np.nan, np.inf, -np.inf, 1e101, -1e200])
def test_one_number_that_is_none_or_too_large_shows(shape: tuple[int, ...], wild: float) -> None:
    plain = np.ones(shape)
    assert all_bounded(plain)
    other = plain.copy()
    other.flat[-1] = wild
    assert not all_bounded(other)
    assert not all_bounded(plain, other)


@pytest.mark.parametrize("machine_code", [False, True])
def test_angles_come_out_within_half_a_turn_of_the_guess(machine_code: bool) -> None:
    if machine_code and not parakin.compile("four-bar").machine_code:
        pytest.skip("heyoka is not installed")
    solver = parakin.compile("four-bar", coordinates="all", machine_code=machine_code)
    y = [solver.home["A"]]
    plain = solver.at(y)
    turns = np.array([0.0, 2.0, -3.0, 1.0])[: len(plain.position)]
    turned = solver.at(y, guess=plain.position + 2 * np.pi * turns + 0.1)
    driven = solver.coordinates.index("A")
    expected = plain.position + 2 * np.pi * turns
    for row in range(len(turns)):
        if row != driven:
            assert turned.position[row] == pytest.approx(expected[row], abs=1e-12)


def test_a_guess_that_is_no_number_fails_its_own_column_only() -> None:
    solver = parakin.compile("gough-stewart", LEGS, machine_code=False)
    home = np.array([solver.home[name] for name in solver.coordinates])
    y = np.array([solver.home[name] for name in LEGS])[:, None].repeat(3, axis=1)
    guess = home[:, None].repeat(3, axis=1)
    guess[0, 1] = np.nan
    status = np.asarray(solver.at(y, guess=guess).status)
    assert status.tolist()[::2] == [0, 0]
    assert status[1] != 0


def test_iterated_coordinates_that_are_not_reported_need_a_tick() -> None:
    solver = parakin.compile("gough-stewart", LEGS, coordinates=["platform.x"], machine_code=False)
    y = [solver.home[name] for name in LEGS]
    tick = solver.at(y)
    assert len(tick.iterated) == len(solver.iterated) == 6
    np.testing.assert_allclose(solver.at(y, guess=tick).position, tick.position, atol=1e-14)
    with pytest.raises(InputError, match="are iterated and not among the coordinates"):
        solver.at(y, guess=tick.position)
    other = parakin.compile("four-bar", coordinates=["B"], machine_code=False)
    with pytest.raises(InputError, match="a Tick of another solver"):
        solver.at(y, guess=other.at([other.home["A"]]))
