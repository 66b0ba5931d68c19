"""The Drive tab in a real browser."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from browser import Page, agree, needs_chromium, shows, until, viewed

import parakin
from parakin.views.solids.drawing import COLOURS

pytestmark = needs_chromium


def _drive_from_home(page: Page) -> None:
    page.tab("Drive")
    page.press("Home")
    until(lambda: page.session.drive_tab.drive is not None)


def _stand_on_another_branch(page: Page, of: int, number: int = 2) -> None:
    _drive_from_home(page)
    page.press("Search for branches here")
    page.page.get_by_text(re.compile(f"{of} distinct, [0-9]+ of them usable")).wait_for()
    entry = page.session.drive_tab._branch_list.options[number - 1]  # "3 of 16, turned through: A2"
    page.choose("Branch", entry)
    page.page.get_by_text(re.compile(f"branch {number} of {of}")).wait_for()


def test_a_slider_moves_it(simulator: Page) -> None:
    _drive_from_home(simulator)
    simulator.enter("platform.y [mm]", "1200")
    solver = parakin.compile("flight-simulator")
    y = np.array([solver.home[name] for name in solver.driven])
    y[1] = 1.2
    tick = solver.at(y)
    agree(simulator, *solver.poses(y, tick))
    assert simulator.said == []


def test_forward_drives_the_actuators_from_where_it_stands(simulator: Page) -> None:
    _drive_from_home(simulator)
    simulator.choose("Kinematics", "forward")
    until(
        lambda: (
            simulator.session.drive_tab.drive is not None
            and simulator.session.drive_tab.drive.solver.driven == ("A2", "B3", "C3")
        )
    )
    simulator.enter("B3 [mm]", "40")
    forward = parakin.compile("flight-simulator", ("A2", "B3", "C3"))
    y = [forward.home["A2"], 0.04, forward.home["C3"]]
    agree(simulator, *forward.poses(y, forward.at(y)))
    simulator.choose("Kinematics", "inverse")


def test_the_handle_leads_the_platform(simulator: Page) -> None:
    _drive_from_home(simulator)
    simulator.page.wait_for_function("window.__viserMutable.nodeRefFromName['/handle']")
    before = simulator.session.drive_tab.drive.y.copy()  # type: ignore[union-attr]
    x, y = _at_rest(simulator, 0.14 * simulator.session.scene.drawing.arrangement.size)
    mouse = simulator.page.mouse
    mouse.move(x, y)
    mouse.down()
    mouse.move(x, y - 40, steps=5)
    until(lambda: simulator.session.drive_tab.drive.y[1] > before[1] + 0.01)  # type: ignore[union-attr]
    mouse.up()
    drive = simulator.session.drive_tab.drive
    assert drive is not None
    # What the mouse did last may still be on its way: where it leads is asked for at each look.
    until(lambda: shows(simulator, *drive.solver.poses(drive.y, drive.tick)))


def _at_rest(page: Page, size: float) -> list[float]:
    """Where the handle's arrow is once it, and the camera, have come to rest."""
    seen: list[list[float]] = []

    def still() -> bool:
        seen.append(page.page.evaluate(_ON_SCREEN, size))
        page.page.wait_for_timeout(300)
        return len(seen) > 2 and seen[-1] == seen[-2] == seen[-3]

    until(still)
    return seen[-1]


# Where the tip of the handle's arrow along y is on the screen, in pixels.
_ON_SCREEN = """size => {
    const {nodeRefFromName, camera} = window.__viserMutable;
    const node = nodeRefFromName['/handle'];
    node.updateWorldMatrix(true, false);
    const tip = node.position.clone().set(0, size, 0).applyMatrix4(node.matrixWorld);
    tip.project(camera);
    const box = document.querySelector('canvas').getBoundingClientRect();
    return [box.x + box.width * (tip.x + 1) / 2, box.y + box.height * (1 - tip.y) / 2];
}"""


def test_another_branch_is_searched_and_driven(browser: Any) -> None:
    with viewed(browser, "five-bar") as page:
        drive_tab = page.session.drive_tab
        _stand_on_another_branch(page, of=4)
        other = parakin.compile("five-bar", near="2", coordinates="all")
        y = np.array([other.home[name] for name in other.driven])
        agree(page, *other.poses(y, other.at(y)))
        page.enter("platform.x [mm]", "20")
        y[0] = 0.02
        agree(page, *other.poses(y, other.at(y)))
        found = drive_tab._found
        page.press("Search for branches here")  # of these driven values
        until(lambda: drive_tab._found is not found)
        page.page.get_by_text(re.compile("branch [234] of 4")).wait_for()
        page.page.get_by_role("combobox", name="Branch").click()
        page.page.get_by_role("option", name="4 of 4").wait_for()
        options = page.page.get_by_role("option").filter(visible=True).all_inner_texts()
        assert options == ["home", "2 of 4", "3 of 4", "4 of 4"]
        page.page.keyboard.press("Escape")
        agree(page, *other.poses(y, other.at(y)))
        page.choose("Kinematics", "forward")  # from where it stands, on its assembly mode
        page.page.get_by_text(re.compile("driven by hand, forward")).wait_for()
        agree(page, *other.poses(y, other.at(y)))
        page.choose("Kinematics", "inverse")
        page.page.get_by_text(re.compile("branch unnumbered")).wait_for()
        agree(page, *other.poses(y, other.at(y)))
        page.choose("Branch", "home")  # for the same driven values
        page.page.get_by_text(re.compile("branch home")).wait_for()
        own = parakin.compile("five-bar", coordinates="all")
        agree(page, *own.poses(y, own.at(y)))
        assert page.said == []


def test_far_from_home_sliders_reach_to_where_it_stands(browser: Any) -> None:
    with viewed(browser, "flight-simulator") as page:
        drive_tab = page.session.drive_tab
        _stand_on_another_branch(page, of=16, number=3)
        page.choose("Kinematics", "forward")
        until(lambda: drive_tab.drive is not None and "A2" in drive_tab.drive.solver.driven)
        assert drive_tab.drive is not None
        y = drive_tab.drive.y.copy()
        until(lambda: page.value("A2 [mm]") == f"{1e3 * y[0]:.0f}")
        assert y[0] < -2.0
        page.enter("B3 [mm]", "5")
        until(lambda: abs(drive_tab.drive.y[1] - 0.005) < 1e-12)  # type: ignore[union-attr]
        assert drive_tab.drive.y[0] == y[0]
        assert drive_tab.drive.y[2] == y[2]


def test_at_a_limit_it_stops_and_the_joint_lights_up(browser: Any) -> None:
    with viewed(browser, "seat-2dof") as page:
        page.tab("Drive")
        page.choose("Kinematics", "forward")
        until(lambda: page.session.drive_tab.drive is not None)
        page.enter("A1 [deg]", "20")
        until(lambda: abs(page.session.drive_tab.drive.y[0] - np.radians(20)) < 1e-9)  # type: ignore[union-attr]
        assert COLOURS["offending"] not in page.colours("/mechanism/crank1/joint A1")
        with page.session._lock:
            page.session.drive_tab.to([2.0, 0.0])
        until(lambda: COLOURS["offending"] in page.colours("/mechanism/crank1/joint A1"))
        assert COLOURS["offending"] not in page.colours("/mechanism/crank2/joint A2")
        np.testing.assert_allclose(page.session.drive_tab.drive.y[0], np.radians(75), atol=1e-5)  # type: ignore[union-attr]
        page.page.get_by_text(re.compile("stopped: A1 is at its limit")).wait_for()
        page.enter("A1 [deg]", "120")
        until(lambda: page.value("A1 [deg]") == "75")


def test_the_range_left_is_told_and_follows(browser: Any) -> None:
    with viewed(browser, "seat-3dof") as page:
        _drive_from_home(page)
        page.page.get_by_text("Range left from here").wait_for()
        page.page.get_by_text("platform.z [mm] -83.2").wait_for()
        home = page.session.drive_tab.drive.y[0]  # type: ignore[union-attr]
        page.enter("platform.z [mm]", f"{1e3 * home + 20:.0f}")
        page.page.get_by_text(re.compile(r"platform.z \[mm\] -10[23]\.")).wait_for()
