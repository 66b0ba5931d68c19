"""Efforts in C: the test program's own comparison, and what is refused."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import parakin
from parakin import InputError
from parakin.arrays import FloatArray
from parakin.model.drives import Friction, Spring

COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")


def compared(folder: Path) -> str:
    flags = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror")
    sources = (str(folder / "k_test.c"), str(folder / "k.c"))
    binary = str(folder / "k_test")
    subprocess.run([str(COMPILER), *flags, "-o", binary, *sources, "-lm"], check=True)
    return subprocess.run([binary], check=True, capture_output=True, text=True).stdout


@needs_compiler
@pytest.mark.parametrize(
    "name", ["flight-simulator", "gough-stewart", "seat-2dof", "hexapod-on-3rps"]
)
def test_the_test_program_agrees_on_efforts(name: str, tmp_path: Path) -> None:
    mechanism = parakin.load(name)
    if name == "hexapod-on-3rps":  # which iterates, and has no masses
        mechanism = mechanism.with_payload("80 kg at platform")
    parakin.export(mechanism, tmp_path / "k.c", forces=True)
    printed = compared(tmp_path)
    assert "0 with another status" in printed
    assert "ns for the efforts of a pose" in printed


@needs_compiler
def test_friction_under_load_and_a_wrench_that_changes(tmp_path: Path) -> None:
    seat = parakin.load("seat-3dof")
    joints = [
        j.model_copy(update={"friction": (Friction(coefficient=0.2),)}) if j.name == "P" else j
        for j in seat.joints
    ]
    law = {"law": "sine", "amplitude": 1, "frequency": 1}
    gust = {"kind": "wrench", "at": "seat.head", "force": [5, 0, 0], "law": law}
    told = seat.model_dump(exclude_defaults=True) | {"joints": tuple(joints)}
    told["forces"] = {**told["forces"], "gust": gust}
    parakin.export(parakin.Mechanism(**told), tmp_path / "k.c", forces=True)
    assert "LOAD_GUST = 1" in (tmp_path / "k.h").read_text()
    assert "0 with another status" in compared(tmp_path)


@needs_compiler
def test_springs_at_angles_that_follow(tmp_path: Path) -> None:
    four_bar = parakin.load("four-bar")
    spring = (Spring(stiffness=2.0, zero=0.3),)
    joints = [
        j.model_copy(update={"spring": spring}) if j.name in "BD" else j for j in four_bar.joints
    ]
    told = four_bar.model_copy(update={"joints": tuple(joints)})
    parakin.export(told, tmp_path / "k.c", forces=True)
    assert "0 with another status" in compared(tmp_path)


@needs_compiler
@pytest.mark.parametrize(
    "names",
    [
        ["H", "Driven", "Coordinates", "Iterations"],
        ["Converged", "Singular", "Nothing", "Y_H"],
        ["Effort_Actuators", "Actuators", "Load_a", "Loop_1"],
    ],
)
def test_names_that_the_header_uses_itself(names: list[str], tmp_path: Path) -> None:
    mechanism = parakin.load("four-bar")
    called = dict(zip("ABCD", names, strict=True))
    table = mechanism.model_dump(exclude_defaults=True, by_alias=True)
    table["joints"] = [{**j, "name": called[j["name"]]} for j in table["joints"]]
    table["guess"] = {called[k]: v for k, v in table["guess"].items()}
    table["home"] = {called[k]: v for k, v in table["home"].items()}
    table["driven"] = [called[k] for k in table["driven"]]
    table.pop("motions")
    loads = {n: {"kind": "payload", "at": "coupler", "mass": 2} for n in ("a", "A", "a_", "p")}
    told = parakin.Mechanism(**{**table, "forces": loads})
    parakin.export(told, tmp_path / "k.c", forces=True)
    assert "0 with another status" in compared(tmp_path)


@needs_compiler
def test_redundant_actuators_share_as_told(tmp_path: Path) -> None:
    """Both do the work that one alone would; what differs from the preload is the least."""
    alone = parakin.load("four-bar")
    heavy = {"mass": 1.0, "com": (0.1, 0.02, 0.0)}
    bodies = (b if b.name == "base" else b.model_copy(update=heavy) for b in alone.bodies)
    alone = alone.model_copy(update={"bodies": tuple(bodies)})
    joints = (j.model_copy(update={"actuated": j.name in "AD"}) for j in alone.joints)
    both = alone.model_copy(update={"joints": tuple(joints)})
    with pytest.raises(InputError, match="2 actuators for 1 freedom"):
        parakin.export(both, tmp_path / "k.c", forces=True)
    with pytest.raises(InputError, match=r"--preload: found an export to \.xml"):
        parakin.export(both, tmp_path / "k.xml", preload={})
    assert not list(tmp_path.iterdir())
    told = {}
    for preload in ({}, {"D": 5.0}):
        parakin.export(both, tmp_path / "k.c", preload=preload)
        assert "0 with another status" in compared(tmp_path)
        told[len(preload)] = rows_of(tmp_path, "efforts")
    parakin.export(alone, tmp_path / "k.c", forces=True)
    by_one = rows_of(tmp_path, "efforts")[:, 0]
    solver = parakin.compile(alone, coordinates="all")
    given = rows_of(tmp_path, "given")
    for k, (y, yd, ydd) in enumerate(given):
        tick = solver.at([y], [yd], [ydd])
        ways = np.array([1.0, tick.value("D", "velocity") / yd])
        least, loaded = told[0][k], told[1][k] - [0.0, 5.0]
        assert least == pytest.approx(ways * by_one[k] / (ways @ ways))
        assert loaded == pytest.approx(ways * (loaded @ ways) / (ways @ ways))
        assert told[1][k] @ ways == pytest.approx(by_one[k])


def rows_of(folder: Path, table: str) -> FloatArray:
    """The rows of a table in the test program."""
    text = (folder / "k_test.c").read_text()
    inner = text.split(f" {table}[SAMPLES]")[1].split("= {", 1)[1].split("\n};")[0]
    return np.array([list(map(float, row.split(","))) for row in re.findall(r"{(.*?)}", inner)])


def test_what_has_no_efforts_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="nothing that makes forces"):
        parakin.export("four-bar", tmp_path / "k.c", forces=True)
    with pytest.raises(InputError, match=r"an export to \.xml"):
        parakin.export("gough-stewart", tmp_path / "k.xml", forces=True)
    assert not list(tmp_path.iterdir())
