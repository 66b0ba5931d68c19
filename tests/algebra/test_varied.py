"""Numbers that vary from design to design, against plain numbers in each design."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from parakin.algebra import varied
from parakin.algebra.spatial import ARRAYS, as_array
from parakin.algebra.varied import Record, Varied, as_number, nominal, scalar_of

DESIGNS = np.array([0.3, 0.4, -0.2, 0.55])


def number(record: Record, designs: np.ndarray = DESIGNS) -> Varied:
    """A number whose scalar is the array of its own values, so that the two can be compared."""
    return Varied(designs, designs.copy(), record)


@pytest.mark.parametrize(
    "formula",
    [
        lambda a: 2.0 * a + 1.0 - a / 3.0,
        lambda a: 1.0 / (a - 2.0) - 3.0,
        lambda a: 3.0 - a * a,
        lambda a: -a,
        lambda a: (a + 1.0) ** 3.0 + (a + 1.0) ** 0.5 + (a + 1.0) ** -1.5,
        abs,
        varied.sin,
        varied.cos,
        varied.tan,
        varied.asin,
        varied.acos,
        varied.atan,
        lambda a: varied.atan2(a, a - 1.0),
        lambda a: varied.sqrt(a + 1.0),
        lambda a: varied.hypot(a, 2.0, a - 1.0),
    ],
)
def test_value_and_scalar_are_those_of_each_design(formula: Callable[[Any], Any]) -> None:
    found = formula(number(Record(ARRAYS)))
    alone = np.array([formula(a) for a in DESIGNS.tolist()])
    np.testing.assert_allclose(found.values, alone, rtol=4e-15)
    np.testing.assert_allclose(found.scalar, alone, rtol=4e-15)


@given(st.floats(-1.0, 1.0))
def test_inverses_hold_over_their_whole_domain(a: float) -> None:
    x = Varied(np.array([a, 0.5]), np.array([a, 0.5]), Record(ARRAYS))
    if a == 0.5:
        return
    for mine, plain in ((varied.asin, math.asin), (varied.acos, math.acos)):
        # Near an end the angle is as uncertain as a root of its distance from there.
        assert scalar_of(mine(x))[0] == pytest.approx(plain(a), abs=1e-15, rel=1e-13)


def test_what_is_the_same_in_all_designs_is_a_plain_float() -> None:
    a = number(Record(ARRAYS))
    assert type(a - a) is float
    assert a - a == 0.0
    assert varied.sin(a) ** 2.0 + varied.cos(a) ** 2.0 == 1.0
    assert a * 0.0 == 0.0


def test_a_number_that_merely_happens_to_be_zero_stays_open() -> None:
    a = Varied(np.array([0.0, 0.1]), 0.0, Record(ARRAYS))
    assert isinstance(a * 2.0, Varied)
    assert isinstance(1.0 + a, Varied)


def test_decisions_follow_the_own_design_and_are_recorded() -> None:
    record = Record(ARRAYS)
    a = number(record)
    assert a > 0.0
    assert not a > 0.35
    assert a <= 0.3
    margins = [
        (as_array(c.margin) > 0 if c.strict else as_array(c.margin) >= 0).tolist()
        for c in record.conditions
    ]
    assert [c.holds for c in record.conditions] == [True, False, True]
    assert margins[0] == [True, True, False, True]
    assert margins[1] == [False, True, False, True]
    assert margins[2] == [True, False, True, False]


def test_no_single_number_can_be_made_of_it_by_mistake() -> None:
    a = number(Record(ARRAYS))
    with pytest.raises(TypeError, match="no single value"):
        float(a)
    with pytest.raises(TypeError):
        math.sin(a)
    with pytest.raises(TypeError):
        np.ones(4) * a
    with pytest.raises(TypeError):
        np.sin(a)  # type: ignore[call-overload]
    assert as_number(a) is a
    assert as_number(3) == 3.0
    assert nominal(a) == 0.3


def test_what_has_no_value_in_some_design_is_not_a_number_there() -> None:
    with np.errstate(invalid="ignore"):  # as kernels on arrays do
        found = varied.sqrt(number(Record(ARRAYS)))
    assert np.isnan(found.values).tolist() == [False, False, True, False]
