"""Gravity, what acts in joints and on bodies, in numbers; and what is refused."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

import parakin
from parakin import InputError, Mechanism
from parakin.model.dynamics import Dynamics, Passive
from parakin.model.evaluation import graph_of

BASE = """
name = "arm"
driven = ["A"]
[bodies]
arm = { mass = 2, points = { tip = [1, 0, 0] } }
cart = {}
[joints.A]
kind = "revolute"
parent = "base"
child = "arm"
actuated = true
[joints.B]
kind = "prismatic"
parent = "arm"
child = "cart"
"""


def mechanism(tmp_path: Path, more: str = "", top: str = "", a: str = "", b: str = "") -> Mechanism:
    text = BASE.replace("[joints.B]", f"{a}\n[joints.B]").replace("name =", f"{top}\nname =")
    (tmp_path / "arm.toml").write_text(f"{text}{b}\n{more}\n")
    return parakin.load(tmp_path / "arm.toml")


def dynamics(tmp_path: Path, more: str = "", top: str = "", a: str = "", b: str = "") -> Dynamics:
    return graph_of(mechanism(tmp_path, more, top, a, b)).dynamics


@pytest.mark.parametrize(
    ("top", "gravity"),
    [
        ("", (0.0, 0.0, -9.80665)),
        ('up = "y"', (0.0, -9.80665, 0.0)),
        ('gravity = "1.62 m/s^2"', (0.0, 0.0, -1.62)),
        ("gravity = 0", (0.0, 0.0, 0.0)),
        ('gravity = [1, "2 m/s^2", -3]', (1.0, 2.0, -3.0)),
    ],
)
def test_gravity_pulls_down_unless_told(
    tmp_path: Path, top: str, gravity: tuple[float, ...]
) -> None:
    assert dynamics(tmp_path, top=top).gravity == gravity


def test_without_masses_there_is_no_gravity() -> None:
    found = graph_of(parakin.load("four-bar")).dynamics
    assert found.gravity == (0.0, 0.0, 0.0)
    assert not found.any


def test_values_are_per_coordinate_in_its_units(tmp_path: Path) -> None:
    found = dynamics(
        tmp_path,
        a='friction = { coulomb = "0.5 N m", viscous = "0.1 N m s/rad" }\n'
        'spring = { stiffness = "2 N m/deg", zero = "5 deg" }\narmature = "1e-3 kg m^2"',
        b='friction = { coulomb = "30 N", viscous = "200 N s/m" }\n'
        'damper = { damping = "5 N s/mm", zero = "1 mm/s" }\narmature = "3 kg"',
    )
    assert found.passive[0] == pytest.approx(
        Passive(360 / math.pi, math.radians(5), 0.0, 0.0, 0.1, 0.5, 1e-3)
    )
    assert found.passive[1] == pytest.approx(Passive(0.0, 0.0, 5000.0, 1e-3, 200.0, 30.0, 3.0))


def test_a_ball_screw_and_a_gear_in_si(tmp_path: Path) -> None:
    b = 'actuated = true\ndrive = { lead = "10 mm", efficiency = 0.9, rotor = "2e-4 kg m^2" }'
    found = dynamics(tmp_path, b=b, a="drive = { ratio = 50, max_effort = '20 N m' }").motors
    assert found[1].ratio == pytest.approx(2 * math.pi / 0.01)
    assert (found[1].efficiency, found[1].back_efficiency) == (0.9, 0.9)
    assert (found[0].ratio, found[0].max_effort) == (50.0, 20.0)
    assert math.isinf(found[0].max_power)


def test_forces_between_points_and_on_bodies(tmp_path: Path) -> None:
    found = dynamics(
        tmp_path,
        """
[forces]
s = { kind = "spring", between = ["arm.tip", "base"], stiffness = "2 N/mm", length = "1 m" }
w = { kind = "wrench", at = "arm.tip", force = [0, 0, "-3 N"], axes = "body" }
p = { kind = "payload", at = "cart", mass = "80 kg", inertia = [1, 2, 2] }
""",
    )
    (spring,), (wrench,), (load,) = found.springs, found.wrenches, found.loads
    assert spring.ends == ((1, (1.0, 0.0, 0.0)), (0, (0.0, 0.0, 0.0)))
    assert (spring.stiffness, spring.length) == (2000.0, 1.0)
    assert (wrench.body, wrench.force, wrench.turns, wrench.inputs) == (
        1,
        (0.0, 0.0, -3.0),
        True,
        0,
    )
    assert (load.body, load.mass.mass) == (2, 80.0)
    assert found.inputs == 1


def test_a_payload_may_be_added_by_name(tmp_path: Path) -> None:
    plain = mechanism(tmp_path)
    twice = plain.with_payload("80 kg at cart").with_payload("500 g at arm.tip")
    loads = graph_of(twice).dynamics.loads
    assert [(load.name, load.body, load.mass.mass) for load in loads] == [
        ("payload", 2, 80.0),
        ("payload 2", 1, 0.5),
    ]
    assert not plain.forces
    for text in ("80 kg", "at cart", "80 kg at "):
        with pytest.raises(InputError, match="expected a mass and a place"):
            plain.with_payload(text)
    with pytest.raises(InputError, match="unknown body or point 'wing'"):
        graph_of(plain.with_payload("1 kg at wing"))


@pytest.mark.parametrize(
    ("where", "text", "said"),
    [
        ("a", "friction = { coulomb = -1 }", "joints.A.friction.coulomb: found -1"),
        ("a", 'friction = { coulomb = "3 N" }', "found '3 N', a force; expected a torque"),
        ("a", "friction = [{}, {}]", "joints.A.friction: found 2 for 1 coordinates"),
        ("a", "friction = { coefficient = 0.1 }", "no radius of a revolute joint's friction"),
        ("a", "friction = { radius = 0.1 }", "one without a coefficient"),
        ("b", "friction = { coefficient = 0.1, radius = 1 }", "a radius of a prismatic joint's"),
        ("b", "drive = { lead = 1 }", "a drive of a joint that is not actuated"),
        ("a", 'drive = { lead = "5 mm" }', "found a lead on a turn"),
        ("b", "actuated = true\ndrive = { ratio = 5 }", "found a gear ratio on a slide"),
        ("a", "drive = { efficiency = 1.2 }", "drive.efficiency: found 1.2; expected from 0 to 1"),
        ("a", "drive = { efficiency = 0 }", "drive.efficiency: found 0; expected above 0"),
        ("a", "drive = { max_effort = 0 }", "drive.max_effort: found 0; expected above zero"),
        ("a", "spring = { zero = 1 }", "joints.A.spring: found no key 'stiffness'"),
        ("more", "[forces.f]\nkind = 'gust'", "forces.f.kind: found 'gust'"),
        (
            "more",
            "[forces.f]\nkind = 'spring'\nbetween = ['arm', 'arm.tip']",
            "forces.f.between: found two points of one body",
        ),
        (
            "more",
            "[forces.f]\nkind = 'payload'\nat = 'base'\nmass = 1",
            "found a payload on the base",
        ),
        (
            "more",
            "[forces.f]\nkind = 'wrench'\nat = 'base'\nforce = [1, 0, 0]",
            "found a wrench on the base",
        ),
        (
            "more",
            "[forces.f]\nkind = 'wrench'\nat = 'arm'\ncsv = 'f.csv'\nforce = [1, 0, 0]",
            "forces.f.csv: found a file beside a law or values",
        ),
        ("top", "gravity = -9.81", "gravity: found -9.81; expected zero or more"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path: Path, where: str, text: str, said: str) -> None:
    with pytest.raises(InputError) as refusal:
        dynamics(tmp_path, **{where: text})
    assert said in str(refusal.value)


def test_springs_and_friction_in_a_ball_are_refused_but_for_damping() -> None:
    hexapod = parakin.load("gough-stewart")
    ball = next(joint for joint in hexapod.joints if joint.kind == "spherical")

    def with_ball(**told: Any) -> Dynamics:
        joint = parakin.Joint(**ball.model_dump(exclude_defaults=True) | told)
        return graph_of(
            hexapod.model_copy(update={"joints": (joint, *hexapod.joints[:-1])})
        ).dynamics

    assert with_ball(friction={"viscous": 0.5}).balls[0].damping == 0.5
    for told in ({"spring": {"stiffness": 1}}, {"friction": {"coulomb": 1}}, {"armature": 1}):
        with pytest.raises(InputError, match="spherical joint"):
            with_ball(**told)
