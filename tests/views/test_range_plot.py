"""The figure of a range: its bars, panels and words, and what is left out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.patches import Rectangle

import parakin
from parakin.errors import InputError
from parakin.views import range_plot, range_text

RIG = Path(__file__).parents[2] / "examples" / "rig.toml"


def test_bars_are_as_long_as_told_and_say_what_stops_them() -> None:
    found = parakin.range(parakin.compile(RIG))
    lengths, angles = range_plot.ranges(found, "rig").axes
    widths = [bar.get_width() for bar in lengths.patches if isinstance(bar, Rectangle)]
    assert widths == pytest.approx(1e3 * found["travel"].values[:3].ravel())
    assert len(angles.patches) == 6
    words = [text.get_text() for text in lengths.texts]
    assert "-375.5  P1 > 1.26 m" in words
    assert "±1.180 m/s" in words
    assert lengths.get_xlabel() == "from the pose [mm]"
    assert angles.get_xlabel() == "from the pose [deg]"


def test_each_pair_has_a_panel() -> None:
    found = parakin.range(parakin.compile(RIG), pairs=True, rays=16)
    figure = range_plot.ranges(found)
    panels = [axes for axes in figure.axes if axes.collections]
    assert len(panels) == 15
    x, y = np.asarray(panels[0].patches[0].get_path().vertices).T
    assert x.max() == pytest.approx(329.63, abs=0.01)
    assert y.max() < 400.0


def test_what_is_free_is_drawn_as_free() -> None:
    (axes,) = range_plot.ranges(parakin.range(parakin.compile("slider-crank"))).axes
    assert [text.get_text() for text in axes.texts] == ["free", "free", ""]


def test_all_that_is_free_in_pairs_too_is_drawn() -> None:
    found = parakin.range(parakin.compile("gough-stewart"), pairs=True, rays=8)
    assert range_plot.ranges(found).axes


def test_nothing_is_drawn_of_a_pose_that_is_none() -> None:
    found = parakin.range(parakin.compile(RIG), {"platform.x": 1.0})
    with pytest.raises(InputError, match=r"at 1\.789 m"):
        range_plot.ranges(found)
    assert "no range from there" in range_text.stopped_words(found)
