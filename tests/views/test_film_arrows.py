"""Arrows of efforts in a film: in proportion, with their numbers, and inside the picture."""

from __future__ import annotations

import numpy as np
import pendulum
import pytest
from weighty import weightless

import parakin
from parakin.views.film_arrows import FilmArrows
from parakin.views.force_arrows import LONGEST
from parakin.views.solids.drawing import drawing_of
from parakin.views.solids.painting import Painter

pytest.importorskip("matplotlib")


def heavy() -> parakin.Solver:
    mechanism = weightless(parakin.load("gough-stewart")).with_payload("500 kg at platform")
    return parakin.compile(mechanism, machine_code=False)


def test_arrows_have_the_efforts_numbers_and_reach_no_further_than_the_longest() -> None:
    from matplotlib.figure import Figure

    solver = heavy()
    ds = solver.solve("heave", bodies=True, forces=True)
    drawing = drawing_of(solver.graph)
    painter = Painter.of(drawing)
    arrows = FilmArrows(drawing, painter, Figure().subplots(), ds)
    R, p = (np.array(part) for part in zip(*drawing.arrangement.poses, strict=True))
    arrows.show(R, p, 0)
    quiver, *numbers = arrows.artists
    # At home, and with no more than its weight and what moves it up and down, each leg pushes
    # alike: the weight's part along the leg.
    effort = ds["effort"].values[0]
    assert np.ptp(effort) < 1e-6 * effort[0]
    leg = solver.graph.joints[solver.graph.coordinates[solver.graph.index("P1", "legs")].joint]
    along = R[leg.parent] @ np.array(leg.F.R)[:, 2]
    assert effort[0] == pytest.approx(500 * pendulum.GRAVITY / 6 / along[2], rel=1e-9)
    assert [text.get_text() for text in numbers] == [f"{effort[0]:,.0f} N"] * 6  # type: ignore[attr-defined]
    size = min(drawing.arrangement.size, drawing.view.span)
    lengths = np.hypot(quiver.U, quiver.V)  # type: ignore[attr-defined]
    part = effort[0] / np.abs(ds["effort"].values).max()
    assert lengths.max() <= LONGEST * size * part + 1e-12
    assert arrows.reach(R[None], p[None], np.array([0])).shape == (6, 2)


def test_a_result_without_forces_has_none() -> None:
    from matplotlib.figure import Figure

    solver = heavy()
    drawing = drawing_of(solver.graph)
    ds = solver.solve("heave", bodies=True)
    arrows = FilmArrows(drawing, Painter.of(drawing), Figure().subplots(), ds)
    assert arrows.artists == []
    assert arrows.reach(np.zeros((1, 1, 3, 3)), np.zeros((1, 1, 3)), np.array([0])).shape == (0, 2)
