"""One pose, on every scalar."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin.algebra.spatial import ARRAYS, FLOATS, as_array
from parakin.kernel.outputs import Outputs
from parakin.kernel.pose import solve_pose

NAMES = ["flight-simulator", "gough-stewart", "four-bar", "six-bar-stephenson", "bricard"]


@pytest.mark.parametrize("name", NAMES)
def test_arrays_give_what_floats_give(name: str) -> None:
    plan = parakin.compile(name, machine_code=False).plan
    outputs = Outputs(tuple(range(len(plan.graph.plain.coordinates))))
    rng = np.random.default_rng(1)
    home = np.array([plan.home[k] - plan.offset(k) for k in plan.driven])
    y = home[:, None] + 0.02 * rng.uniform(-1, 1, (len(home), 5))
    yd, ydd = rng.normal(size=(2, len(home), 5))
    guess = np.array([plan.home[k] - plan.offset(k) for k in plan.iterated])
    guesses = list(guess[:, None].repeat(5, axis=1))
    batch = solve_pose(plan, [list(y), list(yd), list(ydd)], guesses, ARRAYS, outputs, 4)
    for k in range(5):
        orders = [order[:, k].tolist() for order in (y, yd, ydd)]
        single = solve_pose(plan, orders, guess.tolist(), FLOATS, outputs, 4)
        for one, other in zip(single, batch, strict=True):
            there = np.broadcast_to(as_array(other), 5)[k]
            np.testing.assert_allclose(as_array(one), there, rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize("name", NAMES)
def test_home_is_where_it_is(name: str) -> None:
    plan = parakin.compile(name, machine_code=False).plan
    count = len(plan.graph.plain.coordinates)
    outputs = Outputs(tuple(range(count)), derivatives=0)
    home = [float(plan.home[k] - plan.offset(k)) for k in range(count)]
    driven = [home[k] for k in plan.driven]
    guess = [float(plan.home[k] - plan.offset(k)) for k in plan.iterated]
    out = solve_pose(plan, [driven], guess, FLOATS, outputs, 2)
    found = as_array(out)
    np.testing.assert_allclose(found[outputs.order(0)], home, atol=1e-12)
    assert found[outputs.residual] < 1e-14
    assert found[outputs.conditioning] > 1e-3


def test_bodies_are_where_their_points_are_asked_for() -> None:
    """The crank's far end goes round a circle: position, velocity and acceleration by hand."""
    from parakin.algebra.spatial import Vector
    from parakin.kernel import outputs as rows

    plan = parakin.compile("four-bar", machine_code=False).plan
    crank = plan.graph.bodies.index("crank")
    outputs = Outputs((), 2, False, ((crank, Vector((0.04, 0.0, 0.0))),))
    q, qd, qdd = 0.6, 2.0, -3.0
    found = as_array(solve_pose(plan, [[q], [qd], [qdd]], [], FLOATS, outputs))
    along, across = np.array([np.cos(q), np.sin(q), 0.0]), np.array([-np.sin(q), np.cos(q), 0.0])
    np.testing.assert_allclose(found[rows.POSITION], 0.04 * along, atol=1e-15)
    np.testing.assert_allclose(found[rows.VELOCITY], 0.04 * qd * across, atol=1e-15)
    acceleration = 0.04 * (qdd * across - qd * qd * along)
    np.testing.assert_allclose(found[rows.ACCELERATION], acceleration, atol=1e-15)
    np.testing.assert_allclose(found[rows.ANGULAR_VELOCITY], [0.0, 0.0, qd], atol=1e-15)
    np.testing.assert_allclose(found[rows.ORIENTATION].reshape(3, 3)[:, 0], along, atol=1e-15)
