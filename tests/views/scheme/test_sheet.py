"""The sheet: the whole mechanism is on it, to scale."""

from __future__ import annotations

import numpy as np
import pytest

from parakin.files.reading import catalogue, load
from parakin.model.evaluation import graph_of
from parakin.views.scheme.sheet import MANY, WIDTH, Sheet, outline_of, sight_of, write
from parakin.views.solids.drawing import drawing_of

pytest.importorskip("matplotlib")


@pytest.mark.parametrize("name", catalogue())
def test_everything_is_on_the_sheet(name: str) -> None:
    sheet = Sheet.of(drawing_of(graph_of(load(name))))
    for piece in sheet.drawing.pieces:
        for at in sheet.at(piece.body, outline_of(piece)):
            assert sheet.holds(at)
    assert not sheet.holds(np.array([WIDTH, 10.0]))
    few = len(sheet.drawing.arrangement.graph.joints) <= MANY
    assert sheet.s == (6.0 if few else 4.8)


def test_a_planar_mechanism_is_to_scale() -> None:
    sheet = Sheet.of(drawing_of(graph_of(load("four-bar"))))
    a, d = sheet.flat(np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]))  # A, and D at 100 mm on x
    np.testing.assert_allclose(d - a, [0.1 * sheet.scale, 0.0], atol=1e-9)


@pytest.mark.parametrize("name", catalogue())
def test_the_sight_is_square_and_right_handed(name: str) -> None:
    sight = sight_of(drawing_of(graph_of(load(name))))
    R = np.array([*sight.across, sight.eye])
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1)


def test_text_is_verbatim() -> None:
    from matplotlib.figure import Figure

    axes = Figure().add_subplot()
    write(axes, np.zeros(2), "$x_1$", 8.0)
    (text,) = axes.texts
    assert text.get_text() == "$x_1$"
    assert not text.get_parse_math()
