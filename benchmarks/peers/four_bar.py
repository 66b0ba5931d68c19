"""A spatial four-bar with masses, and its motion under gravity by an equation of its own.

A crank and a rocker turn about skew axes of the base; the coupler between them has a spherical
joint at the crank and a universal one at the rocker, so that it does not spin about itself. One
freedom q, the crank's angle, and nothing that takes energy:

    M(q) qdd + M'(q) qd² / 2 = -V'(q).

Places and unit rates of all bodies are written out below with plain vectors, M and V follow, and a
complex step gives their derivatives to the last digit. Nothing of parakin or of an engine is used.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Floats = NDArray[np.floating[Any]]
Vector = NDArray[Any]  # of floats, or of complex numbers for a derivative

CRANK, COUPLER, ROCKER = 0.25, 1.0, 0.6  # lengths [m]
PIVOT = np.array([0.8, -0.1, 0.3])  # of the rocker [m]; the crank's is the origin
TILT = np.radians(50.0)  # of the rocker's axis about x, from the crank's, which is z
GRAVITY = np.array([0.0, -9.80665, 0.0])
DURATION, SPEED = 5.0, 10.0  # [s]; of the crank at first [rad/s], from q = 0
X, Y, Z = np.eye(3)


class Mass(NamedTuple):
    """Of a body, along its axes: x from its joint with the base, or from the spherical one, to the
    next joint; z the axis of a revolute joint, y the coupler's pin in the universal one.
    """

    mass: float  # [kg]
    com: Floats  # [m]
    inertia: Floats  # about the centre of mass, principal moments along the body's axes [kg m²]


MASSES = {
    "crank": Mass(2.0, np.array([0.1, 0.02, 0.01]), np.array([0.004, 0.012, 0.015])),
    "coupler": Mass(1.5, np.array([0.45, 0.03, -0.02]), np.array([0.006, 0.13, 0.125])),
    "rocker": Mass(3.0, np.array([0.25, -0.04, 0.03]), np.array([0.01, 0.09, 0.095])),
}


@dataclass(frozen=True)
class Turning:
    """A body's axes as columns, its origin, and the unit rates of both."""

    axes: Vector
    origin: Vector
    rate: Vector  # of the origin
    spin: Vector  # angular velocity


def tilted() -> Floats:
    """Axes on the base from which the rocker turns about z."""
    c, s = np.cos(TILT), np.sin(TILT)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def about_z(c: Any, s: Any) -> Vector:
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def placed(q: complex) -> dict[str, Turning]:
    """All bodies at a crank angle, with their rates at qd = 1; q may have an imaginary part."""
    base = tilted()
    crank_axes = about_z(np.cos(q), np.sin(q))
    tip = CRANK * crank_axes[:, 0]
    tip_rate = np.cross(Z, tip)
    # |tip - PIVOT - ROCKER (x cos + y sin)| = COUPLER: a cos + b sin = c, of which one branch
    to_tip = tip - PIVOT
    a, b = (2.0 * ROCKER * np.dot(base[:, k], to_tip) for k in (0, 1))
    c = np.dot(to_tip, to_tip) + ROCKER**2 - COUPLER**2
    squares = a * a + b * b
    root = np.sqrt(squares - c * c)
    rocker_axes = base @ about_z((a * c - b * root) / squares, (b * c + a * root) / squares)
    arm = ROCKER * rocker_axes[:, 0]
    along = PIVOT + arm - tip  # from crank to rocker, of constant length
    swing = np.cross(base[:, 2], arm)  # of the rocker's tip, at one radian a second
    speed = np.dot(along, tip_rate) / np.dot(along, swing)
    rocker_spin = speed * base[:, 2]
    # x along the coupler; y its pin, square to x and to the rocker's pin, which is along its axis
    x, x_rate, pin = along / COUPLER, (speed * swing - tip_rate) / COUPLER, base[:, 2]
    across, across_rate = np.cross(pin, x), np.cross(pin, x_rate)
    length = np.sqrt(np.dot(across, across))
    y = across / length
    y_rate = (across_rate - y * np.dot(y, across_rate)) / length
    axes = np.column_stack([x, y, np.cross(x, y)])
    z_rate = np.cross(x_rate, y) + np.cross(x, y_rate)
    turns = np.cross(x, x_rate) + np.cross(y, y_rate) + np.cross(axes[:, 2], z_rate)
    return {
        "crank": Turning(crank_axes, 0 * X, 0 * X, Z),
        "coupler": Turning(axes, tip, tip_rate, turns / 2),
        "rocker": Turning(rocker_axes, PIVOT, 0 * X, rocker_spin),
    }


def inertia_and_potential(q: complex) -> tuple[Any, Any]:
    """M [kg m²] and V [J] at a crank angle."""
    inertia: Any = 0.0
    potential: Any = 0.0
    for name, body in placed(q).items():
        mass, com, moments = MASSES[name]
        arm = body.axes @ com
        velocity = body.rate + np.cross(body.spin, arm)
        spin = body.axes.T @ body.spin
        inertia += mass * np.dot(velocity, velocity) + np.dot(spin, moments * spin)
        potential -= mass * np.dot(GRAVITY, body.origin + arm)
    return inertia, potential


def energy(q: float, qd: float) -> float:
    inertia, potential = inertia_and_potential(q)
    return float(inertia * qd**2 / 2 + potential)


def acceleration(q: float, qd: float) -> float:
    step = 1e-30
    inertia, potential = inertia_and_potential(q + 1j * step)
    slopes = inertia.imag / step, potential.imag / step
    return float(-(slopes[1] + slopes[0] * qd**2 / 2) / inertia.real)


def reference(times: Floats, max_step: float = np.inf) -> tuple[Floats, Floats]:
    """The crank's angle and rate at times from 0 on. max_step: [s]; 2e-11 rad off without."""
    found = solve_ivp(
        lambda _, state: (state[1], acceleration(*state)),
        (0.0, float(times[-1])),
        (0.0, SPEED),
        method="DOP853",
        rtol=1e-13,
        atol=1e-13,
        max_step=max_step,
        t_eval=times,
    )
    assert found.success
    return found.y[0], found.y[1]
