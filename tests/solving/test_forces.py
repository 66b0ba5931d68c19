"""What of forces is asked for; payloads."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import parakin
from parakin import InputError

TEXT = """
name = "lift"
driven = ["S"]
gravity = 10
bodies.table = { mass = 100 }
[joints.S]
kind = "prismatic"
parent = "base"
child = "table"
actuated = true
[forces]
box = { kind = "payload", at = "table", mass = "20 kg", inertia = [1, 1, 1] }
"""


@pytest.fixture
def lift(tmp_path: Path) -> parakin.Solver:
    (tmp_path / "lift.toml").write_text(TEXT)
    return parakin.compile(tmp_path / "lift.toml")


def test_payloads_may_be_others(lift: parakin.Solver) -> None:
    none = lift.at([0.0], forces=True, loads={"box": 0.0}).forces
    assert none is not None
    assert none.effort == pytest.approx([1000.0])
    batch = lift.at(np.zeros((1, 3)), forces=True, loads={"box": [0.0, 20.0, 50.0]}).forces
    assert batch is not None
    assert batch.effort == pytest.approx(np.array([[1000.0, 1200.0, 1500.0]]))
    with pytest.raises(InputError, match="a mass below zero"):
        lift.at([0.0], forces=True, loads={"box": -1.0})
    with pytest.raises(InputError, match="expected one number, or 1"):
        lift.at([0.0], forces=True, loads={"box": [1.0, 2.0]})


def test_where_nothing_is_actuated_the_driven_joints_make_the_forces(tmp_path: Path) -> None:
    text = TEXT.replace("actuated = true\n", "")
    (tmp_path / "lift.toml").write_text(text)
    forces = parakin.compile(tmp_path / "lift.toml").at([0.0], forces=True).forces
    assert forces is not None
    assert forces.actuators == ("S",)
    assert np.isnan(forces.motor_torque).all()
    bare = parakin.load("gough-stewart")
    joints = [j.model_copy(update={"actuated": False, "drive": None}) for j in bare.joints]
    with pytest.raises(InputError, match="none that is actuated"):
        parakin.compile(bare.model_copy(update={"joints": tuple(joints)})).solve(
            "heave", forces=True
        )


def test_what_is_not_solved_has_no_forces() -> None:
    solver = parakin.compile("gough-stewart")
    y = np.array([solver.home[name] for name in solver.driven])
    far = np.where(np.arange(6) == 2, math.nan, y)
    tick = solver.at(np.stack([y, far], axis=1), forces=True, reactions=["P1"])
    assert tick.forces is not None
    assert np.isfinite(tick.forces.effort[:, 0]).all()
    assert np.isnan(tick.forces.effort[:, 1]).all()
    assert np.isnan(tick.forces.reaction_force[..., 1]).all()


def test_minimum_norm_balances_too_and_is_nowhere_nan() -> None:
    solver = parakin.compile("flight-simulator")
    plain = solver.solve("general", reactions=True)
    least = solver.solve("general", reactions=True, indeterminate="minimum-norm")
    known = np.isfinite(plain["reaction_force"].values)
    assert not known.all()
    assert np.isfinite(least["reaction_force"].values).all()
    assert float(least["force_imbalance"].max()) < 1e-9
    scale = np.nanmax(np.abs(plain["reaction_force"].values))
    assert least["reaction_force"].values[known] == pytest.approx(
        plain["reaction_force"].values[known], abs=1e-10 * scale
    )
    with pytest.raises(InputError, match="indeterminate: found 'zero'"):
        solver.solve("general", reactions=True, indeterminate="zero")


CRANK = """
name = "press"
up = "y"
gravity = 0
driven = ["A"]
home.A = "60 deg"
guess.D = "0.5 m"
[bodies]
crank = {}
rod = {}
ram = { mass = 10 }
[joints.A]
kind = "revolute"
parent = "base"
child = "crank"
[joints.B]
kind = "revolute"
parent = "crank"
child = "rod"
on_parent = { at = [0.2, 0, 0] }
[joints.C]
kind = "revolute"
parent = "rod"
child = "ram"
on_parent = { at = [0.5, 0, 0] }
[joints.D]
kind = "prismatic"
parent = "base"
child = "ram"
actuated = true
on_parent = { axis = [1, 0, 0], x = [0, 1, 0] }
on_child = { axis = [1, 0, 0], x = [0, 1, 0] }
[forces]
brake = { kind = "wrench", at = "crank", moment = [0, 0, -3] }
"""


def test_at_a_dead_point_the_efforts_grow_and_their_conditioning_vanishes(tmp_path: Path) -> None:
    """A ram turns a crank that is held back: of type 2 where the rod is in line with the crank."""
    (tmp_path / "press.toml").write_text(CRANK)
    solver = parakin.compile(tmp_path / "press.toml", coordinates="all")

    def ratio(angle: float) -> float:
        """dD/dA, from D = r cos A + sqrt(l² - (r sin A)²)."""
        r, rod, s, c = 0.2, 0.5, math.sin(angle), math.cos(angle)
        return -r * s - r * r * s * c / math.sqrt(rod**2 - (r * s) ** 2)

    for angle in (1.0, 0.3, 0.01, 1e-4, -0.01):
        forces = solver.at([angle], forces=True).forces
        assert forces is not None
        assert forces.effort == pytest.approx([3.0 / ratio(angle)], rel=1e-9)
        expected = ratio(angle) / ratio(math.radians(60))
        assert forces.conditioning == pytest.approx(expected, rel=1e-9)
    law = parakin.laws.cosine(math.radians(60), -2.0, 1.0)
    ds = solver.solve(parakin.from_laws("through", {"A": law}, 1.0, 99.0), forces=True)
    figures = ds["effort_conditioning"].values
    assert figures[0] > 0.0 > figures[-1]
    assert not ds["status"].values.any()


def test_loads_of_each_time_are_cut_into_windows_too() -> None:
    loaded = parakin.load("flight-simulator").with_payload("80 kg at platform")
    solver = parakin.compile(loaded, machine_code=False)
    name = solver.graph.dynamics.loads[0].name
    motion = solver.motion("general")
    masses = np.linspace(50.0, 150.0, motion.count)
    whole = solver.solve(motion, forces=True, loads={name: masses}).effort.values
    size = motion.count // 3
    parts = [
        part.effort.values
        for part in solver.stream(motion, size, loads={name: masses}, forces=True)
    ]
    assert np.concatenate(parts) == pytest.approx(whole, rel=1e-12, abs=1e-9)
    with pytest.raises(InputError, match="expected one number, or"):
        list(solver.stream(motion, size, forces=True, loads={name: masses[:size]}))
