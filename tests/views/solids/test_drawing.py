"""Every mechanism can be drawn, and its pieces are where its joints are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from random_mechanisms import Example, examples

import parakin
from parakin.files.reading import load
from parakin.kinematics.assembly import assembled
from parakin.model.evaluation import graph_of
from parakin.views.solids.drawing import Drawing, drawing_of
from parakin.views.solids.painting import Painter
from parakin.views.solids.shapes import Bar, mesh


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
