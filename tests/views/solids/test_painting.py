"""Pictures of every mechanism of the catalogue."""

from __future__ import annotations

import numpy as np
import pytest

from parakin.files.reading import catalogue, load
from parakin.model.evaluation import graph_of
from parakin.views.solids.drawing import drawing_of
from parakin.views.solids.painting import Painter, picture
from parakin.views.solids.shapes import mesh

pytest.importorskip("matplotlib")


@pytest.mark.parametrize("name", catalogue())
def test_every_mechanism_is_painted(name: str) -> None:
    drawing = drawing_of(graph_of(load(name)))
    assert all(0 <= piece.body < len(drawing.arrangement.poses) for piece in drawing.pieces)
    (axes,) = picture(drawing).axes
    (painted,) = axes.collections
    assert len(painted.get_paths()) > 100
    extent = np.concatenate([path.vertices for path in painted.get_paths()])
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    assert left < extent[:, 0].min()
    assert extent[:, 0].max() < right
    assert bottom < extent[:, 1].min()
    assert extent[:, 1].max() < top


def test_division_keeps_the_area_and_shortens_the_edges() -> None:
    drawing = drawing_of(graph_of(load("gough-stewart")))
    triangles = Painter.of(drawing).triangles
    edges = np.linalg.norm(np.roll(triangles, -1, axis=1) - triangles, axis=2)
    assert edges.max() <= drawing.arrangement.size / 12
    area = np.linalg.norm(
        np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1
    ).sum()
    whole = 0.0
    for solid in (mesh(piece.form, 12) for piece in drawing.pieces):
        a, b, c = solid.vertices[solid.faces].transpose(1, 0, 2)
        whole += np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    assert area == pytest.approx(whole, rel=1e-9)
