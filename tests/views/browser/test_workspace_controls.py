"""The workspace in the scene, asked for in a real browser."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import pytest
from browser import Page, needs_chromium, until, viewed

from parakin.views.browser import surface, workspace_controls
from parakin.views.browser.workspace_controls import WorkspaceControls

pytestmark = needs_chromium

RIG = Path(__file__).parents[3] / "examples" / "rig.toml"


def _controls(page: Page) -> WorkspaceControls:
    return page.session.drive_tab._space


def _in_scene(page: Page) -> int:
    """How many nodes of a workspace the page's own scene has."""
    return int(
        page.page.evaluate(
            """() => Object.entries(window.__viserSceneTree.getState())
                .filter(([name, node]) => name.startsWith('/workspace/') && node).length"""
        )
    )


def _driving(page: Page) -> None:
    page.tab("Drive")
    page.press("Home")
    until(lambda: page.session.drive_tab.drive is not None)


def test_the_surface_comes_while_the_page_lives_and_goes(
    browser: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    goes_on, own = threading.Event(), surface.surface_of

    def waiting(*given: Any) -> Any:
        assert goes_on.wait(60.0)
        return own(*given)

    monkeypatch.setattr(workspace_controls, "surface_of", waiting)
    with viewed(browser, RIG) as page:
        _driving(page)
        page.press("Workspace from here")
        page.page.get_by_text("Finding the workspace …").wait_for()
        page.enter("platform.x [mm]", "100")
        until(lambda: abs(page.session.drive_tab.drive.y[0] - 0.1) < 1e-9)  # type: ignore[union-attr]
        assert _in_scene(page) == 0
        goes_on.set()
        page.page.get_by_text("Workspace of the platform's point, volume 0.079").wait_for()
        page.page.get_by_text("P1 > 1.26 m (").wait_for()
        until(lambda: _in_scene(page) == len(_controls(page)._nodes) > 1)
        page.press("Hide the workspace")
        until(lambda: _in_scene(page) == 0)
        assert page.page.get_by_text("Workspace of the platform's point").count() == 0
        assert page.said == []


def test_one_that_comes_after_another_mechanism_was_chosen_is_dropped(
    browser: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    goes_on, done, own = threading.Event(), threading.Event(), surface.surface_of

    def waiting(*given: Any) -> Any:
        assert goes_on.wait(60.0)
        found = own(*given)
        done.set()
        return found

    monkeypatch.setattr(workspace_controls, "surface_of", waiting)
    with viewed(browser, "five-bar") as page:
        _driving(page)
        page.press("Workspace from here")
        page.page.get_by_text("Finding the workspace …").wait_for()
        page.choose("Mechanism", "seat-2dof")
        until(lambda: page.session.loaded.name == "seat-2dof")
        until(lambda: not _controls(page)._button.visible)  # no slides of a platform
        goes_on.set()
        assert done.wait(60.0)
        page.choose("Mechanism", "five-bar")
        _driving(page)
        page.page.get_by_role("button", name="Workspace from here").wait_for()
        assert _in_scene(page) == 0
        assert _controls(page)._nodes == []


def test_driven_by_its_actuators_it_is_asked_for_all_the_same(browser: Any) -> None:
    with viewed(browser, "five-bar") as page:
        _driving(page)
        page.choose("Kinematics", "forward")
        until(lambda: page.session.drive_tab.drive.solver.driven == ("A1", "A2"))  # type: ignore[union-attr]
        page.press("Workspace from here")
        page.page.get_by_text("Workspace of the platform's point, area").wait_for()
        assert page.session.drive_tab.drive.solver.driven == ("platform.x", "platform.y")  # type: ignore[union-attr]
        until(lambda: _in_scene(page) == 2)
        page.choose("Mechanism", "delta")
        until(lambda: _in_scene(page) == 0)


def test_a_pose_beyond_limits_says_why_there_is_none(browser: Any, tmp_path: Path) -> None:
    short = RIG.read_text("utf-8").replace('"(leg_min + leg_max)/2"', '"leg_max + 10 mm"')
    file = tmp_path / "short.toml"
    file.write_text(short, "utf-8")
    with viewed(browser, file) as page:
        _driving(page)
        page.press("Workspace from here")
        page.page.get_by_text("no workspace from there: P1").wait_for()
        assert _in_scene(page) == 0
