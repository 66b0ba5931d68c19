"""Solids: closed, facing outwards, of the right volume."""

from __future__ import annotations

import numpy as np
import pytest

from parakin.views.solids.shapes import Ball, Bar, Block, Form, Mesh, Plate, mesh, spread


def volume(solid: Mesh) -> float:
    """By the divergence theorem; positive where faces look outwards."""
    a, b, c = solid.vertices[solid.faces].transpose(1, 0, 2)
    return float((a * np.cross(b, c)).sum() / 6)


def polygon(sides: int) -> float:
    """The area of a regular polygon in a circle of radius one."""
    return sides / 2 * float(np.sin(2 * np.pi / sides))


SOLIDS: dict[str, tuple[Form, float, float]] = {
    "bar": (Bar(np.array([[1.0, 2, 3], [1, 4, 3]]), 0.5), 2 * 0.25 * polygon(20), 1e-12),
    "block": (Block(np.ones(3), np.eye(3), (1.0, 2.0, 3.0)), 6.0, 1e-12),
    "plate": (Plate(np.array([[0.0, 0, 1], [2, 0, 1], [0, 3, 1]]), 0.1), 0.3, 1e-12),
    "ball": (Ball(np.ones(3), 0.5), np.pi / 6, 0.05),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_solids_are_closed_and_face_outwards(name: str) -> None:
    form, expected, tolerance = SOLIDS[name]
    solid = mesh(form)
    assert volume(solid) == pytest.approx(expected, rel=tolerance)
    _, same = np.unique(solid.vertices.round(9), axis=0, return_inverse=True)
    faces = same.reshape(-1)[solid.faces]
    faces = faces[[len(set(face)) == 3 for face in faces.tolist()]]  # a ball's poles
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()


def test_how_points_lie() -> None:
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    assert spread(square[:1]) == 0
    assert spread(square[:2]) == 1
    assert spread(square) == 2
    assert spread(np.vstack([square, [0, 0, 1]])) == 3
    assert spread(np.array([[5.0, 5, 5]] * 3)) == 0
    assert spread(1e-7 * square + 3.0) == 2


def test_a_mesh_is_its_own() -> None:
    own = Mesh(np.eye(3), np.array([[0, 1, 2]]))
    assert mesh(own) is own
