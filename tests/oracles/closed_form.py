"""Plane-geometry closed form of the flight simulator, the oracle of the tests.

Nothing here comes from parakin, and nothing is iterated. The leg A, the rod A3-G and the cranks D
and E all move in the x0-y0 plane, so that a pose (x, y, phi) of the platform determines

* the inclination gamma of the rod and the crank D: two circles intersect in D2,
* the leg A, then B and C: distances and angles between points that are now known,
* the crank E: a circle about E1 intersects the line of the rod in E2.

Velocities and accelerations are exact: second-order Taylor jets go through the same geometry.
Equation numbers are those of the paper, symbols too. Arithmetic has 40 digits, in a context of its
own, whatever the global precision of mpmath. Angles in rad, lengths in m.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, TypeAlias

import mpmath  # type: ignore[import-untyped, unused-ignore]

MP = mpmath.mp.clone()
MP.dps = 40

Number: TypeAlias = Any  # an MP.mpf, or what converts to one (mpmath is untyped)
Triple: TypeAlias = tuple[Number, Number, Number]
State: TypeAlias = dict[str, Triple]


_m = MP.mpf


@dataclass(frozen=True)
class Parameters:
    """Geometry in the paper's symbols and, by default, with its values [m]."""

    d1: Number = _m("0.4")  # A3 D2, along the rod
    d2: Number = _m("0.95")  # A1 E1
    d3: Number = _m("0.65")  # E1 D1
    d4: Number = _m("0.25")  # D1 F
    d5: Number = _m("1.35")  # B2 F = C2 F
    l1: Number = _m("0.85")  # A2 A3
    l2: Number = _m("1")  # B3 B4 = C3 C4
    l3: Number = _m("1.3")  # D1 D2
    l4: Number = _m("1.2")  # E1 E2
    b: Number = _m("1.2")  # B4 C4
    h: Number = _m("1.4")  # A3 G
    h_G: Number = _m("1.1")  # F G
    s_A: Number = _m("0.29")
    s_B: Number = _m("0.33")
    s_C: Number = _m("0.33")


@dataclass(frozen=True)
class Jet:
    """A function of time to third order: its value and three derivatives."""

    value: Number
    rate: Number = 0
    accel: Number = 0
    jerk: Number = 0

    def _chain(self, f: Number, df: Number, ddf: Number, dddf: Number) -> Jet:
        """f(self), from f and its first three derivatives at self.value (Faà di Bruno)."""
        return Jet(
            f,
            df * self.rate,
            ddf * self.rate**2 + df * self.accel,
            dddf * self.rate**3 + 3 * ddf * self.rate * self.accel + df * self.jerk,
        )

    def __add__(self, other: Jet | Number) -> Jet:
        o = jet(other)
        return Jet(
            self.value + o.value, self.rate + o.rate, self.accel + o.accel, self.jerk + o.jerk
        )

    def __neg__(self) -> Jet:
        return Jet(-self.value, -self.rate, -self.accel, -self.jerk)

    def __sub__(self, other: Jet | Number) -> Jet:
        return self + -jet(other)

    def __rsub__(self, other: Jet | Number) -> Jet:
        return -self + other

    def __mul__(self, other: Jet | Number) -> Jet:
        o = jet(other)
        return Jet(
            self.value * o.value,
            self.rate * o.value + self.value * o.rate,
            self.accel * o.value + 2 * self.rate * o.rate + self.value * o.accel,
            self.jerk * o.value
            + 3 * self.accel * o.rate
            + 3 * self.rate * o.accel
            + self.value * o.jerk,
        )

    def __truediv__(self, other: Jet | Number) -> Jet:
        o = jet(other)
        return self * o._chain(1 / o.value, -1 / o.value**2, 2 / o.value**3, -6 / o.value**4)

    def __rtruediv__(self, other: Jet | Number) -> Jet:
        return jet(other) / self

    __radd__ = __add__
    __rmul__ = __mul__


def jet(x: Jet | Number) -> Jet:
    return x if isinstance(x, Jet) else Jet(MP.mpf(x))


def sin(x: Jet) -> Jet:
    s, c = MP.sin(x.value), MP.cos(x.value)
    return x._chain(s, c, -s, -c)


def cos(x: Jet) -> Jet:
    s, c = MP.sin(x.value), MP.cos(x.value)
    return x._chain(c, -s, -c, s)


def sqrt(x: Jet) -> Jet:
    if x.value <= 0:
        raise ValueError("out of reach: the circles, or the circle and the line, do not intersect")
    root = MP.sqrt(x.value)
    return x._chain(root, 1 / (2 * root), -1 / (4 * root**3), 3 / (8 * root**5))


def atan2(y: Jet, x: Jet) -> Jet:
    """The angle of (x, y). Its rate is (x y' - y x') / r^2, which is differentiated twice more."""
    turning = x * Jet(y.rate, y.accel, y.jerk) - y * Jet(x.rate, x.accel, x.jerk)
    rate = turning / (x * x + y * y)
    return Jet(MP.atan2(y.value, x.value), rate.value, rate.rate, rate.accel)


def _rod(p: Parameters, x: Jet, y: Jet, side: int = 1) -> tuple[Jet, Jet]:
    """Inclination gamma of the rod, and angle of the crank D.

    D2 is at l3 from D1 and at h - d1 from G; with side = +1, the paper's branch, it lies on the
    left of the line from D1 to G.
    """
    u, v = x - (p.d2 + p.d3), y
    square = u * u + v * v
    dot = (square + p.l3**2 - (p.h - p.d1) ** 2) / 2  # of D1D2 and D1G
    along, across = dot / square, side * sqrt(p.l3**2 * square - dot * dot) / square
    crank_x, crank_y = along * u - across * v, along * v + across * u
    return atan2(v - crank_y, u - crank_x), atan2(crank_y, crank_x)


def _side_leg(p: Parameters, tip: tuple[Jet, Jet, Jet], side: int) -> tuple[Jet, Jet, Jet]:
    """phi10, phi21 + alpha3 and the length of the leg B (side +1) or C (side -1).

    The leg starts from (d2 + d3 + d4, 0, side d5) and its direction is
    (-sin phi10 S, cos phi10 S, -side C), S and C being the sine and cosine of phi21 + alpha3.
    """
    x, y, z = tip[0] - (p.d2 + p.d3 + p.d4), tip[1], p.d5 - side * tip[2]
    in_plane = x * x + y * y
    return atan2(-x, y), atan2(sqrt(in_plane), z), sqrt(in_plane + z * z)


def _geometry(p: Parameters, x: Jet, y: Jet, phi: Jet) -> dict[str, Jet]:
    """Every coordinate but psi, with the lengths |A1A3|, |B1B4| and |C1C4| for A2, B3 and C3."""
    gamma, angle_d = _rod(p, x, y)
    rod_x, rod_y = cos(gamma), sin(gamma)

    a3_x, a3_y = x - p.h * rod_x, y - p.h * rod_y
    angle_a = atan2(a3_y, a3_x)
    length_a = sqrt(a3_x * a3_x + a3_y * a3_y)

    # B4 - G = -a40^T (b/2) u1 = -(C4 - G)
    arm_x, arm_y = p.b / 2 * sin(phi) * rod_y, -p.b / 2 * sin(phi) * rod_x
    arm_z = p.b / 2 * cos(phi)
    b1, b2, length_b = _side_leg(p, (x + arm_x, y + arm_y, arm_z), +1)
    c1, c2, length_c = _side_leg(p, (x - arm_x, y - arm_y, -arm_z), -1)

    # |D2 + s rod - E1| = l4: the positive of the two roots s
    w_x, w_y = a3_x + p.d1 * rod_x - p.d2, a3_y + p.d1 * rod_y
    w_rod = w_x * rod_x + w_y * rod_y
    s = sqrt(w_rod * w_rod - (w_x * w_x + w_y * w_y) + p.l4**2) - w_rod
    angle_e = atan2(w_y + s * rod_y, w_x + s * rod_x)

    return (
        {"A1": angle_a, "A2": length_a, "A3": angle_a - gamma, "A4": phi}
        | {"B1.1": b1, "B1.2": b2, "B3": length_b, "C1.1": c1, "C1.2": c2, "C3": length_c}
        | {"D1": angle_d, "E1": angle_e, "E2P": s, "gamma": gamma}
    )


@dataclass(frozen=True)
class Home:
    """The assembled central configuration: the angles and distances the paper does not print."""

    gamma0: Number
    alpha1: Number
    alpha2: Number
    alpha3: Number
    alpha4: Number
    alpha5: Number
    s: Number  # D2 E2
    A1A3: Number
    B1B4: Number


@cache
def home(p: Parameters) -> Home:
    """Assemble the central configuration: G at (d2 + d3 + d4, h_G), phi = 0."""
    q = _geometry(p, jet(p.d2 + p.d3 + p.d4), jet(p.h_G), jet(0))
    names = ("gamma", "A1", "A3", "B1.2", "D1", "E1", "E2P", "A2", "B3")
    return Home(*(q[name].value for name in names))


def home_inclinations(p: Parameters) -> tuple[Number, Number]:
    """gamma0 on the paper's branch, and on the other one."""
    x, y = jet(p.d2 + p.d3 + p.d4), jet(p.h_G)
    return _rod(p, x, y, +1)[0].value, _rod(p, x, y, -1)[0].value


def example(n: int, t: Number, p: Parameters = Parameters()) -> tuple[Triple, Triple, Triple]:
    """Pose (x, y, phi) at the time t [s] by eq. (6), its first and its second derivative.

    n = 1: vertical (y only); n = 2: rectilinear (x and y); n = 3: general (x, y and phi).
    """
    amplitude = (MP.mpf("0.05") * (n >= 2), MP.mpf("0.1"), MP.pi / 12 * (n >= 3))
    rest = (p.d2 + p.d3 + p.d4, p.h_G, MP.mpf(0))
    course = 1 - cos(Jet(MP.pi / 3 * MP.mpf(t), MP.pi / 3))
    x, y, phi = (start + a * course for start, a in zip(rest, amplitude, strict=True))
    return (
        (x.value, y.value, phi.value),
        (x.rate, y.rate, phi.rate),
        (x.accel, y.accel, phi.accel),
    )


def state(p: Parameters, y: Sequence[Number], yd: Sequence[Number], ydd: Sequence[Number]) -> State:
    """Position, velocity and acceleration of every coordinate, from those of (x, y, phi).

    A1, D1, E1      absolute angles from x0 of the leg A and the cranks: phi10 + alpha1, 4, 5
    A2, B3, C3      displacements lambda from the printed s_A, s_B, s_C
    A3              phi32^A + alpha2, so that gamma = A1 - A3
    A4              phi43^A = phi
    B1.1, C1.1      phi10
    B1.2, C1.2      phi21 + alpha3: the legs B, C point along (-sin phi10 S, cos phi10 S, -+C)
    E2P             the distance D2E2 = s + lambda, along the rod and towards G
    gamma, psi      absolute inclination of the rod A3-G, and gamma - gamma0
    """
    pose = (Jet(*map(MP.mpf, jet)) for jet in zip(y, yd, ydd, strict=True))
    q = _geometry(p, *pose)
    q["A2"] -= p.s_A + p.l1
    q["B3"] -= p.s_B + p.l2
    q["C3"] -= p.s_C + p.l2
    q["psi"] = q["gamma"] - home(p).gamma0
    return {name: (jet.value, jet.rate, jet.accel) for name, jet in q.items()}


def corrected_eq_11(p: Parameters, at: State, yd: Sequence[Number]) -> Triple:
    """v21^A, v32^B, v32^C by eq. (11) with its two wrong signs corrected, at a state."""
    return _eq_11(p, at, yd, -1)


def printed_eq_11(p: Parameters, at: State, yd: Sequence[Number]) -> Triple:
    """v21^A, v32^B, v32^C by eq. (11) as printed: v32^C is wrong unless phi = 0."""
    return _eq_11(p, at, yd, +1)


def _eq_11(p: Parameters, at: State, yd: Sequence[Number], sign: int) -> Triple:
    sin, cos, (vx, vy, phid) = MP.sin, MP.cos, map(MP.mpf, yd)
    a1, a3, phi, gamma, d = (at[name][0] for name in ("A1", "A3", "A4", "gamma", "D1"))
    omega = -(vx * cos(d) + vy * sin(d)) / ((p.h - p.d1) * sin(gamma - d))
    turn, tilt, sink = omega * sin(phi), phid * cos(phi), phid * sin(phi)

    def side_leg(leg: str, turn: Number, tilt: Number, sink: Number) -> Number:
        f, g = at[f"{leg}1.1"][0], at[f"{leg}1.2"][0]
        arm = p.b / 2 * (turn * sin(gamma - f) + tilt * cos(gamma - f))
        return (-vx * sin(f) + vy * cos(f) + arm) * sin(g) + p.b / 2 * sink * cos(g)

    return (
        vx * cos(a1) + vy * sin(a1) - omega * p.h * sin(a3),
        side_leg("B", turn, -tilt, sink),
        side_leg("C", sign * turn, tilt, -sign * sink),
    )
