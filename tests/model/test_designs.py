"""A mechanism with parameters left open, against the same mechanism made anew."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin import InputError, Mechanism
from parakin.algebra.spatial import ARRAYS, FLOATS, as_array
from parakin.model.designs import Designs
from parakin.model.evaluation import graph_of
from parakin.model.graph import Graph


def numbers(graph: Graph) -> np.ndarray:
    """All numbers of a graph's geometry."""
    found: list[float] = []
    for joint in graph.joints:
        for frame in (joint.F, joint.M):
            found += [*np.ravel(frame.R), *frame.p]
        found += [joint.length, *(pair.pitch for pair in joint.pairs)]
    found += [x for _, point in graph.points.values() for x in point]
    for table in (graph.home, graph.stated, graph.guess):
        found += table.values()
    found += [end for limit in graph.limited for end in limit.ends]
    return np.array(found, dtype=float)


@pytest.mark.parametrize("name", sorted(parakin.catalogue()))
def test_any_design_of_the_catalogue_is_what_the_file_says(name: str) -> None:
    mechanism = parakin.load(name)
    if not mechanism.parameters:
        pytest.skip("it has no parameters")
    designs = Designs.of(mechanism, tuple(mechanism.parameters))
    rng = np.random.default_rng(2)
    for size in (0.0, 0.02, 0.05):
        values = designs.own + size * rng.uniform(-1, 1, len(designs.own)) * (
            np.abs(designs.own) + 0.1
        )
        opened = designs.opened(values.tolist(), FLOATS).graph
        anew = graph_of(
            mechanism.with_parameters(dict(zip(designs.names, values.tolist(), strict=True)))
        )
        np.testing.assert_allclose(numbers(opened), numbers(anew), rtol=1e-14, atol=1e-15)


def bar(**parameters: float | str) -> Mechanism:
    return Mechanism(
        name="bar",
        parameters={"length": "0.5 m", "lean": 0, "end": "length/2"} | parameters,
        bodies=[{"name": "base"}, {"name": "bar"}],
        joints=[
            {
                "name": "A",
                "kind": "revolute",
                "parent": "base",
                "child": "bar",
                "on_parent": {"at": ["lean", "end", "2*length"], "axis": [0, "lean", 1]},
            }
        ],
        limits={"A": ["-length", "length"]},
    )


def test_a_parameter_that_is_zero_in_the_file_stays_open() -> None:
    designs = Designs.of(bar(length=0.5), ["lean"])
    opened = designs.opened([np.array([0.0, 0.2])], ARRAYS).graph
    np.testing.assert_array_equal(opened.joints[0].F.p[0], [0.0, 0.2])
    axis = np.array([*opened.joints[0].F.R.column(2)[1:]])
    np.testing.assert_allclose(axis, np.array([[0, 0.2], [1, 1]]) / np.hypot([0, 0.2], 1.0))


def test_parameters_that_are_not_given_follow_from_those_that_are() -> None:
    designs = Designs.of(bar(), ["length", "end"])
    length, end = designs.followed({"length": np.array([1.0, 2.0])}, ARRAYS)
    np.testing.assert_array_equal(length, [1.0, 2.0])
    np.testing.assert_array_equal(end, [0.5, 1.0])
    assert designs.followed({"end": np.array([3.0])}, ARRAYS)[0] == 0.5


def test_a_decision_that_another_design_would_take_otherwise_is_told() -> None:
    designs = Designs.of(bar(length=0.5), ["length"])
    conditions = designs.opened([np.array([0.5, 0.1, -0.1])], ARRAYS).conditions
    held = [
        (as_array(c.margin) > 0.0) == c.holds for c in conditions
    ]  # the limits are no range otherwise
    assert np.logical_and.reduce(held).tolist() == [True, True, False]


@pytest.mark.parametrize(
    ("names", "words"),
    [
        (["lenght"], "unknown parameter 'lenght'; expected one of: end, lean, length"),
        (["length", "length"], "one twice"),
        ([], "no parameters"),
    ],
)
def test_names_are_checked(names: list[str], words: str) -> None:
    with pytest.raises(InputError, match=words):
        Designs.of(bar(), names)


def test_an_exponent_cannot_be_left_open() -> None:
    mechanism = bar(end="2**lean")
    with pytest.raises(InputError, match="an exponent that depends on a parameter left open"):
        Designs.of(mechanism, ["lean"]).opened([0.1], FLOATS)
