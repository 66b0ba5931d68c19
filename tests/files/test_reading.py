"""Mechanisms and motions by name or path, from any file."""

from __future__ import annotations

from pathlib import Path

import pytest
from linkage import Refusal

import parakin
from parakin.exports import export as exports
from parakin.files import reading as files


def test_a_model_read_is_a_file_too(tmp_path: Path) -> None:
    """`parakin check model.xml --expand` gives the TOML of it."""
    pytest.importorskip("mujoco")
    pytest.importorskip("lxml")
    path = exports.export(parakin.load("tricept"), tmp_path / "model.xml")[0]
    (tmp_path / "model.toml").write_text(files.expanded(path))
    assert parakin.load(tmp_path / "model.toml").joints == parakin.load(path).joints


def test_a_variant_with_changes_that_are_no_tables(refusal: Refusal) -> None:
    variant = 'variant_of = "flight-simulator"\nname = "mine"\n'
    for text, said in [
        ("joints = 3", "variant.toml: joints: found 3; expected a table"),
        ("joints.A1 = 3", "variant.toml: joints.A1: found 3; expected a table"),
        ("joints.A1.knd = 3", "variant.toml: joints.A1: found unknown key 'knd'; expected one of"),
        ("parameters = 3", "variant.toml: parameters: found 3; expected a table"),
    ]:
        Path("variant.toml").write_text(variant + text)
        assert said in refusal("check", "variant.toml")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (
            ["trun"],
            "motion of linkage: found unknown name 'trun'; expected a file, or one of: turn",
        ),
        (["trun"], "did you mean 'turn'?"),
        ([""], "motion of linkage: found unknown name ''"),
        (["t" * 300], "motion of linkage: found unknown name 'ttt"),
        (["missing.toml"], "missing.toml: found no such file or directory; expected a readable"),
        (["missing.csv"], "missing.csv: found no such file or directory; expected a readable"),
        (["folder.csv"], "folder.csv: found"),
        (["empty.csv"], "empty.csv: found"),
        (["other.csv"], "other.csv, column 2: found 'B'; expected one of: A, A.acceleration, A.j"),
        (["motion.toml", "--rate", "0"], "rate: found 0; expected a positive number"),
        (["motion.toml", "--rate", "nan"], "rate: found nan; expected a positive number"),
        (["motion.toml", "--rate", "fast"], "argument --rate: found 'fast'; expected a number"),
        (
            ["motion.toml", "--smooth", "1e-3"],
            "found smoothing for a motion given by laws; expecte",
        ),
        (
            ["motion.toml", "--max-gap", "1"],
            "found max_gap for a motion given by laws; expected one",
        ),
        (
            ["recorded.csv", "--rate", "10"],
            "recorded.csv: found a rate for a motion given by samples; expected",
        ),
        (["recorded.csv", "--smooth", "-1"], "smoothing: found -1; expected a positive number"),
    ],
)
def test_a_motion_that_cannot_be_had(arguments: list[str], said: str, refusal: Refusal) -> None:
    Path("folder.csv").mkdir()
    Path("empty.csv").touch()
    Path("other.csv").write_text("time,B\n0,0\n1,1\n")
    rows = "".join(f"{k / 10},{0.7 + k / 100}\n" for k in range(20))
    Path("recorded.csv").write_text("time,A\n" + rows)
    assert said in refusal("solve", "linkage.toml", *arguments, "-o", "old.csv")
