"""A scalar and its rate in time: the recursion run on these gives the next derivative.

Accelerations worked out from positions, rates and second rates that carry their own rates come
with the jerk. What does not change in time is a plain scalar, so that constants cost nothing.
Divisors are inverted once, so that rates by many things share the division.
"""

from __future__ import annotations

from typing import Any

from parakin.algebra.spatial import Functions, Scalar, add, mul, sub


class Dual:
    """value + rate dt, on any scalar that `parakin.algebra.spatial` knows."""

    __slots__ = ("rate", "value")
    __array_ufunc__ = None  # an array leaves sums and products with a dual number to the latter

    def __init__(self, value: Scalar, rate: Scalar) -> None:
        self.value, self.rate = value, rate

    def __add__(self, other: Scalar) -> Scalar:
        return dual(add(self.value, value_of(other)), add(self.rate, rate_of(other)))

    __radd__ = __add__

    def __neg__(self) -> Scalar:
        return dual(sub(0.0, self.value), sub(0.0, self.rate))

    def __sub__(self, other: Scalar) -> Scalar:
        return dual(sub(self.value, value_of(other)), sub(self.rate, rate_of(other)))

    def __rsub__(self, other: Scalar) -> Scalar:
        return dual(sub(other, self.value), sub(0.0, self.rate))

    def __mul__(self, other: Scalar) -> Scalar:
        value = value_of(other)
        rate = add(mul(self.rate, value), mul(self.value, rate_of(other)))
        return dual(mul(self.value, value), rate)

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Scalar:
        quotient = self.value / value_of(other)
        rate = mul(1.0 / value_of(other), sub(self.rate, mul(quotient, rate_of(other))))
        return dual(quotient, rate)

    def __rtruediv__(self, other: Scalar) -> Scalar:
        quotient = other / self.value
        return dual(quotient, mul(sub(0.0, quotient), mul(1.0 / self.value, self.rate)))

    def __pow__(self, exponent: float) -> Scalar:
        value: Any = self.value
        slope = mul(exponent, value ** (exponent - 1.0))
        return dual(value**exponent, mul(slope, self.rate))


def dual(value: Scalar, rate: Scalar) -> Scalar:
    """Value + rate dt; the value itself where the rate is the literal zero."""
    return value if type(rate) is float and rate == 0.0 else Dual(value, rate)


def value_of(a: Scalar) -> Scalar:
    return a.value if isinstance(a, Dual) else a


def rate_of(a: Scalar) -> Scalar:
    return a.rate if isinstance(a, Dual) else 0.0


def dual_functions(functions: Functions) -> Functions:
    """The same on dual numbers too."""

    def sin(a: Scalar) -> Scalar:
        value = value_of(a)
        return dual(functions.sin(value), mul(functions.cos(value), rate_of(a)))

    def cos(a: Scalar) -> Scalar:
        value = value_of(a)
        return dual(functions.cos(value), sub(0.0, mul(functions.sin(value), rate_of(a))))

    def copysign(size: Scalar, sign: Scalar) -> Scalar:
        side: Scalar = functions.copysign(1.0, mul(value_of(size), value_of(sign)))
        return mul(side, size)

    def sqrt(a: Scalar) -> Scalar:
        root: Scalar = functions.sqrt(value_of(a))
        if not isinstance(a, Dual):
            return root
        return dual(root, mul(mul(0.5, functions.inverse(root)), rate_of(a)))

    def atan2(y: Scalar, x: Scalar) -> Scalar:
        a, b = value_of(y), value_of(x)
        turning = sub(mul(b, rate_of(y)), mul(a, rate_of(x)))
        inverse: Scalar = functions.inverse(add(mul(a, a), mul(b, b)))
        return dual(functions.atan2(a, b), mul(inverse, turning))

    def minimum(a: Scalar, b: Scalar) -> Scalar:
        side: Scalar = functions.copysign(0.5, sub(value_of(a), value_of(b)))
        rate = add(mul(sub(0.5, side), rate_of(a)), mul(add(0.5, side), rate_of(b)))
        return dual(functions.minimum(value_of(a), value_of(b)), rate)

    def inverse(a: Scalar) -> Scalar:
        found: Scalar = functions.inverse(value_of(a))
        return dual(found, mul(sub(0.0, mul(found, found)), rate_of(a)))

    return Functions(sin, cos, sqrt, atan2, minimum, copysign, inverse)
