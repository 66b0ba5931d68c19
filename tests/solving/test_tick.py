"""A tick's values by name, and what it shows of itself."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin import InputError


@pytest.fixture(scope="module")
def solver() -> parakin.Solver:
    return parakin.compile("slider-crank", coordinates="all", machine_code=False)


def test_values_by_name(solver: parakin.Solver) -> None:
    y = [solver.home[name] for name in solver.driven]
    tick = solver.at(y, [2.0], [3.0])
    (name,) = solver.driven
    assert tick.value(name) == y[0]
    assert tick.value(name, "velocity") == 2.0
    assert tick.value(name, "acceleration") == 3.0
    batch = solver.at(np.array([y, y]).T)
    np.testing.assert_array_equal(batch.value(name), [y[0], y[0]])


@pytest.mark.parametrize(
    ("coordinate", "quantity", "said"),
    [
        ("a", "position", "coordinate: found 'a'"),
        ("A", "speed", "quantity: found 'speed'"),
        (3, "position", "coordinate: found 3"),
        ("A", None, "quantity: found None"),
    ],
)
def test_other_names_are_refused(
    solver: parakin.Solver, coordinate: str, quantity: str, said: str
) -> None:
    tick = solver.at([solver.home[name] for name in solver.driven])
    with pytest.raises(InputError, match=said):
        tick.value(coordinate, quantity)


def test_what_was_not_compiled_for_has_no_value() -> None:
    solver = parakin.compile("four-bar", derivatives=0, machine_code=False)
    tick = solver.at([solver.home["A"]])
    with pytest.raises(InputError, match="quantity: found 'velocity'"):
        tick.value("A", "velocity")


def test_it_shows_itself_with_units(solver: parakin.Solver) -> None:
    tick = solver.at([solver.home[name] for name in solver.driven])
    page = tick._repr_html_()
    assert "converged" in page
    for name, unit in zip(tick.coordinates, tick.units, strict=True):
        assert f"<td>{name}</td>" in page
        assert f"{unit}/s²" in page or f"{unit}/s" in page
