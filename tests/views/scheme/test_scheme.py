"""Schemes: every joint has its symbol, and text is only text."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from parakin.cli.main import main
from parakin.files.reading import catalogue, load
from parakin.model.bodies import Body, Frame
from parakin.model.evaluation import graph_of
from parakin.model.mechanism import Joint, Mechanism
from parakin.views.scheme.scheme import save, scheme

SVG = "{http://www.w3.org/2000/svg}"


def drawn(mechanism: Mechanism, path: Path) -> ElementTree.Element:
    save(scheme(graph_of(mechanism)), path)
    return ElementTree.parse(path).getroot()


def texts(root: ElementTree.Element) -> list[str]:
    return ["".join(text.itertext()).strip() for text in root.iter(f"{SVG}text")]


def every_kind() -> Mechanism:
    """A chain with a joint of each kind, held up at its end by a rod."""
    kinds = ("revolute", "prismatic", "cylindrical", "helical", "universal", "spherical", "planar")
    names = ["base", *(f"link{k}" for k, _ in enumerate(kinds))]
    joints = [
        Joint(
            name=f"J{k}",
            kind=kind,  # type: ignore[arg-type]
            parent=names[k],
            child=names[k + 1],
            on_parent=Frame(at=(0.3, 0.1 * k, 0.2), axis=(0.2, 1.0, 0.3)),
            pitch="5 mm" if kind == "helical" else None,
        )
        for k, kind in enumerate(kinds)
    ]
    rod = Joint(
        name="R",
        kind="rod",
        parent="base",
        child=names[-1],
        on_parent=Frame(at=(1.5, 0, 0)),
        length=1.5,
    )
    return Mechanism(
        name="zoo", bodies=tuple(Body(name=n) for n in names[1:]), joints=(*joints, rod)
    )


@pytest.mark.parametrize("name", catalogue())
def test_a_scheme_has_a_symbol_for_each_joint_of_each_kind(name: str, tmp_path: Path) -> None:
    mechanism = load(name)
    root = drawn(mechanism, tmp_path / "scheme.svg")
    ids = [element.get("id", "") for element in root.iter()]
    found = Counter(m[1] for i in ids if (m := re.fullmatch(r"([a-z]+)-\d+", i)))
    assert found == Counter(joint.kind for joint in mechanism.joints)
    said = texts(root)
    for joint in mechanism.joints:
        assert joint.name in said


def test_every_kind_of_joint_has_a_symbol(tmp_path: Path) -> None:
    mechanism = every_kind()
    ids = [e.get("id", "") for e in drawn(mechanism, tmp_path / "zoo.svg").iter()]
    for number, joint in enumerate(mechanism.joints):
        assert ids.count(f"{joint.kind}-{number}") == 1


@pytest.mark.parametrize("kind", ["revolute", "spherical", "prismatic", "fixed"])
def test_a_mechanism_without_extent_is_drawn(kind: str, tmp_path: Path) -> None:
    joint = Joint(name="A", kind=kind, parent="base", child="a")  # type: ignore[arg-type]
    alone = Mechanism(name="alone", bodies=(Body(name="a"),), joints=(joint,))
    root = drawn(alone, tmp_path / "alone.svg")
    numbers = re.findall(r"[-\d.]+", " ".join(e.get("d", "") for e in root.iter(f"{SVG}path")))
    assert np.isfinite([float(n) for n in numbers]).all()
    assert any(e.get("id") == f"{kind}-0" for e in root.iter()) == (kind != "fixed")


def test_a_planar_mechanism_is_seen_along_its_axis(tmp_path: Path) -> None:
    """Distances between hinges in the drawing are as the lengths of the links."""
    root = drawn(load("four-bar"), tmp_path / "four-bar.svg")
    middle = {}
    for number in range(4):
        (path,) = next(e for e in root.iter() if e.get("id") == f"revolute-{number}")
        numbers = np.array([float(x) for x in re.findall(r"-?[\d.]+", path.get("d", ""))])
        places = numbers.reshape(-1, 2)
        middle["ABCD"[number]] = (places.min(axis=0) + places.max(axis=0)) / 2
    sides = [np.linalg.norm(middle[a] - middle[b]) for a, b in ("AB", "BC", "CD", "DA")]
    np.testing.assert_allclose(np.array(sides) / sides[0], [1, 3, 2, 2.5], rtol=1e-4)


def test_each_parameter_is_a_dimension_once_and_in_the_table(tmp_path: Path) -> None:
    said = texts(drawn(load("four-bar"), tmp_path / "four-bar.svg"))
    for name, value in (("a", "40 mm"), ("b", "120 mm"), ("c", "80 mm"), ("d", "100 mm")):
        assert said.count(name) == 1
        assert said.count(f"{name} = {value}") == 1


def test_titles_are_text_and_not_markup(tmp_path: Path) -> None:
    title = r"<script>alert(1)</script> & $\alpha$ of $x"
    mechanism = load("four-bar").model_copy(update={"title": title, "source": "$_$ <b>"})
    root = drawn(mechanism, tmp_path / "hostile.svg")
    said = texts(root)
    assert title in said
    assert "$_$ <b>" in said
    assert not list(root.iter(f"{SVG}script"))


@pytest.mark.parametrize(
    ("suffix", "magic"), [(".svg", b"<?xml"), (".pdf", b"%PDF"), (".png", b"\x89PNG")]
)
def test_draw_writes_a_scheme(
    suffix: str, magic: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / f"scheme{suffix}"
    assert main(["draw", "slider-crank", "-o", str(path), "--set", "a=45 mm"]) == 0
    assert capsys.readouterr().out == f"wrote {path}\n"
    assert path.read_bytes().startswith(magic)
    if suffix == ".svg":
        assert "a = 45 mm" in texts(ElementTree.parse(path).getroot())


def test_the_same_mechanism_gives_the_same_file(tmp_path: Path) -> None:
    paths = [tmp_path / name for name in ("one.svg", "two.svg")]
    for path in paths:
        assert main(["draw", "four-bar", "-o", str(path)]) == 0
    assert paths[0].read_bytes() == paths[1].read_bytes()


def test_draw_refuses_other_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "scheme.dxf"
    assert main(["draw", "four-bar", "-o", str(path)]) == 2
    said = capsys.readouterr().err
    place, _, expected = said.partition("; expected one of: .pdf, .png, .svg")
    assert (place, expected) == (
        f"error: {path}: found the suffix '.dxf'",
        "; did you mean '.pdf'?\n",
    )
    assert not path.exists()
    nowhere = tmp_path / "no" / "scheme.svg"
    assert main(["draw", "four-bar", "-o", str(nowhere)]) == 2
    assert "expected a file that can be written" in capsys.readouterr().err
