"""What gives a mechanism forces, in numbers: masses, gravity, what acts in joints and on bodies."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, TypeVar

from parakin.algebra.spatial import ZERO, Vector
from parakin.errors import InputError
from parakin.model.drives import Stop
from parakin.model.expressions import Parameters
from parakin.model.fields import Quantity
from parakin.model.joints import Coordinate, GraphJoint
from parakin.model.limits import Limit
from parakin.model.loads import Acting, BodyWrench, Load, Points, PointSpring
from parakin.model.masses import Mass, amount, mass_of
from parakin.model.mechanism import Joint, Mechanism
from parakin.model.motors import Motor, effort_per, motors_of
from parakin.model.placement import AXES, evaluated
from parakin.model.units import (
    ACCELERATION,
    ANGLE,
    ANGULAR_VELOCITY,
    BARE,
    FORCE,
    INERTIA,
    LENGTH,
    MASS,
    TIME,
    TORQUE,
    VELOCITY,
)

STANDARD_GRAVITY = 9.80665  # [m/s²]

T = TypeVar("T")


class Passive(NamedTuple):
    """What a coordinate meets in its joint, in SI; `zero` and `zero_speed` are those of spring and
    damper, `low` and `high` where its stop begins.
    """

    stiffness: float = 0.0
    zero: float = 0.0
    damping: float = 0.0
    zero_speed: float = 0.0
    viscous: float = 0.0
    coulomb: float = 0.0
    armature: float = 0.0
    stop: float = 0.0
    dissipation: float = 0.0
    low: float = -math.inf
    high: float = math.inf


class Ball(NamedTuple):
    """Damping [N m s/rad] of two bodies' rotation against each other, in a spherical joint."""

    joint: str
    parent: int
    child: int
    damping: float


@dataclass(frozen=True)
class Dynamics:
    """masses: by body. passive, motors: by coordinate (all numbers are those of the graph). levers:
    by coordinate, what times the force across its joint's axis is friction [1 or m].
    """

    gravity: Vector[float] = ZERO
    masses: Mapping[int, Mass] = field(default_factory=dict)
    passive: Mapping[int, Passive] = field(default_factory=dict)
    balls: tuple[Ball, ...] = ()
    levers: Mapping[int, float] = field(default_factory=dict)
    motors: Mapping[int, Motor] = field(default_factory=dict)
    springs: tuple[PointSpring, ...] = ()
    wrenches: tuple[BodyWrench, ...] = ()
    loads: tuple[Load, ...] = ()

    @property
    def any(self) -> bool:
        """Whether there is anything that makes forces."""
        acting = (self.masses, self.passive, self.balls, self.springs, self.wrenches, self.loads)
        return any(acting) or any(motor.rotor for motor in self.motors.values())

    @property
    def inputs(self) -> int:
        """How many numbers it takes at each time: payloads' masses, then what wrenches take."""
        return len(self.loads) + sum(wrench.inputs for wrench in self.wrenches)


def dynamics_of(
    mechanism: Mechanism,
    parameters: Parameters,
    bodies: Mapping[str, int],
    points: Points,
    joints: Sequence[GraphJoint],
    coordinates: Sequence[Coordinate],
    limited: Sequence[Limit],
) -> Dynamics:
    """The mechanism's. Raises InputError on what cannot be."""
    where = mechanism.where
    ends = {limit.coordinate: limit.ends for limit in limited if limit.order == 0}
    known = {k: ends[c.name] for k, c in enumerate(coordinates) if c.name in ends}
    masses: dict[int, Mass] = {}
    for body in mechanism.bodies:
        found = mass_of(body, parameters, f"{where}: bodies.{body.name}")
        if found is not None and body.name != mechanism.base:
            masses[bodies[body.name]] = found
    passive: dict[int, Passive] = {}
    balls: list[Ball] = []
    levers: dict[int, float] = {}
    motors: dict[int, Motor] = {}
    for joint, made in zip(mechanism.joints, joints, strict=False):
        place = f"{where}: joints.{joint.name}"
        if joint.kind == "spherical":
            balls += _ball(joint, made, parameters, place)
        else:
            passive |= _passive(joint, made, known, parameters, place)
            levers |= _levers(joint, made, parameters, f"{place}.friction")
        if joint.drive is not None:
            motors |= motors_of(joint.drive, made, coordinates, parameters, f"{place}.drive")
    acting = Acting(mechanism, parameters, bodies, points)
    loads = acting.loads()
    return Dynamics(
        _gravity(mechanism, parameters, massive=bool(masses or loads)),
        masses,
        passive,
        tuple(balls),
        levers,
        motors,
        acting.springs(),
        acting.wrenches(),
        loads,
    )


def _gravity(mechanism: Mechanism, parameters: Parameters, *, massive: bool) -> Vector[float]:
    place, given = f"{mechanism.where}: gravity", mechanism.gravity
    if isinstance(given, tuple):
        return evaluated(given, parameters, place, ACCELERATION)
    size = STANDARD_GRAVITY if massive else 0.0
    if given is not None:
        size = amount(given, parameters, ACCELERATION, place)
    down = [0.0, 0.0, 0.0]
    down[AXES[mechanism.up]] = -size if size else 0.0
    return Vector(down)


def _each(values: tuple[T, ...], made: GraphJoint, place: str) -> dict[int, T]:
    """A joint's values by coordinate: one for each, or one for all that are alike."""
    if not values:
        return {}
    count = len(made.pairs)
    alike = len({pair.slides for pair in made.pairs}) == 1
    if count == 0 or made.kind == "free":
        raise InputError(place, f"one on a {made.kind} joint", "none: it has no axis of its own")
    if len(values) == 1 and alike:
        values *= count
    if len(values) != count:
        raise InputError(place, f"{len(values)} for {count} coordinates", f"a list of {count}")
    return dict(zip(made.coordinates, values, strict=True))


def _passive(
    joint: Joint,
    made: GraphJoint,
    ends: Mapping[int, tuple[float, float]],
    parameters: Parameters,
    place: str,
) -> dict[int, Passive]:
    turns = {k: not pair.slides for k, pair in zip(made.coordinates, made.pairs, strict=True)}
    found: dict[int, dict[str, float]] = {}

    def note(k: int, key: str, value: float) -> None:
        if value:
            found.setdefault(k, {})[key] = value

    def per(table: object, key: str, k: int, order: int, at: str) -> float:
        text: Quantity = getattr(table, key)
        return amount(text, parameters, effort_per(turns[k], order), f"{at}.{key}")

    at = f"{place}.spring"
    for k, spring in _each(joint.spring, made, at).items():
        note(k, "stiffness", per(spring, "stiffness", k, 0, at))
        dimension = ANGLE if turns[k] else LENGTH
        note(k, "zero", parameters.evaluate(spring.zero, dimension, f"{at}.zero"))
    at = f"{place}.damper"
    for k, damper in _each(joint.damper, made, at).items():
        note(k, "damping", per(damper, "damping", k, 1, at))
        dimension = ANGULAR_VELOCITY if turns[k] else VELOCITY
        note(k, "zero_speed", parameters.evaluate(damper.zero, dimension, f"{at}.zero"))
    at = f"{place}.friction"
    for k, friction in _each(joint.friction, made, at).items():
        note(k, "viscous", per(friction, "viscous", k, 1, at))
        effort = TORQUE if turns[k] else FORCE
        note(k, "coulomb", amount(friction.coulomb, parameters, effort, f"{at}.coulomb"))
    at = f"{place}.stop"
    for k, stop in _each(joint.stop, made, at).items():
        stiffness = per(stop, "stiffness", k, 0, at)
        if not stiffness and stop == Stop():
            continue  # of another coordinate alone
        if not stiffness > 0.0:
            raise InputError(f"{at}.stiffness", "none", "one above zero")
        note(k, "stop", stiffness)
        dimension = TIME.times(ANGLE if turns[k] else LENGTH, -1.0)
        note(k, "dissipation", amount(stop.dissipation, parameters, dimension, f"{at}.dissipation"))
        if k not in ends:
            raise InputError(at, "one of a coordinate without limits", "limits of its position")
        for key, end in zip(("low", "high"), ends[k], strict=True):
            found.setdefault(k, {})[key] = end
    for k, armature in _each(joint.armature, made, f"{place}.armature").items():
        dimension = INERTIA if turns[k] else MASS
        note(k, "armature", amount(armature, parameters, dimension, f"{place}.armature"))
    return {k: Passive(**values) for k, values in found.items()}


def _levers(joint: Joint, made: GraphJoint, parameters: Parameters, place: str) -> dict[int, float]:
    """Of friction under load, by coordinate."""
    found: dict[int, float] = {}
    for k, friction in _each(joint.friction, made, place).items():
        coefficient = amount(friction.coefficient, parameters, BARE, f"{place}.coefficient")
        if not coefficient:
            if friction.radius is not None:
                raise InputError(f"{place}.radius", "one without a coefficient", "both or neither")
            continue
        if joint.kind not in ("revolute", "prismatic"):
            what = f"one on a {joint.kind} joint"
            raise InputError(f"{place}.coefficient", what, "a revolute or prismatic joint")
        turns = joint.kind == "revolute"
        if turns != (friction.radius is not None):
            what = f"{'no' if turns else 'a'} radius of a {joint.kind} joint's friction"
            raise InputError(f"{place}.radius", what, "one of a revolute joint, and of no other")
        radius = 1.0
        if friction.radius is not None:
            radius = amount(friction.radius, parameters, LENGTH, f"{place}.radius")
        found[k] = coefficient * radius
    return found


def _ball(joint: Joint, made: GraphJoint, parameters: Parameters, place: str) -> list[Ball]:
    """Damping in a spherical joint, the same about every axis."""
    for key in ("spring", "stop", "armature"):
        if getattr(joint, key):
            raise InputError(f"{place}.{key}", "one on a spherical joint", "none: it has no axis")
    total = 0.0
    for key, tables in (("friction", joint.friction), ("damper", joint.damper)):
        at = f"{place}.{key}"
        if len(tables) > 1:
            raise InputError(at, f"{len(tables)} of them", "one: a spherical joint turns alike")
        for table in tables:
            value = getattr(table, "viscous", None)
            if value is not None and (table.coulomb or table.coefficient):  # type: ignore[union-attr]
                raise InputError(f"{at}.coulomb", "one in a spherical joint", "viscous alone")
            name = "damping" if value is None else "viscous"
            text: Quantity = getattr(table, name)
            total += amount(text, parameters, effort_per(True, 1), f"{at}.{name}")
            if getattr(table, "zero", 0):
                raise InputError(f"{at}.zero", "one in a spherical joint", "none")
    return [Ball(joint.name, made.parent, made.child, total)] if total else []
