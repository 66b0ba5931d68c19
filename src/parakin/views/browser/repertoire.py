"""What a page can show: mechanisms of the catalogue or of the file that was named, and their
motions, solved. No other file is read than those named.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from parakin.arrays import FloatArray
from parakin.errors import InputError, ParakinError
from parakin.files.parsing import read_bytes
from parakin.files.reading import catalogue, load
from parakin.files.writing import check_suffix
from parakin.model.evaluation import graph_of
from parakin.model.expressions import Parameters, Value
from parakin.model.graph import Graph
from parakin.model.mechanism import Mechanism
from parakin.model.placement import placement_of
from parakin.solving.compiler import compile as compile_mechanism
from parakin.solving.solver import Solver
from parakin.solving.status import SOLVED, Status
from parakin.views.browser.drive import Drive, Stop
from parakin.views.solids.drawing import Drawing, drawing_of
from parakin.views.solids.shapes import Mesh

MESH_SUFFIXES = (".stl", ".obj", ".ply", ".glb")
_MAX_MESH = 100_000_000  # bytes
_SAMPLES = 36_000  # ten minutes at sixty a second: more than a page shows
_WINDOW = 100_000


@dataclass(frozen=True)
class Shown:
    """A mechanism ready to be shown. `solver` is None, and `problem` says why, where nothing of it
    can be driven as its file says.
    """

    name: str
    mechanism: Mechanism
    graph: Graph
    drawing: Drawing
    meshes: Mapping[str, Mesh]
    motions: tuple[str, ...]
    solver: Solver | None
    problem: str = ""


@dataclass(frozen=True)
class Take:
    """A solved motion as it is played, samples that are not solved left out.

    `time` (n,); `coordinates` by name, (n, coordinates) in `q`; `position` (n, bodies, 3) and
    `wxyz` (n, bodies, 4) of all bodies but the base; `point` (n, 3), the platform's, or None;
    `actuators` their names, `units`, and `histories` (3, n, actuators): position, velocity,
    acceleration; `beyond` the joints outside their limits, by number, and when, (n,). `stop` says
    why it ended before its time.
    """

    name: str
    time: FloatArray
    coordinates: tuple[str, ...]
    q: FloatArray
    position: FloatArray
    wxyz: FloatArray
    point: FloatArray | None
    actuators: tuple[str, ...]
    units: tuple[str, ...]
    histories: FloatArray
    conditioning: FloatArray
    residual: FloatArray
    beyond: Mapping[int, Any]
    stop: Stop | None = None
    said: str = ""

    def index(self, at: float) -> int:
        """The sample at a time [s], or the one after it."""
        return min(int(np.searchsorted(self.time, at - 1e-9)), len(self.time) - 1)

    def values(self, at: float) -> dict[str, float]:
        """Position of every coordinate at a time [s]."""
        return dict(zip(self.coordinates, self.q[self.index(at)].tolist(), strict=True))


@dataclass(frozen=True)
class Repertoire:
    """What may be shown. named: the mechanism asked for, a name of the catalogue or a file;
    motions, meshes: files that may be read beside it.
    """

    named: str
    parameters: Mapping[str, Value] = field(default_factory=dict)
    loops: str | None = None
    motions: tuple[str, ...] = ()
    meshes: tuple[str, ...] = ()

    @cached_property
    def names(self) -> tuple[str, ...]:
        """What can be chosen, the mechanism named first."""
        return (self.named, *(name for name in self._catalogue if name != self.named))

    @cached_property
    def _catalogue(self) -> tuple[str, ...]:
        return tuple(catalogue())

    def stamp(self) -> tuple[tuple[str, int, int], ...]:
        """Changes when one of the files named does."""
        stamps = []
        for name in (self.named, self.loops, *self.motions, *self.meshes):
            if name is None or name in self._catalogue:
                continue
            try:
                found = Path(name).stat()
            except OSError:  # being replaced, perhaps
                stamps.append((name, 0, 0))
                continue
            stamps.append((name, found.st_mtime_ns, found.st_size))
        return tuple(stamps)

    def load(self, name: str) -> Shown:
        """A mechanism by one of `names`. Raises InputError, AssemblyError."""
        if name not in self.names:
            raise InputError("mechanism", repr(name), "one that was named, or of the catalogue")
        own = name == self.named
        mechanism = load(name, self.parameters or None, self.loops) if own else load(name)
        graph = graph_of(mechanism)
        drawing = drawing_of(graph)
        meshes, problem = self._meshes(graph)
        solver: Solver | None = None
        try:
            if mechanism.driven:
                solver = compile_mechanism(mechanism, coordinates="all")
            else:
                problem = "No coordinates are driven: the file names none."
        except ParakinError as error:
            problem = str(error)
        motions = (*mechanism.motions, *(self.motions if own else ()))
        return Shown(
            name, mechanism, graph, drawing, meshes, motions if solver else (), solver, problem
        )

    def _meshes(self, graph: Graph) -> tuple[dict[str, Mesh], str]:
        """Shapes of bodies, from files that the mechanism names and the user does too."""
        allowed = {Path(name).resolve() for name in self.meshes}
        folder = Path(graph.mechanism.origin or ".").parent
        found: dict[str, Mesh] = {}
        left = []
        for body in graph.mechanism.bodies:
            if body.mesh is None:
                continue
            path = folder / body.mesh.file
            if path.resolve() not in allowed:
                left.append(body.mesh.file)
                continue
            place = f"{graph.mechanism.where}: bodies.{body.name}.mesh"
            solid = read_mesh(path)
            at = placement_of(
                body.mesh.on_body, Parameters(graph.mechanism.parameters, place), place
            )
            vertices = body.mesh.scale * solid.vertices @ np.array(at.R, dtype=float).T + at.p
            found[body.name] = solid._replace(vertices=vertices)
        if not left:
            return found, ""
        return (
            found,
            f"Not read, since only files named on the command line are (--mesh): {', '.join(left)}",
        )

    def play(self, shown: Shown, motion: str) -> Take:
        """A motion of `shown`, solved. Raises InputError."""
        if shown.solver is None or motion not in shown.motions:
            raise InputError("motion", repr(motion), f"one of {', '.join(shown.motions) or 'none'}")
        return take(shown.solver, motion)


def take(solver: Solver, motion: str) -> Take:
    """Solve a motion and keep what is shown of it; a long one is thinned. Raises InputError."""
    import xarray as xr

    asked = solver.motion(motion)
    stride = max(1, -(-asked.count // _SAMPLES))
    windows = []
    for k, window in enumerate(solver.stream(asked, _WINDOW, bodies=True)):
        first = -(k * _WINDOW) % stride
        windows.append(window.isel(time=slice(first, None, stride)))
    ds = windows[0] if len(windows) == 1 else xr.concat(windows, dim="time", data_vars="minimal")
    status = ds["status"].values
    solved = np.isin(status, SOLVED)
    count = len(solved) if solved.all() else int(np.argmin(solved))
    graph = solver.graph
    names = ds["coordinate"].values.tolist()
    stop = None if count == len(solved) else _stop(solver, ds, count)
    if count == 0:
        raise InputError(
            f"motion {motion}",
            f"its first sample is {Status(int(status[0])).words}",
            "one that starts where the mechanism stands",
        )
    ds = ds.isel(time=slice(count))
    moved = [n for n, a in zip(names, ds["actuated"].values, strict=True) if a] or list(
        solver.driven
    )
    chosen = ds.sel(coordinate=moved)
    histories = np.array(
        [chosen[order].values for order in ("position", "velocity", "acceleration")]
    )
    beyond: dict[int, Any] = {}
    for k, name in enumerate(names):
        low, high = graph.limits(name)
        values = ds["position"].values[:, k]
        outside = (values < low) | (values > high)
        if outside.any():
            number = graph.holder(name)
            beyond[number] = beyond.get(number, False) | outside
    point = None
    if graph.platform is not None:
        rows = graph.joints[graph.platform].coordinates[:3]
        offsets = [solver.plan.offset(k) for k in rows]
        point = (
            ds["position"].sel(coordinate=[graph.coordinates[k].name for k in rows]).values
            + offsets
        )
    return Take(
        motion,
        ds["time"].values,
        tuple(names),
        ds["position"].values,
        ds["body_position"].values,
        ds["body_orientation"].values,
        point,
        tuple(moved),
        tuple(chosen["unit"].values.tolist()),
        histories,
        ds["conditioning"].values,
        ds["residual"].values,
        beyond,
        stop,
        f", one sample in {stride}" if stride > 1 else "",
    )


def _stop(solver: Solver, ds: Any, count: int) -> Stop:
    """Why a motion ended after `count` samples."""
    status = Status(int(ds["status"].values[count]))
    if count == 0:
        return Stop(status, status.words, frozenset())
    last = dict(
        zip(
            ds["coordinate"].values.tolist(), ds["position"].values[count - 1].tolist(), strict=True
        )
    )
    drive = Drive(solver)
    stop = drive.blame(status) if drive.from_pose(last) else Stop(status, status.words, frozenset())
    return stop._replace(
        words=f"ended at {float(ds['time'].values[count - 1]):.4g} s: {stop.words}"
    )


def read_mesh(path: Path) -> Mesh:
    """Triangles from a file. Raises InputError; no file it may refer to is read."""
    import trimesh

    check_suffix(path, MESH_SUFFIXES, {}, "view")
    data = read_bytes(path, _MAX_MESH)
    try:
        found: Any = trimesh.load(io.BytesIO(data), file_type=path.suffix.lower()[1:], force="mesh")
        vertices = np.array(found.vertices, dtype=np.float64)
        faces = np.array(found.faces, dtype=np.int64)
    except Exception as error:  # whatever a broken file makes a foreign reader raise
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InputError(str(path), f"a mesh that cannot be read: {reason}", "triangles") from None
    if not len(faces) or not np.isfinite(vertices).all():
        raise InputError(str(path), "no triangles", "a mesh")
    return Mesh(vertices, faces)
