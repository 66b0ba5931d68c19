"""Surfaces written as binary STL, whole or not at all."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from parakin.arrays import FloatArray
from parakin.files.writing import check_suffix, replacing

SUFFIXES = (".stl",)
_MILLIMETRES = 1e3  # per metre; STL has no units, and programs take it to be in millimetres
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def check_surface(path: Path) -> None:
    """Raises InputError if the suffix of `path` is another."""
    check_suffix(path, SUFFIXES, {}, "")


def write(triangles: FloatArray, path: Path) -> None:
    """Write triangles (n, 3, 3) [m], whose corners go round to the left as seen from outside, in
    millimetres. Raises InputError.
    """
    check_surface(path)
    rows = np.zeros(len(triangles), dtype=_TRIANGLE)
    rows["corners"] = _MILLIMETRES * triangles
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    rows["normal"] = np.divide(normal, size, out=np.zeros_like(normal), where=size > 0.0)
    header = b"parakin, millimetres".ljust(80)
    with replacing(path) as temporary:
        temporary.write_bytes(
            header + np.uint32(len(rows)).astype("<u4").tobytes() + rows.tobytes()
        )
