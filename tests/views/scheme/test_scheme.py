"""Schemes: every joint has its symbol, dimensions are what they say, and labels can be read."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import closed_form
import numpy as np
import pytest

from parakin.cli.main import main
from parakin.files.reading import catalogue, load
from parakin.model.evaluation import graph_of
from parakin.model.mechanism import Body, Frame, Joint, Mechanism
from parakin.views.scheme import symbols
from parakin.views.scheme.dimensioning import lengths, parameters
from parakin.views.scheme.lettering import Label, Obstacles, placed
from parakin.views.scheme.scheme import save, scheme
from parakin.views.scheme.symbols import Sight
from parakin.views.solids.drawing import drawing_of

SVG = "{http://www.w3.org/2000/svg}"
FRONT = Sight(np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), np.array([0.0, 0.0, 1.0]))
X, Y, Z = np.eye(3)
HERE = np.zeros(2)


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


# ---- every joint has its symbol


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


def test_a_bush_is_a_circle_along_its_axis_and_a_rectangle_from_the_side() -> None:
    (circle,) = symbols.sleeve(FRONT, HERE, Z, half=5.0, r=3.0)
    np.testing.assert_allclose(np.linalg.norm(circle.points, axis=1), 3.0, rtol=1e-12)
    (bush,) = symbols.sleeve(FRONT, HERE, X, half=5.0, r=3.0)
    np.testing.assert_allclose(np.abs(bush.points[:, 0]), 5.0, rtol=1e-12)
    assert np.ptp(bush.points[:, 1]) == pytest.approx(6.0)


def test_a_bush_seen_at_an_angle_shows_its_rim_as_an_ellipse() -> None:
    tilt = np.pi / 6
    axis = np.cos(tilt) * X + np.sin(tilt) * Z
    outline, rim = symbols.sleeve(FRONT, HERE, axis, half=5.0, r=3.0)
    assert np.ptp(rim.points[:, 1]) == pytest.approx(2 * 3.0, rel=1e-2)
    assert np.ptp(rim.points[:, 0]) == pytest.approx(2 * 3.0 * np.sin(tilt), rel=1e-2)
    length = 2 * (5.0 * np.cos(tilt) + 3.0 * np.sin(tilt))
    assert np.ptp(outline.points[:, 0]) == pytest.approx(length, rel=1e-2)


def test_a_sliding_sleeve_is_a_rectangle_from_the_side_and_a_square_end_on() -> None:
    (face,) = symbols.box(FRONT, HERE, X, half=5.0, r=3.0)
    np.testing.assert_allclose(np.ptp(face.points, axis=0), [10.0, 6.0])
    (face,) = symbols.box(FRONT, HERE, Z, half=5.0, r=3.0)
    np.testing.assert_allclose(np.ptp(face.points, axis=0), [6.0, 6.0])
    oblique = symbols.box(FRONT, HERE, (X + Z) / np.sqrt(2), half=5.0, r=3.0)
    assert len(oblique) == 2


def test_plates_are_parallel_lines_from_the_side() -> None:
    lower, upper = symbols.plates(FRONT, HERE, Y, s=4.0)
    assert np.ptp(lower.points[:, 1]) == pytest.approx(0, abs=1e-12)
    apart = upper.points[:, 1].mean() - lower.points[:, 1].mean()
    assert abs(apart) == pytest.approx(0.9 * 4.0)


def test_the_forks_of_a_universal_joint_open_to_their_bodies() -> None:
    strokes = symbols.cross(FRONT, HERE, (X, Z), child=Y, s=4.0)
    parent, child = strokes[0].points, strokes[2].points
    assert parent[:, 1].min() < -4.0 < parent[:, 1].max() <= 1e-9
    assert child[:, 1].max() > 4.0 > child[:, 1].min() >= -1e-9


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


# ---- dimensions


def test_dimensions_of_the_flight_simulator_are_the_papers() -> None:
    found = lengths(drawing_of(graph_of(load("flight-simulator"))))
    exact = closed_form.Parameters()
    shown = {"d1", "d2", "d3", "d4", "d5", "l1", "l2", "l3", "l4", "b", "h", "s_A", "s_B", "s_C"}
    assert shown <= set(found)
    for name, places in found.items():
        for length in places:
            apart = np.linalg.norm(length.end - length.start)
            assert apart == pytest.approx(float(getattr(exact, name)), abs=1e-12)


def test_equal_lengths_of_different_names_are_not_taken_for_one_another() -> None:
    """s_B = s_C = 0.33 m: legs B and C stand on either side of the median plane, z = 0."""
    found = lengths(drawing_of(graph_of(load("flight-simulator"))))
    for name, side in (("s_B", 1), ("s_C", -1)):
        assert found[name]
        assert all(side * length.start[2] > 0 for length in found[name])
    equal = load("four-bar").with_parameters({"b": "80 mm", "d": "100 mm"})
    found = lengths(drawing_of(graph_of(equal)))
    b, c = ({tuple(np.round((p.start + p.end) / 2, 9)) for p in found[name]} for name in ("b", "c"))
    assert b
    assert c
    assert not b & c


def test_each_parameter_is_a_dimension_once_and_in_the_table(tmp_path: Path) -> None:
    said = texts(drawn(load("four-bar"), tmp_path / "four-bar.svg"))
    for name, value in (("a", "40 mm"), ("b", "120 mm"), ("c", "80 mm"), ("d", "100 mm")):
        assert said.count(name) == 1
        assert said.count(f"{name} = {value}") == 1


def test_parameters_are_told_in_millimetres_and_degrees() -> None:
    told = {p.name: (p.value, p.as_given) for p in parameters(load("gough-stewart"))}
    assert told["r_base"] == ("1200 mm", "1.2 m")
    assert told["a_base"] == ("20°", "20 deg")
    assert told["leg3_base"] == ("110°", "120 deg - a_base/2")
    bare = load("four-bar").with_parameters({"a": 0.04})
    assert {p.name: p.value for p in parameters(bare)}["a"] == "0.04"


# ---- labels


@pytest.mark.parametrize("name", catalogue())
def test_labels_do_not_cover_one_another(name: str) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = scheme(graph_of(load(name)), table=False)
    renderer = FigureCanvasAgg(figure).get_renderer()  # type: ignore[no-untyped-call]
    boxes = [text.get_window_extent(renderer) for text in figure.axes[0].texts]
    width, height = figure.bbox.size
    for k, a in enumerate(boxes):
        assert a.x0 >= 0
        assert a.y0 >= 0
        assert a.x1 <= width
        assert a.y1 <= height
        for b in boxes[:k]:
            common = max(0.0, min(a.x1, b.x1) - max(a.x0, b.x0))
            common *= max(0.0, min(a.y1, b.y1) - max(a.y0, b.y0))
            assert common < 0.15 * min(a.width * a.height, b.width * b.height)


def test_a_label_makes_way_for_a_line() -> None:
    label = Label("here", np.array([100.0, 100.0]), 4.0, "black", size=8.0)
    ((_, free),) = placed([label], Obstacles(), (200, 200))
    taken = Obstacles()
    taken.line(free + np.array([[-30.0, 0.0], [30.0, 0.0]]))
    ((_, moved),) = placed([label], taken, (200, 200))
    assert abs(moved[1] - free[1]) > 4.0


# ---- text and files


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
