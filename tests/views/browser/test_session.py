"""A page in a real browser: it plays, reports errors, and keeps to itself."""

from __future__ import annotations

import gc
import re
import threading
import time
import weakref
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import Page, agree, needs_chromium, until, viewed

import parakin
from parakin.views.browser.content import Content
from parakin.views.browser.messages import escaped
from parakin.views.browser.viewer import serving
from parakin.views.solids.drawing import COLOURS

pytestmark = needs_chromium
FOUR_BAR = (Path(parakin.__file__).parent / "catalogue" / "four-bar.toml").read_text("utf-8")


def test_play_moves_it_and_pause_holds_it(simulator: Page) -> None:
    before, _ = simulator.poses()
    pixels = simulator.pixels()
    simulator.press("Play")
    until(lambda: simulator.session.time > 0.5)
    simulator.press("Pause")
    until(lambda: not simulator.session.playing)
    held = simulator.session.time
    time.sleep(0.2)
    assert simulator.session.time == held
    after, _ = simulator.poses()
    assert np.abs(after - before).max() > 0.01
    assert np.abs(simulator.pixels() - pixels).max() > 50


def test_a_bad_file_shows_its_message_while_the_last_good_one_stays(
    browser: Any, tmp_path: Path
) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(FOUR_BAR, "utf-8")
    with viewed(browser, path) as page:
        ds = parakin.compile("four-bar").solve("turn", bodies=True)
        home = ds["body_position"].values[0], ds["body_orientation"].values[0]
        agree(page, *home)
        path.write_text(FOUR_BAR.replace("[parameters]", "[parameter]"), "utf-8")
        page.page.get_by_text(re.compile("Error: .*unknown key 'parameter'")).wait_for()
        agree(page, *home)
        path.write_text(re.sub(r"(?m)^b = .*$", 'b = "130 mm"', FOUR_BAR), "utf-8")
        until(lambda: page.session.loaded.graph.parameters["b"] == 0.13)
        until(lambda: not page.page.get_by_text(re.compile("Error:")).is_visible())
        assert page.said == []


def test_two_pages_are_apart_and_closing_one_frees_it(browser: Any) -> None:
    with serving(Content("four-bar"), port=0) as viewer:
        one, two = Page(browser, viewer), Page(browser, viewer)
        two.choose("Mechanism", "slider-crank")
        until(
            lambda: two.session.loaded.name == "slider-crank" and two.session.playback is not None
        )
        two.drawn()
        assert one.session.loaded.name == "four-bar"
        one.press("Play")
        until(lambda: one.session.time > 0.1)
        assert two.session.time == 0.0
        assert not two.session.playing
        players = _players()
        kept = weakref.ref(two.session)
        scene = weakref.ref(two.session.scene)
        two.close()
        until(lambda: len(viewer.sessions) == 1)

        def freed() -> bool:
            gc.collect()
            return kept() is None and scene() is None

        until(freed)
        assert _players() == players - 1
        assert one.session.playing
        one.close()


def _players() -> int:
    """How many threads play, of all pages in this process."""
    return sum(thread.name == "parakin player" for thread in threading.enumerate())


def test_without_loop_it_stops_at_the_end(browser: Any) -> None:
    with viewed(browser, "four-bar") as page:
        page.choose("Speed", "4")
        page.page.get_by_role("checkbox", name="Loop").uncheck()
        page.press("Play")
        until(lambda: page.session.playing)
        until(lambda: not page.session.playing)
        playback = page.session.playback
        assert playback is not None
        assert page.session.time == playback.time[-1]
        agree(page, playback.position[-1], playback.wxyz[-1])


_TOO_FAR = """
[motions.far]
duration = "1 s"
laws = { platform.y = { law = "cosine", by = "1 m" } }
"""


def test_a_motion_that_cannot_go_on_ends_at_its_last_good_pose(
    browser: Any, tmp_path: Path
) -> None:
    path = tmp_path / "mine.toml"
    file = Path(parakin.__file__).parent / "catalogue" / "five-bar.toml"
    path.write_text(file.read_text("utf-8") + _TOO_FAR, "utf-8")
    with viewed(browser, path) as page:
        page.choose("Motion", "far")
        until(lambda: page.session.playback is not None and page.session.playback.name == "far")
        playback = page.session.playback
        assert playback is not None
        assert playback.stop is not None
        page.session.seek(float(playback.time[-1]))
        page.page.get_by_text(re.compile("stopped: ended at 0.[0-9]+ s")).wait_for()
        # Both arms stretched, on the axis of symmetry: the paper-and-pencil end of the reach.
        end = np.sqrt((0.15 + 0.22) ** 2 - 0.1**2)
        assert playback.point is not None
        assert 0 < end - playback.point[-1, 1] < 5e-3
        names = {page.session.loaded.graph.joints[k].name for k in playback.stop.joints}
        assert names
        lit = page.colours(f"/mechanism/{'base'}/joint A1")
        assert (COLOURS["offending"] in lit) == ("A1" in names)


def test_a_bad_motion_is_reported_and_the_one_before_stays(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "recorded.csv"
    path.write_text("time [s],A [deg]\n0,10\n0,20\n", "utf-8")
    with viewed(browser, "four-bar", motions=(str(path),)) as page:
        page.choose("Motion", str(path))
        page.page.get_by_text(re.compile("Error: .*recorded.csv")).wait_for()
        assert page.session.playback is not None
        assert page.session.playback.name == "turn"


def test_what_cannot_be_driven_is_shown_with_the_reason(browser: Any) -> None:
    with viewed(browser, "flight-simulator-upu") as page:
        page.page.get_by_text(re.compile("only 1 can move independently")).wait_for()
        assert page.session.playback is None


def test_text_from_a_file_is_only_text(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    evil = "<img src=x onerror=console.error(1)> **[a](http://elsewhere.example)**"
    path.write_text(re.sub(r"(?m)^title = .*$", f'title = "{evil}"', FOUR_BAR), "utf-8")
    with viewed(browser, path) as page:
        page.page.get_by_text(evil).wait_for()
        assert page.said == []
        assert not any("elsewhere" in url or url.endswith("/x") for url in page.asked)


@pytest.mark.parametrize(
    ("typed", "shown"), [(1e9, 1.0), (-3.0, 0.0), (np.inf, 1.0), (-np.inf, 0.0), (np.nan, 0.0)]
)
def test_a_time_beyond_the_motion_is_its_end(typed: float, shown: float, browser: Any) -> None:
    with viewed(browser, "four-bar") as page:
        playback = page.session.playback
        assert playback is not None
        end = float(playback.time[-1])
        page.session.seek(typed)
        assert page.session.time == shown * end
        assert page.session._slider.value == shown * end
        assert escaped(f"t = {shown * end:.2f} s") in page.session._state_text


def test_a_time_that_is_typed_beyond_the_motion_is_its_end(browser: Any) -> None:
    with viewed(browser, "four-bar") as page:
        assert page.session.playback is not None
        end = float(page.session.playback.time[-1])
        page.enter("Time [s]", "12345")
        until(lambda: page.session.time == end)
        until(lambda: float(page.value("Time [s]")) == end)
