"""Points on bodies, by name."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin import InputError
from parakin.algebra.spatial import as_array
from parakin.solving.bodies import Figures, points_of


def test_all_bodies_but_the_base_at_their_origins() -> None:
    graph = parakin.compile("four-bar", machine_code=False).graph
    assert points_of(graph, False) == {}
    assert list(points_of(graph, True)) == ["crank", "coupler", "rocker"]
    assert all(place == (0.0, 0.0, 0.0) for _, place in points_of(graph, True).values())


def test_points_stand_where_the_file_puts_them() -> None:
    graph = parakin.compile("four-bar", machine_code=False).graph
    (body, place), (base, _) = points_of(graph, ["coupler.P", "base"]).values()
    assert graph.bodies[body] == "coupler"
    np.testing.assert_allclose(as_array(place), [0.06, 0.04, 0.0], atol=1e-15)  # b/2, b/3 of 120 mm
    assert base == 0


def test_unknown_names_are_refused_with_a_near_one() -> None:
    graph = parakin.compile("four-bar", machine_code=False).graph
    with pytest.raises(InputError, match=r"unknown body or point 'coupler\.Q'"):
        points_of(graph, ["coupler.Q"])


def test_a_cranks_end_goes_round() -> None:
    solver = parakin.compile("four-bar", machine_code=False)
    points = points_of(solver.graph, ["crank"])
    figures = Figures.of(solver.plan, points, machine_code=False)
    samples = solver.motion("turn", rate=20.0).samples()
    found = figures.at(samples, np.empty((0, len(samples.time))), False)
    angle, speed = samples.position[0], samples.velocity[0]
    np.testing.assert_allclose(found[0:3], 0.0, atol=1e-15)  # its origin is the pivot
    np.testing.assert_allclose(found[3], np.cos(angle), atol=1e-15)
    np.testing.assert_allclose(found[17], speed, atol=1e-15)
