"""Payloads and efforts on a page in a real browser."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pendulum
import pytest
from browser import Page, needs_chromium, until, viewed

from parakin.views.browser.content import Content
from parakin.views.browser.drive import Drive
from parakin.views.browser.playback import playback_of

pytestmark = needs_chromium

TOOL = """
[forces.tool]
kind = "payload"
at = "arm.tip"
mass = "1 kg"
"""
REACH = 0.8
TEXT = pendulum.TEXT.replace(
    "[bodies.arm]", f'[bodies.arm]\npoints = {{ tip = ["{REACH} m", 0, 0] }}'
)


def held(tool: float, q: float = 0.0) -> float:
    """The torque that holds arm and tool at rest [N m]."""
    moment = pendulum.MASS * pendulum.RADIUS + tool * REACH
    return moment * pendulum.GRAVITY * float(np.cos(q))


@pytest.fixture(scope="module")
def page(browser: Any, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    path = tmp_path_factory.mktemp("payloads") / "pendulum.toml"
    path.write_text(TEXT + TOOL, "utf-8")
    with viewed(browser, path) as found:
        until(lambda: found.session.playback is not None)
        yield found


def test_efforts_are_played(page: Page) -> None:
    page.page.get_by_text("effort [N m]").wait_for()
    page.page.get_by_text("power [W]").wait_for()
    playback = page.session.playback
    assert playback is not None
    assert playback.forces is not None
    effort, power, _ = pendulum.efforts(playback.time)
    more = playback.forces.effort[:, 0] - effort
    q = pendulum.AMPLITUDE * np.sin(pendulum.RATE * playback.time)
    tool = pendulum.GRAVITY * REACH * np.cos(q) - pendulum.RATE**2 * REACH**2 * q
    moving = np.abs(np.cos(pendulum.RATE * playback.time)) > 0.01
    np.testing.assert_allclose(more[moving], tool[moving], atol=1e-9)
    assert np.isfinite(power).all()
    page.session.seek(0.75)  # where it takes the most
    until(lambda: len(page.session.scene.efforts.points) == 1)


def test_a_heavier_payload_takes_more(page: Page) -> None:
    before = page.session.playback
    assert before is not None
    page.enter("tool [kg]", "2")
    until(lambda: page.session.loads == {"tool": 2.0} and page.session.playback is not before)
    after = page.session.playback
    assert after is not None
    assert before.forces is not None
    assert after.forces is not None
    assert after.forces.effort.max() > before.forces.effort.max() + 1.0
    page.tab("Drive")
    page.press("Home")
    page.page.get_by_text(re.compile(rf"A {held(2.0):.2f} N m")).wait_for()
    page.enter("tool [kg]", "3")
    page.page.get_by_text(re.compile(rf"A {held(3.0):.2f} N m")).wait_for()
    page.enter("A [deg]", "60")
    page.page.get_by_text(re.compile(rf"A {held(3.0, np.pi / 3):.2f} N m")).wait_for()
    page.tab("Show")
    page.page.get_by_label("Efforts of the actuators").click()
    until(lambda: len(page.session.scene.efforts.points) == 0)
    assert page.said == []


def test_a_mechanism_without_masses_has_neither(browser: Any) -> None:
    with viewed(browser, "four-bar") as linkage:
        until(lambda: linkage.session.playback is not None)
        assert linkage.session.playback is not None
        assert linkage.session.playback.forces is None
        assert linkage.session.loads == {}
        assert not linkage.page.get_by_text("Payloads").is_visible()
        assert not linkage.page.get_by_text(re.compile("effort")).is_visible()


def test_forces_in_joints_are_shown_where_they_are_wanted(simulator: Page) -> None:
    """All but those that are indeterminate."""
    until(lambda: simulator.session.playback is not None)
    session = simulator.session
    assert len(session.scene.reactions.points) == 0
    simulator.tab("Show")
    simulator.page.get_by_label("Forces in the joints").click()
    until(lambda: len(session.scene.reactions.points) > 0)
    playback = session.playback
    assert playback is not None
    assert playback.forces is not None
    assert playback.forces.reactions is not None
    names = [joint.name for joint in playback.forces.joints]
    assert np.isfinite(playback.forces.reactions[:, names.index("B4")]).all()
    simulator.tab("Drive")
    simulator.press("Home")
    until(lambda: session.drive_tab.drive is not None)
    until(lambda: len(session.scene.reactions.points) > 0)
    simulator.tab("Show")
    simulator.page.get_by_label("Forces in the joints").click()
    until(lambda: len(session.scene.reactions.points) == 0)
    simulator.tab("Play")


def test_wrenches_that_change_with_time_do_not_act_at_rest(tmp_path: Path) -> None:
    path = tmp_path / "pendulum.toml"
    wrench = """
[forces.gust]
kind = "wrench"
at = "arm.tip"
force = [0, "5 N", 0]
law = { law = "sine", amplitude = 1, frequency = "1 Hz" }
"""
    path.write_text(TEXT + wrench, "utf-8")
    loaded = Content(str(path)).load(str(path))
    assert loaded.solver is not None
    forces = Drive(loaded.solver).forces({})
    assert forces is not None
    assert forces.effort[0] == pytest.approx(held(0.0))
    assert playback_of(loaded.solver, "swing").forces is not None
