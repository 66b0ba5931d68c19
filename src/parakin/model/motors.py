"""Drives in numbers: motors behind screws and gears, with their limits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from parakin.errors import InputError
from parakin.model.drives import Drive
from parakin.model.expressions import Parameters
from parakin.model.fields import Quantity
from parakin.model.joints import Coordinate, GraphJoint
from parakin.model.masses import amount
from parakin.model.units import (
    ANGLE,
    ANGULAR_VELOCITY,
    BARE,
    CURRENT,
    FORCE,
    INERTIA,
    LENGTH,
    MASS,
    POWER,
    TORQUE,
    VELOCITY,
    Dimension,
)


class Motor(NamedTuple):
    """A drive in SI: `ratio` motor turns [rad] per unit of the coordinate [rad/m or 1]; limits are
    infinite where none are given, and so is the stiffness.
    """

    ratio: float
    efficiency: float
    back_efficiency: float
    rotor: float
    torque_constant: float | None
    max_effort: float
    max_speed: float
    max_power: float
    max_torque: float
    stiffness: float
    turns: bool  # whether the motor does: a direct linear drive does not


def effort_per(angle: bool, order: int) -> Dimension:
    """Of an effort over a coordinate (order 0) or its velocity (1)."""
    over = (ANGLE if angle else LENGTH)._replace(time=-float(order))
    return (TORQUE if angle else FORCE).times(over, -1.0)


def motors_of(
    drive: Drive,
    made: GraphJoint,
    coordinates: Sequence[Coordinate],
    parameters: Parameters,
    place: str,
) -> dict[int, Motor]:
    """By actuated coordinate. Raises InputError on a drive of none."""
    moved = [k for k in made.coordinates if coordinates[k].actuated]
    if not moved:
        raise InputError(place, "a drive of a joint that is not actuated", "actuated = true")
    return {k: _motor(drive, coordinates[k].angle, parameters, place) for k in moved}


def _motor(drive: Drive, angle: bool, parameters: Parameters, place: str) -> Motor:
    if drive.lead is not None and (angle or drive.ratio is not None):
        found = "a lead on a turn" if angle else "both lead and ratio"
        raise InputError(f"{place}.lead", found, "a lead on a slide, a ratio on a turn")
    if drive.ratio is not None and not angle:
        raise InputError(f"{place}.ratio", "a gear ratio on a slide", "a lead")
    ratio = 1.0
    if drive.lead is not None:
        ratio = 2 * math.pi / _nonzero(drive.lead, parameters, LENGTH, f"{place}.lead")
    elif drive.ratio is not None:
        ratio = _nonzero(drive.ratio, parameters, BARE, f"{place}.ratio")
    turns = angle or drive.lead is not None
    forward = _part(drive.efficiency, parameters, f"{place}.efficiency")
    if not forward:
        raise InputError(f"{place}.efficiency", "0", "above 0, at most 1")
    back = forward
    if drive.back_efficiency is not None:
        back = _part(drive.back_efficiency, parameters, f"{place}.back_efficiency")
    torque, effort = (TORQUE if turns else FORCE), (TORQUE if angle else FORCE)
    constant: float | None = None
    if drive.torque_constant is not None:
        per = torque.times(CURRENT, -1.0)
        constant = _nonzero(drive.torque_constant, parameters, per, f"{place}.torque_constant")
        constant = abs(constant)

    def limit(key: str, dimension: Dimension) -> float:
        text = getattr(drive, key)
        if text is None:
            return math.inf
        value = parameters.evaluate(text, dimension, f"{place}.{key}")
        if not value > 0.0:
            raise InputError(f"{place}.{key}", f"{value:g}", "above zero")
        return value

    return Motor(
        ratio,
        forward,
        back,
        amount(drive.rotor, parameters, INERTIA if turns else MASS, f"{place}.rotor"),
        constant,
        limit("max_effort", effort),
        limit("max_speed", ANGULAR_VELOCITY if angle else VELOCITY),
        limit("max_power", POWER),
        limit("max_torque", torque),
        limit("stiffness", effort_per(angle, 0)),
        turns,
    )


def _nonzero(text: Quantity, parameters: Parameters, dimension: Dimension, place: str) -> float:
    value = parameters.evaluate(text, dimension, place)
    if not abs(value) > 0.0:
        raise InputError(place, f"{value:g}", "a number that is not zero")
    return value


def _part(text: Quantity, parameters: Parameters, place: str) -> float:
    value = parameters.evaluate(text, BARE, place)
    if not 0.0 <= value <= 1.0:
        raise InputError(place, f"{value:g}", "from 0 to 1")
    return value
