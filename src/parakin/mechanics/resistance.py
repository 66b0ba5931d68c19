"""Resistance: what springs, dampers, friction and armatures in joints ask for."""

from __future__ import annotations

from typing import NamedTuple

from parakin.algebra.spatial import Functions, Scalar, add, mul, sub
from parakin.model.dynamics import Passive

AT_REST = 1e-9
"""[m/s or rad/s] Slower than this a coordinate rests, as far as Coulomb friction is concerned: its
direction is then no more than rounding, and friction goes from one value to the other in between.
"""


class Resistance(NamedTuple):
    """effort: what the coordinate's motion needs; band: how far Coulomb friction may change that
    either way, at rest; stored: energy in the spring [J]; lost: power to friction and damper [W].
    """

    effort: Scalar
    band: Scalar
    stored: Scalar
    lost: Scalar


def resistance(
    passive: Passive, value: Scalar, rate: Scalar, second: Scalar, functions: Functions
) -> Resistance:
    """Of a coordinate at a position, velocity and acceleration."""
    stretch = sub(value, passive.zero)
    spring = mul(passive.stiffness, stretch)
    direction: Scalar = functions.minimum(1.0, mul(1.0 / AT_REST, rate))
    direction = mul(-1.0, functions.minimum(1.0, mul(-1.0, direction)))
    braking = add(
        mul(passive.damping, sub(rate, passive.zero_speed)),
        add(mul(passive.viscous, rate), mul(passive.coulomb, direction)),
    )
    effort = add(add(spring, braking), mul(passive.armature, second))
    resting = sub(1.0, mul(direction, direction))
    return Resistance(
        effort, mul(passive.coulomb, resting), mul(0.5, mul(spring, stretch)), mul(braking, rate)
    )
