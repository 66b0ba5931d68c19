"""Bad input of every kind: one message, exit code 2, and nothing written, changed or left behind.

Nearly all of it goes through the command line, since that is where strangers meet it.
"""

from __future__ import annotations

import copy
import importlib.util
import math
import os
import subprocess
import sys
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import parakin
from parakin import InputError
from parakin.cli.main import main
from parakin.files.reading import mechanism_from_table
from parakin.kinematics.assembly import assembled
from parakin.model.evaluation import graph_of
from parakin.model.mechanism import Kind

LINKAGE = """
name = "linkage"
title = "a crank, a coupler and a rocker"
driven = ["A"]

[parameters]
r = "0.2 m"
l = "500 mm"
reach = "r + l"

[guess]
A = "70 deg"

[bodies]
crank = {}
coupler = { points = { P = [0, 0, 0] } }
rocker = {}

[joints.A]
kind = "revolute"
parent = "base"
child = "crank"
actuated = true

[joints.B]
kind = "revolute"
parent = "crank"
child = "coupler"
on_parent = { at = ["r", 0, 0] }

[joints.C]
kind = "revolute"
parent = "coupler"
child = "rocker"
on_parent = { at = ["l", 0, 0] }
on_child = { at = ["0.4 m", 0, 0] }

[joints.D]
kind = "revolute"
parent = "base"
child = "rocker"
on_parent = { at = ["0.5 m", 0, 0] }

[motions.turn]
duration = "2 s"
laws = { A = { law = "poly345", by = "40 deg" } }
"""
MOTION = """
duration = "2 s"
rate = 50

[laws]
A = { law = "poly345", by = "40 deg" }
"""
KINDS = f"one of: {', '.join(sorted(get_args(Kind)))}"
ARITHMETIC = "only numbers, units, parameters, + - * / ** and functions"

Refusal = Callable[..., str]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a good mechanism, a good motion and old results."""
    monkeypatch.chdir(tmp_path)
    Path("linkage.toml").write_text(LINKAGE)
    Path("motion.toml").write_text(MOTION)
    for name in ("old.csv", "old.nc", "old.parquet", "old.png"):
        Path(name).write_text("old")
    return tmp_path


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and not path.is_symlink()
    }


@pytest.fixture
def refusal(here: Path, capsys: pytest.CaptureFixture[str]) -> Refusal:
    """Runs a command that must be refused; gives its message."""

    def run(*arguments: str) -> str:
        before = contents(here)
        capsys.readouterr()
        code = main(arguments)
        out, err = capsys.readouterr()
        assert (code, out) == (2, "")
        assert err.startswith("error: ")
        assert err.count("\n") == 1
        assert err.endswith("\n")
        assert contents(here) == before
        return err.removeprefix("error: ").rstrip("\n")

    return run


def edited(text: str, old: str, new: str) -> str:
    assert text.count(old) > 0, old
    return text.replace(old, new, 1)


def test_the_unspoilt_files_are_good(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "linkage.toml"]) == 0
    assert capsys.readouterr().err == ""
    assert main(["solve", "linkage.toml", "motion.toml"]) == 0
    assert "101 samples solved" in capsys.readouterr().err


# ---- what a mechanism's file says

IN_B = '{ at = ["r", 0, 0] }'
MECHANISM = [
    # unknown names
    ('kind = "revolute"', 'kind = "revolut"', "joints.A.kind: found 'revolut'; expected " + KINDS),
    ('kind = "revolute"', 'kind = "revolut"', "; did you mean 'revolute'?"),
    ('child = "coupler"', 'child = "copler"', "joints.B.child: found unknown body 'copler'"),
    ('child = "coupler"', 'child = "copler"', "one of: base, coupler, crank, rocker; did you"),
    ('parent = "crank"', 'parent = "Crank"', "joints.B.parent: found unknown body 'Crank'"),
    ('driven = ["A"]', 'driven = ["AA"]', "found unknown coordinate 'AA'; expected one of: A, B"),
    ('driven = ["A"]', 'driven = ["A"]\nfrom_home = ["Q"]', "found unknown coordinate 'Q'"),
    ('A = "70 deg"', 'Z = "70 deg"', "guess.Z: found unknown coordinate 'Z'; expected one of: A"),
    ("[guess]", "[home]\nAx = 1\n[guess]", "home.Ax: found unknown coordinate 'Ax'"),
    ("[guess]", "[stated]\nA.y = 1\n[guess]", "stated.A.y: found unknown coordinate 'A.y'"),
    ("[guess]", "[limits]\nQ = [0, 1]\n[guess]", "limits.Q: found unknown coordinate 'Q'"),
    ("[guess]", '[platform]\nbody = "rokker"\n[guess]', "platform.body: found unknown body 'rokk"),
    ("[guess]", '[platform]\nbody = "rokker"\n[guess]', "did you mean 'rocker'?"),
    (
        "[guess]",
        '[platform]\nbody = "coupler"\npoint = "p"\n[guess]',
        "platform.point: found unknown point 'p'; expected one of: P; did you mean 'P'?",
    ),
    (
        'name = "linkage"',
        'name = "linkage"\nvariant_of = "flight-simulato"',
        "variant_of: found 'flight-simulato'; expected one of: ",
    ),
    ('l = "500 mm"', 'l = "500 mmm"', "'mmm' is not a unit; expected one of: Hz, cm, deg"),
    ('l = "500 mm"', 'l = "500 mmm"', "did you mean 'mm'?"),
    ('reach = "r + l"', 'reach = "r + L"', "parameters.reach: found 'r + L': unknown parameter"),
    ('reach = "r + l"', 'reach = "r + L"', "expected one of: l, r, reach; did you mean 'l'?"),
    # keys
    ('title = "a', 'tittle = "a', ": found unknown key 'tittle'; expected one of: base, bodies"),
    ('title = "a', 'tittle = "a', "did you mean 'title'?"),
    ('title = "a', 'origin = "a', ": found unknown key 'origin'; expected no such key"),
    ('name = "linkage"\n', "", ": found no key 'name'; expected a value for name"),
    ('child = "crank"\n', "", "joints.A: found no key 'child'; expected a value for child"),
    ('child = "crank"', 'chlid = "crank"', "joints.A: found unknown key 'chlid'; expected one of"),
    ('child = "crank"', 'chlid = "crank"', "did you mean 'child'?"),
    (
        'child = "crank"',
        'name = "A"\nchild = "crank"',
        "joints.A: found a key 'name'; expected none",
    ),
    (
        IN_B,
        '{ at = ["r", 0, 0], axes = [0, 0, 1] }',
        "joints.B.on_parent: found unknown key 'axes'",
    ),
    ("crank = {}", "crank = { pts = 1 }", "bodies.crank: found unknown key 'pts'; expected one of"),
    ("[guess]", '[platform]\nbdy = "rocker"\n[guess]', "platform: found unknown key 'bdy'"),
    (LINKAGE, "name = 'a'\n[bodies]\n", ": found no table [joints]; expected [joints.NAME] tables"),
    (LINKAGE, "name = 'a'\n[joints]\n", ": found no table [bodies]; expected [bodies.NAME] tables"),
    (
        LINKAGE,
        "name = 'a'\n[bodies]\n[joints]\n",
        "joints: found none; expected at least one joint",
    ),
    # types
    ('name = "linkage"', "name = 3", "name: found 3; expected text"),
    ('name = "linkage"', 'name = "4/bar"', "name: found '4/bar'; expected a name of up to 64"),
    ('driven = ["A"]', 'driven = "A"', "driven: found 'A'; expected a list"),
    ('driven = ["A"]', "driven = [1]", "driven[0]: found 1; expected text"),
    ("crank = {}", "crank = 1", "bodies.crank: found 1; expected a table"),
    ("crank = {}", '"1st" = {}', "bodies.1st.name: found '1st'; expected a name of up to 64"),
    ("crank = {}", '"a\\nb\\u001b[31m" = {}', "bodies.a\\nb\\x1b[31m.name: found"),
    ('kind = "revolute"', "kind = 3", "joints.A.kind: found 3; expected " + KINDS),
    ("actuated = true", 'actuated = "yes"', "joints.A.actuated: found 'yes'; expected true or"),
    (
        "actuated = true",
        "actuated = [0]",
        "joints.A.actuated: found [0]; expected true or false, or",
    ),
    ("actuated = true", "actuated = [2]", "joints.A.actuated: found 2; expected numbers of its"),
    (IN_B, "[1]", "joints.B.on_parent: found [1]; expected a table"),
    (IN_B, '{ at = "r" }', "joints.B.on_parent.at: found 'r'; expected a list"),
    (IN_B, '{ at = ["r", 0] }', "joints.B.on_parent.at: found ['r', 0]; expected a list of 3"),
    (
        IN_B,
        "{ at = [0, 0, 0, 0] }",
        "joints.B.on_parent.at: found [0, 0, 0, 0]; expected a list of",
    ),
    (IN_B, "{ at = [] }", "joints.B.on_parent.at: found []; expected a list of 3"),
    (IN_B, "{ at = [true, 0, 0] }", "joints.B.on_parent.at[0]: found True; expected a number, a"),
    (IN_B, "{ at = [0, {}, 0] }", "joints.B.on_parent.at[1]: found {}; expected a number, a quan"),
    (IN_B, '{ turns = [["x"]] }', "joints.B.on_parent.turns[0]: found ['x']; expected a list of 2"),
    (IN_B, '{ turns = [["w", 1]] }', "on_parent.turns[0][0]: found 'w'; expected one of: x, y, z"),
    ("P = [0, 0, 0]", "P = [0, 0]", "bodies.coupler.points.P: found [0, 0]; expected a list of 3"),
    ('r = "0.2 m"', "r = [1]", "parameters.r: found [1]; expected a number, a quantity like"),
    ('r = "0.2 m"', "r = 2020-01-01", "parameters.r: found datetime.date(2020, 1, 1); expected a"),
    ('r = "0.2 m"', '"a-b" = 1\nr = "0.2 m"', "parameters.a-b: found 'a-b'; expected a name that"),
    ('r = "0.2 m"', 'pi = 3\nr = "0.2 m"', "parameters.pi: found 'pi'; expected a name that"),
    (
        'r = "0.2 m"',
        'lambda = 3\nr = "0.2 m"',
        "parameters.lambda: found 'lambda'; expected a name",
    ),
    ("[parameters]", "[parameters.deep]", "parameters.deep: found {'r': '0.2 m', 'l': '500 mm'"),
    ('A = "70 deg"', "A = {}", "guess.A: found an empty table; expected a value"),
    ('A = "70 deg"', 'B.x = 1\n"B.x" = 2', "guess.B.x: found two values; expected one"),
    ("[guess]", "[limits]\nA = [1]\n[guess]", "limits.A: found [1]; expected a list of 2"),
    ("[guess]", "[limits]\nA = [1, 0]\n[guess]", "limits.A: found [1, 0]; expected a lower limit"),
    ("[guess]", "[platform]\nangles = 3\n[guess]", "platform.angles: found 3; expected a list"),
    (
        "[guess]",
        '[platform]\nbody = "coupler"\nangles = [["a", "x"], ["a", "y"], ["c", "z"]]\n[guess]',
        "expected three distinct names (not x, y, z), one about each of the axes x, y and z",
    ),
    ("[motions.turn]", "[motions]\nup = 3\n[motions.turn]", "motions.up: found 3; expected a tab"),
    # expressions
    ('r = "0.2 m"', 'r = "reach"', "parameters.r: found the cycle r -> reach -> r; expected expr"),
    ('r = "0.2 m"', 'r = "1/0"', "parameters.r: found '1/0': it divides by zero; expected a fin"),
    ('r = "0.2 m"', 'r = "sqrt(-1)"', "parameters.r: found 'sqrt(-1)': it has no real value"),
    ('r = "0.2 m"', 'r = "9**9**9"', "parameters.r: found '9**9**9': it overflows; expected a fin"),
    ('r = "0.2 m"', 'r = ""', "parameters.r: found '': it cannot be parsed; expected a number, a"),
    (
        'r = "0.2 m"',
        'r = "2 reach"',
        "'reach' is a parameter, not a unit; expected 2*reach for that",
    ),
    ('r = "0.2 m"', 'r = "2 + * 3"', "parameters.r: found '2 + * 3': it cannot be parsed; expect"),
    ('r = "0.2 m"', f'r = "{"1+" * 400}1"', "parameters.r: found 801 characters; expected an exp"),
    (
        'r = "0.2 m"',
        f'r = "{"(" * 249}{")" * 249}"',
        "))': it cannot be parsed; expected a number, a",
    ),
    ('r = "0.2 m"', "r = \"__import__('os')\"", "unknown function '__import__'; expected one of"),
    ('r = "0.2 m"', 'r = "l.__class__"', f"it is more than arithmetic; expected {ARITHMETIC}"),
    ('r = "0.2 m"', 'r = "[x for x in l]"', f"it is more than arithmetic; expected {ARITHMETIC}"),
    ('r = "0.2 m"', 'r = "(lambda: 1)()"', f"it is more than arithmetic; expected {ARITHMETIC}"),
    ('r = "0.2 m"', 'r = "_unit0"', "parameters.r: found '_unit0': unknown parameter '_unit0'"),
    # dimensions
    ('r = "0.2 m"', 'r = "0.2 kg"', "'kg' is not a unit of length, angle or time; expected one of"),
    (IN_B, '{ at = ["15 deg", 0, 0] }', "joints.B.on_parent.at[0]: found '15 deg', an angle; expe"),
    (IN_B, '{ turns = [["z", "l"]] }', "joints.B.on_parent.turns[0]: found 'l', a length; expect"),
    ("P = [0, 0, 0]", 'P = [0, "1 s", 0]', "bodies.coupler.points.P[1]: found '1 s', a time; exp"),
    ('A = "70 deg"', 'A = "70 mm"', "guess.A: found '70 mm', a length; expected an angle"),
    (
        "[guess]",
        '[limits]\nA = ["0 m", 1]\n[guess]',
        "limits.A: found '0 m', a length; expected an",
    ),
    # values that are no numbers
    (IN_B, "{ at = [nan, 0, 0] }", "joints.B.on_parent.at[0]: found nan; expected a finite number"),
    (IN_B, "{ at = [0, -inf, 0] }", "joints.B.on_parent.at[1]: found -inf; expected a finite num"),
    (
        IN_B,
        f"{{ at = [1{'0' * 400}, 0, 0] }}",
        "at[0]: found a number out of range; expected a fin",
    ),
    ('r = "0.2 m"', "r = nan", "parameters.r: found nan; expected a finite number"),
    ('r = "0.2 m"', 'r = "1e999"', "parameters.r: found '1e999': it overflows; expected a finite"),
    ('r = "0.2 m"', f"r = {'9' * 5000}", ": found a value that cannot be read: Exceeds the limit"),
    ('A = "70 deg"', "A = inf", "guess.A: found inf; expected a finite number"),
    (
        "[guess]",
        "[limits]\nA = [-inf, inf]\n[guess]",
        "limits.A: found -inf; expected a finite num",
    ),
    # frames
    (IN_B, "{ axis = [0, 0, 0] }", "joints.B.on_parent.axis: found the axis [0.0, 0.0, 0.0]; expe"),
    (IN_B, "{ axis = ['r - r', 0, 0] }", "joints.B.on_parent.axis: found the axis [0.0, 0.0, 0.0]"),
    (
        IN_B,
        "{ axis = [0, 0, 1], x = [0, 0, 2] }",
        "joints.B.on_parent.x: found [0, 0, 2] along the",
    ),
    (IN_B, "{ axis = [0, 0, 1], x = [0, 0, 0] }", "joints.B.on_parent.x: found the axis [0.0, 0.0"),
    (IN_B, "{ x = [0, 0, 1] }", "joints.B.on_parent.x: found [0, 0, 1] along the axis; expected"),
    (
        IN_B,
        '{ axis = [0, 0, 1], turns = [["x", 1]] }',
        "joints.B.on_parent.turns: found both turns and an axis; expected one of them",
    ),
    # pitch and length
    (
        IN_B,
        "{}\npitch = 0.1",
        "joints.B.pitch: found a revolute joint with a pitch; expected a pitch",
    ),
    (
        '"revolute"',
        '"helical"',
        "joints.A.pitch: found a helical joint without a pitch; expected a pitch",
    ),
    (
        '"revolute"',
        '"rod"',
        "joints.A.length: found a rod joint without a length; expected a length for",
    ),
    (
        '"revolute"',
        '"rod"\nlength = "-1 m"',
        "joints.A.length: found -1 m; expected a length above",
    ),
    (
        '"revolute"',
        '"helical"\npitch = "1 s"',
        "joints.A.pitch: found '1 s', a time; expected a len",
    ),
    # limbs
    ("[guess]", "[limbs]\nleg = 3\n[guess]", "limbs.leg: found 3; expected a table"),
    ("[guess]", "[limbs.leg]\n[guess]", "limbs.leg: found no key 'count'; expected a value for co"),
    ("[guess]", "[limbs.leg]\ncount = 0\n[guess]", "limbs.leg.count: found 0; expected 1 to 1000"),
    (
        "[guess]",
        "[limbs.leg]\ncount = 2.5\n[guess]",
        "limbs.leg.count: found 2.5; expected a whole",
    ),
    ("[guess]", "[limbs.leg]\ncount = 1\nlegs = 3\n[guess]", "limbs.leg: found unknown key 'legs'"),
    (
        "[guess]",
        "[limbs.leg]\ncount = 2\neach = { a = [1] }\n[guess]",
        "limbs.leg.each.a: found 1 values; expected a list of 2",
    ),
    (
        "[guess]",
        "[limbs.leg]\ncount = 2\nbodies = { foot = {} }\n[guess]",
        "limbs.leg: bodies: found 'foot' twice; expected names with {i} in them",
    ),
    # structure
    (
        "crank = {}",
        "crank = {}\nlonely = {}",
        "bodies: found lonely not connected to 'base'; expec",
    ),
    ('child = "crank"', 'child = "base"', "joints.A: found 'base' joined to itself; expected two"),
    ("[joints.B]", "[joints.A]", ": found a syntax error: Cannot declare ('joints', 'A') twice"),
    ("crank = {}", "crank = {}\ncrank = {}", ": found a syntax error: Cannot overwrite a value"),
    (
        'name = "linkage"',
        'name = "linkage"\nbase = "ground"',
        "joints.A.parent: found unknown body 'base'; expected one of: coupler, crank, ground, ro",
    ),
    ("[joints.A]", "[joints.platform]", "unknown coordinate 'A'"),
    (
        "[guess]",
        '[platform]\nbody = "coupler"\n[joints.platform]\nkind = "fixed"\nparent = "base"\n'
        'child = "rocker"\n[guess]',
        "joints.platform: found a joint named 'platform'; expected another name",
    ),
]


@pytest.mark.parametrize(("old", "new", "said"), MECHANISM, ids=[case[2] for case in MECHANISM])
def test_a_mechanism_that_says_something_wrong(
    old: str, new: str, said: str, refusal: Refusal
) -> None:
    Path("linkage.toml").write_text(edited(LINKAGE, old, new))
    message = refusal("check", "linkage.toml")
    assert message.startswith("linkage.toml: ")
    assert said in message
    assert "; expected " in message


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


values = [None, True, 0, 1, -1, 0.5, 1e-300, 1e60, math.nan, math.inf, 10**400, "", "x", "A"]
texts = ["base", "1 mm", "3 deg", "3 s", "r", "1/0", *get_args(Kind)]
nested = [
    [],
    [1],
    [1, 2, 3],
    [0, 0, 0],
    ["x"],
    [[1]],
    [["x", "r"]],
    {},
    {"a": 1},
    {"at": [0, 0, 0]},
]
junk = st.sampled_from([*values, *texts, *nested])


def places(table: object) -> Iterator[tuple[Any, Any]]:
    """Every table and list inside one, with each of its keys."""
    keys = list(table) if isinstance(table, dict) else range(len(table))  # type: ignore[arg-type]
    for key in keys:
        yield table, key
        if isinstance(table[key], (dict, list)):  # type: ignore[index]
            yield from places(table[key])  # type: ignore[index]


@settings(deadline=None, max_examples=300)
@given(st.data())
def test_a_mechanism_with_any_value_changed_is_good_or_refused(data: st.DataObject) -> None:
    table = tomllib.loads(LINKAGE)
    inner, key = data.draw(st.sampled_from(list(places(table))))
    inner[key] = copy.deepcopy(data.draw(junk))
    try:
        assembled(graph_of(mechanism_from_table(table, "linkage.toml")))
    except InputError as error:
        assert str(error).startswith("linkage.toml")
        assert "\n" not in str(error)
    except parakin.AssemblyError as error:
        assert "joint" in str(error)


@settings(deadline=None)
@given(st.binary(max_size=200) | st.text("[]{}=.,'\"#\n a1-", max_size=60).map(str.encode))
def test_any_bytes_are_refused_as_a_mechanism(content: bytes) -> None:
    Path("bytes.toml").write_bytes(content)
    with pytest.raises(InputError) as caught:
        parakin.load("bytes.toml")
    assert caught.value.place.startswith("bytes.toml")


# ---- files that are no mechanisms


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "bad.toml: found an empty file; expected a file with text"),
        (b" \n\t\n", "bad.toml: found an empty file; expected a file with text"),
        (b"\xef\xbb\xbf", "bad.toml: found an empty file; expected a file with text"),
        (b"name =", "bad.toml: found a syntax error: Invalid value (at end of document); expected"),
        (b"name = 'a'\nb", "bad.toml: found a syntax error: Expected '=' after a key"),
        (bytes(range(256)), "bad.toml, byte 128: found byte 0x80, which is not UTF-8; expected a"),
        (b"\x7fELF\x02\x01\x01\x00", "bad.toml: found a syntax error"),
        (LINKAGE.encode("utf-16"), "bad.toml, byte 0: found byte 0xff, which is not UTF-8"),
        ("title = 'é'".encode("latin-1"), "bad.toml, byte 9: found byte 0xe9, which is not UTF-8"),
        (b"#" * 1_000_001, "bad.toml: found more than 1000000 bytes; expected a smaller file"),
        (b"a = " + b"[" * 5000 + b"]" * 5000, "bad.toml: found lists or tables more than 12 deep"),
        (b"a = " + b"[" * 50 + b"]" * 50, "bad.toml: found lists or tables more than 12 deep"),
        (b"[" + b".".join([b"a"] * 50) + b"]", "bad.toml: found lists or tables more than 12 deep"),
        (b"joints.a.b = 1\njoints.a.b.c = 2", "bad.toml: found a syntax error"),
    ],
)
def test_a_file_that_is_no_mechanism(content: bytes, said: str, refusal: Refusal) -> None:
    Path("bad.toml").write_bytes(content)
    assert said in refusal("check", "bad.toml")


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("flight-simulatr", "mechanism: found unknown name 'flight-simulatr'; expected a file, or"),
        ("flight-simulatr", "did you mean 'flight-simulator'?"),
        ("", "mechanism: found unknown name ''; expected a file, or one of: "),
        ("x" * 300, "mechanism: found unknown name 'xxx"),
        ("a\0b", r"mechanism: found unknown name 'a\x00b'"),
        ("a\0b.toml", "embedded null byte; expected a path"),
        ("x" * 300 + ".toml", "found file name too long; expected a readable file"),
        ("missing.toml", "missing.toml: found no such file or directory; expected a readable file"),
        ("linkage.toml/x.toml", "linkage.toml/x.toml: found not a directory; expected a readable"),
        (".", ".: found a folder; expected a file"),
        ("folder.toml", "folder.toml: found a folder; expected a file"),
        ("loop.toml", "loop.toml: found too many levels of symbolic links; expected a readable"),
        ("/dev/zero", "/dev/zero: found more than 1000000 bytes; expected a smaller file"),
        ("/dev/null", "/dev/null: found an empty file; expected a file with text"),
        ("/proc/self/mem", "/proc/self/mem: found input/output error; expected a readable file"),
    ],
)
def test_a_path_that_cannot_be_read(path: str, said: str, refusal: Refusal) -> None:
    Path("folder.toml").mkdir()
    Path("loop.toml").symlink_to("loop.toml")
    assert said in refusal("check", path)


# ---- parameters from the command line


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("r", "--set: found 'r'; expected NAME=VALUE"),
        ("=3", "--set: found '=3'; expected NAME=VALUE"),
        ("r=", "--set: found 'r='; expected NAME=VALUE"),
        ("r= ", "--set: found 'r= '; expected NAME=VALUE"),
        ("", "--set: found ''; expected NAME=VALUE"),
        (
            "reech=3",
            "parameters: found unknown parameter 'reech'; expected one of: l, r, reach; di",
        ),
        ("r=3 kg", "parameters.r: found '3 kg': 'kg' is not a unit of length"),
        ("r=nan", "parameters.r: found 'nan': unknown parameter 'nan'"),
        ("r=3 deg", "parameters.reach: found 'r + l': an angle and a length do not go together"),
        ("l=3", "cannot be assembled from its guess"),
        ("r=l=2", "parameters.r: found 'l=2': it cannot be parsed"),
        ("r=reach", "parameters.r: found the cycle r -> reach -> r"),
        ("r=open('x')", "parameters.r: found \"open('x')\": unknown function 'open'"),
    ],
)
def test_a_setting_that_means_nothing(setting: str, said: str, refusal: Refusal) -> None:
    assert said in refusal("check", "linkage.toml", "--set", setting)


# ---- mechanisms that cannot be, or not be driven so


def test_a_mechanism_that_cannot_be_assembled_names_the_joint_and_its_gap(
    refusal: Refusal,
) -> None:
    # The base is 3 m long, the crank, coupler and rocker 0.2 + 0.5 + 0.4 m.
    Path("linkage.toml").write_text(edited(LINKAGE, '"0.5 m"', '"3 m"'))
    message = refusal("check", "linkage.toml")
    assert message.startswith("linkage.toml: cannot be assembled from its guess; the largest gap")
    assert "at joint C: 1900 mm and 0 degrees" in message


@pytest.mark.parametrize("size", ["1e60", "1e160", "1e300", "-1e300"])
def test_dimensions_beyond_sense_are_refused_too(size: str, refusal: Refusal) -> None:
    assert "cannot be assembled" in refusal("check", "flight-simulator", "--set", f"d1={size}")


@pytest.mark.parametrize(
    ("driven", "said"),
    [
        ([], "no driven coordinates are given"),
        (["A", "A"], "a coordinate is driven twice: A, A"),
        (
            ["A", "D"],
            "(A, D), but only 1 can move independently near home: A, D depend on one another",
        ),
        (["a"], "found unknown coordinate 'a'; expected one of: A, B, C, D; did you mean"),
    ],
)
def test_driven_coordinates_that_do_not_fit_a_linkage(
    driven: list[str], said: str, refusal: Refusal
) -> None:
    Path("linkage.toml").write_text(edited(LINKAGE, '["A"]', f"{driven}"))
    message = refusal("solve", "linkage.toml", "motion.toml", "-o", "old.csv")
    assert message.startswith("linkage.toml: ")
    assert said in message


@pytest.mark.parametrize(
    ("driven", "reasons"),
    [
        (["platform.x"], ["mobility is 3", "1 coordinates are driven", "platform.phi"]),
        (["A2", "B3", "C3", "D1"], ["4 coordinates are driven", "only 3 can", "depend on one"]),
        (["platform.x", "platform.y", "platform.z"], ["only 2 can", "platform.z cannot move"]),
        (
            ["A4", "platform.x", "platform.phi"],
            ["only 2 can", ": A4, platform.phi depend on one another"],
        ),
    ],
)
def test_driven_coordinates_too_few_too_many_or_dependent(
    driven: list[str], reasons: list[str]
) -> None:
    with pytest.raises(parakin.DrivenError) as caught:
        parakin.compile("flight-simulator", driven, machine_code=False)
    for reason in (*reasons, *driven):
        assert reason in str(caught.value)


def test_a_mechanism_too_stiff_to_be_driven(refusal: Refusal) -> None:
    assert "but only 1 can move independently" in refusal(
        "solve", "flight-simulator-upu", "general", "-o", "old.csv"
    )


# ---- motions

MOTIONS = [
    (
        "A = {",
        "AA = {",
        "motion.laws: found 'AA', not driven; expected one of: A; did you mean 'A'",
    ),
    ("A = {", "B = {", "motion.laws: found 'B', not driven; expected one of: A"),
    (
        '"poly345"',
        '"poly34"',
        "motion.laws.A.law: found 'poly34'; expected one of: chirp, constant",
    ),
    ('"poly345"', '"poly34"', "did you mean 'poly345'?"),
    ('law = "poly345", ', "", "motion.laws.A: found no key 'law'; expected the key law"),
    ("by =", "bye =", "motion.laws.A: found unknown key 'bye'; expected one of: begin, by"),
    (
        'by = "40 deg"',
        "by = 1, to = 2",
        "motion.laws.A.by and to: found both; expected one of them",
    ),
    (
        'by = "40 deg"',
        "by = [1]",
        "motion.laws.A.by: found [1]; expected a number, a quantity like",
    ),
    ("40 deg", "40 mm", "motion.laws.A.by: found '40 mm', a length; expected an angle"),
    (
        "40 deg",
        "40 deg + q",
        "motion.laws.A.by: found '40 deg + q': unknown parameter 'q'; expected",
    ),
    ("40 deg", "().__class__", f"it is more than arithmetic; expected {ARITHMETIC}"),
    ('"40 deg"', "nan", "motion.laws.A.by: found nan; expected a finite number"),
    ("A = { law", "A = [1]\nB = { law", "motion.laws.A: found [1]; expected a table"),
    ("rate = 50", "rte = 50", "motion: found unknown key 'rte'; expected one of: duration, laws"),
    ("rate = 50", "rate = 0", "motion.rate: found 0; expected a positive number"),
    ("rate = 50", "rate = inf", "motion.rate: found inf; expected a finite number"),
    (
        "rate = 50",
        "rate = 1e30",
        "found 2e+30 steps (2 s at 1e+30 samples per second); expected at",
    ),
    ('"2 s"', '"2 m"', "motion.duration: found '2 m', a length; expected a time"),
    ('"2 s"', "-1", "motion.duration: found -1; expected a positive number"),
    ('duration = "2 s"', "", "motion: found no key 'duration'; expected a value for duration"),
    (MOTION, LINKAGE, "motion: found unknown key 'name'; expected one of: duration, laws, rate"),
    (MOTION, "\n", ": found an empty file; expected a file with text"),
    (MOTION, "duration", ": found a syntax error: Expected '=' after a key"),
]


@pytest.mark.parametrize(("old", "new", "said"), MOTIONS, ids=[case[2] for case in MOTIONS])
def test_a_motion_that_says_something_wrong(
    old: str, new: str, said: str, refusal: Refusal
) -> None:
    Path("motion.toml").write_text(edited(MOTION, old, new))
    message = refusal("solve", "linkage.toml", "motion.toml", "-o", "old.csv")
    assert "motion" in message.split(":")[0]
    assert said in message
    assert "; expected " in message


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


def test_a_motion_of_other_coordinates_is_refused_in_python_too() -> None:
    from parakin.motion.laws import constant, from_laws

    solver = parakin.compile("linkage.toml", machine_code=False)
    for laws in ({"B": constant(0.0)}, {"A": constant(0.0), "B": constant(0.0)}):
        with pytest.raises(InputError) as caught:
            solver.solve(from_laws("other", laws, 1.0, 10.0))
        assert "other" in caught.value.place
        assert "B" in caught.value.found
        assert "A" in caught.value.expected


# ---- where results cannot go


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["-o", "x.txt"], "x.txt: found the suffix '.txt'; expected one of: .csv, .nc, .parquet"),
        (["-o", "x.cvs"], "did you mean '.csv'?"),
        (["-o", "x"], "x: found no suffix; expected one of: .csv, .nc, .parquet"),
        (["-o", ""], "found no suffix; expected one of: .csv, .nc, .parquet"),
        (["--plot", "x.jpg"], "x.jpg: found the suffix '.jpg'; expected one of: .pdf, .png, .svg"),
        (
            ["-o", "nowhere/x.csv"],
            "nowhere/x.csv: found no such file or directory; expected a file",
        ),
        (
            ["-o", "linkage.toml/x.nc"],
            "linkage.toml/x.nc: found not a directory; expected a file t",
        ),
        (["-o", "folder.csv"], "folder.csv: found a folder; expected a file to write"),
        (
            ["-o", "full.csv"],
            "full.csv: found a special file, such as a device; expected a file to write",
        ),
        (["-o", "loop.csv"], "expected a"),
        (["-o", "a\0.csv"], r"'a\x00.csv': found embedded null byte; expected a path"),
        (["-o", "/proc/x.csv"], "/proc/x.csv: found"),
        (["-o", "x" * 300 + ".csv"], ".csv: found file name too long; expected a file that can be"),
        (["-o", "x.csv", "--plot", "nowhere/x.png"], "nowhere/x.png: found no such file or direct"),
        (["-o", "old.csv", "--plot", "folder.png"], "folder.png: found a folder; expected a file"),
        (
            ["-o", "recorded.csv"],
            "recorded.csv: found a file that the command reads; expected another file",
        ),
        (
            ["-o", "link.csv"],
            "link.csv: found a file that the command reads; expected another file",
        ),
    ],
)
def test_a_result_that_cannot_be_written(arguments: list[str], said: str, refusal: Refusal) -> None:
    Path("folder.csv").mkdir()
    Path("folder.png").mkdir()
    Path("full.csv").symlink_to("/dev/full")
    Path("loop.csv").symlink_to("loop.csv")
    Path("link.csv").symlink_to("recorded.csv")
    Path("recorded.csv").write_text("time,A\n0,0\n")
    assert said in refusal("solve", "linkage.toml", "recorded.csv", *arguments)


@pytest.mark.parametrize(
    ("library", "option", "extra"),
    [
        ("h5netcdf", "-o old.nc", "files"),
        ("h5py", "-o old.nc", "files"),
        ("pyarrow", "-o old.parquet", "files"),
        ("matplotlib", "--plot old.png", "plot"),
    ],
)
def test_a_library_that_is_not_installed_is_named(
    library: str, option: str, extra: str, refusal: Refusal, monkeypatch: pytest.MonkeyPatch
) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr("importlib.util.find_spec", lambda n: None if n == library else find(n))
    message = refusal("solve", "linkage.toml", "motion.toml", *option.split())
    file = option.split()[1]
    assert (
        message
        == f"{file}: found {library} is not installed; expected pip install 'parakin[{extra}]'"
    )


def test_a_device_is_never_replaced(refusal: Refusal) -> None:
    Path("full.csv").symlink_to("/dev/full")
    refusal("solve", "linkage.toml", "motion.toml", "-o", "full.csv")
    assert Path("/dev/full").is_char_device()
    assert Path("full.csv").is_symlink()


# ---- the command line itself


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "the following arguments are required: COMMAND; see parakin --help"),
        (
            ["chek", "x"],
            "command: found unknown name 'chek'; expected one of: check, draw, export, ",
        ),
        (["check"], "the following arguments are required: MECHANISM; see parakin check --help"),
        (["solve", "linkage.toml"], "arguments are required: MOTION; see parakin solve --help"),
        (
            ["solve", "linkage.toml", "turn", "--plott"],
            "unrecognized arguments: --plott; see parakin",
        ),
        (
            ["solve", "linkage.toml", "turn", "-o"],
            "argument -o/--output: expected one argument; see",
        ),
    ],
)
def test_a_command_that_cannot_be_parsed(arguments: list[str], said: str, refusal: Refusal) -> None:
    assert said in refusal(*arguments)


# ---- the same in Python


def test_types_refuse_in_python_what_they_refuse_in_a_file() -> None:
    from parakin import Body, Frame, Joint, Mechanism, Platform

    def joint(name: str, parent: str = "base", child: str = "link") -> Joint:
        return Joint(name=name, kind="revolute", parent=parent, child=child)

    def mechanism(*joints: Joint, bodies: tuple[str, ...] = ("link",)) -> Mechanism:
        made = tuple(Body(name=name) for name in bodies)
        return Mechanism(name="arm", bodies=made, joints=joints)

    cases: list[tuple[Callable[[], object], str]] = [
        (lambda: mechanism(joint("A"), joint("A")), "arm: joints: found two named 'A'; expected"),
        (
            lambda: mechanism(joint("A"), bodies=("link", "link")),
            "arm: bodies: found two named 'li",
        ),
        (
            lambda: mechanism(joint("A", child="lnk")),
            "arm: joints.A.child: found unknown body 'lnk'",
        ),
        (
            lambda: mechanism(joint("A", child="base")),
            "arm: joints.A: found 'base' joined to itsel",
        ),
        (mechanism, "arm: joints: found none; expected at least one joint"),
        (lambda: joint("1"), "Joint 1: name: found '1'; expected a name of up to 64"),
        (
            lambda: Joint(name="A", kind="revolut", parent="a", child="b"),  # type: ignore[arg-type]
            "Joint A: kind: found 'revolut'; expected " + KINDS,
        ),
        (lambda: Joint(name="A"), "Joint A: found no key 'kind'; expected values for kind, pa"),  # type: ignore[call-arg]
        (lambda: Frame(at=(1, 2)), "Frame: at: found [1, 2]; expected a list of 3"),  # type: ignore[arg-type]
        (lambda: Frame(axes=(1, 2, 3)), "Frame: found unknown key 'axes'; expected one of: at"),  # type: ignore[call-arg]
        (lambda: Platform(bdy="x"), "Platform: found unknown key 'bdy'; expected one of: angles"),  # type: ignore[call-arg]
        (lambda: parakin.load("linkage.toml", {"q": 1}), "linkage.toml: parameters: found unknown"),
        (lambda: parakin.compile("linkage.toml", ["Q"]), "found unknown coordinate 'Q'; expected"),
        (
            lambda: parakin.compile("linkage.toml", cut=["Q"]),
            "cut: found unknown joint 'Q'; expect",
        ),
        (
            lambda: parakin.compile("linkage.toml", coordinates=["Q"]),
            "coordinates: found unknown coordinate 'Q'; expected one of: A, B, C, D",
        ),
    ]
    for make, said in cases:
        with pytest.raises(InputError) as caught:
            make()
        assert said in str(caught.value)


def test_an_unknown_body_or_point_is_named() -> None:
    solver = parakin.compile("linkage.toml", machine_code=False)
    with pytest.raises(InputError) as caught:
        solver.solve("turn", bodies=["coupler.Q"])
    assert caught.value.found == "unknown body or point 'coupler.Q'"
    assert caught.value.expected.startswith("one of: base, coupler, coupler.P, crank, rocker")


# ---- as a process of its own


LIMITED = """
import resource, sys
import parakin.solving.compiler
from parakin.cli.main import main

# heyoka keeps what it compiles on disk too: not in here
parakin.solving.compiler.has_machine_code = lambda: False
resource.setrlimit(resource.RLIMIT_FSIZE, (9000, 9000))
sys.exit(main())
"""


def run(
    *arguments: str, start: tuple[str, ...] = ("-m", "parakin"), stdout: str = os.devnull
) -> tuple[int, str]:
    """parakin in a process of its own: exit code and what it says on stderr."""
    with open(stdout, "w") as target:
        done = subprocess.run(
            [sys.executable, *start, *arguments],
            stdout=target,
            stderr=subprocess.PIPE,
            text=True,
            env={k: v for k, v in os.environ.items() if k != "PYTHONUNBUFFERED"},
            timeout=600,
            check=False,
        )
    return done.returncode, done.stderr


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["check", "flight-simulatr"], "did you mean 'flight-simulator'?"),
        (["check", "linkage.toml", "--set", "r=l.__class__"], "it is more than arithmetic"),
        (["chek"], "did you mean 'check'?"),
        (
            ["solve", "linkage.toml", "motion.toml", "-o", "nowhere/x.csv"],
            "nowhere/x.csv: found no",
        ),
    ],
)
def test_a_process_says_one_thing_and_exits_with_2(
    arguments: list[str], said: str, here: Path
) -> None:
    before = contents(here)
    code, err = run(*arguments, stdout=f"{here.parent}/stdout")
    assert code == 2
    assert Path(f"{here.parent}/stdout").read_text() == ""
    assert err.startswith("error: ")
    assert said in err
    assert err.count("\n") == 1
    assert contents(here) == before


@pytest.mark.parametrize("option", ["-o old.csv", "-o old.nc", "-o old.parquet", "--plot old.png"])
def test_a_disk_that_fills_up_leaves_the_old_file_and_no_other(option: str, here: Path) -> None:
    before = contents(here)
    name = option.split()[1]
    solve = ("solve", "flight-simulator", "general", *option.split())
    code, err = run(*solve, start=("-c", LIMITED))
    assert err == f"error: {name}: found file too large; expected a file that can be written\n"
    assert code == 2
    assert contents(here) == before


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="the system has no /dev/full")
@pytest.mark.parametrize(
    "arguments",
    [
        ["solve", "flight-simulator", "general", "-o", "-"],
        ["check", "linkage.toml"],
        ["list"],
        ["--help"],
    ],
)
def test_a_standard_output_that_takes_no_more(arguments: list[str]) -> None:
    code, err = run(*arguments, stdout="/dev/full")
    assert code == 2
    assert err == (
        "error: standard output: found no space left on device; expected a stream that accepts "
        "all output\n"
    )


def test_checking_a_file_reads_its_motions_too(refusal: Refusal) -> None:
    text = Path("linkage.toml").read_text()
    Path("linkage.toml").write_text(
        text + '\n[motions.wrong]\nduration = "1 s"\nlaws = { A = { law = "cosin", by = 1 } }\n'
    )
    assert "motions.wrong.laws.A" in refusal("check", "linkage.toml")
