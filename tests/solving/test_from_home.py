"""From home to poses without a guess."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin.solving.from_home import home_state, home_values

LEGS = tuple(f"P{i}" for i in range(1, 7))


@pytest.mark.parametrize("name", ["flight-simulator", "gough-stewart", "3-rps"])
def test_home_is_what_the_solver_answers_there(name: str) -> None:
    solver = parakin.compile(name, coordinates="all", machine_code=False)
    tick = solver.at([solver.home[n] for n in solver.driven])
    values = home_values(solver.graph, solver.plan)
    for row, coordinate in enumerate(solver.coordinates):
        assert tick.position[row] == pytest.approx(values[coordinate], abs=1e-12)


def test_a_home_state_is_at_rest() -> None:
    solver = parakin.compile("gough-stewart", LEGS, machine_code=False)
    state = home_state(solver.chart)
    assert state.driven.shape == (3, 6)
    assert state.iterated.shape == (3, 6)
    assert not state.driven[1:].any()
    assert not state.iterated[1:].any()


def test_the_way_there_is_that_of_the_inverse() -> None:
    """Poses of the hexapod, their leg lengths by geometry, and back from the lengths alone."""
    inverse = parakin.compile("gough-stewart", machine_code=False)
    forward = parakin.compile("gough-stewart", LEGS, machine_code=False)
    rng = np.random.default_rng(4)
    home = np.array([inverse.home[name] for name in inverse.driven])
    pose = home[:, None] + np.array([0.2, 0.2, 0.2, 0.2, 0.2, 0.2])[:, None] * rng.uniform(
        -1, 1, (6, 20)
    )
    there = inverse.at(pose)
    assert not np.asarray(there.status).any()
    legs = np.array([there.value(name) for name in LEGS])
    back = forward.at(legs)
    assert not np.asarray(back.status).any()
    for row, name in enumerate(inverse.driven):
        np.testing.assert_allclose(back.value(name), pose[row], atol=1e-11)
