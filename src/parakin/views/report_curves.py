"""The curves of a report: each coordinate over time with its extremes marked, as inline SVG."""

from __future__ import annotations

import io
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from parakin.analysis.singularities import Closeness
from parakin.arrays import ORDERS, PER_TIME, FloatArray
from parakin.model.motors import Motor
from parakin.views.extremes import Extremes
from parakin.views.flags import flagged_spans
from parakin.views.force_extremes import RPM, ForceExtremes
from parakin.views.scheme.sheet import STYLE
from parakin.views.thinning import thinned
from parakin.views.units import unit_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from parakin.motion.motion import Motion

_BUCKETS = 400  # of a thinned curve
_LAWS = 8000  # samples of a prescribed motion
_WIDTH = 7.2  # inches
_CURVE, _MARK, _LIMIT, _FLAG = "#0072B2", "#111111", "#b3121d", "#b3121d"


def coordinate_curves(
    ds: xr.Dataset, name: str, found: Extremes, limits: tuple[float, float]
) -> Figure:
    """Position, velocity and acceleration of a coordinate side by side, with extremes marked."""
    one = ds.sel(coordinate=name)
    unit = unit_of(str(one["unit"].item()) == "rad")
    scale = unit.per_si
    figure, panels = _figure(1, 3, 1.55)
    span = (float(ds["time"].values[0]), float(ds["time"].values[-1]))
    k = list(found.coordinates).index(name)
    for j, (axes, order) in enumerate(zip(panels, ORDERS[:3], strict=True)):
        _curve(axes, ds["time"].values, scale * one[order].values, _CURVE)
        for values, times, above in (
            (found.high, found.high_time, True),
            (found.low, found.low_time, False),
        ):
            if np.isfinite(values[j, k]):
                at, value = float(times[j, k]), scale * float(values[j, k])
                _mark(axes, at, value, span, above=above)
        axes.margins(y=0.28)
        axes.set_title(
            f"{order} [{unit.symbol.strip()}{PER_TIME[j]}]", fontsize=7.5, loc="left", pad=3
        )
        if j == 0:
            _limit_lines(axes, [scale * limit for limit in limits])
        _finish(axes, ds)
    return figure


def force_curves(ds: xr.Dataset, name: str, found: ForceExtremes, motor: Motor | None) -> Figure:
    """Effort and power of an actuator and, if it has a drive, the motor's torque over its speed,
    within its limits.
    """
    one, k = ds.sel(actuator=name), found.actuators.index(name)
    figure, panels = _figure(1, 2 if motor is None else 3, 1.55)
    time = ds["time"].values
    span = (float(time[0]), float(time[-1]))
    limits = (np.inf, np.inf) if motor is None else (motor.max_effort, motor.max_power)
    for axes, quantity, unit, limit in zip(
        panels, ("effort", "power"), (found.units[k], "W"), limits, strict=False
    ):
        _curve(axes, time, one[quantity].values, _CURVE)
        range_ = found.ranges[quantity]
        for values, times, above in (
            (range_.high, range_.high_time, True),
            (range_.low, range_.low_time, False),
        ):
            if np.isfinite(values[k]):
                _mark(axes, float(times[k]), float(values[k]), span, above=above)
        axes.margins(y=0.28)
        axes.set_title(f"{quantity} [{unit}]", fontsize=7.5, loc="left", pad=3)
        _limit_lines(axes, [-limit, limit])
        _finish(axes, ds)
    band = one["effort_band"].values
    if np.nanmax(band, initial=0.0) > 0.0:
        low, high = one["effort"].values - band, one["effort"].values + band
        rows = thinned(np.array([low, high]), _BUCKETS)
        panels[0].fill_between(time[rows], low[rows], high[rows], color=_CURVE, alpha=0.25)
    if motor is not None:
        _torque_over_speed(panels[2], one, motor)
    return figure


def _torque_over_speed(axes: Axes, one: xr.Dataset, motor: Motor) -> None:
    scale = RPM if motor.turns else 1.0
    speed, torque = scale * one["motor_speed"].values, one["motor_torque"].values
    rows = thinned(np.array([speed, torque]), _BUCKETS)
    axes.plot(speed[rows], torque[rows], color=_CURVE, linewidth=1.1)
    axes.margins(x=0.08, y=0.12)
    _limit_lines(axes, [-motor.max_torque, motor.max_torque])
    fastest = scale * abs(motor.ratio) * motor.max_speed
    low, high = axes.dataLim.intervalx
    for limit in (-fastest, fastest):
        if low - (high - low) < limit < high + (high - low):
            axes.axvline(limit, color=_LIMIT, linewidth=0.8, linestyle="--")
    for line in (axes.axhline, axes.axvline):
        line(0.0, color="0.6", linewidth=0.5, zorder=0)
    unit, per = ("N m", "rpm") if motor.turns else ("N", "m/s")
    axes.set_title(f"motor torque [{unit}]", fontsize=7.5, loc="left", pad=3)
    _dress(axes)
    axes.set_xlabel(f"motor speed [{per}]", fontsize=6.5, labelpad=1)


def driven_curves(motion: Motion, angles: Mapping[str, bool]) -> Figure:
    """The prescribed positions of the driven coordinates."""
    names = motion.coordinates
    columns = min(3, len(names))
    figure, panels = _figure(-(-len(names) // columns), columns, 1.45)
    many = motion.count > _LAWS
    steps = np.linspace(0, motion.count - 1, _LAWS).astype(int)
    parts = [motion.window(i, i + 1) for i in steps.tolist()] if many else [motion.samples()]
    time = np.concatenate([part.time for part in parts])
    position = np.concatenate([part.position for part in parts], axis=1)
    for axes, name, row in zip(panels, names, position, strict=False):
        unit = unit_of(angles[name])
        _curve(axes, time, unit.per_si * row, "#D55E00")
        axes.set_title(
            f"{name} [{unit.symbol.strip()}]", fontsize=7.5, loc="left", pad=3, parse_math=False
        )
        axes.margins(y=0.1)
        _finish(axes, None)
    for axes in panels[len(names) :]:
        axes.set_axis_off()
    return figure


def quality_curves(ds: xr.Dataset, found: Closeness | None) -> Figure:
    """Conditioning and closeness to singularities, 0 to 1, and the residual of all loops."""
    figure, (left, right) = _figure(1, 2, 2.0)
    time = ds["time"].values
    _curve(left, time, ds["conditioning"].values, _CURVE, "as driven")
    if found is not None:
        _curve(left, found.time, found.type1, "#009E73", "type 1", "--")
        _curve(left, found.time, found.type2, "#D55E00", "type 2", "-.")
        for crossing in found.crossings:
            left.axvline(crossing.time, color=_FLAG, linewidth=1.0)
    left.set_ylim(0, 1.05)
    left.legend(fontsize=6.5, frameon=False, ncols=3, loc="lower right")
    left.set_title("conditioning and closeness (0 is singular)", fontsize=7.5, loc="left", pad=3)
    _curve(right, time, np.maximum(ds["residual"].values, 1e-18), _CURVE)
    right.set_yscale("log")
    right.set_title("residual of all loops [m]", fontsize=7.5, loc="left", pad=3)
    for axes in (left, right):
        _finish(axes, ds)
    return figure


def inline_svg(figure: Figure, prefix: str, label: str) -> str:
    """A figure as an <svg> element; its ids begin with `prefix`, to be unique in a page."""
    import matplotlib as mpl

    text = io.StringIO()
    with mpl.rc_context({**STYLE, "svg.hashsalt": prefix}):
        figure.savefig(text, format="svg", metadata={"Date": None})
    svg = text.getvalue()
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg[svg.index("<svg") :], flags=re.DOTALL)
    svg = svg.replace("*{stroke", "svg *{stroke")
    svg = re.sub(r'\bid="', f'id="{prefix}-', svg)
    svg = re.sub(r'href="#', f'href="#{prefix}-', svg)
    svg = re.sub(r"url\(#", f"url(#{prefix}-", svg)
    return svg.replace("<svg", f'<svg role="img" aria-label="{label}"', 1).strip()


def _figure(rows: int, columns: int, height: float) -> tuple[Figure, list[Axes]]:
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context({**STYLE, "font.size": 7, "axes.linewidth": 0.5}):
        figure = Figure(figsize=(_WIDTH, rows * height), layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False)
    return figure, grid.ravel().tolist()


def _curve(
    axes: Axes,
    time: FloatArray,
    values: FloatArray,
    colour: str,
    label: str = "",
    style: str = "-",
) -> None:
    rows = thinned(values[None], _BUCKETS)
    axes.plot(time[rows], values[rows], color=colour, linewidth=1.1, label=label, linestyle=style)


def _mark(axes: Axes, time: float, value: float, span: tuple[float, float], *, above: bool) -> None:
    """An extreme with its value, to its side near an end of the curve."""
    axes.plot([time], [value], "o", color=_MARK, markersize=2.6, zorder=4)
    height = float(np.ptp(axes.dataLim.intervaly))
    value = value if abs(value) > 1e-9 * height else 0.0  # round-off is not shown
    along = (time - span[0]) / (span[1] - span[0]) if span[1] > span[0] else 0.5
    side = "left" if along < 0.15 else "right" if along > 0.85 else "center"
    axes.annotate(
        f"{value:z.4g}",
        (time, value),
        xytext=({"left": 2, "right": -2, "center": 0}[side], 3 if above else -3),
        textcoords="offset points",
        ha=side,
        va="bottom" if above else "top",
        fontsize=6.5,
        parse_math=False,
    )


def _limit_lines(axes: Axes, limits: Sequence[float]) -> None:
    """Limits close enough to the curve to be shown."""
    low, high = axes.dataLim.intervaly
    room = max(high - low, 1e-9)
    for limit in limits:
        if low - room < limit < high + room:
            axes.axhline(limit, color=_LIMIT, linewidth=0.8, linestyle="--")


def _finish(axes: Axes, ds: xr.Dataset | None) -> None:
    """Dress axes over time."""
    axes.margins(x=0)
    if ds is not None and ds.sizes["time"] > 1:
        axes.set_xlim(float(ds["time"].values[0]), float(ds["time"].values[-1]))
    _dress(axes)
    axes.set_xlabel("time [s]", fontsize=6.5, labelpad=1)
    if ds is not None:
        for span in flagged_spans(ds):
            axes.axvspan(*span, color=_FLAG, alpha=0.12, linewidth=0)


def _dress(axes: Axes) -> None:
    if axes.get_yscale() == "linear":
        axes.ticklabel_format(axis="y", style="plain", useOffset=False)
    axes.grid(visible=True, linewidth=0.3, color="0.85")
    axes.tick_params(labelsize=6.5, length=2)
    axes.spines[["top", "right"]].set_visible(False)
