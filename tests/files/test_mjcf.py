"""MuJoCo models as mechanisms: frames, loops, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import parakin
from parakin.errors import InputError
from parakin.model.evaluation import graph_of

mujoco = pytest.importorskip("mujoco")

pytest.importorskip("lxml")

pytest.importorskip("yaml")

# A tree with all that MJCF can say of a frame, and its loops.
LIMB = """<mujoco model="limb">
<compiler angle="degree" eulerseq="zyx"/>
<default><joint axis="0 1 0" range="-90 90" limited="true"/>
  <default class="slide"><joint type="slide" limited="false"/></default></default>
<asset><mesh name="m" file="no such file.stl"/></asset>
<worldbody>
  <geom type="plane" size="1 1 1"/>
  <body name="a" pos="0.1 0.2 0.3" euler="10 20 30">
    <joint name="a" pos="0 0.1 0" ref="15"/>
    <geom type="mesh" mesh="m"/>
    <frame pos="0 0 0.4" axisangle="1 0 0 25">
      <body name="b" quat="0.8 0 0.6 0">
        <joint name="b1" axis="1 1 0"/> <joint name="b2" class="slide" ref="0.05"/>
        <site name="tip" pos="0.2 0 0" zaxis="1 2 3"/>
        <body name="ball" pos="0 0.3 0"><joint name="c" type="ball" limited="false"/>
          <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>
      </body>
    </frame>
  </body>
  <body name="fixed" pos="1 0 0" xyaxes="0 1 0 -1 0 0"><body name="d" childclass="slide">
    <joint name="d"/></body></body>
  <body name="free" pos="1 1 1"><freejoint name="f"/></body>
</worldbody></mujoco>"""


def test_frames_are_where_mujoco_has_them(tmp_path: Path) -> None:
    (tmp_path / "limb.xml").write_text(LIMB)
    graph = graph_of(parakin.load(tmp_path / "limb.xml"))
    bare = LIMB.replace('<mesh name="m" file="no such file.stl"/>', "")
    bare = bare.replace('<geom type="mesh" mesh="m"/>', '<geom size="0.1"/>')
    bare = bare.replace("<compiler ", '<compiler boundmass="1" boundinertia="1" ')
    model = mujoco.MjModel.from_xml_string(bare)
    data = mujoco.MjData(model)
    rng = np.random.default_rng(3)
    from parakin.kinematics.configuration import configure

    for _ in range(5):
        q = rng.uniform(-1, 1, len(graph.coordinates))
        at = configure(graph, graph.tree(), q)
        for k, c in enumerate(graph.coordinates):
            joint = graph.joints[c.joint]
            address = model.jnt_qposadr[model.joint(joint.name).id]
            if joint.kind in ("revolute", "prismatic"):
                data.qpos[address] = q[k]
            elif joint.kind == "spherical" and k == joint.first:
                data.qpos[address : address + 4] = quaternion(*q[k : k + 3])
            elif joint.kind == "free" and k == joint.first:
                data.qpos[address : address + 3] = q[k : k + 3]
                data.qpos[address + 3 : address + 7] = quaternion(*q[k + 3 : k + 6])
        mujoco.mj_kinematics(model, data)
        for name in ("a", "b", "ball", "d", "free"):
            pose = at.pose(graph.bodies.index(name))
            body = model.body(name).id
            np.testing.assert_allclose(pose.p, data.xpos[body], atol=1e-12)
            np.testing.assert_allclose(pose.R, data.xmat[body].reshape(3, 3), atol=1e-12)
    assert graph.limits("a") == pytest.approx((-math.pi / 2, math.pi / 2))
    assert graph.limits("b2") == (-math.inf, math.inf)


def quaternion(x: float, y: float, z: float) -> np.ndarray:
    """Turns about moving x, then y, then z."""
    q = np.array([1.0, 0.0, 0.0, 0.0])
    for axis, angle in enumerate((x, y, z)):
        turn = np.zeros(4)
        turn[0], turn[1 + axis] = math.cos(angle / 2), math.sin(angle / 2)
        mujoco.mju_mulQuat(q, q.copy(), turn)
    return q


BARS = """<worldbody>
  <body name="crank"><joint name="A" axis="0 0 1" ref="40"/><geom size="0.01"/>
    <body name="coupler" pos="0.04 0 0"><joint name="B" axis="0 0 1" ref="-19.7"/>
      <geom size="0.01"/><site name="C" pos="0.12 0 0"/></body></body>
  <body name="rocker" pos="0.1 0 0"><joint name="D" axis="0 0 1" ref="57.3"/>
    <geom size="0.01"/><site name="E" pos="0.08 0 0"/></body>
</worldbody>"""

CLOSURES = {
    "sites": '<connect site1="C" site2="E"/>',
    "hinge of two": """<connect body1="coupler" body2="rocker" anchor="0.12 0 0"/>
        <connect body1="coupler" body2="rocker" anchor="0.12 0 0.03"/>""",
    "weak weld": '<weld site1="C" site2="E" torquescale="0"/>',
}


def laid_out(angles: bool) -> str:
    """The bars with the bodies turned as the joints' `ref` says."""
    text = BARS
    if angles:
        for name, ref in (("crank", "40"), ("coupler", "-19.7"), ("rocker", "57.3")):
            text = text.replace(f'name="{name}"', f'name="{name}" euler="0 0 {ref}"', 1)
    return text


@pytest.mark.parametrize("closure", CLOSURES)
def test_a_four_bar_closed_in_every_way_of_mjcf(closure: str, tmp_path: Path) -> None:
    """Sites do not know how far the loop is open at first; anchors take the first pose as closed,
    so they stand 0.3 mm off.
    """
    text = f"<mujoco>{laid_out(True)}<equality>{CLOSURES[closure]}</equality>"
    text += '<actuator><motor joint="A"/></actuator></mujoco>'
    (tmp_path / "bars.xml").write_text(text)
    mechanism = parakin.load(tmp_path / "bars.xml")
    assert mechanism.driven == ("A",)
    kinds = [joint.kind for joint in mechanism.joints]
    assert kinds.count("revolute") == (4 if closure == "hinge of two" else 3)
    known = parakin.compile("four-bar", machine_code=False)
    solver = parakin.compile(mechanism, machine_code=False)
    angles = np.radians(np.linspace(40, 400, 50))[None]
    found, expected = solver.at(angles), known.at(angles)
    assert not np.any(found.status)
    off = (
        found.position[solver.coordinates.index("D")]
        - expected.position[known.coordinates.index("D")]
    )
    off -= 2 * np.pi * np.round(off / (2 * np.pi))
    assert np.abs(off).max() < (2e-2 if closure == "hinge of two" else 1e-12)


MJCF_REFUSED: dict[str, tuple[str, str, str]] = {
    "entities": ("a.xml", '<!DOCTYPE x [<!ENTITY a "b">]><mujoco>&a;</mujoco>', "or entities"),
    "no xml": ("a.xml", "<mujoco", "a syntax error"),
    "another": ("a.xml", "<svg/>", "expected <mujoco> (MJCF) or <robot> (URDF)"),
    "include": ("a.xml", '<mujoco><include file="b.xml"/></mujoco>', "line 1: found <include>"),
    "gear": (
        "a.xml",
        f'<mujoco>{BARS}<equality><joint joint1="A" joint2="B"/></equality></mujoco>',
        "gears are not supported",
    ),
    "senseless": (
        "a.xml",
        "<mujoco>\n<worldbody><body quat='0 0 0 0'/></worldbody></mujoco>",
        "line 2: found a model that MuJoCo refuses: ",
    ),
    "no number": (
        "a.xml",
        "<mujoco><worldbody><body pos='a'/></worldbody></mujoco>",
        "line 1: pos: found 'a'",
    ),
    "still": ("a.xml", "<mujoco><worldbody/></mujoco>", "no joints that move"),
}


@pytest.mark.parametrize("case", MJCF_REFUSED)
def test_mjcf_files_that_mean_nothing_are_refused(case: str, tmp_path: Path) -> None:
    name, text, said = MJCF_REFUSED[case]
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError) as refusal:
        parakin.load(tmp_path / name)
    assert said in str(refusal.value)
    assert str(tmp_path / name) in str(refusal.value)


HINGE = '<body name="a"><joint name="h" axis="0 0 1" {}/>'


def loaded(tmp_path: Path, text: str) -> parakin.Mechanism:
    (tmp_path / "m.xml").write_text(text)
    return parakin.load(tmp_path / "m.xml")


def refused(tmp_path: Path, text: str) -> str:
    with pytest.raises(InputError) as refusal:
        loaded(tmp_path, text)
    assert refusal.value.place.startswith(str(tmp_path / "m.xml"))
    return str(refusal.value).removeprefix(str(tmp_path / "m.xml"))


def test_a_screw_keeps_its_offsets_and_the_limits_of_its_slide(tmp_path: Path) -> None:
    """q1 - ref1 = c0 + c1 (q2 - ref2): the body stands 0.3 + 0.1 + 0.05 (h - 0.2) up, less 0.3 in
    the pose in which the model is written.
    """
    text = f"""<mujoco><compiler angle="radian"/><worldbody>{HINGE.format('ref="0.2"')}
        <joint name="s" type="slide" axis="0 0 -1" ref="0.3" range="0.35 0.45"/></body></worldbody>
        <equality><joint joint1="s" joint2="h" polycoef="0.1 0.05"/></equality></mujoco>"""
    mechanism = loaded(tmp_path, text)
    (screw,) = mechanism.joints
    assert (screw.name, screw.kind) == ("h", "helical")
    assert screw.pitch == pytest.approx(-0.05 * 2 * math.pi)  # the slide points down
    assert mechanism.limits["h"] == pytest.approx((0.2 - 0.05 / 0.05, 0.2 + 0.05 / 0.05))
    graph = graph_of(mechanism)
    from parakin.kinematics.configuration import configure

    at = configure(graph, graph.tree(), np.array([0.7]))
    assert at.pose(1).p[2] == pytest.approx(-(0.1 + 0.05 * (0.7 - 0.2)))


def test_a_joint_that_an_equality_holds_is_fixed_where_it_is_held(tmp_path: Path) -> None:
    text = f"""<mujoco><compiler angle="radian"/><worldbody>{HINGE.format('ref="0.2"')}
        <body name="b" pos="1 0 0"><joint name="k"/></body></body></worldbody>
        <equality><joint joint1="h" polycoef="0.5"/></equality></mujoco>"""
    mechanism = loaded(tmp_path, text)
    (joint,) = mechanism.joints
    assert joint.name == "k"
    assert joint.on_parent.at == pytest.approx((math.cos(0.5), math.sin(0.5), 0.0))
    twice = text.replace("</equality>", '<joint joint1="h"/></equality>')
    assert "line 3: equality 'loop1': found a joint held twice" in refused(tmp_path, twice)


def test_defaults_say_where_sites_are_and_which_loops_are_closed(tmp_path: Path) -> None:
    text = """<mujoco><default><site pos="0.1 0 0"/>
        <default class="off"><equality active="false"/></default></default><worldbody>
        <body name="a"><joint name="j"/><site name="s"/></body>
        <body name="b"><joint name="k"/><site name="t" pos="0.1 0 0"/></body></worldbody>
        <equality><connect site1="s" site2="t"/>
        <connect class="off" site1="s" site2="t"/></equality>
        </mujoco>"""
    (loop,) = (joint for joint in loaded(tmp_path, text).joints if joint.kind == "spherical")
    assert loop.on_parent.at == (0.1, 0.0, 0.0)
    disabled = text.replace("</mujoco>", '<option><flag equality="disable"/></option></mujoco>')
    mechanism = loaded(tmp_path, disabled)
    assert [joint.name for joint in mechanism.joints] == ["j", "k"]
    assert "equalities are disabled" in mechanism.notes


def test_bodies_without_a_name_do_not_become_others(tmp_path: Path) -> None:
    """The second body has no name; another is called what it would be."""
    text = f"""<mujoco><worldbody>{HINGE.format("")}</body><body><joint/></body>
        <body name="body2"><joint name="joint1"/></body></worldbody></mujoco>"""
    mechanism = loaded(tmp_path, text)
    assert len({joint.child for joint in mechanism.joints}) == 3
    assert len({joint.name for joint in mechanism.joints}) == 3


def test_chains_keep_limits_and_motors_of_each_coordinate(tmp_path: Path) -> None:
    text = """<mujoco><compiler angle="radian"/><worldbody><body name="a">
        <joint name="U.1" axis="0 0 1" range="-1 2"/><joint name="U.2" axis="1 0 0"/></body>
        </worldbody>
        <actuator><motor joint="U.2"/><motor jointinparent="U.1"/></actuator></mujoco>"""
    mechanism = loaded(tmp_path, text)
    assert [joint.kind for joint in mechanism.joints] == ["universal"]
    assert mechanism.limits == {"U.1": (-1.0, 2.0)}
    assert mechanism.driven == ("U.1", "U.2")
    one = loaded(tmp_path, text.replace('<motor joint="U.2"/>', ""))
    assert one.driven == ("U.1",)


def test_what_is_not_used_is_told_once(tmp_path: Path) -> None:
    text = f"""<mujoco><asset><material name="m"/></asset><worldbody><light/>{HINGE.format("")}
        <geom size="1"/><geom size="2"/><site name="s"/></body></worldbody>
        <actuator><motor site="s"/></actuator></mujoco>"""
    said = loaded(tmp_path, text).notes
    assert "Not used: <asset>, <light>." in said
    assert "Actuators that drive no hinge or slide: on line 3." in said


@pytest.mark.parametrize(
    ("after", "said"),
    [
        (
            '<keyframe><key name="home" qpos="1 2"/></keyframe>',
            ", line 1: qpos: found '1 2'; expected 1",
        ),
        ('<keyframe><key name="home"/><key name="home"/></keyframe>', "found a second key 'home'"),
        (
            '<actuator><motor joint="hh"/></actuator>',
            "joint: found unknown joint 'hh'; expected one of",
        ),
        ('<equality><joint joint1="h" polycoef="0 0 1"/></equality>', ""),
    ],
)
def test_the_place_is_told(after: str, said: str, tmp_path: Path) -> None:
    text = f"<mujoco><worldbody>{HINGE.format('')}</body></worldbody>{after}</mujoco>"
    if said:
        assert said in refused(tmp_path, text)
    else:  # without a second joint, powers of it mean nothing
        assert "no joints that move" in refused(tmp_path, text)


def test_a_range_of_a_ball_is_refused(tmp_path: Path) -> None:
    ball = '<body><joint name="b" type="ball" range="0 1"/></body>'
    said = refused(tmp_path, f"<mujoco><worldbody>\n{ball}</worldbody></mujoco>")
    assert said.startswith(", line 2: joint 'b': range: found a range of a ball joint")


def test_lines_are_those_of_the_joints_where_a_body_comes_before_its_parents_own(
    tmp_path: Path,
) -> None:
    """MuJoCo counts the outer body's joint first, though it stands below the inner one's."""
    inner = '<frame><body name="b">\n<joint name="j"/></body></frame>'
    outer = '<joint name="k" type="ball" range="0 1"/>'
    text = f'<mujoco><worldbody><body name="a">{inner}\n{outer}</body></worldbody></mujoco>'
    assert refused(tmp_path, text).startswith(", line 3: joint 'k': range: found")


def test_a_ratio_whose_inverse_is_no_number_is_refused_with_its_place(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(
        """<mujoco><worldbody><body><joint name="x"/><joint name="y" type="slide"/></body>
        </worldbody><equality><joint joint1="x" joint2="y" polycoef="0 1e-320"/></equality>
        </mujoco>"""
    )
    with pytest.raises(InputError, match="line 2: equality 'loop0': found a ratio"):
        parakin.load(path)
