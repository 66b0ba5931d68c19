"""Commands as functions of the same names, and `save` and `record`.

All but three: `list` is `parakin.catalogue`, `modes` is `parakin.modes`, `solve` is `Solver.solve`.

A mechanism is a `Mechanism`, a name of the catalogue, or a file. The suffix of a path selects the
format; a file is written completely or not at all.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from parakin.model.mechanism import Mechanism

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from parakin.analysis.diagnosis import Diagnosis
    from parakin.model.expressions import Value
    from parakin.motion.motion import Motion
    from parakin.solving.solver import Solver
    from parakin.views.browser.viewer import Viewer


def check(mechanism: Mechanism | str | Path) -> Diagnosis:
    """Assemble a mechanism; determine its mobility, redundancy and idle freedoms; and find what
    would be refused or flagged, or is likely a slip.

    Raises InputError, on a bad motion of the mechanism too, and AssemblyError.
    """
    from parakin.analysis.diagnosis import diagnosis
    from parakin.files.reading import loaded

    return diagnosis(loaded(mechanism))


def draw(mechanism: Mechanism | str | Path, path: str | Path | None = None) -> Figure:
    """The kinematic scheme at home, in the symbols of ISO 3952. path: .svg, .pdf or .png, if it is
    to be written. Raises InputError, AssemblyError.
    """
    from parakin.files.reading import loaded
    from parakin.model.evaluation import graph_of
    from parakin.views.scheme import scheme

    if path is not None:
        scheme.check_scheme(Path(path))
    figure = scheme.scheme(graph_of(loaded(mechanism)))
    if path is not None:
        scheme.save(figure, Path(path))
    return figure


def plot(
    result: xr.Dataset,
    path: str | Path | None = None,
    *,
    coordinates: Sequence[str] | None = None,
    symbols: Mapping[str, str] | None = None,
    title: str = "",
) -> Figure:
    """Position, velocity, acceleration and, if the result has them, jerk, effort and power over
    time.

    path: .png, .svg or .pdf, if it is to be written. coordinates: by default the actuated ones,
    or all if there are none. symbols: by coordinate, in mathtext, such as a mechanism's `symbols`.
    Raises InputError.
    """
    from parakin.views import plots

    if path is not None:
        plots.check_figure(Path(path))
    figure = plots.histories(result, coordinates, symbols, title=title)
    if path is not None:
        plots.save(figure, Path(path))
    return figure


def film(
    solver: Solver,
    motion: Motion | str | Path,
    path: str | Path,
    *,
    forces: bool = False,
    preload: Mapping[str, float] | None = None,
) -> None:
    """Solve a motion and film it, .mp4 or .gif. forces: with arrows and curves of the actuators'
    efforts. preload: of redundant actuators, as for `Solver.solve`. Raises InputError.
    """
    from parakin.views import film as films
    from parakin.views.solids.drawing import drawing_of

    films.check_film(Path(path))
    motion = _motion(solver, motion)
    result = solver.solve(motion, bodies=True, forces=forces, preload=preload)
    mechanism = solver.mechanism
    title = f"{mechanism.name}, {motion.name}: {mechanism.title or 'a mechanism'}"
    films.save(drawing_of(solver.graph), result, Path(path), mechanism.symbols, title)


def report(
    mechanism: Mechanism | str | Path,
    motion: Motion | str | Path,
    path: str | Path,
    *,
    preload: Mapping[str, float] | None = None,
) -> None:
    """Write a report about a motion: one HTML file that needs no other. preload: efforts [N or N m]
    that those of redundant actuators are to be nearest to; {} for the least. Raises InputError,
    AssemblyError, DrivenError.
    """
    from parakin.files.reading import loaded
    from parakin.solving.compiler import compile
    from parakin.views import report as reports
    from parakin.views.extremes import extremes

    reports.check_report(Path(path))
    solver = compile(loaded(mechanism), coordinates="all")
    moved = _motion(solver, motion)
    forces = preload is not None or not solver.no_forces
    result = solver.solve(moved, forces=forces, reactions=forces, preload=preload)
    solved = reports.Solved(solver, moved, result, extremes(result))
    made = f"parakin.report({solver.mechanism.name!r}, {moved.name!r}, {Path(path).name!r})"
    reports.write(reports.report(solved, made, datetime.now().astimezone()), Path(path))


def view(
    mechanism: Mechanism | str | Path,
    motions: Sequence[str | Path] = (),
    *,
    parameters: Mapping[str, Value] | None = None,
    loops: str | Path | None = None,
    meshes: Sequence[str | Path] = (),
    host: str = "127.0.0.1",
    port: int = 8080,
) -> AbstractContextManager[Viewer]:
    """Serve a mechanism to browsers while the context lasts; it yields a viewer with a `url`.

    motions: files of further motions to play. parameters, loops: of a mechanism given by its name
    or file, as `load` takes them. meshes: those of the files named by the mechanism that may be
    read. A file is loaded again when it changes. Raises InputError.
    """
    from parakin.views.browser.content import Content
    from parakin.views.browser.viewer import serving

    content = Content(
        mechanism if isinstance(mechanism, Mechanism) else str(mechanism),
        parameters or {},
        None if loops is None else str(loops),
        tuple(map(str, motions)),
        tuple(map(str, meshes)),
    )
    return serving(content, host, port)


def export(
    mechanism: Mechanism | str | Path,
    path: str | Path,
    driven: Sequence[str] | None = None,
    *,
    forces: bool = False,
    preload: Mapping[str, float] | None = None,
) -> list[Path]:
    """Write a mechanism for another program: .xml (MuJoCo), .urdf with a file of its loops, or .c
    with its header and test. Returns the paths. If it fails, no file is changed.

    driven: the driven coordinates of the C code, by default the mechanism's own. forces: a function
    of the actuators' efforts in it, too. preload: efforts [N or N m] that those of redundant
    actuators are to be nearest to; {} for the least. Raises InputError, AssemblyError, DrivenError.
    """
    from parakin.exports.export import export as exported
    from parakin.files.reading import loaded

    return exported(loaded(mechanism), Path(path), driven, forces=forces, preload=preload)


def save(result: xr.Dataset | Iterable[xr.Dataset], path: str | Path) -> None:
    """Write a result, or the windows of `Solver.stream`, as .csv, .nc or .parquet.
    Raises InputError.
    """
    import xarray as xr

    from parakin.files import datasets

    datasets.write([result] if isinstance(result, xr.Dataset) else result, Path(path))


def record(mechanism: Mechanism | str | Path, motion: str | Path, path: str | Path) -> None:
    """Write one .html file that plays a motion without a server. Raises InputError."""
    from parakin.files.reading import loaded
    from parakin.files.writing import check_suffix, replacing
    from parakin.views.browser.content import Content
    from parakin.views.browser.standalone import standalone_page

    check_suffix(Path(path), (".html", ".htm"), {"viser": "viser"}, "view")
    content = Content(loaded(mechanism), motions=(str(motion),))
    shown = content.load(content.first)
    text = standalone_page(shown, content.playback(shown, str(motion)))
    with replacing(Path(path)) as temporary:
        temporary.write_text(text, "utf-8", newline="\n")


def _motion(solver: Solver, motion: Motion | str | Path) -> Motion:
    return solver.motion(motion) if isinstance(motion, (str, Path)) else motion
