"""Dual numbers against derivatives worked out by hand."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from parakin.algebra.dual import Dual, dual, dual_functions, rate_of, value_of
from parakin.algebra.spatial import ARRAYS, FLOATS, as_float

FAR = st.floats(0.5, 3.0)
RATES = st.floats(-2.0, 2.0, allow_subnormal=False).filter(lambda a: abs(a) > 1e-300)


@given(FAR, RATES, FAR, RATES)
def test_sums_products_and_quotients(a: float, da: float, b: float, db: float) -> None:
    x, y = Dual(a, da), Dual(b, db)
    for found, value, rate in (
        (x + y, a + b, da + db),
        (x - y, a - b, da - db),
        (x * y, a * b, da * b + a * db),
        (x / y, a / b, (da * b - a * db) / b**2),
        (2.0 - x, 2.0 - a, -da),
        (2.0 / x, 2.0 / a, -2.0 * da / a**2),
        (-x, -a, -da),
    ):
        assert math.isclose(as_float(value_of(found)), value, rel_tol=1e-14, abs_tol=1e-14)
        assert math.isclose(as_float(rate_of(found)), rate, rel_tol=1e-13, abs_tol=1e-13)


@given(FAR, RATES, FAR, RATES)
def test_functions(a: float, da: float, b: float, db: float) -> None:
    functions = dual_functions(FLOATS)
    root = functions.sqrt(Dual(a, da))
    assert math.isclose(as_float(rate_of(root)), da / (2 * math.sqrt(a)), rel_tol=1e-14)
    angle = functions.atan2(Dual(a, da), Dual(b, db))
    assert math.isclose(as_float(value_of(angle)), math.atan2(a, b), rel_tol=1e-15)
    assert math.isclose(
        as_float(rate_of(angle)), (b * da - a * db) / (a * a + b * b), abs_tol=1e-14
    )


def test_what_rests_is_a_plain_scalar() -> None:
    assert dual(3.0, 0.0) == 3.0
    assert rate_of(3.0) == 0.0
    assert isinstance(dual(3.0, np.float64(0.0)), Dual)  # not a literal


def test_arrays_leave_the_product_to_the_dual_number() -> None:
    x = Dual(np.array([1.0, 2.0]), np.array([3.0, 4.0]))
    product = np.array([2.0, 2.0]) * x
    assert isinstance(product, Dual)
    np.testing.assert_array_equal(product.rate, [6.0, 8.0])
    root = dual_functions(ARRAYS).sqrt(x)
    np.testing.assert_allclose(root.rate, [1.5, 2.0 / math.sqrt(2.0)])
