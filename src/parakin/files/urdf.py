"""URDF models as mechanisms: a tree of links, and loops, which URDF itself cannot describe.

Loops are read from `<loop>` (URDF+, Chignoli et al. 2024), from `<loop_joint>` (Isaac Sim), or
from a YAML file beside it. No mesh or other file is ever opened.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from parakin.algebra.spatial import IDENTITY, IDENTITY_POSE, ZERO, Matrix, Pose, matrix, turned
from parakin.errors import InputError, nearest
from parakin.files.from_links import mechanism_of
from parakin.files.links import TINY, Link, Range, moved
from parakin.files.loop_table import dependents, loops_of_table
from parakin.files.parsing import numbers
from parakin.files.urdf_dynamics import Weights
from parakin.files.vocabulary import check_words, language, line_of, not_used, written
from parakin.model.mechanism import MAX_JOINTS, Mechanism
from parakin.model.placement import about, unit, vector

if TYPE_CHECKING:
    from lxml.etree import _Element

# URDF's own, the loops of URDF+ and Isaac Sim, and what robots' files often add. What is marked `-`
# says nothing of kinematics.
_LANGUAGE = """
robot (!) name version
   link (*) name type
      inertial (?)
         origin (?) xyz rpy quat_xyzw
         mass (?) value
         inertia (?) ixx iyy izz ixy ixz iyz
      visual (-)
      collision (-)
      contact (-)
      sensor (-)
      gravity (-)
      kinematic (-)
      collision_checking (-)
      self_collision_checking (-)
      self_filter (-)
   joint (*) name type independent dont_collapse
      origin (?) xyz rpy quat_xyzw
      parent (?) link
      child (?) link
      axis (?) xyz
      limit (?) lower upper effort velocity acceleration deceleration jerk
                command_effort current gear_velocity {http://drake.mit.edu}acceleration
      mimic (?) joint multiplier offset
      calibration (-)
      dynamics (?) damping friction armature rotor_inertia spring_reference spring_stiffness
      safety_controller (-)
      controller_gains (-)
      joint_properties (-)
      traits (-)
   loop (*) name type
      predecessor (?) link
         origin (?) xyz rpy quat_xyzw
      successor (?) link
         origin (?) xyz rpy quat_xyzw
      axis (?) xyz
   loop_joint (*) name type
      link1 (*) link xyz rpy quat_xyzw
      link2 (*) link xyz rpy quat_xyzw
      axis (?) xyz
   coupling (-)
   collision_filter_group (-)
   drake:collision_filter_group (-)
   fixed_frame (-)
   frame (-)
   gazebo (-)
   material (-)
   mujoco (-)
   ros2_control (-)
   sensor (-)
   transmission (-)
"""
_URDF = language(_LANGUAGE)
_UNREAD = {line.split()[0] for line in _LANGUAGE.splitlines() if "(-)" in line}
_KINDS = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
    "floating": "free",
    "planar": "planar",
    "spherical": "spherical",
    "ball": "spherical",
}
_FREEDOMS = {"revolute": 1, "prismatic": 1, "free": 6, "planar": 3, "spherical": 3, "universal": 2}
_UNBOUNDED = 1000.0  # [m, rad, per s]: URDF must have limits; from here on they mean none
_ROUNDED = 1e-3  # how far a quaternion's length may be from 1
_TREE = (
    "Read from a URDF without loops: an open tree. If the robot has loops, name the file that "
    "specifies them: --loops FILE."
)


def mechanism_from_urdf(
    root: _Element, origin: str, table: Mapping[str, Any] | None, table_origin: str
) -> Mechanism:
    """The mechanism in a URDF model.

    root: the XML. table: the contents of a separate file of loops, if there is one. origin,
    table_origin: the two files, for messages. Raises InputError.
    """
    if len(root) > 20 * MAX_JOINTS:
        raise InputError(origin, f"{len(root)} elements", f"at most {20 * MAX_JOINTS}")
    check_words(root, _URDF, origin)
    for element in root.iterfind("gazebo/joint"):
        raise InputError(line_of(element, origin), "a joint in <gazebo>", "<loop> or <loop_joint>")
    names = [_name(element, origin) for element in root.iterfind("link")]
    _distinct(names, "links", origin)
    solved = set(map(str, dependents(table, table_origin))) if table is not None else set()
    weights = Weights(root, _origin, origin)
    links, screws = _joints(root, names, origin, solved, weights)
    base = _base(names, links, origin)
    loops = [*_loops(root, names, origin), *screws]
    if table is not None:
        before = {link.name: link.kind for link in links if link.passive}
        more, links = loops_of_table(table, names, links, screws, base, table_origin)
        loops += more
        weights.leave_out([x.name for x in links if x.kind != before.get(x.name, x.kind)])
    links = _followed(links, screws)
    closed = any(link.kind != "screw" for link in loops)
    notes = ("Read from URDF." if closed else _TREE) + not_used(
        root, lambda element: written(element) not in _UNREAD
    )
    title = root.get("name") or "robot"
    notes += weights.notes()
    return mechanism_of(title, base, names, links, loops, origin, notes, weights.masses)


def _name(element: _Element, origin: str) -> str:
    name = element.get("name")
    if not name:
        raise InputError(line_of(element, origin), f"a <{element.tag}> without a name", "a name")
    return str(name)


def _distinct(names: Sequence[str], what: str, origin: str) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise InputError(f"{origin}: {what}", f"two named {name!r}", "distinct names")
        seen.add(name)


def _base(names: Sequence[str], links: Sequence[Link], origin: str) -> str:
    """The link that is no joint's child. Raises InputError if the joints do not form a tree."""
    children = [link.child for link in links]
    twice = next((name for name in children if children.count(name) > 1), None)
    if twice is not None:
        expected = "one; loops are specified by <loop>, <loop_joint> or a separate file"
        raise InputError(f"{origin}: link {twice!r}", "two parents", expected)
    roots = [name for name in names if name not in children]
    if len(roots) != 1:
        found = f"{len(roots)} links that are no joint's child: {', '.join(roots[:5])}"
        raise InputError(origin, found, "one, the root of the tree")
    return roots[0]


def _joints(
    root: _Element, names: Sequence[str], origin: str, solved: set[str], weights: Weights
) -> tuple[list[Link], list[Link]]:
    """The joints of the tree, and the couplings that make screws.

    solved: joints that mimic nothing, since loops move them.
    """
    links: list[Link] = []
    mimics: dict[str, tuple[_Element, str]] = {}
    for element in root.iterfind("joint"):
        name = _name(element, origin)
        place = f"{line_of(element, origin)}: joint {name!r:.80}"
        kind = _kind(element, place)
        parent, child = (_end(element, role, names, place) for role in ("parent", "child"))
        F, M = _origin(element.find("origin"), place) @ _axis(element, kind, place), IDENTITY_POSE
        if kind in ("revolute", "prismatic", "planar"):
            M = _axis(element, kind, place)
        links.append(
            Link(
                name, kind, parent, child, F, M,
                (0.0,) * _FREEDOMS.get(kind, 0),
                _limits(element, kind, place),
                _speeds(element, kind, place),
                _independent(element, place),
                place=place,
                passive=weights.passive(element, kind, place),
            )
        )  # fmt: skip
        mimic = element.find("mimic")
        if mimic is not None and name not in solved:
            mimics[name] = mimic, place
    _distinct([link.name for link in links], "joints", origin)
    screws = []
    kinds = {link.name: link.kind for link in links}
    for name, (mimic, place) in mimics.items():
        screw = _mimic(mimic, name, kinds, place)
        if screw.kind == "screw":
            screws.append(screw)
        else:
            links = [_held(link, screw.advance) if link.name == name else link for link in links]
    return links, screws


def _independent(element: _Element, place: str) -> bool:
    """Whether URDF+ has the joint driven."""
    said = element.get("independent", "false").lower()
    if said not in ("true", "false"):
        raise InputError(f"{place}: independent", f"{said!r:.80}", "true or false")
    return said == "true"


def _mimic(element: _Element, name: str, kinds: Mapping[str, str], place: str) -> Link:
    """The screw that a joint makes with the one it mimics; a "fixed" link if it stands still.

    Raises InputError on other joints.
    """
    leader = element.get("joint") or ""
    if leader not in kinds:
        raise InputError(f"{place}: mimic", f"unknown joint {leader!r:.80}", nearest(leader, kinds))
    (ratio,) = numbers(element.get("multiplier"), 1, (1.0,), f"{place}: multiplier")
    (offset,) = numbers(element.get("offset"), 1, (0.0,), f"{place}: offset")
    pair = kinds[leader], kinds[name]
    if ratio == 0 and pair[1] in ("revolute", "prismatic"):
        return Link(name, "fixed", leader, name, advance=offset)
    if abs(ratio) < TINY:
        place = f"{place}: multiplier"
        raise InputError(place, f"{ratio:g}", f"0, or at least {TINY:g}")
    if pair == ("revolute", "prismatic"):
        return Link(name, "screw", leader, name, pitch=ratio, advance=offset, place=place)
    if pair == ("prismatic", "revolute"):
        return Link(
            name, "screw", name, leader, pitch=1 / ratio, advance=-offset / ratio, place=place
        )
    found = f"a joint that mimics {leader!r:.80}"
    expected = "independent joints, screws, or loops instead: gears are not supported"
    raise InputError(place, found, expected)


def _followed(links: Sequence[Link], screws: Sequence[Link]) -> list[Link]:
    """Links with each hinge that mimics a slide where the slide's position has it."""
    slides = {link.name: link.values for link in links}
    values = {
        screw.name: tuple((q - screw.advance) / screw.pitch for q in slides[screw.child])
        for screw in screws
        if screw.name == screw.parent
    }
    return [replace(link, values=values.get(link.name, link.values)) for link in links]


def _held(link: Link, at: float) -> Link:
    """A hinge or slide that stands still at `at` [rad, m]."""
    F = link.F @ moved(link.kind == "prismatic", at)
    return Link(link.name, "fixed", link.parent, link.child, F, link.M)


def _kind(element: _Element, place: str) -> str:
    kind = element.get("type") or ""
    if kind not in _KINDS:
        raise InputError(place, f"type {kind!r}", nearest(kind, _KINDS))
    return _KINDS[kind]


def _end(element: _Element, role: str, names: Sequence[str], place: str) -> str:
    end = element.find(role)
    name = None if end is None else end.get("link")
    if name is None:
        raise InputError(place, f"no <{role} link=...>", "a link")
    if name not in names:
        raise InputError(f"{place}: {role}", f"unknown link {name!r}", nearest(name, names))
    return str(name)


def _origin(element: _Element | None, place: str) -> Pose[float]:
    if element is None:
        return IDENTITY_POSE
    p = vector(numbers(element.get("xyz"), 3, ZERO, f"{place}: xyz"))
    if element.get("quat_xyzw") is None:
        return Pose(_rotation(numbers(element.get("rpy"), 3, ZERO, f"{place}: rpy")), p)
    place = f"{place}: quat_xyzw"
    if element.get("rpy") is not None:
        raise InputError(place, "quat_xyzw beside rpy", "one of them")
    x, y, z, w = numbers(element.get("quat_xyzw"), 4, (), place)
    size = math.hypot(x, y, z, w)
    if abs(size - 1) > _ROUNDED:
        raise InputError(place, f"a quaternion of length {size:g}", "one of length 1")
    x, y, z, w = (a / size for a in (x, y, z, w))
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return Pose(matrix(rows), p)


def _rotation(rpy: Sequence[float]) -> Matrix[float]:
    """The rotation by roll, pitch and yaw: about the fixed x, y and z axes, in this order."""
    R = IDENTITY
    for axis, angle in reversed(list(enumerate(rpy))):
        if angle:
            R = turned(R, axis, math.cos(angle), math.sin(angle))
    return R


def _axis(element: _Element, kind: str, place: str) -> Pose[float]:
    """A frame whose z is the joint's axis."""
    if kind not in ("revolute", "prismatic", "planar"):
        return IDENTITY_POSE
    axis = element.find("axis")
    values = numbers(None if axis is None else axis.get("xyz"), 3, (1.0, 0.0, 0.0), place)
    return Pose(about(unit(vector(values), f"{place}: axis")), ZERO)


def _limits(element: _Element, kind: str, place: str) -> tuple[Range, ...]:
    """A hinge's or slide's limits, if there are any; 0 to 0, where none are told, are none."""
    limit = element.find("limit")
    if limit is None or element.get("type") == "continuous" or _FREEDOMS.get(kind) != 1:
        return ()
    low, high = (
        numbers(limit.get(key), 1, (0.0,), f"{place}: {key}")[0] for key in ("lower", "upper")
    )
    if low > high or (low == high and low != 0):
        raise InputError(f"{place}: limit", f"{low:g} to {high:g}", "lower below upper")
    low = low if low > -_UNBOUNDED else -math.inf
    high = high if high < _UNBOUNDED else math.inf
    limited = low < high and (math.isfinite(low) or math.isfinite(high))
    return ((low, high),) if limited else ()


def _speeds(element: _Element, kind: str, place: str) -> tuple[float, ...]:
    """A hinge's or slide's greatest speed; 0, as where none is told, is none."""
    limit = element.find("limit")
    if limit is None or _FREEDOMS.get(kind) != 1:
        return ()
    (speed,) = numbers(limit.get("velocity"), 1, (0.0,), f"{place}: velocity")
    if speed < 0.0:
        raise InputError(f"{place}: velocity", f"{speed:g}", "a speed of 0 or more")
    return (speed,) if 0.0 < speed < _UNBOUNDED else ()


def _loops(root: _Element, names: Sequence[str], origin: str) -> list[Link]:
    """Loops in the URDF itself."""
    found = []
    for element in root.iterchildren("loop", "loop_joint", "coupling"):
        name = _name(element, origin)
        place = f"{line_of(element, origin)}: loop {name!r:.80}"
        if element.tag == "coupling":
            raise InputError(place, "a <coupling>", "loops: gears are not supported")
        kind = _kind(element, place)
        if kind == "free":
            raise InputError(place, "type 'floating'", "a joint that holds something")
        sides: list[_Element | None]
        if element.tag == "loop":
            sides = [element.find(role) for role in ("predecessor", "successor")]
            origins = [None if side is None else side.find("origin") for side in sides]
        else:
            sides = [*element.iterfind("link1"), *element.iterfind("link2")]  # some write 1 twice
            origins = list(sides)
        if len(sides) != 2:
            raise InputError(place, f"{len(sides)} links", "the two links that it joins")
        ends = []
        for side, at in zip(sides, origins, strict=True):
            link = "" if side is None else side.get("link") or ""
            if link not in names:
                raise InputError(place, f"unknown link {link!r}", nearest(link, names))
            ends.append((link, _origin(at, place) @ _axis(element, kind, place)))
        (a, F), (b, M) = ends
        found.append(Link(name, kind, a, b, F, M, place=place))
    return found
