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

    def plus(self, other: Resistance) -> Resistance:
        """Both together."""
        return Resistance(*(add(a, b) for a, b in zip(self, other, strict=True)))


def direction(rate: Scalar, functions: Functions) -> Scalar:
    """Of a motion: -1 or 1, and between them at rest."""
    found: Scalar = functions.minimum(1.0, mul(1.0 / AT_REST, rate))
    way: Scalar = functions.minimum(1.0, mul(-1.0, found))
    return mul(-1.0, way)


def smooth_direction(rate: Scalar, speed: float, functions: Functions) -> Scalar:
    """Of a motion, from -1 to 1, without a corner: 0.7 at `speed`."""
    found: Scalar = rate / functions.sqrt(add(mul(rate, rate), speed * speed))
    return found


def resistance(
    passive: Passive, value: Scalar, rate: Scalar, second: Scalar, way: Scalar
) -> Resistance:
    """Of a coordinate at a position, velocity and acceleration. way: its direction of motion."""
    stretch = sub(value, passive.zero)
    spring = mul(passive.stiffness, stretch)
    braking = add(
        mul(passive.damping, sub(rate, passive.zero_speed)),
        add(mul(passive.viscous, rate), mul(passive.coulomb, way)),
    )
    effort = add(add(spring, braking), mul(passive.armature, second))
    resting = sub(1.0, mul(way, way))
    return Resistance(
        effort, mul(passive.coulomb, resting), mul(0.5, mul(spring, stretch)), mul(braking, rate)
    )
