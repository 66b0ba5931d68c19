"""Playbacks: thinned evenly, and only of what is solved."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import parakin
from parakin.views.browser.playback import playback_of

_FILE = """
name = "mine"
variant_of = "{variant}"
{more}
[motions.go]
duration = "{duration} s"
rate = 1000
laws = {{ {laws} }}
"""
_ROCK = 'A = { law = "sine", amplitude = "30 deg", frequency = "1 Hz" }'


def solver_of(
    folder: Path,
    variant: str,
    laws: str,
    *,
    more: str = "",
    duration: float = 1,
    rate: float = 1000,
) -> parakin.Solver:
    path = folder / "mine.toml"
    text = _FILE.format(variant=variant, laws=laws, more=more, duration=duration)
    path.write_text(text, "utf-8")
    return parakin.compile(path, coordinates="all")


def test_joints_beyond_their_limits_and_when(tmp_path: Path) -> None:
    """The crank swings by 30 degrees to either side of 40."""
    limits = 'limits = { A = ["5 deg", "65 deg"] }'
    solver = solver_of(tmp_path, "four-bar", _ROCK, more=limits)
    playback = playback_of(solver, "go")
    assert [*playback.beyond_limits] == ["A"]
    beyond = 40 + 30 * np.sin(2 * np.pi * playback.time) > 65
    np.testing.assert_array_equal(playback.beyond_limits["A"], beyond)
    assert playback.stop is None
    assert playback.note == ""


def test_histories_are_of_the_actuators(tmp_path: Path) -> None:
    playback = playback_of(solver_of(tmp_path, "four-bar", _ROCK), "go")
    assert (playback.actuators, playback.units) == (("A",), ("rad",))
    w, wave = 2 * np.pi, np.radians(30) * np.sin(2 * np.pi * playback.time)
    slope = np.radians(30) * np.cos(2 * np.pi * playback.time)
    expected = [np.radians(40) + wave, w * slope, -(w**2) * wave]
    np.testing.assert_allclose(playback.histories[:, :, 0], expected, atol=1e-9)
    assert playback.index(0.2505) == 251
    assert playback.values(0.25)["A"] == pytest.approx(np.radians(70), abs=1e-12)


def test_it_ends_where_the_arms_are_stretched(tmp_path: Path) -> None:
    far = 'platform.y = { law = "cosine", by = "1 m" }'
    playback = playback_of(solver_of(tmp_path, "five-bar", far), "go")
    end = np.sqrt((0.15 + 0.22) ** 2 - 0.1**2)  # by Pythagoras, on the axis of symmetry
    assert playback.point is not None
    assert 0 < end - playback.point[-1, 1] < 5e-3
    assert playback.stop is not None
    assert playback.stop.words.startswith("ended at 0.")
    assert playback.time[-1] < 1


def test_a_long_motion_is_thinned_evenly(tmp_path: Path) -> None:
    playback = playback_of(solver_of(tmp_path, "four-bar", _ROCK, duration=250), "go")
    assert playback.note == ", one sample in 7"  # of 250,001, at most 36,000
    assert len(playback.time) <= 36_000
    np.testing.assert_allclose(np.diff(playback.time), 7e-3, rtol=1e-6)


def test_what_cannot_start_is_refused(tmp_path: Path) -> None:
    nowhere = 'platform.y = { law = "constant", value = "9 m" }'
    solver = solver_of(tmp_path, "five-bar", nowhere)
    with pytest.raises(parakin.InputError, match="motion go: found its first sample is"):
        playback_of(solver, "go")
