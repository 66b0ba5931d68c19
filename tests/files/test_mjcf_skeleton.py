"""The skeleton of a MuJoCo model: what is kept, on which line, and what is refused before."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest

from parakin.errors import InputError
from parakin.files.mjcf_skeleton import check_mjcf, skeleton, used
from parakin.files.parsing import parse_xml
from parakin.files.vocabulary import not_used

mujoco = pytest.importorskip("mujoco")
pytest.importorskip("lxml")


def checked(text: str) -> None:
    check_mjcf(parse_xml(text, "f"), mujoco.mj_printSchema(False, False), "f")


MODEL = """<mujoco model="m">
<default><site pos="1 2 3" type="box" size="1 1 1"/><equality active="false"/></default>
<asset><mesh name="m" file="x.stl"/></asset>

<worldbody><geom type="plane" size="1 1 1"/>
<body name="a" user="1"><joint name="j" damping="1" ref="0.5"/>
<site name="s" rgba="1 0 0 1"/></body></worldbody>
<equality><joint joint1="j" polycoef="0.1"/></equality>
<option timestep="1"><flag equality="disable" contact="disable"/></option>
</mujoco>"""


def test_what_mechanics_needs_is_kept_and_stays_on_its_line() -> None:
    text = skeleton(parse_xml(MODEL, "f"), "f")
    made = ElementTree.fromstring(text)
    site = made.find("default/site")
    assert site is not None
    assert site.attrib == {"pos": "1 2 3", "type": "box", "size": "1 1 1"}
    active = made.find("default/equality")
    assert active is not None
    assert active.attrib == {"active": "false"}
    joint = made.find("worldbody/body/joint")
    assert joint is not None
    assert joint.attrib == {"name": "j", "ref": "0.5", "damping": "1"}
    flag = made.find("option/flag")
    assert flag is not None
    assert flag.attrib == {"equality": "disable"}
    assert made.find("asset") is None
    assert made.find(".//geom") is None
    lines = MODEL.splitlines()
    for number, line in enumerate(text.splitlines()):
        for element in ("<default>", "<body ", "<site name", "<equality>", "<flag"):
            if element in line:
                assert element in lines[number], number + 1


def test_what_is_not_used_is_told() -> None:
    said = not_used(parse_xml(MODEL, "f"), used)
    assert said == " Not used: <asset>, <option>."


def body(inside: str = "", attributes: str = "", after: str = "", before: str = "") -> str:
    """A model with a hinge `j` on a body `a`."""
    own = f'<body name="a"><joint name="j" {attributes}/></body>'
    return f"<mujoco>{before}<worldbody>\n{own}{inside}</worldbody>\n{after}</mujoco>"


REFUSED = {
    "element": (body(after="<equalty/>"), "line 3: found <equalty> in <mujoco>"),
    "attribute": (body(attributes='axs="1 0 0"'), "line 2: found an attribute 'axs' of <joint>"),
    "in a frame": (body('<frame ps="1"/>'), "'ps' of <frame>; expected one of: axisangle"),
    "class": (
        body(attributes='class="nar"'),
        "class: found unknown class 'nar'; expected one of: main",
    ),
    "joint": (
        body(after='<equality><joint joint1="k"/></equality>'),
        "line 3: joint1: found unknown joint 'k'; expected one of: j",
    ),
    "body": (
        body(after='<equality><weld body1="b"/></equality>'),
        "body1: found unknown body 'b'; expected one of: a, world",
    ),
    "tendon": (
        body(after='<equality><tendon tendon1="t"/></equality>'),
        "found an equality of <tendon>; expected connect, weld, or joint",
    ),
    "flex": (body(after='<equality><flex flex="f"/></equality>'), "found an equality of <flex>"),
    "mocap": (body('<body mocap="true"/>'), "line 2: found mocap='true'"),
    "mesh": (body('<site type="mesh" mesh="m"/>'), "found a site placed by a mesh"),
    "aligned": (body('<body><freejoint align="true"/></body>'), "a free joint with align='true'"),
    "all aligned": (
        body('<body><joint type="free"/></body>', before='<compiler alignfree="true"/>'),
        "a free joint with align='true'",
    ),
    "include": (body('<include file="x"/>'), "found <include>; expected one file"),
    "replicate": (body('<replicate count="2"/>'), "<replicate>; expected bodies written out"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_not_read_is_refused(case: str) -> None:
    text, said = REFUSED[case]
    with pytest.raises(InputError) as refusal:
        checked(text)
    assert said in str(refusal.value)
    assert refusal.value.place.startswith("f, line ")


def test_what_looks_alike_and_is_harmless_is_read() -> None:
    checked(body(after='<equality><tendon tendon1="t" active="false"/></equality>'))
    checked(body('<body><freejoint align="true"/><body/></body>'))  # with a body on it, as MuJoCo
    aligned = '<compiler alignfree="true"/>'
    checked(body('<body><freejoint align="false"/></body>', before=aligned))
    checked(body('<body childclass="main"/>'))


@pytest.mark.parametrize(
    ("attributes", "said"),
    [
        (
            'type="hing"',
            "type: found 'hing'; expected one of: ball, free, hinge, slide; did you mean 'h",
        ),
        ('limited="yes"', "limited: found 'yes'; expected one of: auto, false, true"),
        ('pos="1_0 0 0"', "pos: found '1_0 0 0'; expected finite numbers"),
        ('pos="١ 0 0"', "pos: found '١ 0 0'; expected finite numbers"),
        ('ref="0x10"', "ref: found '0x10'; expected finite numbers"),
    ],
)
def test_values_that_are_none_of_mjcf_are_refused(attributes: str, said: str) -> None:
    with pytest.raises(InputError) as refusal:
        skeleton(parse_xml(body(attributes=attributes), "f"), "f")
    assert f"f, line 2: {said}" in str(refusal.value)
