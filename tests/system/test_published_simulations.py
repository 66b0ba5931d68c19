"""Simulated motions against those that others have published, and against conserved energy."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from test_published_forces import ANDREWS

import parakin
from parakin import Status

DENSITY = 7700.0  # [kg/m³], of Modelica's examples


def solver_of(text: str, folder: Path, cut: tuple[str, ...] = ()) -> parakin.Solver:
    (folder / "mechanism.toml").write_text(text)
    return parakin.compile(folder / "mechanism.toml", coordinates="all", cut=cut)


def test_andrews_mechanism_is_where_the_reference_has_it(tmp_path: Path) -> None:
    """0.03 s of 0.033 N m (the test set for IVP solvers: PSIDE at 1e-14)."""
    andrews = solver_of(ANDREWS, tmp_path)
    ds = andrews.simulate(0.03, {"O": "0.033 N m"}, rtol=1e-11)
    assert (ds["status"] == 0).all()
    end = ds.isel(time=-1)
    expected = {
        "O": (15.81077119629904, 1139.920302151208),
        "F": (-15.75637105984298, -1424.379294994111),
        "B": (0.04082224013073101, 11.03291221937134),
        "G": (-0.5347301163226948, 19.29337464421385),
        "A5": (0.5244099658805304, 0.5735699284790808),
        "H": (0.5347301163226948, -19.29337464421385),
        "A7": (1.048080741042263, 0.3231791658026955),
    }
    for name, (angle, rate) in expected.items():
        one = end.sel(coordinate=name)
        assert float(one["position"]) == pytest.approx(angle, abs=5e-9)
        # The published place of K1 is 1e-9 rad off, by which rates change by up to 3e-8 of them.
        assert float(one["velocity"]) == pytest.approx(rate, rel=1e-7)
    assert float(abs(ds["energy_drift"]).max()) < 1e-9
    assert float(ds["closure_drift"].max()) < 1e-9


# Bricard's mechanism (IFToMM A04): five rods of 1 m and 1 kg, 0.1 m square, along the edges of a
# cube, falling from rest; the base holds the first joint and the last.
CORNERS = [(0, 0, 0), (1, 0, 0), (1, -1, 0), (1, -1, 1), (0, -1, 1), (0, 0, 1)]
AXES = [(0, 1, 0), (0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 0)]


def bricard() -> str:
    rods = np.diff(np.array(CORNERS, dtype=float), axis=0)
    text = 'name = "bricard"\nup = "y"\ndriven = ["J1"]\ngravity = "9.81 m/s^2"\nhome.J1 = 0\n'
    text += "guess = { J2 = 0, J3 = 0, J4 = 0, J5 = 0 }\n[bodies]\n"
    for number, along in enumerate(rods, 1):
        across = (1.0 + 0.1**2) / 12
        moments = np.where(along != 0.0, 2 * 0.1**2 / 12, across).tolist()
        centre = (along / 2).tolist()
        text += f"R{number} = {{ mass = 1, com = {centre}, inertia = {moments} }}\n"
    text += "[joints]\n"
    for number, axis in enumerate(AXES, 1):
        x = [1, 0, 0] if axis == (0, 0, 1) else [0, 0, 1]
        frame = f"axis = {list(axis)}, x = {x}"
        place = [0, 0, 0] if number == 1 else rods[number - 2].tolist()
        parent, child = ("base" if number == 1 else f"R{number - 1}"), f"R{number}"
        on_parent, on_child = f"at = {place}, {frame}", frame
        if number == 6:
            parent, child = "base", "R5"
            on_parent, on_child = f"at = [0, 0, 1], {frame}", f"at = {place}, {frame}"
        text += f'J{number} = {{ kind = "revolute", parent = "{parent}", child = "{child}", '
        text += f"on_parent = {{ {on_parent} }}, on_child = {{ {on_child} }} }}\n"
    return text


def test_bricards_mechanism_keeps_its_energy(tmp_path: Path) -> None:
    """10 s from rest; rows of one plan die on the way, and others take over. The place of the third
    rod's beginning after 1 s and 2 s, of a simulation of another formulation.
    """
    solver = solver_of(bricard(), tmp_path)
    ds = solver.simulate(10.0, rate=100, rtol=1e-11, bodies=["R3"])
    assert (ds["status"] == 0).all()
    total = ds["kinetic_energy"] + ds["potential_energy"]
    assert float(abs(total - total[0]).max()) < 1e-8
    place = ds["body_position"].sel(body="R3")
    assert place.values[100] == pytest.approx([0.274481, -0.886708, -0.462330], abs=1e-6)
    assert place.values[200] == pytest.approx([-0.778135, -0.980353, -0.197253], abs=1e-6)


@pytest.mark.parametrize("cut", [("D", "J2"), ("B", "J2")])
def test_full_turns_are_kept_where_another_plan_takes_over(
    tmp_path: Path, cut: tuple[str, ...]
) -> None:
    """Bricard's mechanism beside a drag link whose follower winds up a spring: its joint is cut in
    one plan and not in the next, and whatever is cut, the motion is the same.
    """
    text = bricard().replace('driven = ["J1"]', 'driven = ["J1", "A"]')
    text = text.replace("home.J1 = 0", 'home.J1 = 0\nhome.A = "50 deg"')
    text = text.replace("guess = {", 'guess = { B = "-50 deg", D = "50 deg",')
    light = "{ mass = 0.001, inertia = [1e-6, 1e-6, 1e-6] }"
    bodies = f"[bodies]\na = {{ mass = 1, inertia = [0.1, 0.1, 0.1] }}\nb = {light}\nd = {light}"
    text = (
        text.replace("[bodies]", bodies)
        + """
A = { kind = "revolute", parent = "base", child = "a" }
B = { kind = "revolute", parent = "a", child = "b", on_parent = { at = [0.2, 0, 0] } }
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
spring = { stiffness = 0.01 }
"""
    )
    one = solver_of(text, tmp_path)
    other = solver_of(text, tmp_path, cut)
    first, second = (
        s.simulate(4.0, velocity={"A": 8.0}, rate=50, rtol=1e-11) for s in (one, other)
    )
    for ds in (first, second):
        assert (ds["status"] == 0).all()
        assert float(abs(ds["energy_drift"]).max()) < 1e-6
    angles = [ds["position"].sel(coordinate="D").values for ds in (first, second)]
    assert angles[0][-1] > 6 * math.pi
    assert angles[0] == pytest.approx(angles[1], abs=1e-5)


def box(along: tuple[float, float, float], width: float) -> str:
    """A square bar of Modelica's, from its body's origin."""
    r = np.array(along)
    length = float(np.linalg.norm(r))
    u, mass = r / length, DENSITY * length * width**2
    tensor = np.eye(3) * (length**2 + width**2) / 12
    tensor += np.outer(u, u) * (width**2 / 6 - (length**2 + width**2) / 12)
    xx, yy, zz = (mass * np.diag(tensor)).tolist()
    xy = float(mass * tensor[0, 1])
    inertia = f"{{ xx = {xx}, yy = {yy}, zz = {zz}, xy = {xy}, xz = 0, yz = 0 }}"
    return f"{{ mass = {mass}, com = {(r / 2).tolist()}, inertia = {inertia} }}"


# Modelica.Mechanics.MultiBody.Examples.Loops.PlanarFourbar: a damper at the first joint.
PLANAR = f"""
name = "planar-fourbar"
up = "y"
driven = ["R1"]
home.R1 = 0
guess = {{ R2 = 0, R3 = 0 }}
[bodies]
b1 = {box((0.4, 0, 0), 0.05)}
b2 = {box((0.1, 1.1, 0), 0.05)}
b4 = {box((0.65, 0.1, 0), 0.05)}
[joints]
R1 = {{ kind = "revolute", parent = "base", child = "b1", damper = {{ damping = 0.1 }} }}
R2 = {{ kind = "revolute", parent = "b1", child = "b2", on_parent = {{ at = [0.4, 0, 0] }} }}
R3 = {{ kind = "revolute", parent = "base", child = "b4", on_parent = {{ at = [-0.15, 1, 0] }} }}
R4 = {{ kind = "revolute", parent = "b4", child = "b2", on_parent = {{ at = [0.65, 0.1, 0] }}, on_child = {{ at = [0.1, 1.1, 0] }} }}
"""


def test_modelicas_planar_four_bar(tmp_path: Path) -> None:
    """Its reference result was made by DASSL, at a tolerance of 1e-6 or so: it converges no
    farther, and with damping is 4e-4 rad off after 5 s.
    """
    ds = solver_of(PLANAR, tmp_path).simulate(5.0, rtol=1e-11)
    assert (ds["status"] == 0).all()
    first = ds.sel(coordinate="R1")
    for time, angle, rate, within in (
        (0.1, -0.135510108856004, -2.72234586489693, 1e-5),
        (0.3, -1.31824202202896, -10.0566051039023, 2e-5),
        (5.0, -0.939783395642669, 6.99349011457421, 3e-3),
    ):
        at = first.sel(time=time, method="nearest")
        assert float(at["position"]) == pytest.approx(angle, abs=within)
        assert float(at["velocity"]) == pytest.approx(rate, abs=within)
    assert float(abs(ds["energy_drift"]).max()) < 1e-7


# ...Loops.Fourbar2: b3 is a rod without mass between spherical joints.
SPATIAL = f"""
name = "fourbar2"
up = "y"
driven = ["j1"]
home.j1 = 0
guess.j2 = "-0.2 m"
[bodies.b1]
solid = {{ kind = "cylinder", to = [0, 0.5, 0.1], diameter = "50 mm", density = {DENSITY} }}
[bodies.b2]
solid = {{ kind = "cylinder", to = [0, 0.2, 0], diameter = "50 mm", density = {DENSITY} }}
[joints.j1]
kind = "revolute"
parent = "base"
child = "b1"
on_parent = {{ axis = [1, 0, 0], x = [0, 1, 0] }}
on_child = {{ axis = [1, 0, 0], x = [0, 1, 0] }}
[joints.j2]
kind = "prismatic"
parent = "base"
child = "b2"
on_parent = {{ at = [1.2, 0, 0], axis = [1, 0, 0], x = [0, 1, 0] }}
on_child = {{ axis = [1, 0, 0], x = [0, 1, 0] }}
[joints.rod]
kind = "rod"
parent = "b2"
child = "b1"
length = "sqrt(1.1)"
on_parent = {{ at = [0, 0.2, 0] }}
on_child = {{ at = [0, 0.5, 0.1] }}
"""


def test_modelicas_spatial_four_bar(tmp_path: Path) -> None:
    """DASSL's result moves away from the exact one: 5e-9 rad after 1 ms, 4e-7 after 0.1 s."""
    solver = solver_of(SPATIAL, tmp_path)
    ds = solver.simulate(0.39, velocity={"j1": 5.235987755983}, rtol=1e-11)
    assert (ds["status"] == 0).all()
    first = ds.sel(coordinate="j1")
    for time, angle, rate, within in (
        (0.05, 0.271433146214799, 5.67855581161764, 2e-6),
        (0.1, 0.573376668421537, 6.45142661373691, 1e-6),
        (0.2, 1.32755980232428, 8.76633827389605, 5e-6),
        (0.39, 3.39245098162667, 11.5725985755336, 2e-5),
    ):
        at = first.sel(time=time, method="nearest")
        assert float(at["position"]) == pytest.approx(angle, abs=within)
        assert float(at["velocity"]) == pytest.approx(rate, abs=50 * within)


# ...Loops.Engine1a: a slider-crank with counterweights, and a flywheel of 1 kg m². All turns about
# x; of the crank only its mass's moment about y and z and the moment of inertia about x matter.
ROD_MASS = DENSITY * 0.2 * 0.02 * 0.06
PISTON_MASS = DENSITY * math.pi / 4 * 0.1**2 * 0.1


def crank() -> str:
    """Two journals, and two webs of 0.1 m from the axis to the second one's."""
    first = DENSITY * math.pi / 4 * 0.05**2 * 0.1
    second = DENSITY * math.pi / 4 * 0.03**2 * 0.1
    web = DENSITY * 0.1 * 0.02 * 0.05
    mass = first + second + 2 * web
    centre = (second * 0.1 + 2 * web * 0.05) / mass
    about_axis = first * 0.025**2 / 2 + second * (0.015**2 / 2 + 0.1**2)
    about_axis += 2 * web * ((0.1**2 + 0.05**2) / 12 + 0.05**2)
    moment = about_axis + 1.0 - mass * centre**2
    inertia = f"inertia = {{ xx = {moment}, yy = {moment}, zz = {moment}, xy = 0, xz = 0, yz = 0 }}"
    return f"{{ mass = {mass}, com = [0, {centre}, 0], {inertia} }}"


ENGINE = f"""
name = "engine1a"
up = "y"
driven = ["A"]
home.A = 0
guess = {{ B = 0, D = "0.15 m" }}
[bodies]
crank = {crank()}
rod = {{ mass = {ROD_MASS}, com = [0, 0.1, 0], inertia = {[ROD_MASS * (0.2**2 + 0.06**2) / 12] * 3} }}
piston = {{ mass = {PISTON_MASS} }}
[joints]
A = {{ kind = "revolute", parent = "base", child = "crank", on_parent = {{ axis = [1, 0, 0], x = [0, 1, 0] }}, on_child = {{ axis = [1, 0, 0], x = [0, 1, 0] }} }}
B = {{ kind = "revolute", parent = "crank", child = "rod", on_parent = {{ at = [0, 0.1, 0], axis = [1, 0, 0], x = [0, 1, 0] }}, on_child = {{ axis = [1, 0, 0], x = [0, 1, 0] }} }}
C = {{ kind = "revolute", parent = "rod", child = "piston", on_parent = {{ at = [0, 0.2, 0], axis = [1, 0, 0], x = [0, 1, 0] }}, on_child = {{ axis = [1, 0, 0], x = [0, 1, 0] }} }}
D = {{ kind = "prismatic", parent = "base", child = "piston", on_parent = {{ at = [0, 0.45, 0], axis = [0, -1, 0], x = [1, 0, 0] }}, on_child = {{ axis = [0, -1, 0], x = [1, 0, 0] }} }}
"""


def test_modelicas_engine(tmp_path: Path) -> None:
    """Again as far as DASSL's result is right."""
    ds = solver_of(ENGINE, tmp_path).simulate(5.0, velocity={"A": 10.0}, rtol=1e-11)
    assert (ds["status"] == 0).all()
    first = ds.sel(coordinate="A")
    for time, angle, rate, within in (
        (0.1, 1.0004154411293491, 10.105694909248406, 1e-5),
        (0.2, 2.0605325976228186, 11.178709805561917, 1e-4),
        (5.0, 53.415197349631406, 11.640358486979379, 1e-2),
    ):
        at = first.sel(time=time, method="nearest")
        assert float(at["position"]) == pytest.approx(angle, abs=within)
        assert float(at["velocity"]) == pytest.approx(rate, abs=within)
    total = ds["kinetic_energy"] + ds["potential_energy"]
    assert float(abs(total - total[0]).max()) < 1e-8


def test_the_n_four_bar_is_flagged_where_its_mobility_changes(tmp_path: Path) -> None:
    """IFToMM A02: five bars of 1 m and 1 kg, two squares side by side, sway until all lie along one
    line, where each four-bar could go on in two ways.
    """
    bar = "{ mass = 1, com = [0.5, 0, 0], inertia = [0, 0.0833333333333333, 0.0833333333333333] }"
    text = 'name = "a02"\nup = "y"\ndriven = ["A"]\ngravity = "9.81 m/s^2"\nhome.A = "90 deg"\n'
    text += 'guess = { B = "-90 deg", C = "90 deg", E = "-90 deg", F = "90 deg" }\n[bodies]\n'
    text += "".join(f"{name} = {bar}\n" for name in ("v1", "v2", "v3", "h1", "h2")) + "[joints]\n"
    for name, parent, child, on_parent, on_child in (
        ("A", "base", "v1", 0, 0),
        ("C", "base", "v2", 1, 0),
        ("F", "base", "v3", 2, 0),
        ("B", "v1", "h1", 1, 0),
        ("D", "h1", "v2", 1, 1),
        ("E", "v2", "h2", 1, 0),
        ("G", "h2", "v3", 1, 1),
    ):
        text += f'{name} = {{ kind = "revolute", parent = "{parent}", child = "{child}", '
        text += f"on_parent = {{ at = [{on_parent}, 0, 0] }}, on_child = {{ at = [{on_child}, 0, 0] }} }}\n"
    ds = solver_of(text, tmp_path).simulate(1.0, velocity={"A": -1.0}, rate=200, rtol=1e-10)
    flagged = int(np.flatnonzero(ds["status"].values)[0])
    assert ds["status"].values[flagged] in (Status.SINGULAR, Status.BRANCH_CHANGE)
    assert (ds["status"].values[flagged + 1 :] == Status.NOT_REACHED).all()
    angle = float(ds["position"].sel(coordinate="A")[flagged - 1])
    rate = float(ds["velocity"].sel(coordinate="A")[flagged - 1])
    assert 0.0 < angle < -rate / 200  # the next sample is beyond the line
    total = (ds["kinetic_energy"] + ds["potential_energy"]).values[:flagged]
    assert total == pytest.approx(total[0], abs=1e-6)
