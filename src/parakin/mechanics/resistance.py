"""Resistance: what springs, dampers, friction and armatures in joints ask for."""

from __future__ import annotations

import math
from typing import NamedTuple

from parakin.algebra.spatial import Functions, Scalar, add, mul, sub
from parakin.model.dynamics import Passive

AT_REST = 1e-9
"""[m/s or rad/s] Slower than this a coordinate rests, as far as Coulomb friction is concerned: its
direction is then no more than rounding, and friction goes from one value to the other in between.
"""


class Resistance(NamedTuple):
    """effort: what the coordinate's motion needs; band: how far Coulomb friction may change that
    either way, at rest; stored: energy in spring and stop [J]; lost: power to friction, damper and
    stop [W].
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
    passive: Passive,
    value: Scalar,
    rate: Scalar,
    second: Scalar,
    way: Scalar,
    functions: Functions,
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
    found = Resistance(
        effort, mul(passive.coulomb, resting), mul(0.5, mul(spring, stretch)), mul(braking, rate)
    )
    for side, end in ((1.0, passive.high), (-1.0, passive.low)):
        if passive.stop and math.isfinite(end):
            beyond, going = mul(side, sub(value, end)), mul(side, rate)
            found = found.plus(_stopped(passive, side, beyond, going, functions))
    return found


def _stopped(
    passive: Passive, side: float, beyond: Scalar, going: Scalar, functions: Functions
) -> Resistance:
    """What a stop asks for at how far beyond it a coordinate is, and how fast it goes on: k x (1 +
    c x'), where neither factor is below zero (K. H. Hunt and F. R. E. Crossley, J. Appl. Mech. 42
    (1975) 440).
    """
    # As least of negatives: of NaN and zero it is NaN.
    depth = mul(-1.0, functions.minimum(mul(-1.0, beyond), 0.0))
    firm = mul(passive.stop, depth)
    held: Scalar = firm
    if passive.dissipation:
        gain = add(1.0, mul(passive.dissipation, going))
        held = mul(firm, mul(-1.0, functions.minimum(mul(-1.0, gain), 0.0)))
    return Resistance(mul(side, held), 0.0, mul(0.5, mul(firm, depth)), mul(sub(held, firm), going))
