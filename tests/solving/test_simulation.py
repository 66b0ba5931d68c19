"""The motion that forces make, against closed forms; and what is refused."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.special import ellipj, ellipk

import parakin
from parakin import InputError, Status
from parakin.solving.applied import State

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
INERTIA, WEIGHT = 0.1 + 2 * 0.5**2, 2 * 0.5 * 9.80665  # about the pivot; at the centre of mass

BLOCK = """
name = "block"
driven = ["X"]
home.X = 0
[bodies]
block = { mass = 4 }
[joints.X]
kind = "prismatic"
parent = "base"
child = "block"
on_parent = { axis = [1, 0, 0] }
on_child = { axis = [1, 0, 0] }
actuated = true
"""


def solver(text: str, folder: Path, **options: Any) -> parakin.Solver:
    (folder / "mechanism.toml").write_text(text)
    return parakin.compile(folder / "mechanism.toml", **options)


@pytest.mark.parametrize("machine_code", [False, None])
def test_a_pendulum_swings_as_its_elliptic_function(
    tmp_path: Path, machine_code: bool | None
) -> None:
    """sin(θ/2) = sin(θ0/2) sn(K - ω t) from rest at θ0."""
    pendulum = solver(SWING, tmp_path, machine_code=machine_code)
    start = math.radians(-90.0 + 120.0)
    ds = pendulum.simulate(3.0, start={"A": start}, rate=50, rtol=1e-11)
    k = math.sin(math.radians(60.0))
    omega = math.sqrt(WEIGHT / INERTIA)
    sn, *_ = ellipj(ellipk(k**2) - omega * ds["time"].values, k**2)
    expected = 2.0 * np.arcsin(k * sn) - math.pi / 2
    assert ds["position"].sel(coordinate="A").values == pytest.approx(expected, abs=1e-8)
    assert ds["potential_energy"].values == pytest.approx(WEIGHT * np.sin(expected), abs=1e-7)
    assert float(abs(ds["energy_drift"]).max()) < 1e-8
    assert ds["effort"].values == pytest.approx(0.0, abs=0.0)


def test_a_spring_and_a_damper_ring_down(tmp_path: Path) -> None:
    acting = "spring = { stiffness = 100, zero = 0.1 }\ndamper = { damping = 3 }\narmature = 1\n"
    ds = solver(BLOCK + acting, tmp_path).simulate(4.0, start={"X": 0.3}, rate=100, rtol=1e-11)
    decay = 3.0 / (2 * 5.0)
    omega = math.sqrt(100.0 / 5.0 - decay**2)
    t = ds["time"].values
    shape = np.cos(omega * t) + decay / omega * np.sin(omega * t)
    assert ds["position"].values[:, 0] == pytest.approx(
        0.1 + 0.2 * np.exp(-decay * t) * shape, abs=1e-9
    )
    assert float(abs(ds["energy_drift"]).max()) < 1e-9
    lost = 0.5 * 100 * 0.2**2 - (ds["kinetic_energy"] + ds["potential_energy"]).values[-1]
    assert np.trapezoid(ds["power_lost"].values, t) == pytest.approx(lost, rel=1e-3)


def test_coulomb_friction_stops_a_block(tmp_path: Path) -> None:
    """It slides v²/2a; then creeps, as friction is a slope between the directions."""
    text = f"{BLOCK}friction = {{ coulomb = 8 }}\n"
    block = solver(text, tmp_path)
    ds = block.simulate(1.0, velocity={"X": 1.0}, rest_speed=1e-4, rate=100)
    assert ds["position"].values[-1, 0] == pytest.approx(1.0 / (2 * 2.0), abs=1e-4)
    assert abs(ds["velocity"].values[-1, 0]) < 1e-6
    assert float(abs(ds["energy_drift"]).max()) < 1e-6
    pushed = block.simulate(1.0, {"X": "20 N"}, rate=100)
    assert pushed["position"].values[-1, 0] == pytest.approx(0.5 * (20 - 8) / 4, abs=1e-3)


@pytest.mark.parametrize("kind", ["table", "function", "csv"])
def test_efforts_over_time(tmp_path: Path, kind: str) -> None:
    """4 kg under 8 N sin(t)."""
    times = np.linspace(0.0, 2.0, 20_001)
    (tmp_path / "efforts.csv").write_text(
        "time,X [kN]\n" + "".join(f"{t!r},{8e-3 * math.sin(t)!r}\n" for t in times.tolist())
    )
    law = {"law": "sine", "amplitude": "8 N", "frequency": f"{1 / (2 * math.pi)!r} Hz"}
    efforts: Any = {
        "table": {"X": law},
        "function": lambda state: {"X": 8.0 * math.sin(state.time)},
        "csv": tmp_path / "efforts.csv",
    }[kind]
    ds = solver(BLOCK, tmp_path).simulate(2.0, efforts, rate=20)
    t = ds["time"].values
    assert ds["position"].values[:, 0] == pytest.approx(2.0 * (t - np.sin(t)), abs=1e-7)
    assert ds["effort"].values[:, 0] == pytest.approx(8.0 * np.sin(t), abs=1e-7)
    assert ds["power"].values == pytest.approx(
        ds["effort"].values * ds["velocity"].values, abs=1e-7
    )
    assert ds["effort_unit"].values.tolist() == ["N"]


def test_a_function_sees_where_all_moves() -> None:
    """Servos of a Delta's arms: stiff, and so slow without machine code."""
    pytest.importorskip("heyoka")
    delta = parakin.compile("delta", coordinates="all")
    home = {name: delta.home[name] for name in ("A1", "A2", "A3")}
    seen: list[State] = []

    def servo(state: State) -> dict[str, float]:
        seen.append(state)
        return {
            name: 300.0 * (home[name] - state.position[name]) - 8.0 * state.velocity[name]
            for name in home
        }

    ds = delta.simulate(0.5, servo, rate=100)
    assert (ds["status"] == 0).all()
    assert float(abs(ds["velocity"][-1]).max()) < 1e-2  # it has come to rest
    fallen = delta.home["platform.z"] - float(ds["position"].sel(coordinate="platform.z")[-1])
    assert abs(fallen) < 0.05
    last = seen[-1]
    assert set(home) < set(last.position) == set(last.velocity)
    hold = delta.at([last.position[n] for n in delta.driven], forces=True).forces
    assert hold is not None
    assert ds["effort"].values[-1] == pytest.approx(hold.effort, rel=1e-3)


@pytest.mark.parametrize("name", ["flight-simulator", "gough-stewart"])
def test_the_forces_behind_a_motion_make_it_again(name: str) -> None:
    platform = parakin.compile(name)
    motion = next(iter(platform.mechanism.motions))
    ds = platform.solve(motion, forces=True)
    half = float(ds["time"][-1]) / 2
    spline = CubicSpline(ds["time"].values, ds["effort"].values)
    actuators = ds["actuator"].values.tolist()

    def efforts(state: State) -> dict[str, float]:
        return dict(zip(actuators, spline(state.time).tolist(), strict=True))

    driven = ds.sel(coordinate=list(platform.driven)).isel(time=0)
    start = dict(zip(platform.driven, driven["position"].values.tolist(), strict=True))
    velocity = dict(zip(platform.driven, driven["velocity"].values.tolist(), strict=True))
    again = platform.simulate(half, efforts, start=start, velocity=velocity, rate=10, rtol=1e-11)
    assert (again["status"] == 0).all()
    there = ds.sel(time=again["time"].values, method="nearest")
    assert again["position"].values == pytest.approx(there["position"].values, abs=1e-9)


# A drag link, whose follower turns round as its crank does, against a spring.
DRAG = """
name = "drag-link"
driven = ["A"]
gravity = 0
home.A = "50 deg"
guess = { B = "-50 deg", D = "50 deg" }
[bodies]
a = { mass = 1, com = [0.1, 0, 0], inertia = [0.01, 0.01, 0.01] }
b = { mass = 0.001, inertia = [1e-6, 1e-6, 1e-6] }
d = { mass = 0.001, inertia = [1e-6, 1e-6, 1e-6] }
[joints.A]
kind = "revolute"
parent = "base"
child = "a"
[joints.B]
kind = "revolute"
parent = "a"
child = "b"
on_parent = { at = [0.2, 0, 0] }
[joints.C]
kind = "revolute"
parent = "b"
child = "d"
on_parent = { at = [0.22, 0, 0] }
on_child = { at = [0.2, 0, 0] }
[joints.D]
kind = "revolute"
parent = "base"
child = "d"
on_parent = { at = [0.05, 0, 0] }
spring = { stiffness = 0.02, zero = "50 deg" }
"""


@pytest.mark.parametrize("cut", [(), ("D",)])
def test_a_spring_at_an_angle_that_follows_counts_its_turns(
    tmp_path: Path, cut: tuple[str, ...]
) -> None:
    """Whether its joint is in the tree or not."""
    follower = solver(DRAG, tmp_path, coordinates="all", cut=cut)
    ds = follower.simulate(3.0, velocity={"A": 8.0}, rate=100, rtol=1e-11)
    assert (ds["status"] == 0).all()
    angle = ds["position"].sel(coordinate="D").values
    assert angle.max() - angle.min() > 2 * math.pi
    stored = 0.5 * 0.02 * (angle - math.radians(50.0)) ** 2
    assert ds["potential_energy"].values == pytest.approx(stored, abs=1e-9)
    assert float(abs(ds["energy_drift"]).max()) < 1e-8


# A spatial four-bar, its coupler between two ball joints.
SPINNING = """
name = "rssr"
driven = ["A"]
gravity = 0
home.A = "40 deg"
guess = { D = "60 deg" }
[bodies]
a = { mass = 1, com = [0.05, 0, 0], inertia = [0.001, 0.001, 0.001] }
b = { mass = 2, com = [0.15, 0.01, 0], inertia = [0.002, 0.02, 0.02] }
c = { mass = 1, com = [0.1, 0, 0], inertia = [0.001, 0.001, 0.001] }
[joints.A]
kind = "revolute"
parent = "base"
child = "a"
[joints.S]
kind = "spherical"
parent = "a"
child = "b"
on_parent = { at = [0.1, 0, 0] }
[joints.T]
kind = "spherical"
parent = "b"
child = "c"
on_parent = { at = [0.3, 0, 0] }
on_child = { at = [0.2, 0, 0] }
[joints.D]
kind = "revolute"
parent = "base"
child = "c"
on_parent = { at = [0.25, 0, 0.1], axis = [0.2, 0, 1] }
"""


def test_an_idle_freedom_is_let_go(tmp_path: Path) -> None:
    """Nothing holds the coupler's spin: it needs no effort."""
    with pytest.raises(InputError, match=r"T\.1 idle, and so held; expected them .*: A, T\.1"):
        solver(SPINNING, tmp_path, machine_code=False).simulate(1.0)
    freed = parakin.compile(tmp_path / "mechanism.toml", ["A", "T.1"], coordinates="all")
    ds = freed.simulate(1.0, velocity={"A": 3.0, "T.1": 1.0}, rate=100, rtol=1e-11)
    assert (ds["status"] == 0).all()
    total = (ds["kinetic_energy"] + ds["potential_energy"]).values
    assert total == pytest.approx(total[0], rel=1e-9)
    at = ds.sel(coordinate=["A", "T.1"]).isel(time=60)
    y, yd, ydd = (at[order].values for order in ("position", "velocity", "acceleration"))
    behind = freed.at(y, yd, ydd, ds["position"].values[60], forces=True).forces
    assert behind is not None
    assert behind.effort == pytest.approx(0.0, abs=1e-7)


def test_a_payload_let_go() -> None:
    """A hexapod's legs hold 350 kg; without 100 of them it rises, at first by 100 g/(250 + ...)."""
    loaded = parakin.compile(parakin.load("gough-stewart").with_payload("100 kg at platform"))
    home = [loaded.home[n] for n in loaded.driven]
    held = loaded.at(home, forces=True).forces
    assert held is not None
    efforts = dict(zip(held.actuators, held.effort.tolist(), strict=True))
    rest = loaded.simulate(0.2, efforts, rate=100, rtol=1e-11)
    assert rest["position"].values[-1] == pytest.approx(rest["position"].values[0], abs=1e-9)
    (payload,) = (load.name for load in loaded.graph.dynamics.loads)
    freed = loaded.simulate(0.01, efforts, rate=1000, loads={payload: 0.0})
    first = float(freed["acceleration"].sel(coordinate="platform.z")[0])
    pistons = 6 * 7850 * 0.7 * math.pi / 4 * (0.05**2 - 0.04**2)
    assert 9.80665 * 100 / (250 + 2 * pistons) < first < 9.80665 * 100 / 250


REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"duration": 0.0}, "duration: found 0"),
    ({"duration": math.nan}, "duration: found nan"),
    ({"rate": -1.0}, "rate: found -1"),
    ({"rate": 1e12}, "rate: found 1e\\+12 samples"),
    ({"start": {"Y": 1.0}}, "start: found 'Y', not driven"),
    ({"velocity": {"X": math.inf}}, "velocity of X: found inf"),
    ({"start": {"X": "1 m"}}, "start of X: found '1 m'"),
    ({"efforts": {"Y": 1.0}}, "efforts: found 'Y', not actuated"),
    ({"efforts": {"X": "3 m"}}, "efforts of X: found '3 m', a length"),
    ({"efforts": {"X": {"law": "hop"}}}, "'hop'"),
    ({"efforts": 3.0}, "efforts: found float"),
    ({"efforts": lambda _: {"X": math.nan}}, "efforts at 0 s: .*nan.*finite"),
    ({"efforts": lambda _: {"Z": 1.0}}, "efforts at 0 s: .*by actuated coordinate: X"),
    ({"efforts": lambda _: 3.0}, "efforts at 0 s: found 3.0"),
    ({"efforts": lambda _: {"X": "3"}}, "efforts at 0 s: .*finite numbers"),
    ({"loads": {"y": 3.0}}, "unknown payload or wrench 'y'"),
    ({"rtol": 0.0}, "rtol: found 0"),
    ({"rest_speed": -1.0}, "rest_speed: found -1"),
]


@pytest.mark.parametrize(("given", "said"), REFUSED)
def test_what_cannot_be_simulated_is_refused(
    tmp_path: Path, given: dict[str, Any], said: str
) -> None:
    block = solver(BLOCK, tmp_path, machine_code=False)
    with pytest.raises(InputError, match=said):
        block.simulate(**{"duration": 1.0, **given})


def test_mechanisms_that_forces_do_not_move(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="nothing that makes forces"):
        parakin.compile("four-bar").simulate(1.0)
    floating = BLOCK.replace("mass = 4", "") + "friction = { viscous = 3 }\n"
    with pytest.raises(InputError, match="a freedom, mostly X, that moves no mass"):
        solver(floating, tmp_path).simulate(1.0)
    wedged = BLOCK + "friction = { coefficient = 0.3 }\n"
    with pytest.raises(InputError, match="friction that grows with the load, in X"):
        solver(wedged, tmp_path).simulate(1.0)
    with pytest.raises(InputError, match="start: found a pose that is flagged: out of reach"):
        parakin.compile("delta").simulate(1.0, start={"platform.z": 9.0})


def test_efforts_that_end_too_early(tmp_path: Path) -> None:
    (tmp_path / "efforts.csv").write_text("time,X\n0,1\n0.5,1\n")
    with pytest.raises(InputError, match=r"efforts from 0 s to 0\.5 s"):
        solver(BLOCK, tmp_path).simulate(1.0, tmp_path / "efforts.csv")
    (tmp_path / "w.csv").write_text("time,fx,fy,fz,mx,my,mz\n0,1,0,0,0,0,0\n0.7,1,0,0,0,0,0\n")
    blown = f'{BLOCK}[forces.w]\nkind = "wrench"\nat = "block"\ncsv = "w.csv"\n'
    with pytest.raises(InputError, match=r"forces from 0 s to 0\.7 s; expected from 0 s to 1 s"):
        solver(blown, tmp_path).simulate(1.0)
    held = solver(blown, tmp_path).simulate(1.0, loads={"w": [8, 0, 0, 0, 0, 0]}, rate=10)
    assert held["position"].values[-1, 0] == pytest.approx(1.0, abs=1e-8)


def test_a_lean_solver_is_refused(tmp_path: Path) -> None:
    for lean in ({"derivatives": 1}, {"checks": False}):
        with pytest.raises(InputError, match="without accelerations or checks"):
            solver(BLOCK, tmp_path, **lean).simulate(1.0)


def test_a_simulation_ends_where_it_meets_a_singularity() -> None:
    """A slider-crank that is driven by its slider cannot pass its dead centre."""
    cranked = parakin.load("slider-crank")
    bodies = tuple(
        b if b.name == cranked.base else b.model_copy(update={"mass": 1.0, "inertia": (0.01,) * 3})
        for b in cranked.bodies
    )
    heavy = cranked.model_copy(update={"bodies": bodies, "gravity": 0})
    slide = next(j.name for j in cranked.joints if j.kind == "prismatic")
    by_slide = parakin.compile(heavy, [slide])
    ds = by_slide.simulate(1.0, velocity={slide: 0.5}, rate=1000)
    status = ds["status"].values
    ended = int(np.flatnonzero(status)[0])
    assert status[ended] in (Status.SINGULAR, Status.BRANCH_CHANGE, Status.OUT_OF_REACH)
    assert (status[ended + 1 :] == Status.NOT_REACHED).all()
    for values in (ds["position"], ds["effort"], ds["kinetic_energy"], ds["energy_drift"]):
        assert np.isnan(values.values[ended:]).all()
        assert np.isfinite(values.values[: ended - 5]).all()
    assert ds.sizes["time"] == 1001
