"""Mechanisms with errors of every kind, as a file and in Python."""

from __future__ import annotations

import copy
import math
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkage import LINKAGE, Refusal, edited

import parakin
from parakin import Body, InputError, Joint, Mechanism
from parakin.cli.main import main
from parakin.files.mechanism_toml import mechanism_from_table
from parakin.kinematics.assembly import assembled
from parakin.model.evaluation import graph_of
from parakin.model.mechanism import Kind


@pytest.fixture(autouse=True)
def _here(linkage_folder: Path) -> None:
    """Every test runs in the folder."""


KINDS = f"one of: {', '.join(sorted(get_args(Kind)))}"

ARITHMETIC = "only numbers, units, parameters, + - * / ** and functions"


def test_the_unspoilt_files_are_good(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "linkage.toml"]) == 1  # as home is far from the guess
    assert capsys.readouterr().err == ""
    assert main(["solve", "linkage.toml", "motion.toml"]) == 0
    assert "101 samples solved" in capsys.readouterr().err


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
    (
        'l = "500 mm"',
        'l = "500 mmm"',
        "'mmm' is not a unit; expected one of: A, Hz, N, Nm, W, cm, deg",
    ),
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
    ('A = "70 deg"', "A = {}", "guess.A: found {}; expected a number, a quantity like"),
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
    ('r = "0.2 m"', 'r = "0.2 K"', "'K' is not a unit of length, time, angle, mass or current"),
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
        "limits.A: found [-inf, inf]; expected at least one end",
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


def test_a_loop_of_helical_joints_alone_is_refused() -> None:
    """None of them can be cut, so that nothing would close the loop."""
    ends = (("base", "a"), ("a", "b"), ("b", "base"))
    joints = tuple(
        Joint(name=f"H{k}", kind="helical", parent=p, child=c, pitch=0.01)
        for k, (p, c) in enumerate(ends, 1)
    )
    bodies = (Body(name="a"), Body(name="b"))
    with pytest.raises(InputError, match=r"joints\.H3: found a loop of helical joints alone"):
        Mechanism(name="m", bodies=bodies, joints=joints)
    turn = Joint(name="A", kind="revolute", parent="b", child="base")
    Mechanism(name="m", bodies=bodies, joints=(*joints[:2], turn))


def with_parameter(own: float | str, given: float | str) -> Mechanism:
    made = Mechanism(
        name="bar",
        parameters={"a": own, "twice": "2*a"},
        bodies=[{"name": "base"}, {"name": "bar"}],
        joints=[{"name": "A", "kind": "revolute", "parent": "base", "child": "bar"}],
        driven=["A"],
    )
    return made.with_parameters({"a": given})


@pytest.mark.parametrize(
    ("own", "given", "said"),
    [
        ("1 m", "1 kg", "parameters.a: found '1 kg', a mass; expected a length"),
        ("1 m", "90 deg", "parameters.a: found '90 deg', an angle; expected a length"),
        ("1 m^2", "1 m", "parameters.a: found '1 m', a length; expected a quantity in m^2"),
        ("5 N/m", "5 N", "parameters.a: found '5 N', a force; expected a stiffness, such as N/m"),
    ],
)
def test_a_parameter_keeps_its_dimension(own: str, given: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        with_parameter(own, given)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("own", "given"),
    [
        ("1 m", 2.0),
        ("1 m", "2"),
        ("1 m", "2 cm + 3 mm"),
        (1.0, "2 kg"),
        ("pi/4", "20 deg"),
        ("5 N*m/rad", "5 N*m"),
        ("5 N*m", "5 N*m/deg"),
        ("1 m +", "2 kg"),  # what has no value of its own, or is given none, is told elsewhere
        ("1 m", "2 m +"),
    ],
)
def test_a_number_without_a_unit_stands_for_any(own: float | str, given: float | str) -> None:
    assert with_parameter(own, given).parameters["a"] == given
