"""Loops in a file beside a URDF: what they change, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

import parakin
from parakin.errors import InputError

pytest.importorskip("lxml")

pytest.importorskip("yaml")

TREE = """<robot name="bars">
  <link name="base"/> <link name="crank"/> <link name="tip"/> <link name="end"/> <link name="rod"/>
  <joint name="A" type="revolute"><parent link="base"/><child link="crank"/></joint>
  <joint name="t" type="fixed"><parent link="crank"/><child link="tip"/></joint>
  <joint name="B" type="continuous"><parent link="crank"/><child link="end"/></joint>
  <joint name="S" type="prismatic"><parent link="end"/><child link="rod"/>
    <mimic joint="B" multiplier="0.1" offset="0.2"/></joint>
</robot>"""
LOOP = "closed_loop: [[tip, base]]\ntype: [3d]\n"


def loaded(tmp_path: Path, told: str) -> parakin.Mechanism:
    (tmp_path / "a.urdf").write_text(TREE)
    (tmp_path / "loops.yaml").write_text(told)
    return parakin.load(tmp_path / "a.urdf", loops=tmp_path / "loops.yaml")


def test_home_is_told_by_joint_and_by_lists_where_there_are_several_coordinates(
    tmp_path: Path,
) -> None:
    told = (
        f"{LOOP}joint_name: [A]\njoint_type: [SPHERICAL]\nhome: {{A: [0.1, 0.2, 3e-1], B: 1e-1}}\n"
    )
    mechanism = loaded(tmp_path, told)
    assert mechanism.guess == {"A.1": 0.1, "A.2": 0.2, "A.3": 0.3, "B": 0.1}
    follows = loaded(tmp_path, f"{LOOP}home: {{B: 0.5, S: 0.25}}\n")  # 0.2 + 0.1 * 0.5
    assert follows.guess["B"] == 0.5


REFUSED = {
    "closed_lop: [[tip, end]]": "an unknown key 'closed_lop'; expected one of: closed_loop,",
    "closures: [{link_a: tip, link_b: end, point: [0, 0, 0], axs: [0, 0, 1]}]": (
        "closures[0]: found an unknown key 'axs'; expected one of: axis, link_a, link_b, point"
    ),
    LOOP + "name_mot: [A]\nindependent: [B]": "found independent beside name_mot",
    LOOP + "name_mot: [t]": "motors: found 't'; expected a joint that moves",
    LOOP + "dependent: [C]": "unknown joint 'C'; expected one of: A, B, S, t",
    LOOP + "joint_name: [A, A]\njoint_type: [FIXED, SPHERICAL]": "found a joint twice",
    LOOP + "home: {t: 1}": "home.t: found 1; expected none, as the joint is fixed",
    LOOP + "home: {A: [1]}": "home.A: found [1]; expected a number",
    LOOP + "home: {A: '1_0'}": "home.A: found '1_0'; expected a number",
    LOOP + "home: {A: 1_0}": "loops.yaml, line 3: found '1_0'; expected a plain decimal number",
    LOOP + "home: {A: 010}": "line 3: found '010'; expected a plain decimal number",
    LOOP + "home: {A: 1:30}": "line 3: found '1:30'; expected a plain decimal number",
    LOOP + "home: {A: 0x10}": "line 3: found '0x10'; expected a plain decimal number",
    LOOP + "home: {B: 0.5, S: 0.2}": "home.S: found 0.2; expected 0.25, where it follows 'B'",
    "closures: []\ntype: [3d]": "type: found types without closed_loop",
}


@pytest.mark.parametrize("told", REFUSED)
def test_what_would_be_lost_is_refused(told: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as refusal:
        loaded(tmp_path, told)
    assert REFUSED[told] in str(refusal.value)
    assert refusal.value.place.startswith(str(tmp_path / "loops.yaml"))


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
    (tmp_path / "a.urdf").write_text(TREE)
    (tmp_path / "loops.yaml").write_text(told)
    with pytest.raises(InputError) as refusal:
        parakin.load(tmp_path / "a.urdf", loops=tmp_path / "loops.yaml")
    assert LOOPS_REFUSED[told] in str(refusal.value)
    assert "loops.yaml" in str(refusal.value)
