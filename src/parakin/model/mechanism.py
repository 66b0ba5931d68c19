"""A mechanism as its author describes it: bodies, joints, lengths, what is driven. Data only.

The same types are read from TOML and built in Python. Any length or angle may be a number (SI),
a quantity ("850 mm") or an expression in the parameters ("d2 + d3 + d4"). Names are checked
here; numbers are evaluated in `parakin.model.evaluation`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import pydantic
from pydantic import BeforeValidator

from parakin import notebook
from parakin.errors import InputError, nearest, printable
from parakin.model.bodies import Body, Frame
from parakin.model.drives import Damper, Drive, Friction, Spring, Stop
from parakin.model.expressions import Parameters, Value
from parakin.model.fields import (
    Actuated,
    Angles,
    MechanismName,
    Name,
    Names,
    OneOrMore,
    ParameterName,
    Quantity,
    Range,
    Triple,
    tupled,
)
from parakin.model.forces import Force, Payload
from parakin.model.units import BARE, Dimension, describe
from parakin.model.validation import Table, Text, input_error

# And coordinates: assembly runs in plain Python, where a mechanism of more joints that does not
# close would take minutes.
MAX_JOINTS = 400

Kind = Literal[
    "revolute",
    "prismatic",
    "cylindrical",
    "helical",
    "universal",
    "spherical",
    "planar",
    "free",
    "rod",
    "fixed",
]


class Joint(Table):
    """A joint between two bodies, from `parent` to `child`; its coordinates count that way.

    A universal joint turns about its parent frame's z, then about its child frame's z, which
    lies along the parent frame's x when the first angle is zero. A spherical joint's angles turn
    about x, then y, then z. A cylindrical joint has its angle first, its displacement second. A
    helical joint advances by `pitch` [m] along z in each turn. A planar joint slides along x and
    y, then turns about z; a free one slides along x, y, z and turns as a spherical one. A rod of
    `length` [m] between the two frames' origins, with spherical ends, has no coordinates.

    actuated: whether a motor moves the joint, or which of its coordinates: (2,) is the second.
    friction, spring, damper, stop (at limits), armature (inertia that moves with a coordinate, of a
    rotor behind its gear, say [kg or kg m²]): one for each coordinate, or one for all if these are
    alike. drive: what moves each actuated coordinate. Raises InputError.
    """

    set_by_reader = frozenset({"name"})

    name: Name
    kind: Kind
    parent: Name
    child: Name
    on_parent: Frame = Frame()
    on_child: Frame = Frame()
    actuated: Actuated = False
    pitch: Quantity | None = None
    length: Quantity | None = None
    friction: OneOrMore[Friction] = ()
    spring: OneOrMore[Spring] = ()
    damper: OneOrMore[Damper] = ()
    stop: OneOrMore[Stop] = ()
    armature: OneOrMore[Quantity] = ()
    drive: Drive | None = None


class Platform(Table):
    """The platform: a body, the point on it with coordinates x, y, z, and three named angles.

    The angles turn it from the base's axes about its own moving axes, one after another.
    point: the body's origin by default. Raises InputError.
    """

    body: Name = "platform"
    point: Name | None = None
    angles: Angles = (("roll", "x"), ("pitch", "y"), ("yaw", "z"))


class Mechanism(Table):
    """Bodies, joints and parameters, frozen.

    home: coordinates held at these values at assembly. stated: values that the source gives for
    home; assembly starts from them, and `parakin check` says how far off they are. guess: rough
    starting values. Each value is a number (metres, radians), a quantity ("20 mm") or an
    expression. from_home: coordinates that are counted from home. base: the fixed body's name. up:
    the base's axis that points up in pictures. source, notes: text, printed by `parakin check` and
    reports. origin: the file it was read from, for messages. Raises InputError on names that do not
    exist, duplicates and disconnected bodies.

    gravity: against `up` [m/s²], or a vector in the base's axes; 9.80665 m/s² by default. forces:
    springs between points, wrenches and payloads, by name.
    """

    set_by_reader = frozenset({"origin"})

    name: MechanismName
    title: Text = ""
    source: Text = ""
    notes: Text = ""
    up: Literal["x", "y", "z"] = "z"
    parameters: Mapping[ParameterName, Quantity] = {}
    symbols: Mapping[Text, Text] = {}
    base: Name = "base"
    bodies: Annotated[tuple[Body, ...], BeforeValidator(tupled)]
    joints: Annotated[tuple[Joint, ...], BeforeValidator(tupled)]
    platform: Platform | None = None
    driven: Names = ()
    home: Mapping[str, Quantity] = {}
    stated: Mapping[str, Quantity] = {}
    guess: Mapping[str, Quantity] = {}
    limits: Mapping[str, Range] = {}
    from_home: Names = ()
    gravity: Quantity | Triple | None = None
    forces: Mapping[Name, Force] = {}
    motions: Mapping[Text, Mapping[str, Any]] = {}
    origin: str = ""

    def __init__(self, /, **data: Any) -> None:  # pydantic's own signature
        try:
            super().__init__(**data)
        except pydantic.ValidationError as error:
            where = data.get("origin") or data.get("name", "mechanism")
            raise input_error(error, f"{where}:", data) from None
        _check_names(self)

    @property
    def where(self) -> str:
        """What messages call it: its file, or its name."""
        return printable(self.origin) or self.name

    @property
    def folder(self) -> Path:
        """Where files are that its file names."""
        return Path(self.origin or ".").parent

    def _repr_html_(self) -> str:
        bodies = [body.name for body in self.bodies if body.name != self.base]
        rows = [(j.name, j.kind, j.parent, j.child, _moved_by(j)) for j in self.joints]
        return (
            notebook.heading(self.name, self.title)
            + notebook.picture("scheme", self)
            + notebook.lines(
                source=self.source,
                bodies=", ".join((f"{self.base} (fixed)", *bodies)),
                platform=self.platform.body if self.platform is not None else "",
                driven=", ".join(self.driven),
                masses=", ".join(filter(None, map(_weighed, self.bodies))),
                forces=", ".join(f"{name} ({force.kind})" for name, force in self.forces.items()),
                parameters=", ".join(f"{key} = {value}" for key, value in self.parameters.items()),
                motions=", ".join(self.motions),
            )
            + notebook.table(("joint", "kind", "parent", "child", "actuated"), rows)
        )

    def with_parameters(self, values: Mapping[str, Value]) -> Mechanism:
        """The mechanism with other values for some of its parameters.

        Raises InputError on a parameter that does not exist, and on text of another dimension than
        its own; a number without a unit may stand for any.
        """
        for name in values:
            if name not in self.parameters:
                raise InputError(
                    f"{self.where}: parameters",
                    f"unknown parameter {name!r}",
                    nearest(name, self.parameters),
                )
        found = self.model_copy(update={"parameters": {**self.parameters, **values}})
        for name, value in values.items():
            if isinstance(value, str):
                own, given = (_dimension(mechanism, name) for mechanism in (self, found))
                if own is not None and given is not None and not _alike(own, given):
                    place = f"{self.where}: parameters.{name}"
                    raise InputError(place, f"{value!r}, {describe(given)}", describe(own))
        return found

    def with_payload(self, text: str) -> Mechanism:
        """The mechanism with a payload, "80 kg at seat" or "80 kg at platform.seat": of a mass at a
        body's origin or at a point on it. Raises InputError on text of another form; what it names
        is checked when the mechanism is put in numbers.
        """
        mass, at, where = text.rpartition(" at ")
        if not at or not mass.strip() or not where.strip():
            raise InputError("payload", repr(text), "a mass and a place, such as '80 kg at seat'")
        load = Payload(kind="payload", mass=mass.strip(), at=where.strip())
        name = next(
            name
            for name in ("payload", *(f"payload {k}" for k in range(2, len(self.forces) + 3)))
            if name not in self.forces
        )
        return self.model_copy(update={"forces": {**self.forces, name: load}})


def _weighed(body: Body) -> str:
    """A body and its mass as the file gives it, "" if it gives none."""
    if body.mass is not None:
        text = f"{body.mass:g} kg" if isinstance(body.mass, (int, float)) else body.mass
        return f"{body.name} {text}"
    if body.solid:
        return f"{body.name} as its solids"
    dense = body.mesh is not None and body.mesh.density is not None
    return f"{body.name} as its mesh" if dense else ""


def _moved_by(joint: Joint) -> str:
    """Which of a joint's coordinates are actuated, for a table."""
    if isinstance(joint.actuated, bool):
        return "yes" if joint.actuated else ""
    return ", ".join(f"coordinate {k}" for k in joint.actuated)


def _duplicate(names: Iterable[str]) -> str | None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            return name
        seen.add(name)
    return None


def _check_names(mechanism: Mechanism) -> None:
    bodies = {mechanism.base, *(body.name for body in mechanism.bodies)}
    twice = _duplicate(body.name for body in mechanism.bodies)  # the base may be declared too
    if twice is not None:
        raise InputError(f"{mechanism.where}: bodies", f"two named {twice!r}", "distinct names")
    twice = _duplicate(joint.name for joint in mechanism.joints)
    if twice is not None:
        raise InputError(f"{mechanism.where}: joints", f"two named {twice!r}", "distinct names")
    if not mechanism.joints:
        raise InputError(f"{mechanism.where}: joints", "none", "at least one joint")
    for what, count in (("joints", len(mechanism.joints)), ("bodies", len(mechanism.bodies))):
        if count > MAX_JOINTS + (what == "bodies"):
            expected = f"at most {MAX_JOINTS} joints, and the bodies that they join"
            raise InputError(f"{mechanism.where}: {what}", f"{count}", expected)
    for joint in mechanism.joints:
        place = f"{mechanism.where}: joints.{joint.name}"
        for role, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in bodies:
                raise InputError(f"{place}.{role}", f"unknown body {name!r}", nearest(name, bodies))
        for key, kind in (("pitch", "helical"), ("length", "rod")):
            if (getattr(joint, key) is None) == (joint.kind == kind):
                having = "without" if joint.kind == kind else "with"
                raise InputError(
                    f"{place}.{key}",
                    f"a {joint.kind} joint {having} a {key}",
                    f"a {key} for every {kind} joint and for no other",
                )
        if joint.parent == joint.child:
            raise InputError(place, f"{joint.parent!r} joined to itself", "two different bodies")
    _check_screws(mechanism)
    _check_platform(mechanism, bodies)
    _check_connected(mechanism, bodies)


def _check_screws(mechanism: Mechanism) -> None:
    """Raises InputError on a loop of helical joints alone: some joint has to close it, and none of
    these can, as it would have to know how often it has turned.
    """
    group: dict[str, str] = {}

    def first(body: str) -> str:
        while body in group:
            body = group[body]
        return body

    for joint in mechanism.joints:
        if joint.kind != "helical":
            continue
        a, b = first(joint.parent), first(joint.child)
        if a == b:
            place = f"{mechanism.where}: joints.{joint.name}"
            raise InputError(place, "a loop of helical joints alone", "another kind in every loop")
        group[b] = a


def _check_platform(mechanism: Mechanism, bodies: set[str]) -> None:
    platform = mechanism.platform
    if platform is None:
        return
    place = f"{mechanism.where}: platform"
    if platform.body not in bodies:
        raise InputError(
            f"{place}.body", f"unknown body {platform.body!r}", nearest(platform.body, bodies)
        )
    points = {p for body in mechanism.bodies if body.name == platform.body for p in body.points}
    if platform.point is not None and platform.point not in points:
        raise InputError(
            f"{place}.point", f"unknown point {platform.point!r}", nearest(platform.point, points)
        )
    names = [name for name, _ in platform.angles]
    axes = [axis for _, axis in platform.angles]
    if len(names) != 3 or len({*names, "x", "y", "z"}) != 6 or sorted(axes) != ["x", "y", "z"]:
        raise InputError(
            f"{place}.angles",
            repr([list(angle) for angle in platform.angles]),
            "three distinct names (not x, y, z), one about each of the axes x, y and z",
        )
    if any(joint.name == "platform" for joint in mechanism.joints):
        raise InputError(
            f"{mechanism.where}: joints.platform",
            "a joint named 'platform'",
            "another name: 'platform' is the platform's pose",
        )


def _check_connected(mechanism: Mechanism, bodies: set[str]) -> None:
    loose = _loose(mechanism.base, bodies, [(j.parent, j.child) for j in mechanism.joints])
    if loose:
        raise InputError(
            f"{mechanism.where}: bodies",
            f"{', '.join(loose)} not connected to {mechanism.base!r}",
            "joints that connect every body to the base",
        )
    edges = [(j.parent, j.child) for j in mechanism.joints if j.kind != "rod"]
    if mechanism.platform is not None:
        edges.append((mechanism.base, mechanism.platform.body))
    loose = _loose(mechanism.base, bodies, edges)
    if loose:
        raise InputError(
            f"{mechanism.where}: bodies",
            f"{', '.join(loose)} held only by rods",
            "another joint to every body, or the platform: rods have no coordinates to place it by",
        )


def _loose(base: str, bodies: set[str], edges: list[tuple[str, str]]) -> list[str]:
    """Bodies that cannot be reached from the base."""
    reached, growing = {base}, True
    while growing:
        more = {b for edge in edges for b in edge if reached & set(edge)} - reached
        reached |= more
        growing = bool(more)
    return sorted(bodies - reached)


def _dimension(mechanism: Mechanism, name: str) -> Dimension | None:
    """The dimension of a parameter; None of a number without a unit, and of what has no value,
    which is told when the mechanism is put in numbers.
    """
    try:
        found = Parameters(mechanism.parameters, mechanism.where).dimension(name)
    except InputError:
        return None
    return None if found == BARE else found


def _alike(a: Dimension, b: Dimension) -> bool:
    """Whether the one may stand for the other: radians may be left out of what is per angle."""
    return a == b or (-1 in (a.angle, b.angle) and a._replace(angle=0) == b._replace(angle=0))
