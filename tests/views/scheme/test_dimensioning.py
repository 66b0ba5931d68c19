"""Dimensions are what they say."""

from __future__ import annotations

import closed_form
import numpy as np
import pytest

from parakin.files.reading import load
from parakin.model.evaluation import graph_of
from parakin.views.scheme.dimensioning import lengths, parameters
from parakin.views.solids.drawing import drawing_of


def test_dimensions_of_the_flight_simulator_are_the_papers() -> None:
    found = lengths(drawing_of(graph_of(load("flight-simulator"))))
    exact = closed_form.Parameters()
    shown = {"d1", "d2", "d3", "d4", "d5", "l1", "l2", "l3", "l4", "b", "h", "s_A", "s_B", "s_C"}
    assert shown <= set(found)
    for name, places in found.items():
        for length in places:
            apart = np.linalg.norm(length.end - length.start)
            assert apart == pytest.approx(float(getattr(exact, name)), abs=1e-12)


def test_equal_lengths_of_different_names_are_not_taken_for_one_another() -> None:
    """s_B = s_C = 0.33 m: legs B and C stand on either side of the median plane, z = 0."""
    found = lengths(drawing_of(graph_of(load("flight-simulator"))))
    for name, side in (("s_B", 1), ("s_C", -1)):
        assert found[name]
        assert all(side * length.start[2] > 0 for length in found[name])
    equal = load("four-bar").with_parameters({"b": "80 mm", "d": "100 mm"})
    found = lengths(drawing_of(graph_of(equal)))
    b, c = ({tuple(np.round((p.start + p.end) / 2, 9)) for p in found[name]} for name in ("b", "c"))
    assert b
    assert c
    assert not b & c


def test_parameters_are_in_millimetres_and_degrees() -> None:
    known = {p.name: (p.value, p.as_given) for p in parameters(load("gough-stewart"))}
    assert known["r_base"] == ("1200 mm", "1.2 m")
    assert known["a_base"] == ("20°", "20 deg")
    assert known["leg3_base"] == ("110°", "120 deg - a_base/2")
    bare = load("four-bar").with_parameters({"a": 0.04})
    assert {p.name: p.value for p in parameters(bare)}["a"] == "0.04"
