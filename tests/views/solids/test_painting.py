"""Pictures: where a closed form puts things, and every mechanism of the catalogue."""

from __future__ import annotations

import numpy as np
import pytest

from parakin.files.reading import catalogue, load
from parakin.model.evaluation import graph_of
from parakin.views.solids.drawing import drawing_of
from parakin.views.solids.painting import Painter, picture
from parakin.views.solids.shapes import Ball, Bar, Block, Form, Mesh, Plate, mesh

pytest.importorskip("matplotlib")


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


def test_the_pins_of_a_four_bar_stand_where_its_closed_form_says() -> None:
    drawing = drawing_of(graph_of(load("four-bar")))
    joints = {j.name: k for k, j in enumerate(drawing.arrangement.graph.joints)}
    B = 0.04 * np.exp(1j * np.radians(40))  # a, b, c, d of the file; circles about B and D meet
    across = B - 0.1
    apart = abs(across)
    along = (apart**2 + 0.08**2 - 0.12**2) / (2 * apart)
    C = 0.1 + across / apart * (along - 1j * np.sqrt(0.08**2 - along**2))
    for name, place in {"A": 0j, "B": B, "C": C, "D": 0.1 + 0j}.items():
        pins = [piece for piece in drawing.pieces if piece.joint == joints[name]]
        assert len({piece.body for piece in pins}) == 2
        for pin in pins:
            assert isinstance(pin.form, Bar)
            ends = drawing.arrangement.world(pin.body, pin.form.points)
            np.testing.assert_allclose(ends[:, 0], place.real, atol=1e-9)
            np.testing.assert_allclose(ends[:, 1], place.imag, atol=1e-9)


@pytest.mark.parametrize("name", ["gough-stewart", "flight-simulator", "3-rpr", "tricept"])
def test_a_piston_stays_in_its_cylinder_over_the_stroke(name: str) -> None:
    drawing = drawing_of(graph_of(load(name)))
    graph, seen = drawing.arrangement.graph, 0
    pistons = {p.body: p.form for p in drawing.pieces if p.part == "piston"}
    for piece in drawing.pieces:
        if piece.part != "cylinder" or piece.joint is None:
            continue
        joint = graph.joints[piece.joint]
        tube, rod = piece.form, pistons[joint.child]
        assert isinstance(tube, Bar)
        assert isinstance(rod, Bar)
        bottom, top = drawing.arrangement.world(joint.parent, tube.points)
        length = float(np.linalg.norm(top - bottom))
        axis = (top - bottom) / length
        R = drawing.arrangement.poses[joint.parent][0] @ np.array(joint.F.R, dtype=float)
        inner = drawing.arrangement.world(joint.child, rod.points)[1] - bottom
        np.testing.assert_allclose(np.cross(inner, axis), 0, atol=1e-7 * drawing.arrangement.size)
        for end in drawing.arrangement.stroke(piece.joint):
            out = (end - drawing.arrangement.q[joint.first]) * (R[:, 2] @ axis)
            assert -2.1 * drawing.arrangement.radius <= inner @ axis + out <= length
        seen += 1
    assert seen == {"gough-stewart": 6, "flight-simulator": 4}.get(name, 3)  # E2P slides unpowered
