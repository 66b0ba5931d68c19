"""Hostile files for every reader: something is read or refused in one line, soon, in little memory.

Nothing but the file that was named is opened, whatever it refers to. The fuzzer in `fuzz/` looks
further than what is written down here.
"""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import parakin
from parakin.exports.export import export
from parakin.files.reading import load_motion
from parakin.model.evaluation import graph_of

SOON = 10.0  # seconds for any one file, on a slow machine
NEEDED = {".xml": ("lxml", "mujoco"), ".urdf": ("lxml",), ".yaml": ("lxml", "yaml")}
SUFFIXES = (".toml", ".xml", ".urdf", ".yaml", ".csv")

quick = settings(
    deadline=None,
    max_examples=150,
    phases=(Phase.explicit, Phase.generate, Phase.shrink),
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


def missing(suffix: str) -> str | None:
    """A library that a file of this kind needs and that is not installed."""
    return next((n for n in NEEDED.get(suffix, ()) if importlib.util.find_spec(n) is None), None)


def installed(suffix: str) -> None:
    if missing(suffix):
        pytest.skip(f"{missing(suffix)} is not installed")


LEG = """
name = "four-bar"
driven = ["A"]
guess = { A = "70 deg" }
[bodies]
crank = {}
coupler = {}
rocker = {}
[joints]
A = { kind = "revolute", parent = "base", child = "crank", actuated = true }
B = { kind = "revolute", parent = "crank", child = "coupler", on_parent = { at = [0.2, 0, 0] } }
C = { kind = "revolute", parent = "coupler", child = "rocker", on_parent = { at = [0.5, 0, 0] },
      on_child = { at = [0.4, 0, 0] } }
D = { kind = "revolute", parent = "base", child = "rocker", on_parent = { at = [0.5, 0, 0] } }
""".replace(",\n      ", ", ")
TREE = """<robot name="tree"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/></joint>
<joint name="k" type="revolute"><parent link="b"/><child link="c"/></joint>
<joint name="l" type="prismatic"><parent link="c"/><child link="d"/></joint></robot>"""
LOOP = "closed_loop: [[a, d]]\ntype: [3d]\n"
MOTION = "time [s],A [deg]\n" + "".join(f"{k / 10},{70 + k}\n" for k in range(20))


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[str]]:
    """Texts of sound files, by suffix."""
    folder = tmp_path_factory.mktemp("good")
    catalogue = Path(parakin.__file__).with_name("catalogue")
    names = ("four-bar", "flight-simulator", "delta")
    texts = {".toml": [LEG, *((catalogue / f"{n}.toml").read_text("utf-8") for n in names)]}
    models = [parakin.load(name) for name in names]
    for suffix in (".xml", ".urdf"):
        written = [export(model, folder / f"model{suffix}")[0].read_text() for model in models]
        texts[suffix] = written
    texts[".yaml"] = [LOOP, (folder / "model.loops.yaml").read_text()]
    texts[".csv"] = [MOTION]
    return texts


Read = Callable[[str, bytes], str | None]


@pytest.fixture
def read(tmp_path: Path) -> Read:
    """Reads a file of some kind; gives its refusal in one short line, or None."""
    (tmp_path / "leg.toml").write_text(LEG)
    (tmp_path / "tree.urdf").write_text(TREE)
    graph = graph_of(parakin.load(tmp_path / "leg.toml"))

    def reading(suffix: str, content: bytes) -> str | None:
        path = tmp_path / f"input{suffix}"
        path.write_bytes(content)
        begun = time.process_time()
        said = None
        try:
            if suffix == ".csv":
                load_motion(path, graph, {"A": 1.2})
            elif suffix == ".yaml":
                graph_of(parakin.load(tmp_path / "tree.urdf", loops=path))
            else:
                graph_of(parakin.load(path))
        except parakin.ParakinError as error:
            said = str(error)
            assert said.isprintable()
            assert len(said) < 4000
        assert time.process_time() - begun < SOON
        return said

    return reading


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_the_unspoilt_files_are_read(
    suffix: str, read: Read, good: dict[str, list[str]], tmp_path: Path
) -> None:
    installed(suffix)
    for text in good[suffix]:
        if "_A" not in text:  # beside another tree it names links that are not there
            assert read(suffix, text.encode()) is None


# ---- one by one


def mjcf(inside: str = "", after: str = "", root: str = "", before: str = "") -> str:
    """A model of two bodies side by side, and what is put in or around it."""
    two = '<body name="a"><joint name="j"/></body><body name="b"><joint name="k" type="slide"/></body>'
    return (
        f"<mujoco {root}>{before}<worldbody>{two}{inside}</worldbody>"
        f"<equality>{after}</equality></mujoco>"
    )


def urdf(*joints: str, bodies: str = "abcd") -> str:
    links = "".join(f'<link name="{name}"/>' for name in bodies)
    return f'<robot name="r">{links}{"".join(joints)}</robot>'


def hinge(
    name: str, parent: str, child: str, kind: str = "revolute", inside: str = "", at: str = "0 0 0"
) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}"/>{inside}</joint>'
    )


def mimic(joint: str) -> str:
    return f'<mimic joint="{joint}"/>'


ARM = (hinge("h", "a", "b"), hinge("s", "b", "c", "prismatic"), hinge("t", "c", "d", "prismatic"))
MEGA = "n" * 900_000
HEX = "0x" + "f" * 20_000
JOINT = (
    'name = "l"\n[bodies]\na = {}\n[joints.j]\nkind = "revolute"\nparent = "base"\nchild = "a"\n'
)
ENTITIES = (
    '<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa">'
    + "".join(
        f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip("abcdefgh", "bcdefghi", strict=True)
    )
    + ']><mujoco model="&i;"/>'
)
OUTSIDE = '<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot name="&x;"/>'
ATTRIBUTE = 'a{}="1"'
ACCEPTED = None


def limbs(count: int, inside: str) -> str:
    return f'name = "l"\n[bodies]\na = {{}}\n[limbs.a]\ncount = {count}\n{inside}\n[joints]\n'


def chain(count: int, kind: str = "revolute") -> str:
    bodies = "".join(f"b{k} = {{}}\n" for k in range(count))
    names = ["base", *(f"b{k}" for k in range(count))]
    joints = "".join(
        f'j{k} = {{ kind = "{kind}", parent = "{names[k]}", child = "{names[k + 1]}" }}\n'
        for k in range(count)
    )
    return f'name = "chain"\n[bodies]\n{bodies}[joints]\n{joints}'


# What is read, and a part of what is said against it; None where it is read.
CASES: dict[str, tuple[str, str | bytes, str | None]] = {
    # XML that grows, or reaches outside itself
    "entity bomb": (".xml", ENTITIES, "a document type or entities"),
    "external entity": (".urdf", OUTSIDE, "a document type or entities"),
    "external document type": (".xml", '<!DOCTYPE r SYSTEM "http://x/y"><mujoco/>', "a document ty"),
    "unknown entity": (".urdf", '<robot name="&x;"/>', "a syntax error: Entity 'x' not defined"),
    "XInclude": (
        ".xml",
        mjcf('<xi:include xmlns:xi="http://www.w3.org/2001/XInclude" href="/etc/passwd"/>'),
        "found <xi:include> in <worldbody>",
    ),
    "stylesheet": (".xml", '<?xml-stylesheet href="/etc/passwd"?>' + mjcf(), ACCEPTED),
    "include": (".xml", mjcf('<include file="/etc/passwd"/>'), "found <include>; expected one file"),
    "include at the top": (".xml", mjcf(before='<include file="/etc/passwd"/>'), "found <include>"),
    "attached model": (".xml", mjcf('<attach model="m"/>'), "found <attach>; expected one file"),
    "assets": (
        ".xml",
        mjcf(
            '<geom type="mesh" mesh="m"/><geom type="hfield" hfield="h"/>',
            before='<compiler meshdir="/etc" assetdir="/etc"/><asset><mesh name="m" file="passwd"/>'
            '<hfield name="h" file="/etc/passwd"/><texture file="/etc/passwd"/>'
            '<model name="n" file="/etc/passwd"/></asset>',
        ),
        ACCEPTED,
    ),
    "plugin": (".xml", mjcf(before='<extension><plugin plugin="x"/></extension>'), ACCEPTED),
    "package": (
        ".urdf",
        urdf(*ARM, '<link name="e"><visual><geometry><mesh filename="package://x/y.stl"/>'
             '</geometry></visual></link>', hinge("u", "d", "e")),
        ACCEPTED,
    ),
    # too deep
    "deep elements": (".xml", "<mujoco>" + "<body>" * 5000, "Excessive depth"),
    "deep bodies": (".xml", mjcf("<body>" * 200 + "<joint/>" + "</body>" * 200), ACCEPTED),
    "deep classes": (".xml", mjcf(before="<default>" * 240 + "</default>" * 240), "MuJoCo refuses"),
    "deep links": (".urdf", "<robot>" + "<link name='a'>" * 9000, "Excessive depth"),
    "deep YAML": (".yaml", "[" * 100_000, "more than 12 deep"),
    "deep tables of YAML": (".yaml", "{a: " * 100_000, "more than 12 deep"),
    "deep lists of YAML": (".yaml", "- " * 400_000, "more than 12 deep"),
    "deep keys of YAML": (".yaml", "? " * 400_000, "more than 12 deep"),
    "deep TOML": (".toml", "a = " + "[" * 400_000, "more than 12 deep"),
    "deep inline tables": (".toml", "a = " + "{a = " * 100_000, "more than 12 deep"),
    "deep keys": (".toml", "a" + ".a" * 400_000 + " = 1", "more than 12 deep"),
    "deep quoted keys": (".toml", '"a=,"' + '."\\"."' * 100_000 + " = 1", "more than 12 deep"),
    "dots in a text": (".toml", f'title = "{"a." * 400}"\n# {"b." * 400}\n' + JOINT, "more than 12"),
    # too long
    "long name of a body": (".xml", mjcf(f'<body name="{MEGA}"><joint/></body>'), ACCEPTED),
    "long class": (".xml", mjcf(f'<body childclass="{MEGA}"/>'), "childclass: found unknown class"),
    "long name of a model": (".xml", mjcf(root=f'model="{MEGA}"'), ACCEPTED),
    "long element": (".xml", mjcf(f"<{MEGA}/>"), "a syntax error"),
    "long attribute": (".xml", mjcf(f'<body {MEGA}="1"/>'), "a syntax error"),
    "many attributes": (
        ".xml",
        mjcf(f"<body {' '.join(ATTRIBUTE.format(k) for k in range(60_000))}/>"),
        "line 1: found 60000 attributes; expected at most 200",
    ),
    "many numbers": (".xml", mjcf(f'<body pos="{"1 " * 400_000}"/>'), "MuJoCo refuses"),
    "long name of a robot": (".urdf", f'<robot name="{MEGA}"/>', "0 links that are no joint's"),
    "long name of a mechanism": (".toml", f'name = "{MEGA}"' + JOINT[10:], "found 'nnnn"),
    "long key": (".toml", f"{MEGA} = 1", "no table [bodies]"),
    "long expression": (".toml", JOINT + f"on_parent = {{ at = ['{'1+' * 400_000}1', 0, 0] }}", "800001 characters"),
    "long text in YAML": (".yaml", f"closed_loop: {MEGA}", "expected a list"),
    "long key in YAML": (".yaml", f"? {MEGA}\n: 1", "an unknown key 'nnn"),
    "long column": (".csv", f"time,{MEGA}\n0,0\n", "field larger than field limit"),
    "long cell": (".csv", f"time,A\n0,{MEGA}\n1,1\n", "expected"),
    "long line": (".csv", "time,A\n0" + ",0" * 400_000 + "\n", "400001 cells"),
    # too many
    "many bodies": (".xml", mjcf("<body><joint/></body>" * 900), "at most 1600"),
    "many fixed bodies": (".xml", mjcf("<body/>" * 20_000), "at most 1600"),
    "many loops": (".xml", mjcf(after='<connect body1="a" anchor="0 0 0"/>' * 12_000), "at most 1600"),
    "many sites": (".xml", mjcf("".join(f'<site name="s{k}"/>' for k in range(9000))), ACCEPTED),
    "many links": (".urdf", urdf(bodies="a" * 9000), "at most 8000"),
    "many joints": (
        ".urdf",
        '<robot name="r"><link name="l0"/>'
        + "".join(f'<link name="l{k + 1}"/>{hinge(f"j{k}", f"l{k}", f"l{k + 1}")}' for k in range(2000))
        + "</robot>",
        "2000 joints; expected at most 400",
    ),
    "many rods": (
        ".toml",
        'name = "l"\n[bodies]\na = {}\n[joints]\n'
        + "".join(f'j{k} = {{ kind = "rod", parent = "base", child = "a", length = 1 }}\n' for k in range(9000)),
        "9000; expected at most 400 joints",
    ),
    "a long chain": (".toml", chain(9000), "9000; expected at most 400 joints"),
    "many coordinates": (".toml", chain(300, "spherical"), "900 coordinates; expected at most 400"),
    "many limbs": (
        ".toml",
        limbs(1000, "".join(f'joints."j{{i}}q{k}" = {{ kind = "fixed" }}\n' for k in range(9000))),
        "1000 limbs of",
    ),
    "long limbs": (".toml", limbs(1000, f'symbols = {{ "a{{i}}" = "{MEGA}" }}'), "1000 limbs of"),
    "many parameters": (
        ".toml",
        JOINT + "[parameters]\n" + "".join(f'p{k} = "p{k + 1}"\n' for k in range(9000)) + "p9000 = 1",
        "expected",
    ),
    "many loops of YAML": (".yaml", "closed_loop:\n" + "- [a, d]\n" * 80_000, "expected at most 400"),
    "many keys of YAML": (".yaml", "".join(f"k{k}: 1\n" for k in range(60_000)), "an unknown key 'k0'"),
    # numbers
    "no number": (".xml", mjcf('<body pos="nan 0 0"/>'), "pos: found 'nan 0 0'; expected finite"),
    "endless": (".xml", mjcf('<body><joint ref="inf"/></body>'), "ref: found 'inf'; expected fin"),
    "beyond doubles": (".xml", mjcf('<body euler="1e999 0 0"/>'), "euler: found '1e999 0 0'"),
    "beyond sense": (".xml", mjcf('<body pos="1e308 0 0"/>'), "expected finite numbers below 1e+10"),
    "no size": (".xml", mjcf('<body quat="0 0 0 0"/>'), "a model that MuJoCo refuses"),
    "no axis": (".xml", mjcf('<body><joint axis="0 0 0"/></body>'), "a model that MuJoCo refuses"),
    "hexadecimal": (".xml", mjcf('<body pos="0x10 0 0"/>'), "pos: found '0x10 0 0'"),
    "home of no number": (
        ".xml",
        mjcf(before='<keyframe><key name="home" qpos="nan 1"/></keyframe>'),
        "qpos: found 'nan 1'; expected 2 finite numbers",
    ),
    "no Euler angles": (".xml", mjcf(before='<compiler eulerseq="x"/>'), "a model that MuJoCo refuses"),
    "infinite place": (".urdf", urdf(*ARM[:2], hinge("t", "c", "d", at="inf 0 0")), "3 finite numbers"),
    "huge place": (".urdf", urdf(*ARM[:2], hinge("t", "c", "d", at="1e999 0 0")), "3 finite numbers"),
    "huge whole number": (".toml", "a = " + "9" * 900_000, "a value that cannot be read"),
    "huge hexadecimal": (".toml", f"name = {HEX}", "a whole number of 80000 bits"),
    "huge in YAML": (".yaml", LOOP + f"home: {{j: {HEX}}}", "a number of 20002 characters"),
    "huge name in YAML": (".yaml", f"closed_loop: [[{HEX}, d]]", "a number of 20002 characters"),
    "sexagesimal": (".yaml", LOOP + f"home: {{j: 1{':59' * 300_000}}}", "a number of 900001 ch"),
    "NaN in YAML": (".yaml", LOOP + "home: {j: .nan}", "home.j: found nan; expected a number"),
    "infinity in YAML": (".yaml", LOOP + "home: {j: -.inf}", "home.j: found -inf; expected a num"),
    "NaN in a motion": (".csv", "time,A\n0,nan\n1,1\n", "line 2, column 'A': found 'nan'"),
    "infinite time": (".csv", "time,A\n0,1\n1e999,1\n", "column 'time': found '1e999'"),
    # encodings
    "UTF-16": (".xml", mjcf().encode("utf-16"), "not UTF-8"),
    "UTF-16 without a mark": (".urdf", urdf(*ARM).encode("utf-16-le"), "a syntax error"),
    "UTF-32": (".yaml", LOOP.encode("utf-32"), "not UTF-8"),
    "said to be UTF-16": (".xml", '<?xml version="1.0" encoding="utf-16"?>' + mjcf(), ACCEPTED),
    "said to be nonsense": (".xml", '<?xml version="1.0" encoding="x"?>' + mjcf(), ACCEPTED),
    "Latin-1": (".urdf", '<robot name="é"/>'.encode("latin-1"), "byte 0xe9, which is not UTF-8"),
    "bad UTF-8": (".toml", b'name = "\xc0\x80"', "byte 0xc0, which is not UTF-8"),
    "surrogate": (".yaml", b"a: \xed\xa0\x80", "byte 0xed, which is not UTF-8"),
    "UTF-16 motion": (".csv", MOTION.encode("utf-16"), "not UTF-8"),
    "mark in XML": (".xml", "\ufeff" + mjcf(), ACCEPTED),
    "mark in YAML": (".yaml", "\ufeff" + LOOP, ACCEPTED),
    "null in XML": (".xml", "<mujoco>\0</mujoco>", "a syntax error"),
    "null by its number": (".urdf", '<robot name="&#0;"/>', "a syntax error"),
    "null in YAML": (".yaml", "a: \0", "a syntax error"),
    "null in TOML": (".toml", 'name = "\0"', "a syntax error"),
    "null in a motion": (".csv", "time,A\n0,\0\n1,1\n", "expected"),
    "controls in names": (
        ".xml",
        mjcf('<body name="&#10;&#x202e;"><joint name="&#x1F600;"/></body>', root='model="&#x9b;[31m"'),
        "expected text without control characters",
    ),
    # YAML's own
    "alias": (".yaml", "a: &a [1]\nb: *a", "a reference (*name)"),
    "alias of itself": (".yaml", "&a [*a]", "a reference (*name)"),
    "billion laughs": (".yaml", "a: &a [x,x]\nb: &b [*a,*a]\nc: [*b,*b]", "a reference (*name)"),
    "object": (".yaml", "!!python/object/apply:os.system [true]", "could not determine a constr"),
    "tag": (".yaml", LOOP + "x: !foo 1", "could not determine a constructor"),
    "merge key": (".yaml", f"<<: {{{LOOP.replace(chr(10), ', ')}}}", ACCEPTED),
    "merge of a list": (".yaml", "<<: [1]\n" + LOOP, "a syntax error"),
    "date": (".yaml", LOOP + "home: {j: 2020-01-01}", "home.j: found datetime.date(2020, 1, 1)"),
    "no date": (".yaml", LOOP + "home: {j: 2020-13-45}", "a value that cannot be read"),
    "key twice": (".yaml", LOOP + LOOP, "line 3: found 'closed_loop' twice; expected one value"),
    "key twice within": (".yaml", LOOP + "home: {j: 1, j: 2}", "line 3: found 'j' twice"),
    "numbers as keys": (".yaml", LOOP + "1: 2\n~: 3\n[a]: 4", "expected"),
    "number as a joint": (".yaml", LOOP + "home: {1: 2}", "unknown joint 1; expected one of: j, k"),
    "list as a joint": (".yaml", LOOP + "name_mot: [[1]]", "unknown joint [1]; expected one of"),
    "table as a joint": (".yaml", LOOP + "name_mot: [{a: 1}]", "unknown joint {'a': 1}; expect"),
    "set": (".yaml", "!!set {a, b}", "expected a table of loops"),
    "truth for a number": (".yaml", LOOP + "home: {j: yes}", "home.j: found True; expected a num"),
    "two documents": (".yaml", "---\na: 1\n---\nb: 2", "a syntax error"),
    "tab": (".yaml", "\t- a", "a syntax error"),
    "version": (".yaml", "%YAML 9.9\n---\n" + LOOP, "a syntax error"),
    # joined to themselves, twice, in circles
    "circle of links": (".urdf", urdf(hinge("h", "a", "b"), hinge("k", "b", "a"), bodies="ab"), "0 links"),
    "link on itself": (".urdf", urdf(hinge("h", "b", "b"), bodies="ab"), "one rigid body"),
    "two parents": (".urdf", urdf(*ARM, hinge("u", "a", "d")), "link 'd': found two parents"),
    "name twice": (".urdf", urdf(*ARM, bodies="abcdd"), "two named 'd'; expected distinct"),
    "joint twice": (".urdf", urdf(ARM[0], ARM[0]), "expected"),
    "mimic of itself": (".urdf", urdf(hinge("s", "a", "b", "prismatic", mimic("s")), bodies="ab"), "mimics 's'"),
    "mimic of nothing": (".urdf", urdf(hinge("s", "a", "b", "prismatic", "<mimic/>"), bodies="ab"), "mimic: found unknown joint ''"),
    "mimics of one": (
        ".urdf",
        urdf(ARM[0], hinge("s", "b", "c", "prismatic", mimic("h")).replace("<mimic", '<axis xyz="1 0 0"/><mimic'),
             hinge("t", "c", "d", "prismatic", mimic("h"))),
        "a joint that already belongs to a screw",
    ),
    "screw of itself": (".xml", mjcf(after='<joint joint1="k" joint2="k"/>'), "a model that MuJoCo refuses"),
    "screw twice": (
        ".xml",
        mjcf(
            '<body name="c"><joint name="h"/><body name="d"><joint type="slide" name="s"/></body></body>',
            '<joint joint1="s" joint2="h"/><joint joint1="s" joint2="h"/>',
        ),
        "a joint that already belongs to a screw, 'h' or 's'; expected one coupling",
    ),
    "weld to itself": (".xml", mjcf(after='<weld body1="a" body2="a"/>'), "expected"),
    "connect to itself": (".xml", mjcf(after='<connect body1="a" body2="a" anchor="0 0 0"/>'), "expected"),
    "body twice": (".xml", mjcf('<body name="a"/>'), "a model that MuJoCo refuses"),
    "root on itself": (".toml", JOINT.replace('"base"', '"a"'), "'a' joined to itself"),
    "held only by rods": (
        ".toml",
        JOINT.replace('"revolute"', '"rod"').replace("child", "length = 1\nchild"),
        "a held only by rods",
    ),
    "variant of limbs alone": (
        ".toml",
        'variant_of = "gough-stewart"\n[joints.J]\nkind = "revolute"',
        "joints.J: found no key 'parent'",
    ),
    # nothing at all
    "empty XML": (".xml", "", "an empty file"),
    "empty URDF": (".urdf", " \n", "an empty file"),
    "empty YAML": (".yaml", "", "an empty file"),
    "YAML of comments": (".yaml", "#" * 900_000, "found None; expected a table of loops"),
    "empty motion": (".csv", "", "no text"),
    "another root": (".xml", "<svg/>", "found <svg>; expected <mujoco> (MJCF) or <robot> (URDF)"),
    "another name space": (".xml", '<mujoco xmlns="http://x"/>', "expected <mujoco> (MJCF) or <robot> (URDF)"),
    "no bodies": (".xml", "<mujoco/>", "no joints that move"),
    "no links": (".urdf", "<robot/>", "0 links"),
}  # fmt: skip


def encoded(content: str | bytes) -> bytes:
    return content if isinstance(content, bytes) else content.encode()


@pytest.mark.parametrize("case", CASES)
def test_a_hostile_file(case: str, read: Read) -> None:
    suffix, content, said = CASES[case]
    installed(suffix)
    found = read(suffix, encoded(content))
    if said is None:
        assert found is None
    else:
        assert found is not None
        assert said in found


# ---- at random

TOKENS = [
    *(
        "nan",
        "inf",
        "-1",
        "0",
        "1e999",
        "1e308",
        "1e-320",
        "9" * 400,
        "0x10",
        '"',
        "'",
        "<",
        ">",
        "/>",
    ),
    *(
        "]]>",
        "&",
        "&#0;",
        "<!--",
        "<![CDATA[",
        "\0",
        "\n",
        "\t",
        "{",
        "}",
        "[",
        "]",
        "=",
        ",",
        ":",
        "- ",
    ),
    *(
        "*a",
        "&a",
        "!!python/name:os.system",
        "<<: ",
        "{i}",
        "mimic",
        "weld",
        "free",
        "base",
        "world",
    ),
    *("é", "\u202e", "\U0001f600", " ", "#", '"""', "true", "~", "2020-01-01", "é" * 300),
]


@st.composite
def spoilt(draw: st.DrawFn, texts: list[str]) -> bytes:
    """A sound file with some pieces cut out, doubled, moved, or replaced by something nasty."""
    content = draw(st.sampled_from(texts)).encode()
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(content)))
        stop = start + draw(st.sampled_from([0, 1, 2, 5, 20, 200]))
        piece = content[start:stop]
        words = st.sampled_from(TOKENS).map(str.encode)
        new = draw(st.one_of(words, st.binary(max_size=4), st.just(piece * 2), st.just(b"")))
        content = content[:start] + new + content[stop:]
    return content


@pytest.mark.parametrize("suffix", SUFFIXES)
@quick
@given(data=st.data())
def test_a_spoilt_file_is_read_or_refused(
    suffix: str, data: st.DataObject, read: Read, good: dict[str, list[str]]
) -> None:
    installed(suffix)
    read(suffix, data.draw(spoilt(good[suffix])))


number = st.sampled_from(
    ["0", "1", "-1", "0.5", "90", "1e-9", "1e9"] * 3 + ["nan", "inf", "1e300", "x"]
)
name = st.sampled_from(["a", "b", "c", "d", "e", "j", "k", "world", "j.1", "j.2", "j.3", "", "é"])
SIZES = {
    **dict.fromkeys("pos euler axis anchor xyz rpy zaxis".split(), 3),
    **{"quat": 4, "axisangle": 4, "xyaxes": 6, "range": 2, "ref": 1, "relpose": 7, "polycoef": 5},
    **{"qpos": 2, "lower": 1, "upper": 1, "multiplier": 1, "torquescale": 1, "fromto": 6},
}
CHOICES = {
    **{key: ["true", "false", "auto", "2"] for key in ("limited", "active", "autolimits")},
    "type": "hinge slide ball revolute continuous prismatic fixed floating planar spherical x".split(),
    "angle": ["radian", "degree", "turns"],
    "eulerseq": ["xyz", "zyx", "XYZ", "xyx", "x", "abc"],
}
BELONGING = {
    "body": "name pos euler quat childclass axisangle xyaxes zaxis",
    "frame": "pos euler childclass",
    "joint": "name type pos axis range limited ref class joint1 joint2 polycoef",
    "freejoint": "name",
    "site": "name pos zaxis fromto",
    "connect": "name body1 body2 anchor site1 site2 active",
    "weld": "name body1 body2 anchor relpose torquescale site1 site2",
    "compiler": "angle eulerseq autolimits",
    "key": "name qpos",
    "link": "name",
    "loop": "name type",
    "loop_joint": "name type",
    **dict.fromkeys("parent child link1 link2 predecessor successor".split(), "link xyz rpy"),
    "origin": "xyz rpy",
    "limit": "lower upper",
    "mimic": "joint multiplier",
    "robot": "name",
}


@st.composite
def attribute(draw: st.DrawFn, key: str) -> str:
    if key in CHOICES:
        return draw(st.sampled_from(CHOICES[key]))
    if key not in SIZES:
        return draw(name)
    size = SIZES[key] + draw(st.sampled_from([0, 0, 0, 0, 0, 0, 0, 1, -1]))
    return " ".join(draw(number) for _ in range(size))


WITHIN = {
    "mujoco": "compiler default worldbody worldbody worldbody equality keyframe actuator asset",
    "worldbody": "body frame site joint geom",
    "body": "body body joint joint freejoint frame site geom inertial",
    "frame": "body joint frame",
    "default": "default joint site equality",
    "equality": "connect weld joint tendon",
    "keyframe": "key",
    "actuator": "motor",
    "robot": "link link joint joint loop loop_joint coupling",
    "joint": "parent child origin axis limit mimic",
    "loop": "predecessor successor axis",
    "loop_joint": "link1 link2 axis",
    "predecessor": "origin",
    "successor": "origin",
}


@st.composite
def element(draw: st.DrawFn, tag: str, depth: int = 0) -> str:
    """An element with attributes and elements that might belong there."""
    known = BELONGING.get(tag, "model").split()
    keys = draw(st.lists(st.sampled_from(known), max_size=4, unique=True))
    attributes = "".join(f' {key}="{draw(attribute(key))}"' for key in keys)
    inside = ""
    if depth < 5 and tag in WITHIN:
        tags = draw(st.lists(st.sampled_from(WITHIN[tag].split()), max_size=4))
        inside = "".join(draw(element(each, depth + 1)) for each in tags)
    return f"<{tag}{attributes}>{inside}</{tag}>"


@pytest.mark.parametrize(("suffix", "root"), [(".xml", "mujoco"), (".urdf", "robot")])
@quick
@given(data=st.data())
def test_elements_at_random_are_read_or_refused(
    suffix: str, root: str, data: st.DataObject, read: Read
) -> None:
    installed(suffix)
    read(suffix, data.draw(element(root)).encode())


@quick
@given(
    st.dictionaries(
        st.sampled_from(
            "closures closed_loop type name_mot independent dependent home joint_name joint_type".split()
        ),
        st.recursive(
            st.sampled_from(["a", "b", "d", "j", "k", "6d", "3d", "SPHERICAL", "UJOINT_XY"])
            | st.none() | st.booleans() | st.integers() | st.floats() | st.dates(),
            lambda inner: st.lists(inner, max_size=4)
            | st.dictionaries(
                st.sampled_from(["link_a", "link_b", "point", "axis", "j", "k"]) | st.integers(),
                inner,
                max_size=4,
            ),
            max_leaves=12,
        ),
        max_size=4,
    )
)  # fmt: skip
def test_tables_of_loops_at_random_are_read_or_refused(read: Read, told: dict[str, object]) -> None:
    installed(".yaml")
    import yaml

    read(".yaml", yaml.safe_dump(told).encode())


@quick
@given(
    st.lists(
        st.lists(
            st.sampled_from(["time", "A", "A.velocity", "A [deg]", "status", "0", "1", "2", "nan"])
            | st.sampled_from(["1e999", '"', '""', "x", "", "٣", "1_0", "0x1", " 1 ", "1" * 400]),
            max_size=4,
        ).map(",".join),
        max_size=8,
    )
)
def test_tables_of_motions_at_random_are_read_or_refused(read: Read, rows: list[str]) -> None:
    read(".csv", "\n".join(rows).encode())


# ---- what is opened, and how much memory it takes

WATCHED = """
import difflib, json, os, resource, sys
from pathlib import Path
import parakin

folder, catalogue = Path(sys.argv[1]), Path(parakin.__file__).with_name("catalogue")
os.chdir(folder)
read = {}


def reading(path):
    try:
        if path.suffix == ".yaml":
            parakin.load(folder / "tree.urdf", loops=path)
        else:
            parakin.load(path)
    except parakin.ParakinError:
        pass


for path in sorted(folder.glob("good.*")):  # what is imported opens files of its own
    reading(path)
opened = []
sys.addaudithook(lambda event, given: opened.append(str(given[0])) if event == "open" else None)
begun = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
for path in sorted(folder.glob("case*")):
    opened.clear()
    reading(path)
    others = set(opened) - {str(path), str(folder / "tree.urdf")}
    others = {name for name in others if Path(name).parent != catalogue}  # of variants
    if others or (path.suffix != ".yaml" and not opened):
        read[path.name] = sorted(others)
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(json.dumps({"others": read, "kilobytes": peak - begun}))
"""


def hostile_folder(folder: Path) -> Iterator[Path]:
    """Every case as a file, with those that are sound."""
    (folder / "tree.urdf").write_text(TREE)
    for suffix, text in ((".toml", LEG), (".xml", mjcf()), (".urdf", TREE), (".yaml", LOOP)):
        (folder / f"good{suffix}").write_text(text)
    for number, (suffix, content, _) in enumerate(CASES.values()):
        if suffix != ".csv":
            path = folder / f"case{number}{suffix}"
            path.write_bytes(encoded(content))
            yield path


def test_no_other_file_is_opened_and_memory_is_bounded(tmp_path: Path) -> None:
    pytest.importorskip("resource")
    for suffix in SUFFIXES:
        installed(suffix)
    before = set(hostile_folder(tmp_path))
    done = subprocess.run(
        [sys.executable, "-c", WATCHED, str(tmp_path)],
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
    )
    assert done.stderr == ""
    assert done.returncode == 0
    found = json.loads(done.stdout)
    assert found["others"] == {}
    assert found["kilobytes"] < 400_000
    there = {path for path in tmp_path.iterdir() if path.name.startswith("case")}
    assert there == before
    assert not list(tmp_path.glob("*.TXT"))  # MuJoCo writes down what it warns of


# ---- as far as the report goes


def test_a_check_of_one_of_the_largest_mechanisms_ends(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from parakin.cli.main import main

    count = 133
    text = chain(count, "spherical")
    text = text.replace(" }\n", ", on_parent = { at = [0.1, 0, 0.05], axis = [1, 1, 0] } }\n")
    end = f'parent = "base", child = "b{count - 1}", on_parent = {{ at = [1000, 0, 0] }}'
    (tmp_path / "large.toml").write_text(text + f'end = {{ kind = "prismatic", {end} }}\n')
    begun = time.process_time()
    assert main(["check", str(tmp_path / "large.toml")]) == 2
    assert time.process_time() - begun < 60.0  # of processor time, some ten seconds of it
    assert "cannot be assembled" in capsys.readouterr().err
