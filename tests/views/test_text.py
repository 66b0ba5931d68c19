"""Text for a terminal: numbers of published mechanisms and of closed forms."""

from __future__ import annotations

import io
import re

from rich.console import Console, RenderableType

import parakin
from parakin import Status
from parakin.analysis.mobility import mobility
from parakin.kinematics.assembly import assembled
from parakin.model.evaluation import graph_of
from parakin.views.extremes import extremes
from parakin.views.text import (
    catalogue_table,
    flag_words,
    mechanism_report,
    mobility_lines,
    modes_report,
    solve_report,
)


def printed(text: RenderableType) -> str:
    console = Console(file=io.StringIO(), width=1000)
    console.print(text)
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


def lines_of(name: str) -> list[str]:
    graph = graph_of(parakin.load(name))
    found = mobility(graph, assembled(graph), len(graph.mechanism.driven))
    return [line.plain.strip() for line in mobility_lines(graph, found)]


def test_mobility_of_a_bennett_linkage() -> None:
    """Four hinges: by formula it could not move, but it does (Bennett 1903)."""
    heading, formula, rank, *_ = lines_of("bennett")
    assert heading == "Mobility"
    assert formula == "Grübler-Kutzbach: -2 (4 bodies with the base, 4 joints)"
    assert rank.startswith("by rank: 1 at home, 1 at ")


def test_mobility_of_a_planar_four_bar() -> None:
    """The formula counts three equations too many; the loop's rank is that of the plane."""
    lines = lines_of("four-bar")
    assert "Grübler-Kutzbach: -2 (4 bodies with the base, 4 joints)" in lines
    (loop,) = (line for line in lines if line.startswith("the loop"))
    assert loop.endswith("has rank 3: 3 of its six equations come for free")
    assert lines[-1] == "driven: A"


def test_mobility_of_a_gough_platform() -> None:
    """Six legs with universal and spherical joints: 6 by formula, and none redundant."""
    lines = lines_of("gough-stewart")
    assert any(line.startswith("Grübler-Kutzbach: 6 (14 bodies") for line in lines)
    assert any(line.endswith("0 redundant") for line in lines)


def test_too_few_freedoms_and_the_joints_that_cause_it() -> None:
    *_, short, cause = lines_of("flight-simulator-upu")
    assert short == "3 coordinates are to be driven, but only 1 can move"
    assert cause.startswith("cause: joint")
    assert cause.endswith("would give mobility 3")


def test_home_in_millimetres_and_degrees() -> None:
    text = printed(mechanism_report(parakin.check("four-bar")))
    (row,) = (line for line in text.splitlines() if line.startswith("A *"))
    assert row.split()[2:4] == ["40.0000", "deg"]  # as its file has it
    assert "source: " in text


def test_strokes_and_peaks_of_a_turn() -> None:
    solver = parakin.compile("four-bar", machine_code=False)
    result = solver.solve("turn")
    text = printed(solve_report(result, extremes(result), 2.0))
    heading, row, summary = text.splitlines()[:3]
    assert re.split(r" {2,}", heading.strip())[:2] == ["actuated", "from"]
    assert row.split()[:4] == ["A", "[deg]", "40.000", "400.000"]
    assert "+0.000 .. +360.000" in row
    assert summary.startswith(f"{result.sizes['time']:,} samples solved in 2.00 s (")


def test_jerk_has_a_column_where_it_is_known() -> None:
    solver = parakin.compile("four-bar", machine_code=False, derivatives=3)
    result = solver.solve("turn")
    text = printed(solve_report(result, extremes(result), 0.5))
    assert "peak jerk" in text.splitlines()[0]
    assert "deg/s³" in text.splitlines()[1]


def test_flags_are_counted_and_the_first_is_named() -> None:
    solver = parakin.compile("four-bar", machine_code=False)
    result = solver.solve("turn")
    assert flag_words(extremes(result)) == ""
    result["status"].values[[7, 9]] = Status.LIMIT_EXCEEDED
    result["status"].values[11] = Status.SINGULAR
    time = float(result["time"][7])
    assert flag_words(extremes(result)) == (
        "flagged: 1 singular, 2 limit exceeded; "
        f"the first at sample 7, t = {time:.6g} s: limit exceeded"
    )


def test_modes_of_a_five_bar() -> None:
    """Each arm of a planar 5R has two sides: four working modes."""
    solver = parakin.compile("five-bar", machine_code=False)
    text = printed(modes_report(solver.graph, solver.driven, parakin.modes(solver)))
    title, heading, *rows = text.splitlines()
    assert title == "five-bar, driven: platform.x, platform.y"
    assert "[deg]" in heading
    assert [row.split()[0] for row in rows[:4]] == ["home", "2", "3", "4"]


def test_the_catalogue() -> None:
    text = printed(catalogue_table({"mine": ("[bold]a title", ""), "b": ("B", "go, rest")}))
    _, mine, other = text.splitlines()
    assert mine.split() == ["mine", "[bold]a", "title", "none"]
    assert other.split() == ["b", "B", "go,", "rest"]
