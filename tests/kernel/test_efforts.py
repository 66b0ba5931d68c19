"""Efforts and reactions of small mechanisms by hand; what is linear; what is redundant."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import parakin
from parakin import InputError, Joint, Mechanism
from parakin.model.drives import Friction

PENDULUM = """
name = "pendulum"
up = "y"
gravity = 10
driven = ["A"]
[bodies]
arm = { mass = 2, com = [0.5, 0, 0], inertia = [0.1, 0.2, 0.3] }
[joints.A]
kind = "revolute"
parent = "base"
child = "arm"
actuated = true
"""


@pytest.fixture
def pendulum(tmp_path: Path) -> parakin.Solver:
    (tmp_path / "pendulum.toml").write_text(PENDULUM)
    return parakin.compile(tmp_path / "pendulum.toml")


def test_a_pendulum_is_the_textbooks(pendulum: parakin.Solver) -> None:
    q, qd, qdd = 0.4, 1.5, -2.0
    forces = pendulum.at([q], [qd], [qdd], reactions=True).forces
    assert forces is not None
    m, r, g = 2.0, 0.5, 10.0
    assert forces.effort[0] == pytest.approx((0.3 + m * r * r) * qdd + m * g * r * math.cos(q))
    assert forces.power[0] == pytest.approx(forces.effort[0] * qd)
    # Along the base's axes, at the pivot: m (a_C - g).
    along, across = np.array([math.cos(q), math.sin(q)]), np.array([-math.sin(q), math.cos(q)])
    pull = m * (r * qdd * across - r * qd**2 * along + [0.0, g])
    assert forces.reaction_force[0] == pytest.approx([*pull, 0.0])
    assert forces.reaction_moment[0] == pytest.approx([0.0, 0.0, forces.effort[0]])
    assert forces.imbalance == pytest.approx(0.0, abs=1e-14)


def test_a_batch_is_its_poses_one_by_one(pendulum: parakin.Solver) -> None:
    y, yd, ydd = np.random.default_rng(3).uniform(-1.0, 1.0, (3, 1, 11))
    batch = pendulum.at(y, yd, ydd, reactions=True, energies=True).forces
    assert batch is not None
    for k in range(11):
        alone = pendulum.at(y[:, k], yd[:, k], ydd[:, k], reactions=True, energies=True).forces
        assert alone is not None
        assert alone.effort == pytest.approx(batch.effort[:, k], rel=1e-15)
        assert alone.reaction_force == pytest.approx(batch.reaction_force[..., k], rel=1e-14)
        assert alone.kinetic == pytest.approx(np.asarray(batch.kinetic)[k], rel=1e-15)


def test_numpy_and_machine_code_agree() -> None:
    for name, motion in (("flight-simulator", "general"), ("seat-3dof", "sway")):
        fast, plain = (parakin.compile(name, machine_code=code) for code in (None, False))
        a, b = (s.solve(motion, reactions=True, energies=True) for s in (fast, plain))
        for variable in ("effort", "motor_torque", "reaction_force", "kinetic_energy"):
            scale = np.nanmax(np.abs(b[variable].values))
            assert a[variable].values == pytest.approx(
                b[variable].values, rel=1e-10, abs=1e-11 * scale, nan_ok=True
            )


def test_windows_and_threads_change_nothing() -> None:
    solver = parakin.compile("gough-stewart")
    whole = solver.solve("tour", reactions=["P1"])
    parts = list(solver.stream("tour", 777, reactions=["P1"], parallel=True))
    for name in ("effort", "power", "reaction_force", "motor_torque", "effort_conditioning"):
        joined = np.concatenate([part[name].values for part in parts])
        assert joined == pytest.approx(whole[name].values, rel=1e-12, abs=1e-10)


def redundant() -> Mechanism:
    """The catalogue's four-bar with masses and two motors."""
    four_bar = parakin.load("four-bar")
    joints = [j.model_copy(update={"actuated": j.name in ("A", "D")}) for j in four_bar.joints]
    bodies = [
        b if b.name == "base" else b.model_copy(update={"mass": 1.0, "com": (0.1, 0.02, 0.0)})
        for b in four_bar.bodies
    ]
    told = {"joints": tuple(joints), "bodies": tuple(bodies)}
    return four_bar.model_copy(update=told)


def test_more_actuators_than_freedoms_share_as_told() -> None:
    solver = parakin.compile(redundant(), coordinates="all")
    y, yd, ydd = [solver.home["A"]], [2.0], [3.0]
    with pytest.raises(InputError, match="2 actuators for 1 freedom:"):
        solver.at(y, yd, ydd, forces=True)
    alone = parakin.load("four-bar").model_copy(update={"bodies": redundant().bodies})
    by_one = parakin.compile(alone).at(y, yd, ydd, forces=True).forces
    least = solver.at(y, yd, ydd, forces=True, preload={})
    assert least.forces is not None
    assert by_one is not None
    ratio = least.value("D", "velocity") / 2.0  # of D's rate to A's
    needed = by_one.effort[0]
    expected = np.array([1.0, ratio]) * needed / (1.0 + ratio**2)  # the least that do the work
    assert least.forces.effort == pytest.approx(expected)
    loaded = solver.at(y, yd, ydd, forces=True, preload={"D": 5.0}).forces
    assert loaded is not None
    assert loaded.effort @ [1.0, ratio] == pytest.approx(needed)
    off = loaded.effort - [0.0, 5.0]
    assert off == pytest.approx(np.array([1.0, ratio]) * (off @ [1, ratio]) / (1 + ratio**2))
    with pytest.raises(InputError, match="'B', not actuated"):
        solver.at(y, forces=True, preload={"B": 1.0})


def test_reactions_of_a_redundant_mechanism_balance() -> None:
    solver = parakin.compile(redundant())
    ds = solver.solve(next(iter(solver.mechanism.motions)), reactions=True, preload={"A": 3.0})
    assert float(ds["force_imbalance"].max()) < 1e-10


@pytest.mark.parametrize("value", ["2 N m", None, 10**400, [1, 2], 1j, float("nan")])
def test_preloads_and_loads_are_finite_numbers(value: object) -> None:
    solver = parakin.compile(redundant())
    with pytest.raises(InputError, match=r"preload of A: .*; expected a finite number"):
        solver.at([solver.home["A"]], forces=True, preload={"A": value})  # type: ignore[dict-item]
    loaded = parakin.compile(single().with_payload("1 kg at coupler"))
    with pytest.raises(InputError, match="loads of payload"):
        loaded.at([0.0], forces=True, loads={"payload": value})  # type: ignore[dict-item]


def test_forces_that_cannot_be_had_are_refused() -> None:
    plain = parakin.compile("four-bar")
    with pytest.raises(InputError, match="nothing that makes forces"):
        plain.at([plain.home["A"]], forces=True)
    seat = parakin.load("seat-2dof")
    joints = [j.model_copy(update={"actuated": j.name == "A1"}) for j in seat.joints]
    joints = [j.model_copy(update={"drive": None}) if j.name == "A2" else j for j in joints]
    few = parakin.compile(seat.model_copy(update={"joints": tuple(joints)}))
    with pytest.raises(InputError, match="1 actuated coordinates for 2 freedoms"):
        few.solve("sway", forces=True)
    with pytest.raises(InputError, match="unknown joint 'Q'"):
        plain_with_mass().at([0.0], reactions=["Q"])
    with pytest.raises(InputError, match="unknown payload or wrench 'cat'"):
        plain_with_mass().at([0.0], forces=True, loads={"cat": 4.0})


def plain_with_mass() -> parakin.Solver:
    """The four-bar with masses, and friction in no joint."""
    return parakin.compile(single())


def single(**friction: float) -> Mechanism:
    """The four-bar with masses and one motor, and with friction in two passive hinges."""
    told = (Friction(**friction),) if friction else ()
    joints = [
        j.model_copy(update={"friction": told}) if j.name in ("C", "D") else j
        for j in parakin.load("four-bar").joints
    ]
    return redundant().model_copy(update={"joints": tuple(joints)})


def test_friction_at_rest_is_a_band_of_the_efforts() -> None:
    """Of hinges at rest the motor feels their share, as far as they would turn with it."""
    solver = parakin.compile(single(coulomb=2.0), coordinates="all")
    y = [solver.home["A"]]
    resting = solver.at(y, forces=True).forces
    moving = solver.at(y, [1.0])
    assert resting is not None
    share = sum(abs(float(moving.value(name, "velocity"))) for name in ("C", "D"))
    assert resting.band == pytest.approx([2.0 * share])


def test_friction_takes_the_power_that_it_says() -> None:
    """Of journals, coefficient times radius times the force that each carries."""
    solver = parakin.compile(single(coefficient=0.3, radius=0.05), coordinates="all")
    y, yd, ydd = [solver.home["A"] + 0.3], [2.0], [-1.0]
    tick = solver.at(y, yd, ydd, reactions=["C", "D"], energies=True)
    free = parakin.compile(single()).at(y, yd, ydd, forces=True).forces
    assert tick.forces is not None
    assert free is not None
    carried = np.hypot(tick.forces.reaction_force[:, 0], tick.forces.reaction_force[:, 1])
    rates = np.array([tick.value(name, "velocity") for name in ("C", "D")])
    lost = 0.3 * 0.05 * carried @ np.abs(rates)
    assert tick.forces.lost == pytest.approx(lost, rel=1e-12)
    assert (tick.forces.effort - free.effort) * yd == pytest.approx([lost], rel=1e-9)
    assert tick.forces.imbalance == pytest.approx(0.0, abs=1e-12)


def test_friction_under_load_on_an_incline(tmp_path: Path) -> None:
    (tmp_path / "incline.toml").write_text(
        """
name = "incline"
driven = ["S"]
gravity = [0, 0, -10]
bodies.block = { mass = 2 }
[joints.S]
kind = "prismatic"
parent = "base"
child = "block"
actuated = true
on_parent = { axis = ["cos(30 deg)", 0, "sin(30 deg)"] }
friction = { coefficient = 0.2 }
"""
    )
    solver = parakin.compile(tmp_path / "incline.toml")
    weight, normal = 20 * math.sin(math.pi / 6), 20 * math.cos(math.pi / 6)
    for way in (-1.0, 1.0):
        forces = solver.at([0.0], [way], forces=True, energies=True).forces
        assert forces is not None
        assert forces.effort == pytest.approx([weight + way * 0.2 * normal])
        assert forces.lost == pytest.approx(0.2 * normal)
        assert forces.band == pytest.approx([0.0])
    resting = solver.at([0.0], forces=True).forces
    assert resting is not None
    assert resting.effort == pytest.approx([weight])
    assert resting.band == pytest.approx([0.2 * normal])


def wound(*, checks: bool = True, coordinates: str | list[str] = "all") -> parakin.Solver:
    """The catalogue's four-bar without masses, its coupler wound up against the crank."""
    four_bar = parakin.load("four-bar")
    spring = {"stiffness": 2.0, "zero": 0.3}
    joints = [
        Joint.model_validate(j.model_dump(exclude_defaults=True) | {"spring": spring})
        if j.name == "B"
        else j
        for j in four_bar.joints
    ]
    told = four_bar.model_copy(update={"joints": tuple(joints)})
    return parakin.compile(told, coordinates=coordinates, checks=checks, machine_code=False)


def test_springs_count_full_turns_of_angles_that_follow(tmp_path: Path) -> None:
    """The spring's energy is that of the angle as reported, and the motor's power its rate."""
    solver = wound()
    (tmp_path / "turns.toml").write_text(
        'duration = "2 s"\nrate = "100 Hz"\nlaws = { A = { law = "poly345", by = "1080 deg" } }\n'
    )
    motion = solver.motion(tmp_path / "turns.toml")
    ds = solver.solve(motion, forces=True, energies=True)
    position, velocity = (ds[name].sel(coordinate="B").values for name in ("position", "velocity"))
    assert np.ptp(position) > 6 * math.pi - 1.0
    power = 2.0 * (position - 0.3) * velocity
    assert ds.power.values[:, 0] == pytest.approx(power, abs=1e-9)
    assert ds.potential_energy.values == pytest.approx((position - 0.3) ** 2, abs=1e-9)
    parts = list(wound(coordinates=["A"]).stream(motion, 37, forces=True))
    joined = np.concatenate([part.effort.values for part in parts])
    assert joined == pytest.approx(ds.effort.values, abs=1e-9)
    for other in (wound(coordinates=["A"]), wound(coordinates=["A"], checks=False)):
        tick = other.at([solver.home["A"]])
        for k, driven in enumerate(ds.position.sel(coordinate="A").values.tolist()):
            tick = other.at([driven], guess=tick, forces=True)
            assert tick.forces is not None
            assert tick.forces.effort == pytest.approx(ds.effort.values[k], abs=1e-9)
