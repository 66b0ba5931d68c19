"""Models of other programs: out, back in, and those that others have written."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from engines import MujocoTwin
from hypothesis import HealthCheck, Phase, given, settings
from literature import JACK
from random_mechanisms import Example, examples

import parakin
from parakin.analysis.mobility import mobility
from parakin.cli.main import main
from parakin.errors import AssemblyError, InputError
from parakin.exports import export as exports
from parakin.files import reading as files
from parakin.kinematics.assembly import assembled
from parakin.model.evaluation import graph_of
from parakin.model.mechanism import Mechanism

mujoco = pytest.importorskip("mujoco")
pytest.importorskip("lxml")
pytest.importorskip("yaml")

NAMES = parakin.catalogue()
SHAPES = ("model.xml", "model.urdf")


def back(mechanism: Mechanism, folder: Path, shape: str) -> Mechanism:
    """The mechanism, written and read again."""
    path, *loops = exports.export(mechanism, folder / shape)
    return parakin.load(path, loops=loops[0] if loops else None)


def home(mechanism: Mechanism) -> tuple[dict[str, float], int]:
    """Coordinates at home as their joints count, and the mobility."""
    graph = graph_of(mechanism)
    at = assembled(graph)
    values = dict(zip([c.name for c in graph.coordinates], at.q.tolist(), strict=True))
    return values, mobility(graph, at).home


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("name", NAMES)
def test_the_catalogue_comes_back(name: str, shape: str, tmp_path: Path) -> None:
    """With the same joints (but for rods, which come back as bodies), home and mobility."""
    mechanism = parakin.load(name)
    again = back(mechanism, tmp_path, shape)
    ours, theirs = home(mechanism), home(again)
    assert ours[1] == theirs[1]
    assert max(abs(value - theirs[0][n]) for n, value in ours[0].items()) < 1e-12
    kinds = {j.name: j.kind for j in mechanism.joints if j.kind != "rod"}
    assert kinds.items() <= {j.name: j.kind for j in again.joints}.items()
    actuated = {j.name for j in mechanism.joints if j.actuated}
    assert actuated == {j.name for j in again.joints if j.actuated}
    assert again.driven == tuple(n for n in again.driven if n.split(".")[0] in actuated)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("name", ["flight-simulator", "delta", "six-bar-watt", "tricept"])
def test_what_comes_back_moves_alike(name: str, shape: str, tmp_path: Path) -> None:
    mechanism = parakin.load(name)
    driven = [j.name for j in mechanism.joints if j.actuated]
    solvers = [
        parakin.compile(m, driven, machine_code=False)
        for m in (mechanism, back(mechanism, tmp_path, shape))
    ]
    rng = np.random.default_rng(0)
    move = 0.02 * solvers[0].graph.length * rng.uniform(-1, 1, (len(driven), 50))
    answers = []
    for solver in solvers:
        start = np.array([[solver.home[n]] for n in driven])
        tick = solver.at(start + move)
        assert not np.any(tick.status)
        names = [n for n in solvers[0].coordinates if n in solver.coordinates]
        rows = [solver.coordinates.index(n) for n in names]
        offsets = np.array([[solver.home[n]] for n in names])
        answers.append(tick.position[rows] - offsets)
    assert len(answers[0]) >= len(driven)
    # (Two plans, each closed to 1e-12 of a length, at moves of up to 60 mm and 0.06 rad.)
    np.testing.assert_allclose(answers[0][: len(answers[1])], answers[1], rtol=0, atol=1e-10)


def test_screws_go_out_and_come_back(tmp_path: Path) -> None:
    """A jack: its screw is a hinge and a slide that are coupled. One turn in MuJoCo is one here."""
    mechanism = files.mechanism_from_table(tomllib.loads(JACK), "jack")
    solver = parakin.compile(mechanism, machine_code=False)
    twin = MujocoTwin(
        mujoco.MjModel.from_xml_path(str(exports.export(mechanism, tmp_path / "jack.xml")[0]))
    )
    guess = np.array([solver.home[n] for n in solver.coordinates])
    for turn in np.linspace(0.0, 2 * math.pi, 9):
        tick = solver.at([solver.home["H"] + turn], guess=guess)
        guess = tick.position
        twin.solve({"H": solver.home["H"] + turn}, {"H": 0.0}, {"H": 0.0})
        for name, value in zip(solver.coordinates, tick.position, strict=True):
            assert abs(twin.data.qpos[twin.place(name)] - value) < 1e-10, name
    for shape in SHAPES:
        again = back(mechanism, tmp_path, shape)
        ours, theirs = home(mechanism)[0], home(again)[0]
        assert {j.name: j.kind for j in again.joints}["H"] == "helical"
        assert max(abs(value - theirs[n]) for n, value in ours.items()) < 1e-9


@given(examples())
@settings(
    max_examples=25,
    deadline=None,
    derandomize=True,
    database=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=list(HealthCheck),
)
def test_random_mechanisms_come_back(
    tmp_path_factory: pytest.TempPathFactory, example: Example
) -> None:
    folder = tmp_path_factory.mktemp("random")
    try:
        ours = home(example.mechanism)
    except AssemblyError:
        return
    for shape in SHAPES:
        theirs = home(back(example.mechanism, folder, shape))
        assert ours[1] == theirs[1], shape
        common = ours[0].keys() & theirs[0].keys()
        turns = [(ours[0][n] - theirs[0][n]) / (2 * math.pi) for n in common]
        assert max(abs(t - round(t)) for t in turns) < 1e-9, shape


def test_a_model_read_is_a_file_too(tmp_path: Path) -> None:
    """`parakin check model.xml --expand` gives the TOML of it."""
    path = exports.export(parakin.load("tricept"), tmp_path / "model.xml")[0]
    (tmp_path / "model.toml").write_text(files.expanded(path))
    assert parakin.load(tmp_path / "model.toml").joints == parakin.load(path).joints


@pytest.mark.parametrize("name", ["flight-simulator", "gough-stewart", "delta", "seat-3dof"])
def test_a_newcomer_moves_it_and_the_loops_stay_closed(name: str, tmp_path: Path) -> None:
    """Two seconds in MuJoCo, the servos following sines: no loop opens by a tenth of a millimetre
    in a machine of metres, and the actuators are where they were told to be.
    """
    path = exports.export(parakin.load(name), tmp_path / "model.xml")[0]
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    rest = data.ctrl.copy()
    reach = 0.05 * model.stat.extent * (model.jnt_type[model.actuator_trnid[:, 0]] == 2) + 0.05
    places = model.jnt_qposadr[model.actuator_trnid[:, 0]]
    opened = behind = 0.0
    for step in range(1000):
        data.ctrl[:] = rest + 0.2 * reach * np.sin(
            3.0 * step * model.opt.timestep + np.arange(model.nu)
        ) * min(1.0, step / 200)
        mujoco.mj_step(model, data)
        opened = max(opened, float(np.abs(data.efc_pos[: data.ne]).max()))
        behind = max(behind, float(np.abs(data.qpos[places] - data.ctrl).max()))
    assert opened < 1e-4
    assert 0.0 < behind < 0.5 * reach.max()


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
    limits = {c.name: c.limits for c in graph.coordinates}
    assert limits["a"] == pytest.approx((-math.pi / 2, math.pi / 2))
    assert limits["b2"] == (-math.inf, math.inf)


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
    assert main(["check", str(tmp_path / "bars.urdf")]) == 0
    said = capsys.readouterr().out
    assert "Read from a URDF without loops: an open tree" in said
    assert "--loops FILE" in said
    assert "by rank: 3 at home" in said


def test_mujoco_has_the_urdf_where_we_have_it(tmp_path: Path) -> None:
    """The exported tree, read by MuJoCo's own URDF reader, at our home. (It leaves out fixed
    links' names; bodies with a joint of their own are compared.)
    """
    mechanism = parakin.load("tricept")
    text = exports.export(mechanism, tmp_path / "model.urdf")[0].read_text()
    text = text.replace(
        "<visual>",
        '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
        "</inertial><visual>",
    ).replace("<robot ", '<robot xmlns:mujoco="x" ', 1)
    extra = '<mujoco><compiler boundmass="1" boundinertia="1" fusestatic="false"/></mujoco>'
    model = mujoco.MjModel.from_xml_string(text.replace("</robot>", f"{extra}</robot>"))
    data = mujoco.MjData(model)
    graph = graph_of(mechanism)
    at = assembled(graph)
    for c, value in zip(graph.coordinates, at.q, strict=True):
        joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, c.name)
        if joint >= 0:
            data.qpos[model.jnt_qposadr[joint]] = value
    mujoco.mj_kinematics(model, data)
    for k, name in enumerate(graph.bodies[1:], start=1):
        np.testing.assert_allclose(at.pose(k).p, data.xpos[model.body(name).id], atol=1e-12)


REFUSED: dict[str, tuple[str, str, str]] = {
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
        "<mujoco><worldbody><body childclass='a'/></worldbody></mujoco>",
        "refuses",
    ),
    "no number": (
        "a.xml",
        "<mujoco><worldbody><body pos='a'/></worldbody></mujoco>",
        "line 1: pos: found 'a'",
    ),
    "still": ("a.xml", "<mujoco><worldbody/></mujoco>", "no joints that move"),
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


@pytest.mark.parametrize("case", REFUSED)
def test_files_that_mean_nothing_are_refused(case: str, tmp_path: Path) -> None:
    name, text, said = REFUSED[case]
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError) as refusal:
        parakin.load(tmp_path / name)
    assert said in str(refusal.value)
    assert str(tmp_path / name) in str(refusal.value)


LOOPS_REFUSED = {
    "[1, 2]": "a table of loops",
    "{}": "found no loops",
    "closed_loop: [[tip, and]]": "unknown link 'and'",
    "closed_loop: [[tip]]": "two links that coincide",
    "closed_loop: [[tip, end]]\ntype: [4d]": "3d (a point) or 6d (a frame)",
    "closed_loop: [[tip, end]]\ntype: []": "a type for each",
    "closed_loop: [[tip, end]]\nname_mot: [E]": "unknown joint 'E'",
    "closures: [{link_a: tip, link_b: end, point: [1, 2]}]": "three numbers",
    "closures: [{link_a: tip, link_b: end, point: [1, 2, x]}]": "a number",
    "closures: [{link_a: tip, link_b: end, point: [1, 2, 3], axis: [0, 0, 0]}]": "not zero",
    "closures: &a [*a]": "values written out",
    "closed_loop: [": "line 2: found a syntax error",
    "closed_loop: !!python/object:os.system [a]": "a syntax error",
}


@pytest.mark.parametrize("told", LOOPS_REFUSED)
def test_files_of_loops_that_mean_nothing_are_refused(told: str, tmp_path: Path) -> None:
    (tmp_path / "a.urdf").write_text(LINKS % "")
    (tmp_path / "loops.yaml").write_text(told)
    with pytest.raises(InputError) as refusal:
        parakin.load(tmp_path / "a.urdf", loops=tmp_path / "loops.yaml")
    assert LOOPS_REFUSED[told] in str(refusal.value)
    assert "loops.yaml" in str(refusal.value)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("delta", "model.txt"), "'.txt'; expected .xml (MJCF), .urdf or .c"),
        (("delta", "model"), "no suffix"),
        (("delta", "no/model.xml"), "no such file or directory"),
        (("delta", "model.xml", "--driven", "A1"), "models can be solved for any"),
        (("delta", "model.c", "--driven", "A9"), "unknown coordinate 'A9'"),
        (("delta", "model.xml", "--loops", "a.yaml"), "a URDF; other files contain their loops"),
    ],
)
def test_exports_that_mean_nothing_are_refused(
    arguments: tuple[str, ...],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["export", *arguments]) == 2
    assert said in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_an_export_that_fails_leaves_the_old_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Several files are written whole, all of them or none."""
    for name in ("k.c", "k.h", "k_test.c"):
        (tmp_path / name).write_text("old")
    write: Callable[..., int] = Path.write_text

    def failing(self: Path, *arguments: str, **named: str) -> int:
        if self.suffix == ".h":
            raise OSError(28, "No space left on device")
        return write(self, *arguments, **named)

    monkeypatch.setattr(Path, "write_text", failing)
    with pytest.raises(InputError):
        exports.export(parakin.load("four-bar"), tmp_path / "k.c")
    assert [p.read_text() for p in tmp_path.iterdir()] == ["old"] * 3
