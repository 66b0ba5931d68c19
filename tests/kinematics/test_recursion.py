"""Velocities and accelerations of the recursion against differentiation, which knows no recursion.

Automatic differentiation: the kernel runs on second-order jets of 40 digits, so that its positions
alone carry their first and second derivatives along a motion. Finite differences: of the solved
positions of bodies.
"""

from __future__ import annotations

from collections.abc import Callable

import closed_form
import numpy as np
import pytest
from closed_form import MP, Jet, jet
from jets import jet_functions
from scipy.spatial.transform import Rotation

import parakin
from parakin.arrays import ORDERS
from parakin.kernel.outputs import Outputs
from parakin.kernel.pose import solve_pose

Compiled = Callable[..., parakin.Solver]


@pytest.mark.parametrize("driven", [(), ("A2", "B3", "C3"), ("platform.x", "A1", "C3")])
def test_rates_agree_with_automatic_differentiation(driven: tuple[str, ...], reading: bool) -> None:
    def compiled(*driven: str) -> parakin.Solver:
        return parakin.compile(
            "flight-simulator",
            driven or None,
            coordinates="all",
            derivatives=3,
            machine_code=reading,
        )

    solver = compiled(*driven)
    names, cones = solver.coordinates, solver.graph.cones
    inverse = compiled().solve("general").sel(time=1.25)
    drives = inverse.sel(coordinate=list(solver.driven))
    y, yd, ydd, yddd = (drives[q].values for q in ORDERS)
    guess = inverse.position.sel(coordinate=list(solver.coordinates)).values
    tick = solver.at(y, yd, ydd, guess, yddd=yddd)
    assert tick.status == 0
    at = dict(zip(solver.coordinates, tick.position, strict=True))
    numbers = [n if n in cones else solver.graph.index(n, "test") for n in names]
    started = [MP.mpf(at[solver.graph.coordinates[k].name]) for k in solver.plan.iterated]
    outputs = Outputs(tuple(numbers), derivatives=0)
    jets = [Jet(*map(MP.mpf, orders)) for orders in zip(y, yd, ydd, yddd, strict=True)]
    found = solve_pose(solver.plan, [jets], [Jet(q) for q in started], jet_functions(), outputs, 3)
    exact = [jet(q) for q in found[: len(names)]]
    for quantity, part, bound in (
        (tick.position, "value", 1e-13),
        (tick.velocity, "rate", 1e-13),
        (tick.acceleration, "accel", 1e-12),
        (tick.jerk, "jerk", 1e-11),
    ):
        ours = dict(zip(solver.coordinates, quantity, strict=True))
        for name, value in zip(names, exact, strict=True):
            assert abs(ours[name] - float(getattr(value, part))) < bound, (name, part)
    assert float(jet(found[len(names)]).value) < 1e-14  # the residual of those positions


def test_bodies_move_as_their_positions_say(compiled: Compiled) -> None:
    # Central differences of order four at 1 kHz: truncation (w h)^4 is below 1e-12 for motions of
    # a second or so, round-off 1e-16 / h = 1e-13 for velocity and 1e-16 / h^2 = 1e-10 beyond.
    result = compiled().solve("general", bodies=True)
    h = 1e-3
    w = result.body_angular_velocity.values
    for first, second, bound in (
        (result.body_position.values, result.body_velocity.values, 5e-12),
        (result.body_velocity.values, result.body_acceleration.values, 5e-12),
        (w, result.body_angular_acceleration.values, 5e-12),
    ):
        slope = (first[:-4] - 8 * first[1:-3] + 8 * first[3:-1] - first[4:]) / (12 * h)
        np.testing.assert_allclose(slope, second[2:-2], rtol=0, atol=bound)
    for b in range(result.sizes["body"]):
        turns = Rotation.from_quat(result.body_orientation.values[:, b], scalar_first=True)
        step = (turns[2:] * turns[:-2].inv()).as_rotvec() / (2 * h)
        np.testing.assert_allclose(step, w[1:-1, b], rtol=0, atol=1e-6)  # second order


def test_bodies_meet_at_their_joints(compiled: Compiled) -> None:
    points = ["platform", "platform.G", "platform.B4", "rod.D2", "base.F"]
    result = compiled().solve("general", bodies=points)
    position = result.body_position
    np.testing.assert_allclose(
        position.sel(body="platform.G"), position.sel(body="platform"), rtol=0, atol=1e-15
    )
    driven = result.position.sel(coordinate=["platform.x", "platform.y"]).values
    np.testing.assert_allclose(
        position.sel(body="platform.G").values[:, :2], driven, rtol=0, atol=1e-15
    )
    # D2 stays l3 from D1, B4 one leg's length from B1.
    from_d1 = position.sel(body="rod.D2").values - [1.6, 0, 0]
    np.testing.assert_allclose(np.linalg.norm(from_d1, axis=1), 1.3, rtol=0, atol=1e-14)
    from_b1 = position.sel(body="platform.B4").values - [1.85, 0, 1.35]
    stroke = result.position.sel(coordinate="B3").values
    np.testing.assert_allclose(np.linalg.norm(from_b1, axis=1), 1.33 + stroke, atol=1e-14)


def test_orientation_angles_are_those_of_equation_3(compiled: Compiled) -> None:
    result = compiled().solve("general", bodies=["platform"])
    psi, phi = (result.position.sel(coordinate=f"platform.{n}").values for n in ("psi", "phi"))
    gamma0 = float(closed_form.home(closed_form.Parameters()).gamma0)
    expected = Rotation.from_euler("ZX", np.column_stack([psi + gamma0, phi]))
    ours = Rotation.from_quat(result.body_orientation.values[:, 0], scalar_first=True)
    assert float((expected * ours.inv()).magnitude().max()) < 1e-14


def test_both_readings_agree() -> None:
    arrays = parakin.compile("flight-simulator", coordinates="all", machine_code=False)
    code = parakin.compile("flight-simulator", coordinates="all")
    ours, theirs = arrays.solve("general", bodies=True), code.solve("general", bodies=True)
    for name in ours.data_vars:
        np.testing.assert_allclose(ours[name], theirs[name], rtol=0, atol=2e-14)
