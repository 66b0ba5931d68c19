"""Messages: what Markdown makes of them, and what they report."""

from __future__ import annotations

import html
import re

import pytest

import parakin
from parakin.solving.status import Status
from parakin.views.browser.drive import Stop
from parakin.views.browser.messages import PoseState, escaped, pose_message, range_message


@pytest.mark.parametrize(
    "text",
    [
        "<img src=x onerror=alert(1)> **[a](http://elsewhere.example)**",
        "1. _x_ `y` # z > w | ~v~ \\ & &amp; !",
        "plain words",
    ],
)
def test_markdown_shows_text_from_a_file_verbatim(text: str) -> None:
    from markdown_it import MarkdownIt

    rendered = MarkdownIt("commonmark").enable(["table", "strikethrough"]).render(escaped(text))
    inside = re.fullmatch(r"<p>(.*)</p>\n", rendered)
    assert inside is not None
    assert html.unescape(inside[1]) == text
    assert "<" not in inside[1]


def test_a_good_pose() -> None:
    lines = pose_message(PoseState("turn, t = 0.50 s", 0.75, 2e-16)).splitlines()
    assert [line.strip() for line in lines] == [
        "turn\\, t \\= 0\\.50 s",
        "converged",
        "conditioning 0.750 · residual 2.0e-16 m",
        "no limits declared · branch home",
    ]
    assert "limits kept" in pose_message(PoseState("turn", 0.75, 2e-16, limits=2))


def test_a_pose_at_a_limit_highlights_its_joint() -> None:
    stop = Stop(Status.LIMIT_EXCEEDED, "A1 is at its limit", frozenset({3}))
    state = PoseState("by hand", 0.5, 0.0, stop, branch="2 of 4")
    assert state.highlighted == {3}
    message = pose_message(state)
    assert "**stopped: A1 is at its limit**" in message
    assert message.endswith("limits reached · branch 2 of 4")


def test_a_pose_beyond_its_limits_names_the_joints() -> None:
    state = PoseState("swing", 0.5, 0.0, beyond_limits={"A1": 3, "B": 5})
    assert state.highlighted == {3, 5}
    message = pose_message(state)
    assert "**limit exceeded**" in message
    assert "limits exceeded: A1\\, B · branch" in message
    told = PoseState("swing", 0.5, 0.0, beyond_limits={"A1": 3}, because="A1 at 2 m, limit 1 m")
    assert "**limit exceeded\\: A1 at 2 m\\, limit 1 m**" in pose_message(told)


def test_the_range_left_names_what_stops() -> None:
    seat = parakin.compile("seat-3dof")
    lines = range_message(parakin.range(seat)).replace("\\", "").split("  \n")
    assert lines[0] == "**Range left from here:**"
    assert lines[1] == "platform.z [mm] -83.2 (A1 < -75°) .. +71.4 (A1 > 75°)"
    assert range_message(None) == ""


def test_what_nothing_stops_is_free() -> None:
    text = range_message(parakin.range(parakin.compile("slider-crank"))).replace("\\", "")
    assert text.endswith("A [deg] free .. free")
