"""Forces on bodies in numbers: springs between points, wrenches, payloads."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from parakin.algebra.spatial import ZERO, Vector
from parakin.errors import InputError, nearest
from parakin.model.expressions import Parameters
from parakin.model.forces import AppliedWrench, Payload, SpringBetween
from parakin.model.masses import NOTHING, Mass, amount, tensor_of
from parakin.model.mechanism import Mechanism
from parakin.model.motors import effort_per
from parakin.model.placement import evaluated
from parakin.model.units import FORCE, LENGTH, MASS, TORQUE

Points = Mapping[str, tuple[int, Vector[float]]]


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


class Acting:
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
                amount(text, self.parameters, effort_per(False, order), f"{place}.{key}")
                for order, key, text in (
                    (0, "stiffness", table.stiffness),
                    (1, "damping", table.damping),
                )
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
            if body == 0:
                raise InputError(f"{place}.at", "a wrench on the base", "one on a body that moves")
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
