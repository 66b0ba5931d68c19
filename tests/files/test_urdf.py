"""URDF as a mechanism: loops in every convention, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import parakin
from parakin.cli.main import main
from parakin.errors import InputError

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
