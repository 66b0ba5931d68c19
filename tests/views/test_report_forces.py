"""The forces of a report, against closed forms."""

from __future__ import annotations

import html
import re
from pathlib import Path

import numpy as np
import pendulum
import pytest

import parakin
from parakin.model.forces import Payload
from parakin.model.mechanism import Mechanism
from parakin.views.extremes import extremes
from parakin.views.report_curves import force_curves

pytest.importorskip("matplotlib")


def section(folder: Path, mechanism: Mechanism, motion: str) -> tuple[str, str]:
    """The page, and the words of its section on forces."""
    parakin.report(mechanism, motion, folder / "page.html")
    page = (folder / "page.html").read_text("utf-8")
    _, found, rest = page.partition("<h2>Forces</h2>")
    return page, html.unescape(
        re.sub(r"<[^>]+>", " ", rest.partition("</section>")[0] * bool(found))
    )


def test_peaks_masses_and_limits_are_those_of_the_closed_form(tmp_path: Path) -> None:
    mechanism = pendulum.pendulum().with_payload("0.5 kg at arm")
    page, words = section(tmp_path, mechanism, "swing")
    effort, power, torque = pendulum.efforts(np.linspace(0.0, 2.0, 20_001))
    assert re.search(r"arm\s+2\s+500, 0, 0\s", words)
    assert re.search(r"payload on arm\s+0.5\s+0, 0, 0\s+total\s+2.5\s", words)
    assert f"{effort.max():.2f} N m" in words
    assert f"{power.max():.2f} W" in words
    assert f"{100 * effort.max() / 30:.0f} %" in words
    assert re.search(r"A, torque.*0.2 N m\s+24\d %\s+exceeded", words, re.DOTALL)
    assert "beyond its drive: A needs a torque of" in page.partition("<main>")[0]
    assert "its motor's torque over its speed" in words
    assert np.abs(torque).max() > 0.2


def test_a_mechanism_without_masses_has_no_such_section(tmp_path: Path) -> None:
    page, words = section(tmp_path, parakin.load("slider-crank"), "turn")
    assert words == ""
    assert "Forces" not in page


def test_why_there_are_no_efforts(tmp_path: Path) -> None:
    """Three freedoms and two actuators: the masses are shown, and the reason."""
    known = parakin.load("flight-simulator")
    joints = tuple(
        joint.model_copy(update={"actuated": False, "drive": None}) if joint.name == "A2" else joint
        for joint in known.joints
    )
    seat = Payload(kind="payload", at="platform", mass="80 kg")
    mechanism = known.model_copy(update={"joints": joints, "forces": {"seat": seat}})
    _, words = section(tmp_path, mechanism, "general")
    assert "There are no efforts" in words
    assert "2 actuated coordinates for 3 freedoms" in words
    assert "seat on platform" in words


def test_torque_over_speed_within_the_drive_s_limits() -> None:
    solver = parakin.compile(pendulum.pendulum(), machine_code=False)
    swing = solver.solve("swing", forces=True).isel(time=slice(None, None, 2))  # not thinned
    found = extremes(swing).forces
    assert found is not None
    motor = solver.graph.dynamics.motors[0]
    effort, power, chart = force_curves(swing, "A", found, motor).axes
    assert [axes.get_title(loc="left") for axes in (effort, power, chart)] == [
        "effort [N m]",
        "power [W]",
        "motor torque [N m]",
    ]
    _, _, torque = pendulum.efforts(swing["time"].values)
    curve = chart.lines[0]
    moving = np.abs(swing["velocity"].values[:, 0]) > 0.1
    np.testing.assert_allclose(np.asarray(curve.get_ydata())[moving], torque[moving], rtol=1e-9)
    fastest = pendulum.AMPLITUDE * pendulum.RATE * pendulum.RATIO * 30 / np.pi
    assert np.asarray(curve.get_xdata()).max() == pytest.approx(fastest)
    heights = [np.asarray(line.get_ydata(), dtype=float) for line in chart.lines[1:]]
    assert {-0.2, 0.2} <= {float(y[0]) for y in heights if np.ptp(y) == 0.0}
