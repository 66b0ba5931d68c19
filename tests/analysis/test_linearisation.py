"""Small motions, against closed forms and against what a simulation begins with."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import parakin
from parakin import InputError
from parakin.analysis.linearisation import Linearisation
from parakin.model.drives import Damper, Spring

SWING = """
name = "swing"
up = "y"
driven = ["A"]
home.A = "-90 deg"
[bodies]
arm = { mass = 2, com = [0.5, 0, 0], inertia = [0.1, 0.1, 0.1] }
[joints.A]
kind = "revolute"
parent = "base"
child = "arm"
"""
INERTIA, WEIGHT = 0.1 + 2 * 0.5**2, 2 * 0.5 * 9.80665


def swing(folder: Path, more: str = "") -> parakin.Solver:
    (folder / "swing.toml").write_text(SWING + more)
    return parakin.compile(folder / "swing.toml", machine_code=False)


def test_a_hanging_pendulum(tmp_path: Path) -> None:
    found = parakin.linearise(swing(tmp_path))
    assert (found.driven, found.actuators) == (("A",), ("A",))
    assert found.mass[0, 0] == pytest.approx(INERTIA)
    assert found.stiffness[0, 0] == pytest.approx(WEIGHT)
    assert found.damping == pytest.approx(0.0, abs=1e-15)
    frequencies, shapes = found.modes()
    assert frequencies == pytest.approx([math.sqrt(WEIGHT / INERTIA) / (2 * math.pi)])
    assert shapes[0, 0] ** 2 * INERTIA == pytest.approx(1.0)
    omega = math.sqrt(WEIGHT / INERTIA)
    assert sorted(found.poles.imag) == pytest.approx([-omega, omega])
    assert found.poles.real == pytest.approx(0.0, abs=1e-12)


def test_an_upright_one_falls(tmp_path: Path) -> None:
    found = parakin.linearise(swing(tmp_path), [math.pi / 2])
    assert found.stiffness[0, 0] == pytest.approx(-WEIGHT)
    assert found.modes()[0] == pytest.approx([-math.sqrt(WEIGHT / INERTIA) / (2 * math.pi)])
    assert found.poles.real.max() == pytest.approx(math.sqrt(WEIGHT / INERTIA))


def test_springs_dampers_and_armatures_count_and_coulomb_friction_does_not(tmp_path: Path) -> None:
    more = (
        "spring = { stiffness = 5, zero = '-90 deg' }\ndamper = { damping = 0.3 }\narmature = 0.2\n"
    )
    more += "friction = { coulomb = 2, viscous = 0.1 }\n"
    found = parakin.linearise(swing(tmp_path, more))
    assert found.mass[0, 0] == pytest.approx(INERTIA + 0.2)
    assert found.stiffness[0, 0] == pytest.approx(WEIGHT + 5)
    assert found.damping[0, 0] == pytest.approx(0.4)
    m, d, k = INERTIA + 0.2, 0.4, WEIGHT + 5
    assert sorted(found.poles.imag) == pytest.approx(
        [sign * math.sqrt(k / m - (d / (2 * m)) ** 2) for sign in (-1, 1)]
    )
    assert found.poles.real == pytest.approx(-d / (2 * m))


def loaded(name: str) -> parakin.Solver:
    """With a spring and a damper in the first actuated joint, and a payload."""
    mechanism = parakin.load(name)
    joints = list(mechanism.joints)
    place = next(k for k, joint in enumerate(joints) if joint.actuated)
    acting = {"spring": (Spring(stiffness=300.0),), "damper": (Damper(damping=20.0),)}
    joints[place] = joints[place].model_copy(update=acting)
    body = mechanism.platform.body if mechanism.platform else mechanism.bodies[-1].name
    told = mechanism.model_copy(update={"joints": tuple(joints)}).with_payload(f"30 kg at {body}")
    return parakin.compile(told, coordinates="all")


def first_accelerations(
    solver: parakin.Solver, held: dict[str, float], y: Any, yd: Any
) -> np.ndarray:
    """Of the driven coordinates, where a simulation begins."""
    start, velocity = (dict(zip(solver.driven, x.tolist(), strict=True)) for x in (y, yd))
    ds = solver.simulate(1e-4, held, start=start, velocity=velocity, rate=1e4, rest_speed=1e6)
    found = ds["acceleration"].sel(coordinate=list(solver.driven)).values[0]
    return np.asarray(found, dtype=float)


@pytest.mark.parametrize("name", ["flight-simulator", "seat-3dof", "delta"])
def test_it_is_the_slope_of_what_a_simulation_begins_with(name: str) -> None:
    solver = loaded(name)
    found = parakin.linearise(solver)
    held = dict(zip(found.actuators, found.efforts.tolist(), strict=True))
    home, n = np.array([solver.home[c] for c in solver.driven]), len(solver.driven)
    A, B, C, D = found.state_space
    step = 1e-4
    for k in range(2 * n):
        offset = step * np.eye(2 * n)[k]
        ends = [
            first_accelerations(solver, held, home + sign * offset[:n], sign * offset[n:])
            for sign in (-1.0, 1.0)
        ]
        slope = (ends[1] - ends[0]) / (2 * step)
        assert A[n:, k] == pytest.approx(slope, abs=1e-5 * np.abs(A).max())
    for j, name_ in enumerate(found.actuators):
        more = held | {name_: held[name_] + 1.0}
        gained = first_accelerations(solver, more, home, np.zeros(n))
        assert B[n:, j] == pytest.approx(gained, rel=1e-6, abs=1e-7)
    assert np.array_equal(A[:n], np.eye(n, 2 * n, n))
    assert not B[:n].any()
    assert not D.any()
    tick = solver.at(home, np.arange(1.0, n + 1))
    rates = [tick.value(actuator, "velocity") for actuator in found.actuators]
    assert C[:, :n] @ np.arange(1.0, n + 1) == pytest.approx(rates)


def test_modes_diagonalise() -> None:
    found = parakin.linearise(loaded("flight-simulator"))
    frequencies, shapes = found.modes()
    assert shapes.T @ found.mass @ shapes == pytest.approx(np.eye(3), abs=1e-9)
    squares = np.sign(frequencies) * (2 * math.pi * frequencies) ** 2
    assert shapes.T @ found.stiffness @ shapes == pytest.approx(np.diag(squares), abs=1e-6)
    assert (np.diff(frequencies) >= 0).all()


def test_what_is_not_at_rest_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"y: found a pose with -9\.807 N m in A that"):
        parakin.linearise(swing(tmp_path), [0.0])
    held = parakin.linearise(swing(tmp_path), [0.0], efforts={"A": WEIGHT})
    assert isinstance(held, Linearisation)
    assert held.stiffness[0, 0] == pytest.approx(0.0, abs=1e-12)
    with pytest.raises(InputError, match="'B', not actuated"):
        parakin.linearise(swing(tmp_path), efforts={"B": 1.0})
    with pytest.raises(InputError, match="a pose that is not solved"):
        parakin.linearise(loaded("delta"), [0.0, 0.0, 9.0])
    with pytest.raises(InputError, match="nothing that makes forces"):
        parakin.linearise(parakin.compile("four-bar"))


def ziegler(folder: Path, force: float) -> parakin.Solver:
    """Two links of 1 m, springs of 1 N m, masses of 2 and 1 kg at their ends, under a force that
    follows the second one.
    """
    light = "com = [1, 0, 0], inertia = [1e-12, 1e-12, 1e-12]"
    (folder / "ziegler.toml").write_text(f"""
name = "ziegler"
gravity = 0
driven = ["A", "B"]
home.A = 0
home.B = 0
[bodies]
a = {{ mass = 2, {light} }}
b = {{ mass = 1, {light} }}
[joints.A]
kind = "revolute"
parent = "base"
child = "a"
spring = {{ stiffness = 1 }}
[joints.B]
kind = "revolute"
parent = "a"
child = "b"
on_parent = {{ at = [1, 0, 0] }}
spring = {{ stiffness = 1 }}
[forces.P]
kind = "wrench"
at = "b"
force = [{-force}, 0, 0]
axes = "body"
""")
    return parakin.compile(folder / "ziegler.toml", machine_code=False)


@pytest.mark.parametrize("force", [1.0, 2.0, 2.5])
def test_modes_under_a_force_that_follows(tmp_path: Path, force: float) -> None:
    """Ziegler's column: M = [[3, 1], [1, 1]] in absolute angles, and K as he has it; it flutters
    where (7 - 2 P)² < 8, from 2.086 N on.
    """
    found = parakin.linearise(ziegler(tmp_path, force))
    matrix = np.linalg.solve(
        np.array([[3.0, 1.0], [1.0, 1.0]]), np.array([[2.0 - force, force - 1.0], [-1.0, 1.0]])
    )
    squares = np.sort_complex(np.linalg.eigvals(matrix).astype(complex))
    frequencies = found.modes()[0]
    if force < 2.086:
        assert frequencies == pytest.approx(np.sqrt(squares.real) / (2 * math.pi), rel=1e-6)
    else:
        assert np.isnan(frequencies).all()
        assert found.poles.real.max() > 0.1


def test_what_is_light_must_rest_too(tmp_path: Path) -> None:
    """A gram that falls, beside a truck."""
    (tmp_path / "big.toml").write_text("""
name = "big"
up = "y"
driven = ["A", "Z"]
home.A = 0
home.Z = 0
[bodies]
arm = { mass = "1 g", com = [0.1, 0, 0], inertia = [1e-6, 1e-6, 1e-6] }
truck = { mass = "10000 kg" }
[joints.A]
kind = "revolute"
parent = "base"
child = "arm"
[joints.Z]
kind = "prismatic"
parent = "base"
child = "truck"
on_parent = { axis = [1, 0, 0] }
on_child = { axis = [1, 0, 0] }
spring = { stiffness = "1 N/m" }
""")
    big = parakin.compile(tmp_path / "big.toml", machine_code=False)
    with pytest.raises(InputError, match="N m in A that nothing balances"):
        parakin.linearise(big)
    hanging = parakin.linearise(big, [-math.pi / 2, 0.0])
    arm = math.sqrt(1e-3 * 9.80665 * 0.1 / (1e-6 + 1e-5)) / (2 * math.pi)
    assert hanging.modes()[0] == pytest.approx([math.sqrt(1 / 1e4) / (2 * math.pi), arm], rel=1e-9)


def test_a_payload_alone_hangs_in_equilibrium(tmp_path: Path) -> None:
    (tmp_path / "swing.toml").write_text("""
name = "swing"
up = "y"
driven = ["A"]
home.A = "-90 deg"
[bodies]
arm = { points = { tip = [0.5, 0, 0] } }
[joints.A]
kind = "revolute"
parent = "base"
child = "arm"
[forces.p]
kind = "payload"
at = "arm.tip"
mass = "2 kg"
""")
    found = parakin.linearise(parakin.compile(tmp_path / "swing.toml", machine_code=False))
    assert found.modes()[0] == pytest.approx([math.sqrt(9.80665 / 0.5) / (2 * math.pi)], rel=1e-9)
    swing = parakin.compile(tmp_path / "swing.toml", machine_code=False)
    with pytest.raises(InputError, match=r"y: found shape \(1, 2\)"):
        parakin.linearise(swing, np.zeros((1, 2)))
    with pytest.raises(InputError, match="efforts of A: found nan"):
        parakin.linearise(swing, efforts={"A": math.nan})
