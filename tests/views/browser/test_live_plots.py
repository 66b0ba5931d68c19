"""Live plots: units, values and the cursor, as a page is sent them."""

from __future__ import annotations

import contextlib
from typing import Any

import numpy as np
import pendulum
import pytest
from browser import chromium, needs_chromium, viewed

import parakin
from parakin.views.browser.live_plots import LivePlots
from parakin.views.browser.playback import Playback, playback_of


class Plot:
    """What viser's handle of a plot has."""

    def __init__(self, data: tuple[Any, ...], series: Any, title: str, scales: Any) -> None:
        self.data, self.series, self.title, self.scales = data, series, title, scales
        self.axes: Any = ()
        self.removed = False

    def remove(self) -> None:
        self.removed = True


class Gui:
    """What viser's gui is asked for."""

    def __init__(self) -> None:
        self.plots: list[Plot] = []

    def add_folder(self, _: str) -> contextlib.AbstractContextManager[None]:
        return contextlib.nullcontext()

    def add_uplot(self, data: Any, series: Any, *, title: str, scales: Any, **_: Any) -> Plot:
        self.plots.append(Plot(data, series, title, scales))
        return self.plots[-1]


@pytest.fixture(scope="module")
def general() -> Playback:
    return playback_of(parakin.compile("flight-simulator", coordinates="all"), "general")


def test_lengths_are_in_millimetres(general: Playback) -> None:
    gui = Gui()
    LivePlots(gui).show(general)
    titles = ["position [mm]", "velocity [mm/s]", "acceleration [mm/s²]", "effort [N]", "power [W]"]
    assert [plot.title for plot in gui.plots] == titles
    labels = [series["label"] for series in gui.plots[0].series]
    assert labels == ["t [s]", "A2", "B3", "C3", "now"]
    slider = gui.plots[0].data[1]
    assert np.max(slider) == pytest.approx(1e3 * general.histories[0, :, 0].max(), rel=1e-12)


def test_angles_are_in_degrees() -> None:
    """The crank turns once in a second."""
    gui = Gui()
    LivePlots(gui).show(playback_of(parakin.compile("four-bar", coordinates="all"), "turn"))
    assert gui.plots[0].title == "position [deg]"
    assert np.ptp(gui.plots[0].data[1]) == pytest.approx(360, abs=1e-9)


def test_the_cursor_is_upright_on_the_curves(general: Playback) -> None:
    gui = Gui()
    plots = LivePlots(gui)
    plots.show(general)
    plots.cursor(1.2345)
    for plot in gui.plots:
        time, *curves, cursor = plot.data
        assert (np.diff(time) >= 0).all()
        (at,) = {float(t) for t in time[np.isfinite(cursor)]}
        assert at == 1.2345
        low, high = plot.scales["y"]["range"]
        assert cursor[np.isfinite(cursor)].tolist() == [low, high]
        assert low < min(curve.min() for curve in curves)
        assert high > max(curve.max() for curve in curves)


def test_another_motion_replaces_them(general: Playback) -> None:
    gui = Gui()
    plots = LivePlots(gui)
    plots.show(general)
    plots.show(general)
    assert [plot.removed for plot in gui.plots] == [True] * 5 + [False] * 5
    plots.clear()
    assert all(plot.removed for plot in gui.plots)


@needs_chromium
def test_no_tick_is_cut_off() -> None:
    """Signs of four-digit ticks were."""
    drawn = """
        window.drawn = [];
        const fill = CanvasRenderingContext2D.prototype.fillText;
        CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
            const left = this.textAlign === "right" ? x - this.measureText(text).width : x;
            window.drawn.push([text, this.getTransform().transformPoint({x: left, y}).x]);
            return fill.apply(this, arguments);
        };"""
    with chromium() as browser:
        browser.add_init_script(drawn)
        with viewed(browser, "four-bar") as page:
            ticks = "window.drawn.filter(([text, _]) => /^[-\u2212]\\d?,?\\d{3}/.test(text))"
            page.page.wait_for_function(f"() => {ticks}.length")
            assert min(left for _, left in page.page.evaluate(ticks)) >= 0


def test_efforts_and_power_have_plots_that_follow_payloads() -> None:
    loaded = pendulum.pendulum().with_payload("0 kg at arm")
    solver = parakin.compile(loaded, coordinates="all")
    gui = Gui()
    plots = LivePlots(gui)
    plots.show(playback_of(solver, "swing", {"payload": 0.0}))
    assert [plot.title for plot in gui.plots[3:]] == ["effort [N m]", "power [W]"]
    effort, *_ = pendulum.efforts(np.linspace(0.0, 2.0, 20_001))
    for _ in range(2):
        drawn = gui.plots[3].data[1]
        assert np.nanmax(drawn) == pytest.approx(effort.max(), rel=1e-3)
        assert np.nanmin(drawn) == pytest.approx(effort.min(), rel=1e-3)
        plots.show_forces(playback_of(solver, "swing", {"payload": 5.0}))  # on the axis
    assert len(gui.plots) == 5
    assert not any(plot.removed for plot in gui.plots)
