"""The motion that forces make, against closed forms; and what is refused."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
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


def heavy(name: str, **changes: Any) -> parakin.Mechanism:
    """Of this name, each body with a mass."""
    mechanism = parakin.load(name)
    told = {"mass": 1.0, "inertia": (0.01,) * 3, "solid": ()}
    bodies = tuple(
        body if body.name == mechanism.base else body.model_copy(update=told)
        for body in mechanism.bodies
    )
    return mechanism.model_copy(update={"bodies": bodies, "gravity": 0, **changes})


def test_others_take_over_where_the_driven_coordinates_die() -> None:
    """A slider-crank driven by its slider passes its dead centres, as driven by its crank."""
    cranked = heavy("slider-crank")
    slide = next(j.name for j in cranked.joints if j.kind == "prismatic")
    (crank,) = cranked.driven
    by_slide = parakin.compile(cranked, [slide], coordinates="all")
    ds = by_slide.simulate(1.5, velocity={slide: 0.5}, rate=1000, rtol=1e-11)
    assert (ds["status"] == 0).all()
    place = ds["position"].sel(coordinate=slide).values
    stroke = math.sqrt(0.16**2 - 0.02**2) - math.sqrt(0.08**2 - 0.02**2)
    assert np.ptp(place) == pytest.approx(stroke, rel=1e-4)
    first = float(ds["velocity"].sel(coordinate=crank)[0])
    by_crank = parakin.compile(cranked, coordinates="all")
    same = by_crank.simulate(1.5, velocity={crank: first}, rate=1000, rtol=1e-11)
    for order in ("position", "velocity", "acceleration"):
        for name in by_crank.coordinates:
            one, other = (each[order].sel(coordinate=name).values for each in (ds, same))
            assert one == pytest.approx(other, rel=1e-6, abs=1e-7 * abs(other).max())
    assert float(abs(ds["energy_drift"]).max()) < 1e-7
    assert ds.attrs["motion"] == "simulation"


def test_a_simulation_ends_where_nothing_can_take_over() -> None:
    """A parallelogram stretched out: it can go on as one, or crossed."""
    equal = {"a": "40 mm", "b": "100 mm", "c": "40 mm", "d": "100 mm"}
    guess = {"B": "-40 deg", "D": "40 deg"}
    flat = parakin.compile(heavy("four-bar", parameters=equal, guess=guess))
    (crank,) = flat.driven
    ds = flat.simulate(2.0, velocity={crank: 2.0}, rate=1000)
    status = ds["status"].values
    ended = int(np.flatnonzero(status)[0])
    assert status[ended] in (Status.SINGULAR, Status.BRANCH_CHANGE, Status.OUT_OF_REACH)
    assert (status[ended + 1 :] == Status.NOT_REACHED).all()
    for values in (ds["position"], ds["effort"], ds["kinetic_energy"], ds["energy_drift"]):
        assert np.isnan(values.values[ended:]).all()
        assert np.isfinite(values.values[: ended - 5]).all()
    assert ds.sizes["time"] == 2001


SERVO = {"stiffness": "400 N/m", "damping": "16 N s/m"}


def block_at(t: Any, omega: float, decay: float) -> Any:
    """From rest at one to rest at zero."""
    damped = math.sqrt(omega**2 - decay**2)
    return np.exp(-decay * t) * (np.cos(damped * t) + decay / damped * np.sin(damped * t))


@pytest.mark.parametrize("machine_code", [False, None])
def test_a_servo_holds_a_block(tmp_path: Path, machine_code: bool | None) -> None:
    """4 kg x'' = 400 (0.3 - x) - 16 x': at 10 rad/s, a fifth of critical damping."""
    block = solver(BLOCK, tmp_path, machine_code=machine_code)
    ds = block.simulate(2.0, {"X": {**SERVO, "target": "0.3 m"}}, rate=50, rtol=1e-11)
    t = ds["time"].values
    expected = 0.3 - 0.3 * block_at(t, 10.0, 2.0)
    x, v = ds["position"].values[:, 0], ds["velocity"].values[:, 0]
    assert x == pytest.approx(expected, abs=1e-9)
    assert ds["effort"].values[:, 0] == pytest.approx(400 * (0.3 - x) - 16 * v, abs=1e-9)
    assert float(abs(ds["energy_drift"]).max()) < 1e-9
    home = block.simulate(2.0, {"X": SERVO}, start={"X": 0.1}, rate=50, rtol=1e-11)
    assert home["position"].values[:, 0] == pytest.approx(0.1 * block_at(t, 10.0, 2.0), abs=1e-9)


def test_a_servo_follows_a_law_and_a_table(tmp_path: Path) -> None:
    """Its target's rate counts: with the force that the mass needs it follows without a lag."""
    law = {"law": "sine", "amplitude": "0.1 m", "frequency": "1 Hz"}
    w = 2 * math.pi
    force = {"law": "sine", "amplitude": f"{-4 * 0.1 * w**2!r} N", "frequency": "1 Hz"}
    block = solver(BLOCK, tmp_path)
    times = np.linspace(0.0, 1.0, 2001)
    table = "".join(f"{t!r},{0.1 * math.sin(w * t)!r}\n" for t in times.tolist())
    (tmp_path / "legs.csv").write_text(f"time,X\n{table}")
    for target, within in ((law, 1e-10), (str(tmp_path / "legs.csv"), 1e-7)):
        efforts = {"X": {**SERVO, "target": target, "effort": force}}
        ds = block.simulate(1.0, efforts, velocity={"X": 0.1 * w}, rate=100, rtol=1e-11)
        expected = 0.1 * np.sin(w * ds["time"].values)
        assert ds["position"].values[:, 0] == pytest.approx(expected, abs=within)
    written = '[efforts]\nX = { stiffness = "400 N/m", damping = 16, target = "legs.csv" }\n'
    (tmp_path / "servo.toml").write_text(written)
    ds = block.simulate(1.0, tmp_path / "servo.toml", rate=100)
    assert (ds["status"] == 0).all()
    with pytest.raises(InputError, match=r"targets from 0 s to 1 s"):
        block.simulate(1.1, tmp_path / "servo.toml")


def test_a_servo_gives_no_more_than_it_has(tmp_path: Path) -> None:
    """20 N at most push 4 kg by 5 m/s^2 while it is far off."""
    block = solver(BLOCK, tmp_path)
    servo = {"stiffness": 1e4, "damping": 400, "target": 1.0, "most": "20 N"}
    for sign in (1.0, -1.0):
        ds = block.simulate(0.4, {"X": {**servo, "target": sign}}, rate=50)
        t = ds["time"].values
        assert ds["position"].values[:, 0] == pytest.approx(sign * 2.5 * t**2, abs=1e-8)
        assert ds["effort"].values[:, 0] == pytest.approx(sign * 20.0, abs=0.0)
    bound = block.simulate(0.1, {"X": {"effort": 50.0, "most": 20.0}}, rate=50)
    assert bound["effort"].values[:, 0] == pytest.approx(20.0, abs=0.0)


def test_servos_hold_the_legs_of_a_hexapod() -> None:
    """As a function of the state says it, but in machine code."""
    hexapod = parakin.compile("gough-stewart")
    held = hexapod.at([hexapod.home[n] for n in hexapod.driven], forces=True).forces
    assert held is not None
    legs = dict(zip(held.actuators, held.effort.tolist(), strict=True))
    target = {name: hexapod.home[name] + 0.01 * k for k, name in enumerate(legs)}
    by_data = {
        name: {"stiffness": 2e5, "damping": 5e3, "effort": legs[name], "target": target[name]}
        for name in legs
    }

    def by_function(state: State) -> dict[str, float]:
        return {
            n: legs[n] + 2e5 * (target[n] - state.position[n]) - 5e3 * state.velocity[n]
            for n in legs
        }

    one, other = (hexapod.simulate(0.1, how, rate=100) for how in (by_data, by_function))
    assert one["position"].values == pytest.approx(other["position"].values, abs=1e-9)
    assert one["effort"].values == pytest.approx(other["effort"].values, rel=1e-6, abs=1e-4)


REFUSED_SERVOS: list[tuple[dict[str, Any], str]] = [
    ({"stiffnes": 3}, "efforts of X: found 'stiffnes'; expected .*stiffness"),
    ({"stiffness": -3}, "efforts of X.stiffness: found -3; expected zero or more"),
    ({"stiffness": "3 N"}, "efforts of X.stiffness: found '3 N'"),
    ({"stiffness": 3, "target": "2 N"}, "efforts of X.target: found '2 N'"),
    ({"stiffness": 3, "target": {"law": "hop"}}, "efforts of X.target"),
    ({"stiffness": 3, "target": "nowhere.csv"}, "nowhere.csv"),
    ({"stiffness": math.nan}, "efforts of X.stiffness"),
    ({}, "efforts of X"),
]


@pytest.mark.parametrize(("table", "message"), REFUSED_SERVOS)
def test_servos_that_are_refused(tmp_path: Path, table: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        solver(BLOCK, tmp_path, machine_code=False).simulate(1.0, {"X": table})


def test_a_block_bounces_off_its_stop(tmp_path: Path) -> None:
    """x'' = -k/m x (1 + c x') has c v - ln(1 + c v) + k/m (c x)²/2 as a constant."""
    text = f'{BLOCK}stop = {{ stiffness = "4 MN/m", dissipation = "0.4 s/m" }}\n'
    block = solver(f"{text}[limits]\nX = [-1, 0.5]\n", tmp_path)
    ds = block.simulate(1.0, velocity={"X": 1.0}, rate=2000, rtol=1e-10)
    x, v = ds["position"].values[:, 0], ds["velocity"].values[:, 0]

    def constant(speed: float) -> float:
        return 0.4 * speed - math.log1p(0.4 * speed)

    back = brentq(lambda speed: constant(speed) - constant(1.0), -1.0, -0.1)
    assert v[-1] == pytest.approx(back, abs=1e-8)
    assert ds["power_lost"].values.max() > 0.0
    deepest = math.sqrt(2 * constant(1.0) / 0.4**2 / 1e6)
    assert x.max() == pytest.approx(0.5 + deepest, abs=0.1 * deepest)
    assert float(abs(ds["energy_drift"]).max()) < 1e-8
    beyond = ds["status"].values == Status.LIMIT_EXCEEDED
    assert (x[beyond] > 0.5).all()
    assert (x[~beyond] < 0.5 + 1e-9).all()
    ended = block.simulate(1.0, velocity={"X": 1.0}, rate=2000, end_at_limits=True)
    (first,) = np.flatnonzero(ended["status"].values == Status.LIMIT_EXCEEDED)
    assert float(ended["first_at"][first]) == pytest.approx(0.5, abs=1e-6)
    assert (ended["status"].values[first + 1 :] == Status.NOT_REACHED).all()
    assert np.isnan(ended["position"].values[first + 1 :]).all()
    assert np.isfinite(ended["position"].values[: first + 1]).all()


def test_loops_are_closed_again_when_asked() -> None:
    """With a rough tolerance they drift; projected they do so less."""
    bars = parakin.compile(heavy("four-bar"))
    (crank,) = bars.driven
    drifting, closed = (
        bars.simulate(10.0, velocity={crank: 6.0}, rate=50, rtol=1e-6, project=every)
        for every in (math.inf, 0.25)
    )
    last = [float(each["closure_drift"][-1]) for each in (drifting, closed)]
    assert last[1] < 0.01 * last[0]
    with pytest.raises(InputError, match="project: found 0"):
        bars.simulate(1.0, project=0.0)


def test_a_short_pulse_is_not_stepped_over(tmp_path: Path) -> None:
    """Free motion takes long steps: 40 N over 3 ms after a second of rest give 4 kg 30 mm/s."""
    pulse = "0,0\n1,0\n1.001,40\n1.003,40\n1.004,0\n2,0\n"
    (tmp_path / "pulse.csv").write_text(f"time,X\n{pulse}")
    ds = solver(BLOCK, tmp_path).simulate(2.0, tmp_path / "pulse.csv", rate=1000)
    assert float(ds["velocity"][-1, 0]) == pytest.approx(0.03, rel=1e-6)
    blown = f'{BLOCK}[forces.w]\nkind = "wrench"\nat = "block"\ncsv = "w.csv"\n'
    rows = [[float(cell) for cell in line.split(",")] for line in pulse.split()]
    wrench = "".join(f"{t},{f},0,0,0,0,0\n" for t, f in rows)
    (tmp_path / "w.csv").write_text(f"time,fx,fy,fz,mx,my,mz\n{wrench}")
    ds = solver(blown, tmp_path).simulate(2.0, rate=1000)
    assert float(ds["velocity"][-1, 0]) == pytest.approx(0.03, rel=1e-6)


def test_taylor_series_are_exact_to_rounding(tmp_path: Path) -> None:
    """A pendulum over ten swings by its elliptic function."""
    pytest.importorskip("heyoka")
    pendulum = solver(SWING, tmp_path)
    start = math.radians(-90.0 + 120.0)
    how: dict[str, Any] = {"start": {"A": start}, "rate": 50, "method": "taylor"}
    ds = pendulum.simulate(20.0, rtol=1e-15, **how)
    k = math.sin(math.radians(60.0))
    omega = math.sqrt(WEIGHT / INERTIA)
    sn, *_ = ellipj(ellipk(k**2) - omega * ds["time"].values, k**2)
    expected = 2.0 * np.arcsin(k * sn) - math.pi / 2
    assert ds["position"].sel(coordinate="A").values == pytest.approx(expected, abs=3e-12)
    assert float(abs(ds["energy_drift"]).max()) < 1e-12


def test_taylor_series_make_what_steps_make(tmp_path: Path) -> None:
    """Servos, Coulomb friction; and driven coordinates that others take over from."""
    pytest.importorskip("heyoka")
    servo = {"X": {"stiffness": 1e3, "damping": 10, "target": 0.9}}
    block = solver(f'{BLOCK}friction = {{ coulomb = "2 N" }}\n', tmp_path)
    cranked = heavy("slider-crank")
    slide = next(j.name for j in cranked.joints if j.kind == "prismatic")
    cases = [(block, servo, {}), (parakin.compile(cranked, [slide]), None, {slide: 0.5})]
    for each, efforts, velocity in cases:
        one, other = (
            each.simulate(1.5, efforts, velocity=velocity, rate=100, rtol=1e-12, method=method)
            for method in ("dop853", "taylor")
        )
        assert (one["status"].values == other["status"].values).all()
        assert one["position"].values == pytest.approx(other["position"].values, abs=2e-8)


def test_what_taylor_series_cannot_have(tmp_path: Path) -> None:
    block = solver(BLOCK, tmp_path)
    refused: list[tuple[dict[str, Any], str]] = [
        ({"efforts": lambda _: {"X": 1.0}}, "efforts: found a Python function, of which"),
        ({"efforts": {"X": {"law": "sine", "amplitude": 1, "frequency": 1}}}, "over time"),
        ({"method": "euler"}, "method: found 'euler'"),
        ({"rtol": 1e-17}, "rtol: found 1e-17; expected 2.3e-16 to 0.001"),
        ({"rtol": 1e-15, "method": "dop853"}, "rtol: found 1e-15; expected 3e-14"),
        ({"rtol": math.nan}, "rtol: found nan"),
        ({"efforts": {"X": {"effort": 1, "most": 2}}}, "with stops or servos' bounds"),
    ]
    for given, message in refused:
        with pytest.raises(InputError, match=message):
            block.simulate(1.0, **{"method": "taylor", **given})
    stopped = solver(f"{BLOCK}stop = {{ stiffness = 1e3 }}\n[limits]\nX = [-1, 1]\n", tmp_path)
    with pytest.raises(InputError, match="with stops or servos' bounds"):
        stopped.simulate(1.0, method="taylor")
    plain = solver(BLOCK, tmp_path, machine_code=False)
    with pytest.raises(InputError, match="'taylor', without machine code"):
        plain.simulate(1.0, method="taylor")


@pytest.mark.parametrize("cut", [(), ("D",), ("B",)])
def test_a_servo_at_a_joint_that_is_cut(cut: tuple[str, ...]) -> None:
    """Whatever joint is left out of the tree, and turns counted: it winds the follower up."""
    bars = heavy("four-bar", parameters={"a": 0.2, "b": 0.22, "c": 0.2, "d": 0.05})
    joints = tuple(j.model_copy(update={"actuated": j.name == "D"}) for j in bars.joints)
    guess = {"B": "-50 deg", "D": "50 deg"}
    link = bars.model_copy(update={"joints": joints, "guess": guess, "home": {"A": "50 deg"}})
    dragged = parakin.compile(link, coordinates="all", cut=cut)
    target = dragged.home["D"] + 12.0
    servo = {"D": {"stiffness": 2.0, "damping": 0.5, "target": target}}
    ds = dragged.simulate(8.0, servo, rate=50, rtol=1e-11)
    assert (ds["status"] == 0).all()
    angle, rate = (ds[order].sel(coordinate="D").values for order in ("position", "velocity"))
    assert angle[-1] == pytest.approx(target, abs=1e-3)
    expected = 2.0 * (target - angle) - 0.5 * rate
    assert ds["effort"].values[:, 0] == pytest.approx(expected, abs=1e-7)
    assert float(abs(ds["energy_drift"]).max()) < 1e-8
    by_hand = dragged.simulate(
        0.5,
        lambda state: {"D": 2.0 * (target - state.position["D"]) - 0.5 * state.velocity["D"]},
        rate=50,
        rtol=1e-11,
    )
    for order in ("position", "velocity"):
        assert by_hand[order].values == pytest.approx(ds[order].values[:26], abs=1e-8)


def test_a_function_is_told_of_all_coordinates_always() -> None:
    """Of affine ones, cut ones, and the platform's; the same after another plan took over."""
    flight = parakin.compile("flight-simulator")
    told: list[State] = []

    def free(state: State) -> dict[str, float]:
        told.append(state)
        return {}

    y = {name: flight.home[name] for name in flight.driven}
    flight.simulate(0.01, free, velocity=dict.fromkeys(y, 0.1), rate=100)
    names = {c.name for c in flight.graph.coordinates}
    assert all(set(state.position) == set(state.velocity) == names for state in told)
    every = parakin.compile("flight-simulator", coordinates="all")
    last = told[-1]
    there = [last.position[name] for name in flight.driven]
    rates = [last.velocity[name] for name in flight.driven]
    tick = every.at(there, rates)
    for name in every.coordinates:
        if name in names:
            assert last.position[name] == pytest.approx(tick.value(name), abs=1e-8)
            assert last.velocity[name] == pytest.approx(tick.value(name, "velocity"), abs=1e-8)


def test_what_is_too_stiff_ends_flagged(tmp_path: Path) -> None:
    """With the words that tell what to do; an implicit method goes on."""
    stiff = solver(f"{BLOCK}damper = {{ damping = 1e8 }}\n", tmp_path)
    ds = stiff.simulate(1.0, {"X": 10.0}, velocity={"X": 0.1}, rate=10)
    assert ds["status"].values[-1] in (Status.NOT_SMOOTH, Status.NOT_REACHED)
    assert "method 'radau'" in ds.attrs["ended"]
    ds = stiff.simulate(1.0, {"X": 10.0}, velocity={"X": 0.1}, rate=10, method="radau")
    assert (ds["status"] == 0).all()
    assert ds["velocity"].values[-1, 0] == pytest.approx(1e-7, rel=1e-5)
    switched = solver(BLOCK, tmp_path).simulate(
        1.0, lambda s: {"X": -10.0 * math.copysign(1.0, s.velocity["X"])}, velocity={"X": 0.1}
    )
    assert Status.NOT_SMOOTH in switched["status"].values
    assert np.isnan(switched["position"].values[-1]).all()


def test_what_runs_away_ends_flagged(tmp_path: Path) -> None:
    """v' = v² is infinite after a second; and a force beyond all numbers at once."""
    block = solver(BLOCK, tmp_path)
    ds = block.simulate(2.0, lambda s: {"X": 4 * s.velocity["X"] ** 2}, velocity={"X": 1.0})
    (first, *_) = np.flatnonzero(ds["status"].values)
    assert ds["status"].values[first] == Status.NOT_SMOOTH
    assert float(ds["time"][first]) == pytest.approx(1.0, abs=1.5e-3)
    for how in ({"velocity": {"X": 1e300}}, {"efforts": {"X": 1e308}}):
        ds = block.simulate(1.0, **how)  # type: ignore[arg-type]
        assert Status.NOT_SMOOTH in ds["status"].values


def test_a_delta_that_falls_freely_ends(tmp_path: Path) -> None:
    delta = parakin.compile("delta")
    start = {"platform.x": 0.14, "platform.y": -0.23, "platform.z": -0.46}
    ds = delta.simulate(1.0, velocity=start, rate=100)
    assert set(ds["status"].values.tolist()) <= {int(each) for each in Status}
    assert np.isfinite(ds["position"].values[ds["status"].values == 0]).all()


def test_efforts_as_results_have_them(tmp_path: Path) -> None:
    """A table of `solve` with forces drives a simulation; positions are no efforts."""
    from parakin.files.datasets import write

    block = solver(
        f'{BLOCK}[motions.m]\nduration = 1\nlaws = {{ X = {{ law = "poly4567", by = 0.3 }} }}\n',
        tmp_path,
    )
    motion = block.solve("m", forces=True)
    write(iter([motion]), tmp_path / "table.csv")
    ds = block.simulate(1.0, tmp_path / "table.csv", rate=100)
    assert ds["position"].values[-1, 0] == pytest.approx(0.3, abs=1e-5)
    for header in ("X.position", "X,X.velocity"):
        rest = ",1" * header.count("X")
        (tmp_path / "e.csv").write_text(f"time,{header}\n0{rest}\n1{rest}\n")
        with pytest.raises(InputError, match=r"a (position|velocity); expected efforts: X, or"):
            block.simulate(1.0, tmp_path / "e.csv")


def test_times_that_are_asked_for(tmp_path: Path) -> None:
    block = solver(f"{BLOCK}spring = {{ stiffness = 400 }}\n", tmp_path)
    times = [0.1, 0.13, 1.7]
    ds = block.simulate(2.0, start={"X": 1.0}, times=times, rtol=1e-11)
    assert ds["time"].values.tolist() == times
    expected = np.cos(10.0 * np.array(times))
    assert ds["position"].values[:, 0] == pytest.approx(expected, abs=1e-9)
    assert ds["energy_drift"].values == pytest.approx(0.0, abs=1e-8)
    for wrong in ([0.2, 0.1], [-1.0, 0.0], [0.0, 3.0], [math.nan], [], "x", [[0.0]]):
        with pytest.raises(InputError, match="times: found"):
            block.simulate(2.0, times=wrong)


def test_a_distance_that_shrinks_to_nothing_ends_nothing() -> None:
    """The flight simulator's leg E passes the centre that its row measures from, where it is as
    regular as ever: so says the simulation that its actuators drive, which has another row there.
    """
    flight = heavy("flight-simulator")
    sliders = [c.name for c in parakin.compile(flight).graph.coordinates if c.actuated]
    posed = parakin.compile(flight, coordinates="all")
    speeds = np.random.default_rng(2).uniform(-0.5, 0.5, 3).tolist()
    one = posed.simulate(
        0.9, velocity=dict(zip(posed.driven, speeds, strict=True)), rate=50, rtol=1e-10
    )
    rates = {name: float(one["velocity"].sel(coordinate=name)[0]) for name in sliders}
    moved = parakin.compile(flight, sliders, coordinates="all")
    other = moved.simulate(0.9, velocity=rates, rate=50, rtol=1e-10)
    for ds in (one, other):
        assert (ds["status"] == 0).all()
        assert float(abs(ds["energy_drift"]).max()) < 1e-8
    assert one["position"].values == pytest.approx(other["position"].values, abs=1e-7)


@pytest.mark.parametrize("rtol", [1e-3, 1e-5, 1e-7, 1e-9, 1e-11])
def test_what_comes_to_rest_is_told_to_the_end(tmp_path: Path, rtol: float) -> None:
    """Where nothing moves any more, what the integration leaves is no motion."""
    acting = "spring = { stiffness = 400 }\ndamper = { damping = 40 }\n"
    ds = solver(f"{BLOCK}{acting}", tmp_path).simulate(20.0, start={"X": 0.1}, rate=100, rtol=rtol)
    assert (ds["status"] == 0).all()
    assert abs(float(ds["position"][-1, 0])) < 10 * rtol


def test_a_hexapod_on_servos_comes_to_rest() -> None:
    """Stiff, and so slow without machine code."""
    pytest.importorskip("heyoka")
    hexapod = parakin.compile("gough-stewart")
    servo = {"stiffness": "200 kN/m", "damping": "8 kN s/m"}
    legs = {f"P{k}": servo for k in range(1, 7)}
    ds = hexapod.simulate(2.0, legs, rate=50)
    assert (ds["status"] == 0).all()
    still = hexapod.simulate(2.0, legs, rate=50, method="radau", rtol=1e-6)
    assert (still["status"] == 0).all()
    assert still["position"].values[-1] == pytest.approx(ds["position"].values[-1], abs=1e-6)


def test_a_long_run_is_not_taken_for_a_stiff_one(tmp_path: Path) -> None:
    """Its steps are short because efforts are looked at in every sample."""
    law = {"law": "sine", "amplitude": 1, "frequency": "0.01 Hz"}
    ds = solver(BLOCK, tmp_path).simulate(3000.0, {"X": law}, rate=5, times=[1.0, 3000.0])
    assert (ds["status"] == 0).all()


def test_redundant_actuators_cannot_hold(tmp_path: Path) -> None:
    bars = heavy("four-bar")
    joints = tuple(j.model_copy(update={"actuated": j.name in "AD"}) for j in bars.joints)
    both = parakin.compile(bars.model_copy(update={"joints": joints}), machine_code=False)
    with pytest.raises(InputError, match="hold: found 2 actuators for 1 freedoms"):
        both.simulate(0.1, hold=True)


def test_a_servo_with_the_efforts_of_a_result_feeds_forward(tmp_path: Path) -> None:
    from parakin.files.datasets import write

    law = 'laws = { X = { law = "poly4567", by = 0.3 } }'
    block = solver(f"{BLOCK}[motions.m]\nduration = 1\n{law}\n", tmp_path)
    motion = block.solve("m", forces=True)
    write(iter([motion]), tmp_path / "legs.csv")
    file = str(tmp_path / "legs.csv")
    servo = {"stiffness": 400, "damping": 16, "target": file}
    behind = block.simulate(1.0, {"X": servo}, rate=100)
    ahead = block.simulate(1.0, {"X": {**servo, "effort": file}}, rate=100)
    there = motion["position"].sel(time=ahead["time"].values, method="nearest").values
    assert ahead["position"].values == pytest.approx(there, abs=1e-6)
    assert np.abs(behind["position"].values - there).max() > 1e-3
