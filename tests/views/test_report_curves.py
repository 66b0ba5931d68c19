"""The curves of a report: extremes, limits and flags are where they are."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes

import parakin
from parakin.views.extremes import extremes
from parakin.views.report_curves import (
    coordinate_curves,
    driven_curves,
    inline_svg,
    quality_curves,
)

pytest.importorskip("matplotlib")
RISE = np.radians(30)


@pytest.fixture(scope="module")
def solver() -> parakin.Solver:
    mechanism = parakin.load("four-bar")
    law = {"law": "sine", "amplitude": "30 deg", "frequency": "1 Hz"}
    rock = {"duration": "1 s", "rate": 1000, "laws": {"A": law}}
    return parakin.compile(
        mechanism.model_copy(update={"motions": {"rock": rock}}), machine_code=False
    )


@pytest.fixture(scope="module")
def rock(solver: parakin.Solver) -> xr.Dataset:
    return solver.solve("rock")


def marks(axes: Axes) -> list[tuple[float, float]]:
    points = [line.get_xydata() for line in axes.lines if line.get_marker() == "o"]
    return sorted((float(p[0][0]), float(p[0][1])) for p in map(np.asarray, points))


def test_extremes_of_a_sine_are_marked(rock: xr.Dataset) -> None:
    """The crank swings by 30 degrees to either side of 40."""
    figure = coordinate_curves(rock, "A", extremes(rock), (np.radians(5), np.radians(72)))
    position, velocity, acceleration = figure.axes
    np.testing.assert_allclose(marks(position), [(0.25, 70), (0.75, 10)], atol=1e-9)
    speed, push = 30 * 2 * np.pi, 30 * (2 * np.pi) ** 2
    (_, fast), (at, slow) = sorted(marks(velocity), key=lambda mark: -mark[1])
    assert (fast, at, slow) == pytest.approx((speed, 0.5, -speed))
    np.testing.assert_allclose(marks(acceleration), [(0.25, -push), (0.75, push)], rtol=1e-9)
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles == ["position [°]", "velocity [°/s]", "acceleration [°/s²]"]
    assert {label.get_text() for label in position.texts} == {"70", "10"}
    dashed = [line.get_ydata() for line in position.lines if line.get_linestyle() == "--"]
    assert sorted(float(np.asarray(y)[0]) for y in dashed) == pytest.approx([5, 72])


def test_limits_far_away_are_left_out(rock: xr.Dataset) -> None:
    figure = coordinate_curves(rock, "A", extremes(rock), (-10.0, np.inf))
    assert not [line for line in figure.axes[0].lines if line.get_linestyle() == "--"]


def test_what_is_driven(solver: parakin.Solver) -> None:
    figure = driven_curves(solver.motion("rock"), {"A": True})
    (line,) = figure.axes[0].lines
    time, angle = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
    np.testing.assert_allclose(angle, 40 + 30 * np.sin(2 * np.pi * time), atol=1e-9)
    assert figure.axes[0].get_title(loc="left") == "A [°]"


def test_quality_shows_closeness_and_where_singularities_are_crossed(
    solver: parakin.Solver, rock: xr.Dataset
) -> None:
    """The rocker reverses where crank and coupler are in line: by the law of cosines."""
    plain = quality_curves(rock, None)
    whole = quality_curves(rock, parakin.singularities(solver, rock))
    (left, right), (more, _) = plain.axes, whole.axes
    assert right.get_yscale() == "log"
    (own,) = left.lines
    assert [line.get_label() for line in more.lines[:3]] == [own.get_label(), "type 1", "type 2"]
    a, b, c, d = 40, 120, 80, 100  # [mm], of the file
    line_up = np.arccos(((a + b) ** 2 + d**2 - c**2) / (2 * (a + b) * d))
    phase = np.arcsin((line_up - np.radians(40)) / RISE)
    expected = [(np.pi - phase) / (2 * np.pi), 1 + phase / (2 * np.pi)]
    crossed = [float(np.asarray(line.get_xdata())[0]) for line in more.lines[3:]]
    np.testing.assert_allclose(sorted(crossed), expected, atol=1e-8)


def test_ids_of_an_inline_figure_begin_with_its_prefix(rock: xr.Dataset) -> None:
    figure = coordinate_curves(rock, "A", extremes(rock), (-np.inf, np.inf))
    svg = inline_svg(figure, "mine", "A over time")
    root = ElementTree.fromstring(svg)
    assert root.get("aria-label") == "A over time"
    ids = [element.get("id") for element in root.iter() if element.get("id")]
    assert ids
    assert all(name is not None and name.startswith("mine-") for name in ids)
    referred = re.findall(r'(?:href="|url\()#([^")]+)', svg)
    assert referred
    assert set(referred) <= set(ids)
