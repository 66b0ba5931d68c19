"""Every mechanism can be drawn, and its pieces are where its joints are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from random_mechanisms import Example, examples

import parakin
from parakin.kinematics.assembly import assembled
from parakin.model.evaluation import graph_of
from parakin.views.solids.drawing import Drawing, drawing_of
from parakin.views.solids.painting import Painter
from parakin.views.solids.shapes import Bar, Mesh, mesh, spread


def _drawn(mechanism: parakin.Mechanism) -> Drawing:
    graph = graph_of(mechanism)
    return drawing_of(graph, assembled(graph).q)


@settings(deadline=None, max_examples=60)
@given(examples())
def test_whatever_closes_can_be_drawn(example: Example) -> None:
    drawing = _drawn(example.mechanism)
    bodies = range(len(drawing.arrangement.graph.bodies))
    for piece in drawing.pieces:
        solid = mesh(piece.form)
        assert piece.body in bodies
        assert np.isfinite(solid.vertices).all()
        assert solid.faces.min() >= 0
        assert solid.faces.max() < len(solid.vertices)
    shown = {piece.joint for piece in drawing.pieces if piece.joint is not None}
    for number, joint in enumerate(drawing.arrangement.graph.joints):
        assert number in shown or joint.kind in ("fixed", "free")
    assert np.isfinite(drawing.view.eye).all()
    assert len(Painter.of(drawing).triangles)


@pytest.mark.parametrize("name", parakin.catalogue())
def test_both_halves_of_a_hinge_are_on_one_axis(name: str) -> None:
    """In the world, where bodies stand at home: their two bars share a line, and overlap."""
    drawing = _drawn(parakin.load(name))
    for number, joint in enumerate(drawing.arrangement.graph.joints):
        if joint.kind != "revolute":
            continue
        bars = [
            drawing.arrangement.world(piece.body, piece.form.points)
            for piece in drawing.pieces
            if piece.joint == number and isinstance(piece.form, Bar)
        ]
        (a, b), *others = bars
        along = (b - a) / np.linalg.norm(b - a)
        ends = sorted([0.0, float((b - a) @ along)])
        for c, d in others:
            for point in (c, d):
                off = point - a - ((point - a) @ along) * along
                assert np.linalg.norm(off) < 1e-9 * max(1.0, drawing.arrangement.size)
            reached = sorted([float((c - a) @ along), float((d - a) @ along)])
            assert reached[0] < ends[1]
            assert reached[1] > ends[0]


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_size_makes_no_difference(scale: float) -> None:
    lengths = {
        key: scale * value for key, value in (("a", 0.04), ("b", 0.12), ("c", 0.08), ("d", 0.1))
    }
    drawing = _drawn(parakin.load("four-bar").with_parameters(lengths))
    usual = _drawn(
        parakin.load("four-bar").with_parameters({k: v / scale for k, v in lengths.items()})
    )
    assert len(drawing.pieces) == len(usual.pieces)
    for ours, theirs in zip(drawing.pieces, usual.pieces, strict=True):
        np.testing.assert_allclose(
            mesh(ours.form).vertices, scale * mesh(theirs.form).vertices, atol=1e-9 * scale
        )


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
