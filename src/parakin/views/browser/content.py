"""What the pages offer: the catalogue, the mechanism and the files named at start-up.

No other file is read.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from parakin.algebra.spatial import as_array
from parakin.caching import cached_property
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
from parakin.views.browser.playback import Playback, playback_of
from parakin.views.solids.drawing import Drawing, drawing_of
from parakin.views.solids.shapes import Mesh

MESH_SUFFIXES = (".stl", ".obj", ".ply", ".glb")
_MAX_MESH = 100_000_000  # bytes


@dataclass(frozen=True)
class LoadedMechanism:
    """A mechanism ready to be shown. If it cannot be driven as its file specifies, `solver` is
    None and `problem` is the reason.
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
class Content:
    """What the pages may show.

    mechanism: the one to begin with, itself, or a name of the catalogue or a file; parameters,
    loops: for the latter, as `parakin.load` takes them; motions, meshes: other files that may be
    read; payloads: masses on the first mechanism's bodies, such as "80 kg at seat".
    """

    mechanism: Mechanism | str
    parameters: Mapping[str, Value] = field(default_factory=dict)
    loops: str | None = None
    motions: tuple[str, ...] = ()
    meshes: tuple[str, ...] = ()
    payloads: tuple[str, ...] = ()

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The mechanisms to choose from, the one to begin with first."""
        return (self.first, *(name for name in self._catalogue if name != self.first))

    @property
    def first(self) -> str:
        """The name of the mechanism to begin with."""
        return self.mechanism if isinstance(self.mechanism, str) else self.mechanism.name

    @cached_property
    def _catalogue(self) -> tuple[str, ...]:
        return tuple(catalogue())

    def stamp(self) -> tuple[tuple[str, int, int], ...]:
        """A value that changes when one of the files does."""
        stamps = []
        file = self.mechanism if isinstance(self.mechanism, str) else None
        for name in (file, self.loops, *self.motions, *self.meshes):
            if name is None or name in self._catalogue:
                continue
            try:
                found = Path(name).stat()
            except OSError:  # perhaps while an editor replaces it
                stamps.append((name, 0, 0))
                continue
            stamps.append((name, found.st_mtime_ns, found.st_size))
        return tuple(stamps)

    def load(self, name: str) -> LoadedMechanism:
        """Load one of `names`. Raises InputError, AssemblyError."""
        if name not in self.names:
            expected = "one from the catalogue, or the one named at start-up"
            raise InputError("mechanism", repr(name), expected)
        own = name == self.first
        mechanism = self._first() if own else load(name)
        graph = graph_of(mechanism)
        drawing = drawing_of(graph)
        meshes, problem = self._meshes(graph)
        solver: Solver | None = None
        try:
            if mechanism.driven:
                solver = compile_mechanism(mechanism, coordinates="all")
            else:
                problem = "The file names no driven coordinates."
        except ParakinError as error:
            problem = str(error)
        others = self.motions if own else ()
        motions = (*mechanism.motions, *(m for m in others if m not in mechanism.motions))
        return LoadedMechanism(
            name, mechanism, graph, drawing, meshes, motions if solver else (), solver, problem
        )

    def _first(self) -> Mechanism:
        if isinstance(self.mechanism, Mechanism):
            found = self.mechanism
        else:
            found = load(self.mechanism, self.parameters or None, self.loops)
        for text in self.payloads:
            found = found.with_payload(text)
        return found

    def _meshes(self, graph: Graph) -> tuple[dict[str, Mesh], str]:
        """Shapes of bodies from the mesh files that both the mechanism and the user name, and a
        message about the others.
        """
        allowed = {Path(name).resolve() for name in self.meshes}
        found: dict[str, Mesh] = {}
        skipped = []
        for body in graph.mechanism.bodies:
            if body.mesh is None:
                continue
            path = graph.mechanism.folder / body.mesh.file
            if path.resolve() not in allowed:
                skipped.append(body.mesh.file)
                continue
            place = f"{graph.mechanism.where}: bodies.{body.name}.mesh"
            solid = read_mesh(path)
            at = placement_of(
                body.mesh.on_body, Parameters(graph.mechanism.parameters, place), place
            )
            vertices = body.mesh.scale * solid.vertices @ as_array(at.R).T + as_array(at.p)
            found[body.name] = solid._replace(vertices=vertices)
        if not skipped:
            return found, ""
        return found, f"Not read because not named with --mesh: {', '.join(skipped)}"

    def findings(self, loaded: LoadedMechanism) -> list[str]:
        """What of the first mechanism, and of the files named at start-up, cannot be shown."""
        found = [loaded.problem] if loaded.problem else []
        for motion in self.motions:
            try:
                if loaded.solver is not None:
                    loaded.solver.motion(motion)
            except ParakinError as error:
                found.append(str(error))
        mechanism = loaded.mechanism
        used = {(mechanism.folder / b.mesh.file).resolve() for b in mechanism.bodies if b.mesh}
        for mesh in self.meshes:
            try:
                read_mesh(Path(mesh))
            except InputError as error:
                found.append(str(error))
                continue
            if Path(mesh).resolve() not in used:
                unused = InputError("--mesh", repr(mesh), "a file that the mechanism names")
                found.append(str(unused))
        return found

    def playback(
        self,
        loaded: LoadedMechanism,
        motion: str,
        loads: Mapping[str, float] | None = None,
        *,
        reactions: bool = False,
    ) -> Playback:
        """Solve one of the mechanism's motions; loads, reactions as of `playback_of`. Raises
        InputError.
        """
        if loaded.solver is None or motion not in loaded.motions:
            raise InputError(
                "motion", repr(motion), f"one of {', '.join(loaded.motions) or 'none'}"
            )
        return playback_of(loaded.solver, motion, loads, reactions=reactions)


def read_mesh(path: Path) -> Mesh:
    """Read triangles from a file, but no file that it refers to. Raises InputError."""
    import trimesh

    check_suffix(path, MESH_SUFFIXES, {}, "view")
    data = read_bytes(path, _MAX_MESH)
    try:
        found: Any = trimesh.load(io.BytesIO(data), file_type=path.suffix.lower()[1:], force="mesh")
        vertices = np.array(found.vertices, dtype=np.float64)
        faces = np.array(found.faces, dtype=np.int64)
    except Exception as error:  # a broken file can make a reader raise anything
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InputError(str(path), f"a mesh that cannot be read: {reason}", "triangles") from None
    if not len(faces) or not np.isfinite(vertices).all():
        raise InputError(str(path), "no triangles", "a mesh")
    return Mesh(vertices, faces)
