"""From a mechanism to its graph: expressions evaluated; bodies, joints, coordinates numbered."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence

from parakin.algebra.spatial import IDENTITY, IDENTITY_POSE, ZERO, Pose, Vector
from parakin.algebra.varied import Varied, nominal
from parakin.errors import InputError, nearest
from parakin.model.dynamics import Dynamics, dynamics_of
from parakin.model.expressions import Bare, Parameters
from parakin.model.graph import Graph
from parakin.model.joints import PAIRS, THETA, Z_TURN, Coordinate, GraphJoint, Pair
from parakin.model.limits import limits_of
from parakin.model.mechanism import MAX_JOINTS, Joint, Mechanism, Platform
from parakin.model.placement import AXES, evaluated, placement_of
from parakin.model.units import ANGLE, LENGTH, Dimension

_FARTHEST = 1e100  # [m]: products of lengths stay finite
_CONED = ("spherical", "universal")  # kinds of joints that have a cone angle


def graph_of(
    mechanism: Mechanism,
    bare: list[Bare] | None = None,
    free: Mapping[str, Varied | float] | None = None,
) -> Graph:
    """A mechanism in numbers, SI. bare: a list that takes note of numbers without a unit. free:
    parameters of another design, or that vary; what depends on them does too, but for the
    characteristic length of what varies, and what acts on the mechanism is left out.

    Raises InputError at the first expression that cannot be evaluated.
    """
    where = mechanism.where
    parameters = Parameters(mechanism.parameters, where, bare, free)
    values = parameters.all()
    others = [body.name for body in mechanism.bodies if body.name != mechanism.base]
    bodies = {name: k for k, name in enumerate([mechanism.base, *others])}
    points = _points(mechanism, bodies, parameters)
    joints: list[GraphJoint] = []
    coordinates: list[Coordinate] = []
    for joint in mechanism.joints:
        place = f"{where}: joints.{joint.name}"
        made = _joint(joint, bodies, len(coordinates), parameters, place)
        coordinates += _coordinates(joint, made, len(joints), place)
        joints.append(made)
    if len(coordinates) > MAX_JOINTS:
        expected = f"at most {MAX_JOINTS}"
        raise InputError(f"{where}: joints", f"{len(coordinates)} coordinates", expected)
    if mechanism.platform is not None:
        pose = _pose(mechanism.platform, bodies, points, len(coordinates))
        coordinates += _pose_coordinates(mechanism.platform, len(joints))
        joints.append(pose)
    reach = {
        j.name: max(math.hypot(*map(nominal, frame.p)) for frame in (j.F, j.M)) for j in joints
    }
    for name, far in reach.items():
        if not far < _FARTHEST:
            expected = f"less than {_FARTHEST:g} m"
            raise InputError(f"{where}: joints.{name}", f"a frame {far:g} m away", expected)
    named = _Named(mechanism, parameters, joints, coordinates)
    named.check_lists()
    angles = {c.name: c.angle for c in coordinates}
    limited = limits_of(mechanism, parameters, angles, named.cones)
    return Graph(
        mechanism,
        values,
        tuple(bodies),
        points,
        tuple(joints),
        tuple(coordinates),
        named.cones,
        limited,
        named.positions("home"),
        named.positions("stated"),
        named.positions("guess"),
        frozenset(named.numbers[name] for name in mechanism.from_home),
        max(reach.values(), default=0.0) or 1.0,
        Dynamics()
        if free
        else dynamics_of(mechanism, parameters, bodies, points, joints, coordinates, limited),
    )


def _points(
    mechanism: Mechanism, bodies: Mapping[str, int], parameters: Parameters
) -> dict[str, tuple[int, Vector[float]]]:
    """By `body.point`, the body's number and the point in its components."""
    place = f"{mechanism.where}: bodies"
    return {
        f"{body.name}.{point}": (
            bodies[body.name],
            evaluated(triple, parameters, f"{place}.{body.name}.points.{point}", LENGTH),
        )
        for body in mechanism.bodies
        for point, triple in body.points.items()
    }


def _joint(
    joint: Joint, bodies: Mapping[str, int], first: int, parameters: Parameters, place: str
) -> GraphJoint:
    pairs, length = PAIRS.get(joint.kind, ()), 0.0
    if joint.pitch is not None:
        advance = parameters.evaluate(joint.pitch, LENGTH, f"{place}.pitch")
        pairs = (Z_TURN._replace(pitch=advance / (2 * math.pi)),)
    if joint.length is not None:
        length = parameters.evaluate(joint.length, LENGTH, f"{place}.length")
        if not length > 0:
            raise InputError(f"{place}.length", f"{length:g} m", "a length above zero")
    return GraphJoint(
        joint.name,
        joint.kind,
        bodies[joint.parent],
        bodies[joint.child],
        placement_of(joint.on_parent, parameters, f"{place}.on_parent"),
        placement_of(joint.on_child, parameters, f"{place}.on_child"),
        pairs,
        THETA if joint.kind == "universal" else IDENTITY,
        first,
        bool(joint.actuated),
        length,
        joint.on_parent.oriented or joint.on_child.oriented,
    )


def _coordinates(joint: Joint, made: GraphJoint, number: int, place: str) -> list[Coordinate]:
    """The coordinates of joint `number`: X if there is one, else X.1, X.2, ..."""
    count = len(made.pairs)
    actuated = joint.actuated
    if isinstance(actuated, bool):
        actuated = tuple(range(1, count + 1)) if actuated else ()
    for k in actuated:
        if k > count:
            expected = f"numbers of its coordinates, up to {count}"
            raise InputError(f"{place}.actuated", f"{k}", expected)
    names = [joint.name] if count == 1 else [f"{joint.name}.{k + 1}" for k in range(count)]
    return [
        Coordinate(name, number, not pair.slides, k in actuated)
        for k, (name, pair) in enumerate(zip(names, made.pairs, strict=True), start=1)
    ]


def _pose(
    platform: Platform,
    bodies: Mapping[str, int],
    points: Mapping[str, tuple[int, Vector[float]]],
    first: int,
) -> GraphJoint:
    """The platform's pose, as a joint that is free in all six directions."""
    origin = points[f"{platform.body}.{platform.point}"][1] if platform.point else ZERO
    slides = tuple(Pair(True, axis) for axis in range(3))
    turns = tuple(Pair(False, AXES[axis]) for _, axis in platform.angles)
    there = Pose(IDENTITY, origin)
    return GraphJoint(
        "platform",
        "free",
        0,
        bodies[platform.body],
        IDENTITY_POSE,
        there,
        slides + turns,
        IDENTITY,
        first,
    )


def _pose_coordinates(platform: Platform, number: int) -> list[Coordinate]:
    labels = ["x", "y", "z", *(name for name, _ in platform.angles)]
    return [Coordinate(f"platform.{label}", number, k > 2, False) for k, label in enumerate(labels)]


class _Named:
    """What a mechanism specifies for coordinates by name."""

    def __init__(
        self,
        mechanism: Mechanism,
        parameters: Parameters,
        joints: Sequence[GraphJoint],
        coordinates: Sequence[Coordinate],
    ) -> None:
        self.mechanism, self.parameters = mechanism, parameters
        self.coordinates = coordinates
        self.numbers = {c.name: k for k, c in enumerate(coordinates)}
        self.cones = {f"{j.name}.cone": j for j in joints if j.kind in _CONED}

    def check_lists(self) -> None:
        for key in ("driven", "from_home"):
            for name in getattr(self.mechanism, key):
                _check_known(name, f"{self.mechanism.where}: {key}", self.numbers)

    def positions(self, table: str) -> dict[int, float]:
        """A table of positions (home, stated or guess) by number."""
        found: dict[int, float] = {}
        for name, text in getattr(self.mechanism, table).items():
            place = f"{self.mechanism.where}: {table}.{name}"
            _check_known(name, place, self.numbers)
            value = self.parameters.evaluate(text, self._dimension(name), place)
            found[self.numbers[name]] = value
        return found

    def _dimension(self, name: str) -> Dimension:
        return ANGLE if self.coordinates[self.numbers[name]].angle else LENGTH


def _check_known(name: str, place: str, known: Collection[str]) -> None:
    if name not in known:
        raise InputError(place, f"unknown coordinate {name!r}", nearest(name, known))
