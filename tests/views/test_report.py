"""The page about a motion: its numbers, that it stands alone, and that nothing in it can run."""

from __future__ import annotations

import re
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path

import closed_form
import numpy as np
import pytest

import parakin
from parakin import Status
from parakin.cli.main import main

VOID = {"meta", "br", "link", "img", "input", "hr"}
HOSTILE = "<script>alert('x')</script><img src=x onerror=alert(1)>&\"$title"

# A crank-rocker whose crank swings; hostile wherever a file may say what it likes.
FOUR_BAR = """
name = "four-bar-of-ours"
variant_of = "four-bar"
title = '''{hostile}'''
source = '''{hostile}'''
notes = '''{hostile}'''
{more}
[motions.rock]
title = '''{hostile}'''
duration = "1 s"
rate = 1000
laws = {{ A = {{ law = "sine", amplitude = "30 deg", frequency = "1 Hz" }} }}
"""


class Page(HTMLParser):
    """Tables as rows of cells, tags, and whether every tag is closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tables: list[list[list[str]]] = []
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words = ""
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append([])
        elif tag in ("td", "th"):
            self.tables[-1][-1].append("")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if "style" in self.open:
            return
        self.words += data
        if {"td", "th"} & set(self.open):
            self.tables[-1][-1][-1] += data

    def table(self, heading: str) -> dict[str, dict[str, str]]:
        """Rows by their first cell of the first table with a column `heading`."""
        rows = next(t for t in self.tables if heading in t[0])
        return {row[0]: dict(zip(rows[0], row, strict=True)) for row in rows[1:]}


def number(cell: str) -> float:
    match = re.match(r"-?[\d.]+", cell)
    assert match
    return float(match[0])


def time(cell: str) -> float:
    return float(cell.rpartition("at ")[2].removesuffix(" s"))


def report(tmp_path: Path, *arguments: str, expected: int = 0) -> tuple[str, Page]:
    path = tmp_path / "page.html"
    assert main(["report", *arguments, "-o", str(path)]) == expected
    text = path.read_text("utf-8")
    return text, Page(text)


@pytest.fixture(scope="module")
def general(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Page]:
    return report(tmp_path_factory.mktemp("page"), "flight-simulator", "general")


Variant = Callable[..., str]


@pytest.fixture
def four_bar(tmp_path: Path) -> Variant:
    def write(hostile: str = "ours", more: str = "") -> str:
        path = tmp_path / "four-bar.toml"
        path.write_text(FOUR_BAR.format(hostile=hostile, more=more))
        return str(path)

    return write


# ---- its numbers


def test_extremes_of_the_sliders_are_those_of_the_closed_form(general: tuple[str, Page]) -> None:
    exact = {"A2": [], "B3": [], "C3": []}  # type: dict[str, list[list[float]]]
    grid = np.arange(0, 3001, 10)
    for i in grid:
        y, yd, ydd = closed_form.example(3, closed_form.MP.mpf(int(i)) / 1000)
        at = closed_form.state(closed_form.Parameters(), y, yd, ydd)
        for name, rows in exact.items():
            rows.append([1e3 * float(v) for v in at[name]])
    shown = general[1].table("peak speed")
    assert set(shown) == set(exact)
    for name, rows in exact.items():
        values = np.array(rows)
        row = shown[name]
        low, high = values[:, 0].min(), values[:, 0].max()
        near = 2e-3  # [mm]: the grid of 10 ms misses an extreme by less
        assert number(row["least"]) == pytest.approx(low, abs=near)
        assert number(row["greatest"]) == pytest.approx(high, abs=near)
        assert number(row["stroke"]) == pytest.approx(high - low, abs=2 * near)
        speed, push = np.abs(values[:, 1]), np.abs(values[:, 2])
        assert number(row["peak speed"]) == pytest.approx(speed.max(), rel=1e-4)
        assert number(row["peak acceleration"]) == pytest.approx(push.max(), rel=1e-4)
        for column, curve in (
            ("least", -values[:, 0]),
            ("greatest", values[:, 0]),
            ("peak speed", speed),
            ("peak acceleration", push),
        ):
            assert time(row[column]) == pytest.approx(grid[curve.argmax()] / 1e3, abs=0.011)


def test_extremes_are_marked_on_the_curves(general: tuple[str, Page]) -> None:
    text, page = general
    words = (t.strip() for t in re.findall(r"<text[^>]*>([^<]*)</text>", text))
    labels = np.array([float(w) for w in words if re.fullmatch(r"-?\d+(\.\d+)?", w)])
    for row in page.table("peak speed").values():
        for column in ("least", "greatest", "peak acceleration"):
            value = number(row[column])
            apart = np.abs(np.abs(labels) - abs(value)).min()
            assert apart <= 5e-4 * (1 + abs(value))  # three decimals there, four digits here


def test_cones_and_joints_outside_the_tree_are_told(general: tuple[str, Page]) -> None:
    rows = next(t for t in general[1].tables if len(t) > 15 and "stroke" in t[0])
    names = {row[0] for row in rows}
    assert {"B4.cone", "C4.cone", "B4.1", "E2", "platform.psi"} <= names


def test_the_page_says_what_check_says(
    general: tuple[str, Page], capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    assert main(["check", "flight-simulator"]) == 0
    said = capsys.readouterr().out.partition("Mobility\n")[2].partition("\n\n")[0]
    assert "Grübler-Kutzbach: -3" in said
    for line in said.splitlines():
        assert line.strip() in general[1].words


def test_where_it_came_from_is_told(general: tuple[str, Page]) -> None:
    words = general[1].words
    assert "parakin report flight-simulator general -o " in words
    assert parakin.__version__ in words
    assert "Example 3, general evolution (Figs. 9-11)" in words
    assert re.search(r"20\d\d-\d\d-\d\d \d\d:\d\d:\d\d", words)
    assert "3 s, 3,001 samples; driven: platform.x, platform.y, platform.phi" in words


# ---- limits and flags


@pytest.mark.parametrize(("high", "word", "code"), [(75, "ok", 0), (65, "exceeded", 1)])
def test_limits_are_kept_or_exceeded(
    high: float, word: str, code: int, tmp_path: Path, four_bar: Variant
) -> None:
    """The crank swings by 30 degrees to either side of 40."""
    path = four_bar(more=f'limits = {{ A = ["5 deg", "{high} deg"] }}')
    _, page = report(tmp_path, path, "rock", expected=code)
    row = page.table("peak speed")["A"]
    assert row["limits"] == f"5 .. {high}°"
    assert number(row["margin"]) == pytest.approx(min(10 - 5, high - 70), abs=1e-3)
    assert row["kept"] == word
    assert number(row["peak speed"]) == pytest.approx(30 * 2 * np.pi, abs=1e-3)
    assert number(row["peak acceleration"]) == pytest.approx(30 * (2 * np.pi) ** 2, abs=1e-3)
    assert time(row["peak acceleration"]) in (0.25, 0.75)


def test_flags_are_said_at_the_top(
    tmp_path: Path, four_bar: Variant, capsys: pytest.CaptureFixture[str]
) -> None:
    path = four_bar(more='limits = { A = ["5 deg", "65 deg"] }')
    _, page = report(tmp_path, path, "rock", expected=1)
    (bad,) = (attrs for tag, attrs in page.tags if "verdict" in (attrs.get("class") or ""))
    assert bad["class"] == "verdict bad"
    assert bad["role"] == "alert"
    ds = parakin.compile(path).solve("rock")
    count = int((ds["status"].values == Status.LIMIT_EXCEEDED).sum())
    asked = np.degrees(np.asarray(ds["position"].sel(coordinate="A")))
    assert count == int((asked > 65).sum()) > 0
    assert f"flagged: {count:,} limit exceeded; the first at sample" in page.words
    assert "flagged: " in capsys.readouterr().err


def test_a_motion_that_cannot_be_solved_has_its_page(tmp_path: Path) -> None:
    (tmp_path / "high.toml").write_text(
        'duration = "2 s"\nrate = 100\n'
        'laws = { platform.y = { law = "poly345", by = "3 m", begin = "1 s" } }\n'
    )
    _, page = report(tmp_path, "flight-simulator", str(tmp_path / "high.toml"), expected=1)
    assert "Not all of this motion is solved" in page.words
    assert "not reached" in page.words


def test_nothing_solved_is_told(tmp_path: Path) -> None:
    (tmp_path / "gone.toml").write_text(
        'duration = "1 s"\nrate = 10\nlaws = { platform.y = { law = "constant", value = "9 m" } }\n'
    )
    motion = str(tmp_path / "gone.toml")
    _, page = report(tmp_path, "flight-simulator", motion, expected=1)
    assert "nothing solved" in page.words
    assert "nan" not in page.words


# ---- it stands alone, and nothing in it runs


def test_the_page_asks_for_nothing(general: tuple[str, Page]) -> None:
    text, page = general
    known = {"http://www.w3.org/1999/xlink", "http://www.w3.org/2000/svg"}
    assert set(re.findall(r"\w+://[^\s\"'<>)]*", text)) <= known
    for tag, attrs in page.tags:
        assert tag not in ("script", "link", "img", "iframe", "object", "base")
        assert "src" not in attrs
        assert not any(key.startswith("on") for key in attrs)
        for key in ("href", "xlink:href"):
            assert (attrs.get(key) or "#").startswith("#")
    assert "@import" not in text


def test_ids_are_the_pages_own_and_all_that_is_referred_to_exists(
    general: tuple[str, Page],
) -> None:
    text, page = general
    ids = [attrs["id"] for _, attrs in page.tags if "id" in attrs]
    assert len(ids) == len(set(ids)) > 100
    asked = set(re.findall(r"(?:href=\"|url\()#([^\")]+)", text))
    assert asked <= set(ids)


def test_what_a_file_says_is_escaped(tmp_path: Path, four_bar: Variant) -> None:
    text, page = report(tmp_path, four_bar(HOSTILE), "rock")
    tags = {tag for tag, _ in page.tags}
    assert not tags & {"script", "img"}
    assert page.words.count(HOSTILE) >= 4  # title, source, notes and the motion's title
    assert "<script" not in text


def test_a_hostile_command_is_escaped(tmp_path: Path, four_bar: Variant) -> None:
    folder = tmp_path / "<b>&"
    folder.mkdir()
    path = Path(four_bar()).rename(folder / "m.toml")
    text, page = report(tmp_path, str(path), "rock")
    assert "<b>" not in text
    assert "<b>&" in page.words


def test_a_bad_suffix_and_an_input_are_refused(
    tmp_path: Path, four_bar: Variant, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "page.pdf"
    assert main(["report", "four-bar", "turn", "-o", str(path)]) == 2
    said = capsys.readouterr().err
    assert said == f"error: {path}: found the suffix '.pdf'; expected one of: .htm, .html\n"
    assert main(["report", "four-bar", "jump", "-o", str(tmp_path / "page.html")]) == 2
    assert "unknown name 'jump'" in capsys.readouterr().err
    assert not list(tmp_path.glob("page.*"))
