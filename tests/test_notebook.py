"""What mechanisms, solvers and ticks show in a notebook."""

from __future__ import annotations

import base64
import re
from html.parser import HTMLParser

import numpy as np
import pendulum
import pytest

import parakin
from parakin import notebook

HOSTILE = "<script>alert(1)</script> & <b>"


class Cells(HTMLParser):
    """The rows of all tables, and all text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.text = ""
        self.open: list[str] = []
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag in {"p", "b", "br", "img", "table", "thead", "tbody", "tr", "th", "td"}
        if tag not in ("br", "img"):
            self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        elif tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data
        if {"td", "th"} & set(self.open):
            self.rows[-1][-1] += data


def shown(thing: object) -> Cells:
    return Cells(thing._repr_html_())  # type: ignore[attr-defined]


def test_cells_are_escaped() -> None:
    cells = Cells(notebook.table((HOSTILE,), [(HOSTILE,)]) + notebook.heading(HOSTILE, HOSTILE))
    assert cells.rows == [[HOSTILE], [HOSTILE]]
    assert Cells(notebook.lines(title=HOSTILE, nothing="")).text == f"title: {HOSTILE}"
    assert notebook.lines(nothing="") == ""


@pytest.mark.parametrize("name", parakin.catalogue())
def test_a_mechanism_shows_its_bodies_and_joints(name: str) -> None:
    mechanism = parakin.load(name)
    cells = shown(mechanism)
    assert [row[0] for row in cells.rows[1:]] == [joint.name for joint in mechanism.joints]
    assert all(body.name in cells.text for body in mechanism.bodies)
    for name_, value in mechanism.parameters.items():
        assert f"{name_} = {value}" in cells.text


def test_what_a_file_says_is_only_text() -> None:
    hostile = {"title": HOSTILE, "source": HOSTILE}
    mechanism = parakin.load("four-bar").model_copy(update=hostile)
    assert shown(mechanism).text.count(HOSTILE) == 2
    assert HOSTILE in shown(parakin.compile(mechanism, machine_code=False)).text


def test_a_solver_shows_what_drives_and_how_the_rest_is_found() -> None:
    driven = ("A2", "B3", "C3")
    solver = parakin.compile("flight-simulator", driven, machine_code=False)
    rows = {row[0]: row[1:] for row in shown(solver).rows[1:]}
    bodies = {*solver.graph.bodies[1:], "body", "total"}  # of the table of masses
    assert set(rows) - bodies == set(solver.coordinates)
    assert {name for name, row in rows.items() if row[1] == "driven"} == set(driven)
    assert {name for name, row in rows.items() if row[1] == "iterated"} == set(solver.iterated)
    assert rows["platform.x"][0] == "1.85 m"  # as the paper has it
    assert rows["platform.psi"][0] == "0 rad"


def test_a_tick_shows_its_values() -> None:
    """The crank of a slider-crank drives its slider as in any textbook."""
    solver = parakin.compile("slider-crank", machine_code=False)
    tick = solver.at([0.7], [2.0], [0.0])
    cells = shown(tick)
    assert cells.text.startswith("converged: residual ")
    rows = {row[0]: row[1:] for row in cells.rows[1:]}
    driven = solver.driven[0]
    assert rows[driven] == ["0.7 rad", "2 rad/s", "0 rad/s²"]
    assert {unit for row in rows.values() for unit in re.findall(r"(?<= )\D+$", row[1])} == {
        "rad/s",
        "m/s",
    }


def test_a_batch_shows_what_became_of_it() -> None:
    solver = parakin.compile("five-bar", machine_code=False)
    y = np.array([solver.home[name] for name in solver.driven])
    batch = solver.at(np.stack([y, y, [9.0, 9.0]], axis=1))
    assert shown(batch).text == "3 poses: 2 converged, 1 out of reach"


def test_units_are_those_of_results() -> None:
    solver = parakin.compile("flight-simulator", coordinates="all")  # with cone angles
    tick = solver.at([solver.home[name] for name in solver.driven])
    assert tick.coordinates == solver.coordinates
    result = solver.solve("general")
    assert list(tick.units) == result["unit"].values.tolist()
    assert tick.units[tick.coordinates.index("B4.cone")] == "rad"


def test_values_by_name() -> None:
    solver = parakin.compile("five-bar", machine_code=False, derivatives=3)
    y = np.array([solver.home[name] for name in solver.driven])
    tick = solver.at(y, [0.1, 0.2])
    assert tick.value("platform.x") == pytest.approx(y[0], abs=1e-15)
    assert tick.value("platform.y", "velocity") == pytest.approx(0.2, abs=1e-15)
    for quantity in ("position", "velocity", "acceleration", "jerk"):
        for k, name in enumerate(solver.coordinates):
            assert tick.value(name, quantity) == getattr(tick, quantity)[k]
    batch = solver.at(np.stack([y, y + 0.01], axis=1))
    np.testing.assert_allclose(batch.value("platform.x"), [y[0], y[0] + 0.01], atol=1e-15)
    with pytest.raises(parakin.InputError, match=r"did you mean 'platform.x'"):
        tick.value("platform.X")
    lean = parakin.compile("five-bar", machine_code=False, derivatives=0, checks=False)
    assert lean.at(y).value("A1") == pytest.approx(tick.value("A1"), abs=1e-12)
    with pytest.raises(parakin.InputError, match="one of: position"):
        lean.at(y).value("A1", "velocity")
    assert "residual" not in shown(lean.at(y)).text


def test_a_mechanism_shows_its_scheme() -> None:
    page = parakin.load("four-bar")._repr_html_()
    (data,) = re.findall(r'src="data:image/svg\+xml;base64,([^"]+)"', page)
    svg = base64.b64decode(data).decode("utf-8")
    assert "<svg" in svg
    for name in ("crank", "coupler", "rocker"):
        assert name in page


def test_what_does_not_assemble_shows_no_scheme_and_its_table_all_the_same() -> None:
    page = parakin.load("four-bar", {"b": 3.0})._repr_html_()
    assert "<img" not in page
    assert "<td>revolute</td>" in page
    assert notebook.picture("nothing", None) == ""


def test_masses_and_forces_are_shown_where_there_are_any() -> None:
    mechanism = pendulum.pendulum().with_payload("0.5 kg at arm")
    page = shown(mechanism)
    assert "masses: arm 2.0 kg" in page.text
    assert "forces: payload (payload)" in page.text
    solver = parakin.compile(mechanism, machine_code=False)
    rows = shown(solver).rows
    assert rows[-3:] == [
        ["arm", "2 kg", "0.5, 0, 0 m"],
        ["payload on arm", "0.5 kg", "0, 0, 0 m"],
        ["total", "2.5 kg", ""],
    ]
    turned, speed = 1.0, 2.0
    heading, row = shown(solver.at([turned], [speed], [0.0], forces=True)).rows[-2:]
    effort = pendulum.MASS * pendulum.GRAVITY * pendulum.RADIUS * np.cos(turned) + pendulum.COULOMB
    torque = effort / pendulum.RATIO / pendulum.EFFICIENCY
    assert heading[:4] == ["actuator", "effort", "power", "motor torque, SI"]
    assert row == [
        "A",
        f"{effort:.6g} N m",
        f"{effort * speed:.6g} W",
        f"{torque:.6g}",
        "100",
        f"{100 * torque:.6g} W",
        f"{torque / pendulum.TORQUE_CONSTANT:.6g} A",
    ]
    assert shown(solver.at([0.0])).rows[-1][0] == "A"
    assert "actuator" not in shown(solver.at([0.0])).text


def test_why_there_are_no_efforts_is_shown() -> None:
    known = parakin.load("flight-simulator").with_payload("80 kg at platform")
    joints = tuple(
        joint.model_copy(update={"actuated": False, "drive": None}) if joint.name == "A2" else joint
        for joint in known.joints
    )
    solver = parakin.compile(known.model_copy(update={"joints": joints}), machine_code=False)
    assert "2 actuated coordinates for 3 freedoms" in solver.no_forces
    assert f"efforts: none: {solver.no_forces}" in shown(solver).text
    assert parakin.compile(known, machine_code=False).no_forces == ""
    assert "efforts" not in shown(parakin.compile("four-bar", machine_code=False)).text
