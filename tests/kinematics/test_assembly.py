"""Home and other closed configurations, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

import parakin
from parakin.errors import AssemblyError
from parakin.kinematics.assembly import CLOSED, assembled, close, joint_gap, neighbours
from parakin.kinematics.configuration import closure_system, configure, loop_signs
from parakin.model.evaluation import graph_of


def test_the_four_bars_home_is_that_of_its_triangles() -> None:
    """Crank 40, coupler 120, rocker 80, ground 100 mm at 40°: the law of cosines, twice."""
    a, b, c, d, crank = 0.04, 0.12, 0.08, 0.1, math.radians(40)
    across = math.sqrt(a * a + d * d - 2 * a * d * math.cos(crank))
    below = math.atan2(-a * math.sin(crank), d - a * math.cos(crank))
    at_b = math.acos((b * b + across**2 - c * c) / (2 * b * across))
    at_d = math.acos((c * c + across**2 - b * b) / (2 * c * across))
    graph = graph_of(parakin.load("four-bar"))
    home = assembled(graph).q
    at = {coordinate.name: home[k] for k, coordinate in enumerate(graph.coordinates)}
    assert at["A"] == pytest.approx(crank, abs=1e-15)
    assert at["A"] + at["B"] == pytest.approx(below + at_b, abs=1e-14)  # the coupler's inclination
    assert at["D"] == pytest.approx(math.pi + below - at_d, abs=1e-14)


def test_what_cannot_close_says_by_how_much() -> None:
    mechanism = parakin.load("four-bar", {"b": 0.3})
    with pytest.raises(AssemblyError, match="four-bar"):
        assembled(graph_of(mechanism))
    graph = graph_of(mechanism)
    tree = graph.posed_tree()
    start = np.zeros(len(graph.coordinates))
    for name, value in {"A": 3.0, "B": -3.0, "D": 0.1}.items():
        start[graph.index(name, "test")] = value
    at, norm = close(graph, tree, start)
    assert norm > CLOSED
    (cut,) = tree.cuts
    mm, degrees = joint_gap(at, cut)
    assert mm == pytest.approx(80.0, abs=1e-3)  # 300 mm against 40 + 100 + 80, stretched out
    assert degrees < 1e-6


def test_neighbours_are_closed_and_elsewhere() -> None:
    graph = graph_of(parakin.load("gough-stewart"))
    tree = graph.posed_tree()
    home = assembled(graph)
    home = configure(graph, tree, home.q)
    found = neighbours(graph, tree, home, 3)
    assert len(found) == 3
    for at in found:
        gaps = closure_system(graph, tree, at, loop_signs(graph, tree))[0]
        assert np.linalg.norm(gaps) < CLOSED
        assert np.abs(at.q - home.q).max() > 1e-3
