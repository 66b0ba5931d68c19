"""Symbols: from the side and end on they are what ISO 3952 draws."""

from __future__ import annotations

import numpy as np
import pytest

from parakin.views.scheme import symbols
from parakin.views.scheme.symbols import Sight

FRONT = Sight(np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), np.array([0.0, 0.0, 1.0]))
X, Y, Z = np.eye(3)
HERE = np.zeros(2)


def test_a_bush_is_a_circle_along_its_axis_and_a_rectangle_from_the_side() -> None:
    (circle,) = symbols.sleeve(FRONT, HERE, Z, half=5.0, r=3.0)
    np.testing.assert_allclose(np.linalg.norm(circle.points, axis=1), 3.0, rtol=1e-12)
    (bush,) = symbols.sleeve(FRONT, HERE, X, half=5.0, r=3.0)
    np.testing.assert_allclose(np.abs(bush.points[:, 0]), 5.0, rtol=1e-12)
    assert np.ptp(bush.points[:, 1]) == pytest.approx(6.0)


def test_a_bush_seen_at_an_angle_shows_its_rim_as_an_ellipse() -> None:
    tilt = np.pi / 6
    axis = np.cos(tilt) * X + np.sin(tilt) * Z
    outline, rim = symbols.sleeve(FRONT, HERE, axis, half=5.0, r=3.0)
    assert np.ptp(rim.points[:, 1]) == pytest.approx(2 * 3.0, rel=1e-2)
    assert np.ptp(rim.points[:, 0]) == pytest.approx(2 * 3.0 * np.sin(tilt), rel=1e-2)
    length = 2 * (5.0 * np.cos(tilt) + 3.0 * np.sin(tilt))
    assert np.ptp(outline.points[:, 0]) == pytest.approx(length, rel=1e-2)


def test_a_sliding_sleeve_is_a_rectangle_from_the_side_and_a_square_end_on() -> None:
    (face,) = symbols.box(FRONT, HERE, X, half=5.0, r=3.0)
    np.testing.assert_allclose(np.ptp(face.points, axis=0), [10.0, 6.0])
    (face,) = symbols.box(FRONT, HERE, Z, half=5.0, r=3.0)
    np.testing.assert_allclose(np.ptp(face.points, axis=0), [6.0, 6.0])
    oblique = symbols.box(FRONT, HERE, (X + Z) / np.sqrt(2), half=5.0, r=3.0)
    assert len(oblique) == 2


def test_plates_are_parallel_lines_from_the_side() -> None:
    lower, upper = symbols.plates(FRONT, HERE, Y, s=4.0)
    assert np.ptp(lower.points[:, 1]) == pytest.approx(0, abs=1e-12)
    apart = upper.points[:, 1].mean() - lower.points[:, 1].mean()
    assert abs(apart) == pytest.approx(0.9 * 4.0)


def test_the_forks_of_a_universal_joint_open_to_their_bodies() -> None:
    strokes = symbols.cross(FRONT, HERE, (X, Z), child=Y, s=4.0)
    parent, child = strokes[0].points, strokes[2].points
    assert parent[:, 1].min() < -4.0 < parent[:, 1].max() <= 1e-9
    assert child[:, 1].max() > 4.0 > child[:, 1].min() >= -1e-9
