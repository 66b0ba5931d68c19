"""What meshes enclose: volumes, centroids and inertia tensors of bodies that are told by a density.

A mesh is read only from the folder of the mechanism's file, or below. It has to be closed, with
all its triangles facing outwards: the volume of any other is not defined.
"""

from __future__ import annotations

import importlib.util
import io
from pathlib import Path
from typing import Any

import numpy as np

from parakin.errors import InputError, not_installed
from parakin.files.force_histories import beside
from parakin.files.parsing import read_bytes
from parakin.files.writing import check_suffix
from parakin.model.bodies import Body, MeshMoments
from parakin.model.mechanism import Mechanism

_SUFFIXES = (".stl", ".obj", ".ply", ".glb")
_MOST = 100_000_000  # bytes
_FLAT = 1e-12  # of the cube of the mesh's size: what a volume must be more than


def with_mesh_moments(mechanism: Mechanism) -> Mechanism:
    """The mechanism with the `moments` of each mesh that has a density. Raises InputError on files
    that cannot be read, and on meshes that enclose no volume.
    """
    if not any(_unread(body) for body in mechanism.bodies):
        return mechanism
    known: dict[Path, MeshMoments] = {}
    bodies = []
    for body in mechanism.bodies:
        if not _unread(body):
            bodies.append(body)
            continue
        assert body.mesh is not None
        place = f"{mechanism.where}: bodies.{body.name}.mesh.file"
        path = beside(mechanism, body.mesh.file, place)
        if path not in known:
            known[path] = moments_of(path, place)
        mesh = body.mesh.model_copy(update={"moments": known[path]})
        bodies.append(body.model_copy(update={"mesh": mesh}))
    return mechanism.model_copy(update={"bodies": tuple(bodies)})


def _unread(body: Body) -> bool:
    mesh = body.mesh
    return mesh is not None and mesh.density is not None and mesh.moments is None


def moments_of(path: Path, place: str) -> MeshMoments:
    """Of the mesh in a file, in its own units. place: what names it, for messages. Raises
    InputError.
    """
    if importlib.util.find_spec("trimesh") is None:
        raise not_installed(place, "trimesh", "view")
    check_suffix(path, _SUFFIXES, {}, "view")
    mesh = _mesh(path)
    where = f"{place}: {path}"
    if not mesh.is_watertight:
        counts = np.unique(mesh.edges_sorted, axis=0, return_counts=True)[1]
        found = f"an open mesh: {int((counts != 2).sum())} edges without two triangles"
        raise InputError(where, found, "a closed one, as a mass follows from its volume")
    if not mesh.is_winding_consistent:
        raise InputError(where, "triangles that face inwards and outwards", "all outwards")
    near = mesh.vertices.mean(axis=0)  # whence integrals lose no digits
    mesh.apply_translation(-near)
    mesh.density = 1.0
    with np.errstate(all="ignore"):  # of a flat mesh
        volume, centroid = float(mesh.volume), mesh.center_mass + near
        tensor = np.array(mesh.moment_inertia, dtype=float)
    if not volume > _FLAT * float(np.ptp(mesh.vertices, axis=0).max()) ** 3:
        found = f"a mesh of volume {volume:.6g}"
        raise InputError(where, found, "a volume above zero: triangles that face outwards")
    x, y, z = (float(a) for a in centroid)
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    xx, yy, zz, xy, xz, yz = (float(tensor[i, j]) for i, j in pairs)
    return MeshMoments(volume=volume, centroid=(x, y, z), inertia=(xx, yy, zz, xy, xz, yz))


def _mesh(path: Path) -> Any:
    """Triangles with the vertices that they share made one. No file that it refers to is read."""
    import trimesh

    data = read_bytes(path, _MOST)
    try:
        found: Any = trimesh.load(io.BytesIO(data), file_type=path.suffix.lower()[1:], force="mesh")
        vertices, faces = np.array(found.vertices, dtype=float), np.array(found.faces, dtype=int)
        mesh = trimesh.Trimesh(vertices, faces, process=True)
    except Exception as error:  # a broken file can make a reader raise anything
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InputError(str(path), f"a mesh that cannot be read: {reason}", "triangles") from None
    if not len(mesh.faces) or not np.isfinite(mesh.vertices).all():
        raise InputError(str(path), "no triangles", "a mesh")
    return mesh
