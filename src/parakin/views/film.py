"""Films of results: the moving mechanism next to the time histories of its actuators.

Every frame shows the last solved sample at its time; poses are not interpolated.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from parakin.arrays import ORDERS, FloatArray, IntArray
from parakin.errors import InputError
from parakin.files.writing import check_suffix, replacing
from parakin.solving.results import flag_words
from parakin.views.film_arrows import FilmArrows
from parakin.views.plots import draw_histories
from parakin.views.solids.drawing import Drawing
from parakin.views.solids.painting import Painter

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

Image = NDArray[np.uint8]

SUFFIXES = (".mp4", ".gif")
RATE = 25  # frames a second: 40 ms, a duration that GIF can represent
_LONGEST = 20.0  # seconds; longer motions are played faster
_WIDTH, _HEIGHT = 1280, 720  # even: H.264 stores colours at half the resolution
_HELD = RATE  # frames that the last pose is shown if a motion is not solved to its end
_FITTED = 24  # poses that must fit into the picture


def check_film(path: Path) -> None:
    """Raises InputError if the suffix is not one of a film, or a package is missing."""
    writer = {"av": "PyAV"} if path.suffix.lower() == ".mp4" else {"PIL": "Pillow"}
    check_suffix(path, SUFFIXES, {"matplotlib": "matplotlib"} | writer, "video")


class Timing(NamedTuple):
    """The sample of each frame, how much faster than real time, and why the motion ended early."""

    samples: IntArray
    speed: float
    ended: str


def timing(ds: xr.Dataset) -> Timing:
    """Frames at `RATE` up to the last sample with a pose. Raises InputError if none has one."""
    time = ds["time"].values
    posed = np.flatnonzero(np.isfinite(ds["body_position"].values).all(axis=(1, 2)))
    if not len(posed):
        raise InputError(f"motion {ds.attrs['motion']}", "no sample with a pose", "at least one")
    duration = float(time[posed[-1]] - time[posed[0]])
    speed = max(1.0, duration / _LONGEST)
    count = round(duration / speed * RATE) + 1
    at = np.linspace(time[posed[0]], time[posed[-1]], count)
    # A rounding error must not put a frame before the sample it falls on.
    slack = 1e-9 * max(1.0, float(np.abs(time).max()))
    samples = posed[np.searchsorted(time[posed], at + slack, side="right") - 1]
    ended = ""
    if posed[-1] + 1 < len(time):
        why = flag_words(ds, int(posed[-1]) + 1)
        ended = f"ends at {time[posed[-1]]:.3g} s: {why}"
        samples = np.append(samples, np.full(_HELD, posed[-1]))
    return Timing(samples, speed, ended)


def poses(drawing: Drawing, ds: xr.Dataset) -> tuple[FloatArray, FloatArray]:
    """R (samples, bodies, 3, 3) and p (samples, bodies, 3) of the drawing's bodies and its fixed
    base, from a result with all bodies.
    """
    from scipy.spatial.transform import Rotation

    n, places = ds.sizes["time"], {name: k for k, name in enumerate(ds["body"].values.tolist())}
    R = np.tile(np.eye(3), (n, len(drawing.arrangement.poses), 1, 1))
    p = np.zeros((n, len(drawing.arrangement.poses), 3))
    for body, name in enumerate(drawing.arrangement.graph.bodies):
        if name in places:
            p[:, body] = ds["body_position"].values[:, places[name]]
            turn = ds["body_orientation"].values[:, places[name]]
            good = np.isfinite(turn).all(axis=1)
            R[~good, body] = np.nan
            R[good, body] = Rotation.from_quat(turn[good], scalar_first=True).as_matrix()
    return R, p


def images(
    drawing: Drawing,
    ds: xr.Dataset,
    symbols: Mapping[str, str] | None = None,
    title: str = "",
) -> Iterator[Image]:
    """The frames (height, width, 3), at `RATE`, of a result with all bodies."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    shown = timing(ds)
    R, p = poses(drawing, ds.isel(time=shown.samples))
    time = ds["time"].values[shown.samples]

    figure = Figure(figsize=(_WIDTH / 100, _HEIGHT / 100), dpi=100, layout="constrained")
    canvas = FigureCanvasAgg(figure)
    grid = figure.add_gridspec(1, 2, width_ratios=(1.1, 1))
    left, right = figure.add_subfigure(grid[0]), figure.add_subfigure(grid[1])
    quantities = [name for name in (*ORDERS, "effort") if name in ds]
    draw_histories(right, ds, symbols=symbols, orders=quantities)
    cursors = [axes.axvline(time[0], color="0.2", linewidth=1.0) for axes in right.axes]
    figure.suptitle(title, fontsize=11, parse_math=False)

    painter, axes = Painter.of(drawing), left.subplots()
    painted = painter.paint(axes, R[0], p[0])
    some = np.unique(np.linspace(0, len(R) - 1, _FITTED).round().astype(int))
    way = painter.seen(_traced(drawing, R, p))
    efforts = FilmArrows(drawing, painter, axes, ds)
    inside = np.concatenate([way, efforts.reach(R[some], p[some], shown.samples[some])])
    _frame(axes, painter.window(R[some], p[some]), inside)
    (trace,) = axes.plot([], [], color="#D55E00", linewidth=1.2, zorder=3)
    clock = axes.text(0.01, 0.01, "", transform=axes.transAxes, fontsize=10, zorder=4)
    flag = axes.text(0.01, 0.97, "", transform=axes.transAxes, fontsize=10, color="#B00000")
    moving = [painted, trace, clock, flag, *cursors, *efforts.artists]
    for artist in moving:
        artist.set_animated(True)
    # What does not move is drawn once.
    canvas.draw()  # type: ignore[no-untyped-call]
    still = canvas.copy_from_bbox(figure.bbox)  # type: ignore[no-untyped-call]
    faster = f"   (shown {shown.speed:.3g} times faster)" if shown.speed > 1 else ""
    for k in range(len(time)):
        canvas.restore_region(still)  # type: ignore[no-untyped-call]
        polygons, colours = painter.polygons(R[k], p[k])
        painted.set_verts(polygons)  # type: ignore[arg-type]  # arrays are ten times faster
        painted.set(facecolors=colours, edgecolors=colours)
        trace.set_data(way[: k + 1, 0], way[: k + 1, 1])
        efforts.show(R[k], p[k], int(shown.samples[k]))
        clock.set_text(f"t = {time[k]:.2f} s{faster}")
        last = bool(shown.ended) and shown.samples[k] == shown.samples[-1]
        flag.set_text(shown.ended if last else flag_words(ds, int(shown.samples[k])))
        for cursor in cursors:
            cursor.set_xdata([time[k], time[k]])
        for artist in moving:
            artist.draw(canvas.get_renderer())  # type: ignore[no-untyped-call]
        seen = np.asarray(canvas.buffer_rgba())  # type: ignore[no-untyped-call]
        yield seen[:, :, :3].copy()


def _frame(axes: Axes, window: FloatArray, inside: FloatArray) -> None:
    """Make axes show a window: left, right, bottom and top, and points (n, 2)."""
    (left, right), (bottom, top) = (
        (np.nanmin([low, *along]), np.nanmax([high, *along]))
        for low, high, along in zip(window[::2], window[1::2], inside.T, strict=True)
    )
    axes.set(xlim=(left, right), ylim=(bottom, top))


def _traced(drawing: Drawing, R: FloatArray, p: FloatArray) -> FloatArray:
    """The platform's point (n, 3), or the first named point of a link; NaN if there is none."""
    graph = drawing.arrangement.graph
    if graph.platform is not None:
        joint = graph.joints[graph.platform]
        body, place = joint.child, np.array(joint.M.p, dtype=float)
    else:
        named = [(b, np.array(at, dtype=float)) for b, at in graph.points.values() if b]
        if not named:
            return np.full((len(R), 3), np.nan)
        body, place = named[0]
    return np.asarray(R[:, body] @ place + p[:, body])


def save(
    drawing: Drawing,
    ds: xr.Dataset,
    path: Path,
    symbols: Mapping[str, str] | None = None,
    title: str = "",
) -> None:
    """Write the film of a result with all bodies as MP4 or GIF. Raises InputError."""
    check_film(path)
    frames = images(drawing, ds, symbols, title)
    with replacing(path) as temporary:
        if path.suffix.lower() == ".mp4":
            _write_mp4(frames, temporary)
        else:
            _write_gif(frames, temporary)


def _write_mp4(frames: Iterator[Image], path: Path) -> None:
    import av

    with av.open(str(path), "w", format="mp4", options={"movflags": "faststart"}) as box:
        stream = box.add_stream("libx264", rate=RATE, options={"crf": "20"})
        stream.width, stream.height, stream.pix_fmt = _WIDTH, _HEIGHT, "yuv420p"
        for image in frames:
            box.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
        box.mux(stream.encode())


def _write_gif(frames: Iterator[Image], path: Path) -> None:
    from PIL import Image as Pillow

    # Half as large: GIF compresses little.
    small = (Pillow.fromarray(image).reduce(2) for image in frames)
    indexed = (image.quantize(128, Pillow.Quantize.FASTOCTREE) for image in small)
    first = next(indexed)
    first.save(
        path,
        format="GIF",
        save_all=True,
        append_images=indexed,
        duration=1000 // RATE,
        loop=0,
    )
