"""Simplices of a grid, and balls and boxes free of facets, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from parakin.design.clearance import half_width, radius
from parakin.design.simplices import connected, cut, pieces, sizes


@pytest.mark.parametrize("d", [2, 3])
def test_half_spaces_are_cut_exactly(d: int) -> None:
    """Straight boundaries are met exactly, however they lie to the grid."""
    normal = np.array([0.9, -0.5, 0.3])[:d]
    places = np.moveaxis(np.indices((7,) * d), 0, -1).reshape(-1, d).astype(float)
    height = (places - 3.0) @ normal - 0.21
    inside = (height < 0.0).reshape((7,) * d)
    cuts = cut(inside, np.arange(7**d).reshape(inside.shape))
    a, b = cuts.edges.T
    part = (height[a] / (height[a] - height[b]))[:, None]
    found = pieces(cuts, places, places[a] + part * (places[b] - places[a]))
    points = 6.0 * np.random.default_rng(16).random((10**6, d))
    share = float((((points - 3.0) @ normal) < 0.21).mean())
    size = sizes(cuts, found, inside.ravel().astype(np.intp))[1]
    assert size == pytest.approx(6.0**d * share, rel=2e-3)
    corners = (places[a] + part * (places[b] - places[a]))[found.facets]
    assert np.abs((corners - 3.0) @ normal - 0.21).max() < 1e-13


def test_corners_touch_only_along_edges_of_simplices() -> None:
    assert connected(np.eye(2, dtype=bool))[1] == 1
    assert connected(np.eye(2, dtype=bool)[::-1])[1] == 2


def test_the_nearest_of_a_triangle_is_inside_it_on_a_side_or_a_corner() -> None:
    flat = np.array([[[1.0, -5.0, -5.0], [1.0, 5.0, -5.0], [1.0, 0.0, 9.0]]])
    assert radius(flat) == pytest.approx(1.0)
    assert half_width(flat) == pytest.approx(1.0)
    beside = flat + np.array([0.0, 0.0, 7.0])
    assert radius(beside) == pytest.approx(np.hypot(1.0, 2.0))
    assert half_width(beside) == pytest.approx(2.0)
    plane = np.array([[[3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 3.0]]])
    assert radius(plane) == pytest.approx(np.sqrt(3.0))
    assert half_width(plane) == pytest.approx(1.0)
