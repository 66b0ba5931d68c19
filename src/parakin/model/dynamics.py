"""What gives a mechanism forces, in numbers: masses, gravity, what acts in joints and on bodies."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeVar

from parakin.algebra.spatial import ZERO, Vector
from parakin.errors import InputError, nearest
from parakin.model.drives import Drive
from parakin.model.expressions import Parameters
from parakin.model.fields import Quantity
from parakin.model.forces import AppliedWrench, Payload, SpringBetween
from parakin.model.joints import Coordinate, GraphJoint
from parakin.model.masses import NOTHING, Mass, amount, mass_of, tensor_of
from parakin.model.mechanism import Joint, Mechanism
from parakin.model.placement import AXES, evaluated
from parakin.model.units import (
    ACCELERATION,
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

STANDARD_GRAVITY = 9.80665  # [m/s²]

Points = Mapping[str, tuple[int, Vector[float]]]
T = TypeVar("T")


class Passive(NamedTuple):
    """What a coordinate meets in its joint, in SI; `zero` and `zero_speed` are those of spring and
    damper.
    """

    stiffness: float = 0.0
    zero: float = 0.0
    damping: float = 0.0
    zero_speed: float = 0.0
    viscous: float = 0.0
    coulomb: float = 0.0
    armature: float = 0.0


class Ball(NamedTuple):
    """Damping [N m s/rad] of two bodies' rotation against each other, in a spherical joint."""

    parent: int
    child: int
    damping: float


class PointSpring(NamedTuple):
    """A spring and damper between points of two bodies."""

    name: str
    ends: tuple[tuple[int, Vector[float]], tuple[int, Vector[float]]]
    stiffness: float
    damping: float
    length: float


class BodyWrench(NamedTuple):
    """A force and moment on a body at a point, along its own axes if `turns`, else the base's.

    law: the table of a law of time that both are multiplied by; csv: a file of all six instead.
    """

    name: str
    body: int
    point: Vector[float]
    force: Vector[float]
    moment: Vector[float]
    turns: bool
    law: Mapping[str, Any] | None = None
    csv: str | None = None

    @property
    def inputs(self) -> int:
        """How many numbers it takes at each time: none, a factor, or force and moment."""
        return 6 if self.csv is not None else int(self.law is not None)


class Load(NamedTuple):
    """A payload on a body; the inertia of what has another mass is in proportion."""

    name: str
    body: int
    mass: Mass


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
) -> Dynamics:
    """The mechanism's. Raises InputError on what cannot be."""
    where = mechanism.where
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
            passive |= _passive(joint, made, parameters, place)
            levers |= _levers(joint, made, parameters, f"{place}.friction")
        if joint.drive is not None:
            motors |= _motors(joint.drive, made, coordinates, parameters, f"{place}.drive")
    acting = _Forces(mechanism, parameters, bodies, points)
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


def _per(angle: bool, order: int) -> Dimension:
    """Of an effort over a coordinate (order 0) or its velocity (1)."""
    over = (ANGLE if angle else LENGTH)._replace(time=-float(order))
    return (TORQUE if angle else FORCE).times(over, -1.0)


def _passive(
    joint: Joint, made: GraphJoint, parameters: Parameters, place: str
) -> dict[int, Passive]:
    turns = {k: not pair.slides for k, pair in zip(made.coordinates, made.pairs, strict=True)}
    found: dict[int, dict[str, float]] = {}

    def note(k: int, key: str, value: float) -> None:
        if value:
            found.setdefault(k, {})[key] = value

    for k, spring in _each(joint.spring, made, f"{place}.spring").items():
        at, angle = f"{place}.spring", turns[k]
        note(
            k, "stiffness", amount(spring.stiffness, parameters, _per(angle, 0), f"{at}.stiffness")
        )
        dimension = ANGLE if angle else LENGTH
        note(k, "zero", parameters.evaluate(spring.zero, dimension, f"{at}.zero"))
    for k, damper in _each(joint.damper, made, f"{place}.damper").items():
        at, angle = f"{place}.damper", turns[k]
        note(k, "damping", amount(damper.damping, parameters, _per(angle, 1), f"{at}.damping"))
        dimension = ANGULAR_VELOCITY if angle else VELOCITY
        note(k, "zero_speed", parameters.evaluate(damper.zero, dimension, f"{at}.zero"))
    for k, friction in _each(joint.friction, made, f"{place}.friction").items():
        at, angle = f"{place}.friction", turns[k]
        note(k, "viscous", amount(friction.viscous, parameters, _per(angle, 1), f"{at}.viscous"))
        effort = TORQUE if angle else FORCE
        note(k, "coulomb", amount(friction.coulomb, parameters, effort, f"{at}.coulomb"))
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
    for key in ("spring", "armature"):
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
            total += amount(text, parameters, _per(True, 1), f"{at}.{name}")
            if getattr(table, "zero", 0):
                raise InputError(f"{at}.zero", "one in a spherical joint", "none")
    return [Ball(made.parent, made.child, total)] if total else []


def _motors(
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
        limit("stiffness", _per(angle, 0)),
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


class _Forces:
    """The tables of `forces`, one kind after the other."""

    def __init__(
        self,
        mechanism: Mechanism,
        parameters: Parameters,
        bodies: Mapping[str, int],
        points: Points,
    ) -> None:
        self.tables = mechanism.forces
        self.parameters, self.place = parameters, f"{mechanism.where}: forces"
        self.known = {name: (k, ZERO) for name, k in bodies.items()} | dict(points)

    def _at(self, name: str, place: str) -> tuple[int, Vector[float]]:
        if name not in self.known:
            found = f"unknown body or point {name!r}"
            raise InputError(place, found, nearest(name, self.known))
        return self.known[name]

    def springs(self) -> tuple[PointSpring, ...]:
        made = []
        for name, table in self.tables.items():
            if not isinstance(table, SpringBetween):
                continue
            place = f"{self.place}.{name}"
            first, second = (self._at(end, f"{place}.between") for end in table.between)
            if first[0] == second[0]:
                raise InputError(f"{place}.between", "two points of one body", "of two bodies")
            stiffness, damping = (
                amount(getattr(table, key), self.parameters, _per(False, order), f"{place}.{key}")
                for order, key in enumerate(("stiffness", "damping"))
            )
            length = amount(table.length, self.parameters, LENGTH, f"{place}.length")
            made.append(PointSpring(name, (first, second), stiffness, damping, length))
        return tuple(made)

    def wrenches(self) -> tuple[BodyWrench, ...]:
        made = []
        for name, table in self.tables.items():
            if not isinstance(table, AppliedWrench):
                continue
            place = f"{self.place}.{name}"
            body, point = self._at(table.at, f"{place}.at")
            force = evaluated(table.force, self.parameters, f"{place}.force", FORCE)
            moment = evaluated(table.moment, self.parameters, f"{place}.moment", TORQUE)
            if table.csv is not None and (table.law is not None or any(force) or any(moment)):
                raise InputError(f"{place}.csv", "a file beside a law or values", "one of them")
            turns = table.axes == "body"
            made.append(BodyWrench(name, body, point, force, moment, turns, table.law, table.csv))
        return tuple(made)

    def loads(self) -> tuple[Load, ...]:
        made = []
        for name, table in self.tables.items():
            if not isinstance(table, Payload):
                continue
            place = f"{self.place}.{name}"
            body, com = self._at(table.at, f"{place}.at")
            mass = amount(table.mass, self.parameters, MASS, f"{place}.mass")
            tensor = NOTHING
            if table.inertia is not None:
                tensor = tensor_of(table.inertia, self.parameters, f"{place}.inertia")
                if mass == 0.0 and any(any(row) for row in tensor):
                    found = "an inertia of no mass"
                    raise InputError(f"{place}.inertia", found, "a mass above zero")
            if body == 0:
                raise InputError(f"{place}.at", "a payload on the base", "one on a body that moves")
            made.append(Load(name, body, Mass(mass, com, tensor)))
        return tuple(made)
