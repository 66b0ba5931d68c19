"""What weighs and resists in MJCF, where `oracles/random_mjcf.py` does not tell: what is left out,
classes, lists in exported models. (Random trees are compared with MuJoCo's inverse dynamics.)
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from weighty import masses

import parakin
from parakin.errors import InputError
from parakin.model.drives import Drive
from parakin.model.evaluation import graph_of

pytest.importorskip("mujoco")
pytest.importorskip("lxml")

MODEL = """<mujoco>{before}<worldbody><body name="a"><joint name="j" {joint}/>{inside}</body>
</worldbody>{after}</mujoco>"""
BALL = '<inertial pos="0 0 1" mass="2" diaginertia="1 1 1"/>'


def loaded(
    folder: Path, joint: str = "", inside: str = BALL, before: str = "", after: str = ""
) -> parakin.Mechanism:
    text = MODEL.format(joint=joint, inside=inside, before=before, after=after)
    (folder / "m.xml").write_text(text)
    return parakin.load(folder / "m.xml")


def test_a_joint_meets_what_its_attributes_say(tmp_path: Path) -> None:
    """Angles in degrees; a spring's zero counts as the coordinate does, wherever `ref` is."""
    said = 'armature="0.1" damping="0.2" frictionloss="0.3" stiffness="4" springref="30" ref="10"'
    mechanism = loaded(tmp_path, said)
    passive = graph_of(mechanism).dynamics.passive[0]
    assert (passive.armature, passive.viscous, passive.coulomb) == (0.1, 0.2, 0.3)
    assert (passive.stiffness, passive.zero) == pytest.approx((4, math.radians(30)))
    assert mechanism.gravity == (0.0, 0.0, -9.81)


def test_what_is_disabled_does_not_act(tmp_path: Path) -> None:
    flag = '<option><flag gravity="disable" spring="disable" frictionloss="disable"/></option>'
    said = 'damping="0.2" frictionloss="0.3" stiffness="4"'
    mechanism = loaded(tmp_path, said, before=flag)
    passive = graph_of(mechanism).dynamics.passive[0]
    assert (passive.viscous, passive.coulomb, passive.stiffness) == (0.2, 0.0, 0.0)
    assert mechanism.gravity == (0.0, 0.0, 0.0)


def test_shapes_weigh_what_mujoco_says(tmp_path: Path) -> None:
    """A ball of 1000 kg/m³ by default; what is told beside it counts instead."""
    ball = '<geom size="0.1"/>'
    found = masses(graph_of(loaded(tmp_path, inside=ball)))["a"]
    mass = 1000 * 4 / 3 * math.pi * 1e-3
    inertia = np.eye(3).ravel() * 0.4 * mass * 0.01
    np.testing.assert_allclose(found, [mass, 0, 0, 0, *inertia], rtol=1e-12)
    found = masses(graph_of(loaded(tmp_path, inside=ball + BALL)))["a"]
    np.testing.assert_allclose(found, [2, 0, 0, 1, *np.eye(3).ravel()])
    shape = '<geom type="mesh" mesh="none" {}/>'
    asset = '<asset><mesh name="none" file="no such file.stl"/></asset>'
    mechanism = loaded(tmp_path, inside=ball + shape.format(""), before=asset)
    assert "bodies shaped by meshes, which are not read: a." in mechanism.notes
    assert not graph_of(mechanism).dynamics.masses
    for harmless in ('mass="0"', 'density="0"', 'class="seen"'):
        seen = '<default><default class="seen"><geom density="0"/></default></default>'
        inside = ball + shape.format(harmless)
        found = masses(graph_of(loaded(tmp_path, inside=inside, before=asset + seen)))["a"]
        assert found[0] == pytest.approx(mass)
    mechanism = loaded(tmp_path, inside=shape.format("") + BALL, before=asset)
    assert masses(graph_of(mechanism))["a"][0] == 2


def test_bodies_without_anything_weigh_nothing(tmp_path: Path) -> None:
    mechanism = loaded(tmp_path, inside="")
    assert mechanism.gravity is None
    assert not graph_of(mechanism).dynamics.any
    point = '<inertial pos="0 0 1" mass="2" diaginertia="0 0 0"/>'
    found = masses(graph_of(loaded(tmp_path, inside=point)))["a"]
    np.testing.assert_allclose(found, [2, 0, 0, 1, *([0] * 9)])


def test_a_screw_meets_what_its_hinge_and_slide_do(tmp_path: Path) -> None:
    """The slide stands at 0.3 + 0.5 times the angle: energies of both are one's."""
    slide = (
        '<joint name="s" type="slide" armature="4" damping="8" frictionloss="2" stiffness="16" '
        'springref="1"/>'
    )
    couple = '<equality><joint joint1="s" joint2="j" polycoef="0.3 0.5"/></equality>'
    radians = '<compiler angle="radian"/>'
    joint = 'armature="1" damping="1" frictionloss="1" stiffness="4" springref="0.4"'
    mechanism = loaded(tmp_path, joint, slide + BALL, radians, couple)
    passive = graph_of(mechanism).dynamics.passive[0]
    assert (passive.armature, passive.viscous, passive.coulomb) == pytest.approx((2, 3, 2))
    # 4 (q - 0.4) + 0.5 · 16 (0.3 + 0.5 q - 1) = 8 (q - 0.9)
    assert (passive.stiffness, passive.zero) == pytest.approx((8, 0.9))


def test_gears_of_motors_on_hinges_are_drives(tmp_path: Path) -> None:
    motor = '<actuator><motor joint="j" {}/></actuator>'
    for gear, ratio in (('gear="50"', 50.0), ("", None), ('gear="1"', None)):
        (joint,) = loaded(tmp_path, after=motor.format(gear)).joints
        assert joint.drive == (None if ratio is None else Drive(ratio=ratio))
    classes = (
        '<default><motor gear="3"/><default class="c"><position gear="7"/></default></default>'
    )
    for said, ratio in (("", 3.0), ('class="c"', 7.0)):
        (joint,) = loaded(tmp_path, before=classes, after=motor.format(said)).joints
        assert joint.drive == Drive(ratio=ratio)
    mechanism = loaded(tmp_path, 'type="slide"', after=motor.format('gear="50"'))
    assert "Not used: gears of actuators on line 2." in mechanism.notes


@pytest.mark.parametrize(
    ("joint", "said"),
    [
        ('type="ball" stiffness="1"', "Not used: stiffness of 'j'."),
        ('type="ball" armature="1" frictionloss="1"', "frictionloss and armature of 'j'."),
        ('type="free" damping="1"', "Not used: damping of 'j'."),
        ('springdamper="1 1"', "Not used: springdamper on line 1."),
        ('damping="1 2"', "Not used: nonlinear springs and dampers of 'j'."),
    ],
)
def test_what_has_no_counterpart_is_told(joint: str, said: str, tmp_path: Path) -> None:
    more = '<body name="b"><joint/><geom size="1"/></body>'
    assert said in loaded(tmp_path, joint, BALL + more).notes


def test_damping_of_a_ball_is_that_of_a_spherical_joint(tmp_path: Path) -> None:
    (joint,) = loaded(tmp_path, 'type="ball" damping="0.7"').joints
    assert joint.kind == "spherical"
    (friction,) = joint.friction
    assert friction.viscous == 0.7


def test_bodies_within_a_joint_that_weigh_something_stay(tmp_path: Path) -> None:
    """U.1 and U.2 make a universal joint, unless the body between them has a mass."""
    text = """<mujoco><worldbody><body name="a"><joint name="U.1" axis="0 0 1"/>{}
        <body name="b"><joint name="U.2" axis="1 0 0"/>{}</body></body></worldbody></mujoco>"""
    kinds = []
    for own in ("", BALL):
        (tmp_path / "m.xml").write_text(text.format(own, BALL))
        mechanism = parakin.load(tmp_path / "m.xml")
        kinds.append([joint.kind for joint in mechanism.joints])
        assert len(masses(graph_of(mechanism))) == 1 + bool(own)
    assert kinds == [["universal"], ["revolute", "revolute"]]


def test_earlier_exports_have_bodies_within_joints_that_weigh_nothing(tmp_path: Path) -> None:
    """They are called after the joint, and their shapes weighed something in MuJoCo alone."""
    (tmp_path / "m.xml").write_text(
        """<mujoco><worldbody><body name="U link"><joint name="U.1" axis="0 0 1"/>
        <geom size="1"/><body name="b"><joint name="U.2" axis="1 0 0"/><geom size="1"/></body>
        </body></worldbody></mujoco>"""
    )
    mechanism = parakin.load(tmp_path / "m.xml")
    assert [joint.kind for joint in mechanism.joints] == ["universal"]
    assert list(masses(graph_of(mechanism))) == ["b"]


def test_shapes_that_classes_tell_may_be_meshes(tmp_path: Path) -> None:
    classes = '<default><geom type="mesh" mesh="none"/></default>'
    mechanism = loaded(tmp_path, inside='<geom size="1"/>', before=classes)
    assert "bodies shaped by meshes, which are not read: a." in mechanism.notes
    (tmp_path / "n").mkdir()
    mechanism = loaded(tmp_path / "n", inside='<geom type="sphere" size="1"/>', before=classes)
    assert "shaped by meshes" not in mechanism.notes


TENDON = """<tendon><spatial {}><site site="s"/><site site="{}"/></spatial></tendon>"""


def spring_model(said: str, end: str = "t") -> dict[str, str]:
    ground = '</body><body name="g" pos="0 0 3"><site name="s"/>'
    site = '<site name="t" pos="0 4 0"/>'
    return {"inside": BALL + site + ground, "after": TENDON.format(said, end)}


def test_tendons_of_two_sites_are_springs_between_points(tmp_path: Path) -> None:
    """From (0, 0, 3) to (0, 4, 0) it is 5 m long at first."""
    mechanism = loaded(tmp_path, **spring_model('name="k" stiffness="2" damping="3"'))
    (spring,) = graph_of(mechanism).dynamics.springs
    assert (spring.name, spring.stiffness, spring.damping) == ("k", 2, 3)
    assert spring.length == pytest.approx(5)
    assert "<tendon>" not in mechanism.notes
    mechanism = loaded(tmp_path, **spring_model('stiffness="2" springlength="0.5"'))
    assert graph_of(mechanism).dynamics.springs[0].length == 0.5
    for other in ('stiffness="2" range="0 1"', 'stiffness="2" springlength="0 1"', ""):
        mechanism = loaded(tmp_path, **spring_model(other))
        assert not mechanism.forces
        assert "Not used: <tendon>." in mechanism.notes
    with pytest.raises(InputError) as refusal:
        loaded(tmp_path, **spring_model('stiffness="-2"'))
    assert "line 2: stiffness: found -2; expected zero or more" in str(refusal.value)
    with pytest.raises(InputError) as refusal:
        loaded(tmp_path, **spring_model('stiffness="2"', "u"))
    assert "line 2: found unknown site 'u'; expected one of: s, t" in str(refusal.value)


def test_less_than_nothing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError) as refusal:
        loaded(tmp_path, 'damping="-1"')
    assert "line 1: joint 'j': damping: found -1; expected zero or more" in str(refusal.value)
    with pytest.raises(InputError) as refusal:
        loaded(tmp_path, inside='<inertial pos="0 0 0" mass="1" diaginertia="1 1 3"/>')
    assert "a model that MuJoCo refuses" in str(refusal.value)
