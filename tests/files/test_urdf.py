"""URDF as a mechanism: loops in every convention, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import parakin
from parakin.cli.main import main
from parakin.errors import InputError
from parakin.kinematics.configuration import configure
from parakin.model.evaluation import graph_of

pytest.importorskip("lxml")

pytest.importorskip("yaml")

LINKS = """<robot name="bars">
  <link name="base"/> <link name="crank"/> <link name="coupler"/> <link name="rocker"/>
  <link name="tip"/> <link name="end"/>
  <joint name="A" type="revolute"><parent link="base"/><child link="crank"/>
    <axis xyz="0 0 1"/><limit lower="-7" upper="7" effort="1" velocity="1"/></joint>
  <joint name="B" type="continuous"><parent link="crank"/><child link="coupler"/>
    <origin xyz="0.04 0 0"/><axis xyz="0 0 1"/></joint>
  <joint name="D" type="continuous"><parent link="base"/><child link="rocker"/>
    <origin xyz="0.1 0 0" rpy="0 0 0"/><axis xyz="0 0 1"/></joint>
  <joint name="t" type="fixed"><parent link="coupler"/><child link="tip"/>
    <origin xyz="0.12 0 0"/></joint>
  <joint name="e" type="fixed"><parent link="rocker"/><child link="end"/>
    <origin xyz="0.08 0 0"/></joint>
  %s
</robot>"""

GUESS = "home: {A: 0.698, B: -0.344, D: 1.0}\n"

CONVENTIONS: dict[str, tuple[str, str]] = {
    "gepetto": ("", f"closed_loop: [[tip, end]]\ntype: [3d]\nname_mot: [A]\n{GUESS}"),
    # With all joints at zero the coupler's end is at x = 0.16, the rocker's at 0.18: told for a
    # pose in which they meet, the file shifts the rocker.
    "urdf+": (
        """<loop name="C" type="revolute"><predecessor link="coupler"><origin xyz="0.12 0 0"/>
        </predecessor><successor link="rocker"><origin xyz="0.08 0 0"/></successor>
        <axis xyz="0 0 1"/></loop>""",
        "",
    ),
    "isaac": (
        """<loop_joint name="C" type="spherical"><link1 link="coupler" xyz="0.12 0 0" rpy="0 0 0"/>
        <link2 link="rocker" xyz="0.08 0 0" rpy="0 0 0"/></loop_joint>""",
        "",
    ),
    "isaac as documented": (
        """<loop_joint name="C" type="spherical"><link1 link="coupler" xyz="0.12 0 0" rpy="0 0 0"/>
        <link1 link="rocker" xyz="0.08 0 0" rpy="0 0 0"/></loop_joint>""",
        "",
    ),
}


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_a_four_bar_in_every_convention_of_urdf(convention: str, tmp_path: Path) -> None:
    inside, beside = CONVENTIONS[convention]
    (tmp_path / "bars.urdf").write_text(LINKS % inside)
    (tmp_path / "loops.yaml").write_text(beside)
    loops = tmp_path / "loops.yaml" if beside else None
    mechanism = parakin.load(tmp_path / "bars.urdf", loops=loops)
    assert ("open tree" in mechanism.notes) is False
    near = {"A": math.radians(40), "B": math.radians(-20), "D": math.radians(57)}
    solver = parakin.compile(mechanism, "A", near=near, machine_code=False)
    known = parakin.compile("four-bar", machine_code=False)
    angles = np.radians(np.linspace(40, 400, 50))[None]
    found, expected = solver.at(angles), known.at(angles)
    assert not np.any(found.status)
    for name in ("B", "D"):
        a = found.position[solver.coordinates.index(name)]
        b = expected.position[known.coordinates.index(name)]
        assert np.abs(np.exp(1j * a) - np.exp(1j * b)).max() < 1e-12


def test_a_hinge_told_in_the_frame_of_the_root(tmp_path: Path) -> None:
    """loop_closures.yaml: a parallelogram folded flat at zero, its last hinge at x = 0.16."""
    text = (LINKS % "").replace('xyz="0.1 0 0"', 'xyz="0.12 0 0"').replace('"0.08', '"0.04')
    (tmp_path / "bars.urdf").write_text(text)
    told = """closures:
- {link_a: coupler, link_b: rocker, point: [0.16, 0.0, 0.0], axis: [0.0, 0.0, 1.0]}
dependent: [B, D]
independent: [A]
"""
    (tmp_path / "loops.yaml").write_text(told)
    mechanism = parakin.load(tmp_path / "bars.urdf", loops=tmp_path / "loops.yaml")
    assert mechanism.driven == ("A",)
    solver = parakin.compile(mechanism, near={"A": 1.0, "B": -1.0, "D": 1.0}, machine_code=False)
    tick = solver.at(np.linspace(0.5, 2.0, 20)[None])
    rows = [solver.coordinates.index(n) for n in ("A", "B", "D")]
    a, b, d = tick.position[rows]
    np.testing.assert_allclose(d, a, atol=1e-12)
    np.testing.assert_allclose(b, -a, atol=1e-12)


def test_joints_that_the_file_of_loops_makes_into_others(tmp_path: Path) -> None:
    (tmp_path / "bars.urdf").write_text(LINKS % "")
    told = "closed_loop: [[tip, end]]\ntype: [3d]\njoint_name: [B, D]\n"
    (tmp_path / "loops.yaml").write_text(told + "joint_type: [SPHERICAL, UJOINT_ZX]\n")
    kinds = {
        joint.name: joint.kind
        for joint in parakin.load(tmp_path / "bars.urdf", loops=tmp_path / "loops.yaml").joints
    }
    assert kinds == {"A": "revolute", "B": "spherical", "D": "universal", "loop1": "spherical"}


def test_a_urdf_without_loops_says_that_it_is_a_tree(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "bars.urdf").write_text(LINKS % "")
    assert main(["check", str(tmp_path / "bars.urdf")]) == 2  # as when it is solved
    said, refused = capsys.readouterr()
    assert "no driven coordinates are given" in refused
    assert "Read from a URDF without loops: an open tree" in said
    assert "--loops FILE" in said
    assert "by rank: 3 at home" in said


URDF_REFUSED: dict[str, tuple[str, str, str]] = {
    "type": ("a.urdf", (LINKS % "").replace('"continuous"', '"contious"', 1), "did you mean"),
    "mimic": (
        "a.urdf",
        (LINKS % "")
        .replace('<joint name="D"', '<joint name="D" ')
        .replace('<origin xyz="0.1 0 0" rpy="0 0 0"/>', '<mimic joint="A"/>'),
        "gears are not supported",
    ),
    "unknown link": (
        "a.urdf",
        (LINKS % "").replace('<child link="tip"', '<child link="top"'),
        "'tip'",
    ),
    "two parents": (
        "a.urdf",
        (LINKS % "").replace('<child link="end"', '<child link="tip"'),
        "two parents; expected one; loops are specified by",
    ),
    "coupling": ("a.urdf", LINKS % '<coupling name="c"/>', "line 14: loop 'c'"),
}


@pytest.mark.parametrize("case", URDF_REFUSED)
def test_urdf_files_that_mean_nothing_are_refused(case: str, tmp_path: Path) -> None:
    name, text, said = URDF_REFUSED[case]
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError) as refusal:
        parakin.load(tmp_path / name)
    assert said in str(refusal.value)
    assert str(tmp_path / name) in str(refusal.value)


def urdf(*elements: str) -> str:
    """Links a, b, c with a hinge `h` from a to b, and more elements, each on its own line."""
    links = "".join(f'<link name="{name}"/>' for name in "abc")
    hinge = '<joint name="h" type="revolute"><parent link="a"/><child link="b"/></joint>'
    return "\n".join([f"<robot>{links}{hinge}", *elements, "</robot>"])


def slide(inside: str, kind: str = "prismatic") -> str:
    """A joint `s` from b to c."""
    ends = '<parent link="b"/><child link="c"/>'
    return f'<joint name="s" type="{kind}">{ends}{inside}</joint>'


def loaded(tmp_path: Path, text: str) -> parakin.Mechanism:
    (tmp_path / "a.urdf").write_text(text)
    return parakin.load(tmp_path / "a.urdf")


def where(mechanism: parakin.Mechanism, *q: float) -> tuple[np.ndarray, np.ndarray]:
    """Place and orientation of the last body at these coordinates."""
    graph = graph_of(mechanism)
    pose = configure(graph, graph.tree(), np.array(q)).pose(len(graph.bodies) - 1)
    return np.array(pose.p), np.array(pose.R)


def test_a_joint_that_mimics_another_keeps_its_offset_and_limits(tmp_path: Path) -> None:
    mimic = '<mimic joint="h" multiplier="0.5" offset="0.1"/><limit lower="-0.1" upper="0.3"/>'
    mechanism = loaded(tmp_path, urdf(slide(mimic)))
    (screw,) = mechanism.joints
    assert screw.kind == "helical"
    assert mechanism.limits["h"] == pytest.approx((-0.4, 0.4))
    p, _ = where(mechanism, 0.6)
    np.testing.assert_allclose(p, [0.1 + 0.5 * 0.6, 0.0, 0.0], atol=1e-15)
    down = urdf(slide(f'<axis xyz="-1 0 0"/>{mimic}'))
    p, _ = where(loaded(tmp_path, down), 0.6)
    np.testing.assert_allclose(p, [-0.4, 0.0, 0.0], atol=1e-15)


def test_a_hinge_that_mimics_a_slide_and_one_that_stands_still(tmp_path: Path) -> None:
    leads = urdf(slide("")).replace(
        "</joint>", '<mimic joint="s" multiplier="2" offset="1"/></joint>', 1
    )
    mechanism = loaded(tmp_path, leads)
    assert mechanism.guess == {"h": 1.0}  # the slide at zero
    p, R = where(mechanism, 1.5)
    np.testing.assert_allclose(p, [0.25, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(R, Rotation.from_euler("x", 1.5).as_matrix(), atol=1e-15)
    still = loaded(tmp_path, urdf(slide('<mimic joint="h" multiplier="0" offset="0.3"/>')))
    assert [joint.kind for joint in still.joints] == ["revolute"]
    (body,) = (body for body in still.bodies if body.name == "b")
    assert body.points["c"] == pytest.approx((0.3, 0.0, 0.0))


def test_an_origin_by_a_quaternion(tmp_path: Path) -> None:
    turn = Rotation.from_rotvec([0.1, -0.4, 0.7])
    text = " ".join(map(str, turn.as_quat()))
    fixed = urdf(slide(f'<origin xyz="1 2 3" quat_xyzw="{text}"/>', "revolute"))
    p, R = where(loaded(tmp_path, fixed), 0.0, 0.0)
    np.testing.assert_allclose(p, [1.0, 2.0, 3.0], atol=1e-15)
    np.testing.assert_allclose(R, turn.as_matrix(), atol=1e-15)


def test_what_is_not_used_is_told_once(tmp_path: Path) -> None:
    unused = "<gazebo><any/></gazebo><gazebo/><transmission/><material/>"
    assert loaded(tmp_path, urdf(slide("<dynamics/>"), unused)).notes.endswith(
        "Not used: <gazebo>, <material>, <transmission>."
    )


PLACES = {
    '<mimic joint="h" multipler="2"/>': "line 2: found an attribute 'multipler' of <mimic>",
    '<mimic joint="hh"/>': "joint 's': mimic: found unknown joint 'hh'; expected one of: h, s",
    '<limit lower="1" upper="-1"/>': "joint 's': limit: found 1 to -1; expected lower below upper",
    '<limit lower="1_0" upper="20"/>': "joint 's': lower: found '1_0'; expected 1 finite number",
    '<origin xyz="١ 0 0"/>': "joint 's': xyz: found '١ 0 0'; expected 3 finite numbers",
    '<origin xyz="1\u00a00 0"/>': "joint 's': xyz: found '1\\xa00 0'; expected 3 finite numbers",
    "<origin/><origin/>": "line 2: found a second <origin>; expected one",
    '<origin rpy="0 0 0" quat_xyzw="0 0 0 1"/>': "found quat_xyzw beside rpy; expected one of them",
    '<origin quat_xyzw="0 0 0 2"/>': "found a quaternion of length 2; expected one of length 1",
    '<axs xyz="1 0 0"/>': "line 2: found <axs> in <joint>; expected one of: axis,",
}


@pytest.mark.parametrize("inside", PLACES)
def test_a_joint_that_is_told_wrongly_is_refused_with_its_place(
    inside: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError) as refusal:
        loaded(tmp_path, urdf(slide(inside)))
    assert str(refusal.value).startswith(f"{tmp_path / 'a.urdf'}, line 2: ")
    assert PLACES[inside] in str(refusal.value)


ELEMENTS = {
    "<lop/>": "line 3: found <lop> in <robot>",
    '<loop name="l" type="floating"/>': "'floating'; expected a joint that holds something",
    '<xacro:if xmlns:xacro="x"/>': "found <xacro:if> in <robot>; expected URDF, as written by",
    "<gazebo><joint/></gazebo>": "found a joint in <gazebo>; expected <loop> or <loop_joint>",
}


@pytest.mark.parametrize("element", ELEMENTS)
def test_elements_that_are_not_read_are_refused(element: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as refusal:
        loaded(tmp_path, urdf(slide(""), element))
    assert ELEMENTS[element] in str(refusal.value)


@pytest.mark.parametrize(
    ("limit", "position", "velocity"),
    [
        ('lower="-1" upper="2" velocity="3"', (-1.0, 2.0), (-3.0, 3.0)),
        ('lower="-1" upper="2" velocity="0"', (-1.0, 2.0), None),  # as where none is told
        ('lower="-1000" upper="2"', (-math.inf, 2.0), None),
        ('lower="-1000" upper="1000" velocity="1000"', None, None),
        ('velocity="0.5"', None, (-0.5, 0.5)),
    ],
)
def test_limits_of_positions_and_speeds(
    tmp_path: Path, limit: str, position: tuple[float, float], velocity: tuple[float, float]
) -> None:
    path = tmp_path / "slide.urdf"
    path.write_text(
        f'<robot name="r"><link name="a"/><link name="b"/><joint name="J" type="prismatic">'
        f'<parent link="a"/><child link="b"/><limit effort="1" {limit}/></joint></robot>'
    )
    graph = graph_of(parakin.load(path))
    unlimited = (-math.inf, math.inf)
    assert graph.limits("J") == (position or unlimited)
    assert graph.limits("J", 1) == (velocity or unlimited)


def test_a_limit_open_at_one_end_comes_back_from_a_urdf(tmp_path: Path) -> None:
    legs = parakin.load("gough-stewart").model_copy(
        update={"limits": {"P1": (-math.inf, 0.5), "P2": (0.1, 0.6), "P2.velocity": (-0.4, 0.4)}}
    )
    parakin.export(legs, tmp_path / "legs.urdf")
    graph = graph_of(parakin.load(tmp_path / "legs.urdf", loops=tmp_path / "legs.loops.yaml"))
    assert graph.limits("P1") == (-math.inf, 0.5)
    assert graph.limits("P2") == (0.1, 0.6)
    assert graph.limits("P2", 1) == (-0.4, 0.4)


def test_a_ratio_whose_inverse_is_no_number_is_refused_with_its_place(tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(
        """<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
        <joint name="s" type="prismatic"><parent link="a"/><child link="b"/></joint>
        <joint name="h" type="revolute"><parent link="b"/><child link="c"/>
        <mimic joint="s" multiplier="1e-320"/></joint></robot>"""
    )
    with pytest.raises(InputError, match="line 3: joint 'h': multiplier"):
        parakin.load(path)
