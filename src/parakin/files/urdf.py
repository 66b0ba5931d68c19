"""URDF models as mechanisms: a tree of links, and loops, which URDF itself cannot describe.

Loops are read from `<loop>` (URDF+, Chignoli et al. 2024), from `<loop_joint>` (Isaac Sim), from
a YAML file of `closures` (scikit-robot's loop_closures.yaml: a hinge's point and axis in the root
link's frame, all joints at zero) or of `closed_loop`, `type` and `name_mot` (Gepetto's
example-parallel-robots: pairs of links that coincide). No mesh or other file is ever opened.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from parakin.algebra.spatial import IDENTITY, IDENTITY_POSE, ZERO, Matrix, Pose, turned
from parakin.errors import InputError, nearest
from parakin.files.from_links import mechanism_of
from parakin.files.links import Link
from parakin.files.parsing import numbers
from parakin.model.joints import THETA
from parakin.model.mechanism import MAX_JOINTS, Mechanism
from parakin.model.placement import AXES, about, unit, vector

if TYPE_CHECKING:
    from lxml.etree import _Element

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
_UNBOUNDED = 1000.0  # [m]: a slide must have limits in URDF; these mean that it has none
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
    names = [_name(element, origin) for element in root.iterfind("link")]
    _distinct(names, "links", origin)
    links, screws = _joints(root, names, origin, table or {})
    base = _base(names, links, origin)
    loops = [*_loops(root, names, origin), *screws]
    if table is not None:
        more, links = _from_table(table, names, links, base, table_origin)
        loops += more
    closed = any(link.kind != "screw" for link in loops)
    notes = "Read from URDF." if closed else _TREE
    title = root.get("name") or "robot"
    return mechanism_of(title, base, names, links, loops, origin, notes)


def _name(element: _Element, origin: str) -> str:
    name = element.get("name")
    if not name:
        place = f"{origin}, line {element.sourceline}"
        raise InputError(place, f"a <{element.tag}> without a name", "a name")
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
    root: _Element, names: Sequence[str], origin: str, table: Mapping[str, Any]
) -> tuple[list[Link], list[Link]]:
    """The joints of the tree, and the couplings that make screws."""
    dependent = table.get("dependent")
    solved = set(map(str, dependent)) if isinstance(dependent, list) else set()
    links, screws = [], []
    for element in root.iterfind("joint"):
        name = _name(element, origin)
        place = f"{origin}, line {element.sourceline}: joint {name!r}"
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
                (element.get("independent") or "").lower() == "true",  # as URDF+ has it
            )
        )  # fmt: skip
        mimic = element.find("mimic")
        if mimic is not None and name not in solved:
            (ratio,) = numbers(mimic.get("multiplier"), 1, (1.0,), f"{place}: multiplier")
            screws.append(Link(name, "screw", str(mimic.get("joint")), name, pitch=ratio))
    _distinct([link.name for link in links], "joints", origin)
    kinds = {link.name: link.kind for link in links}
    for screw in screws:
        if kinds.get(screw.parent) != "revolute" or kinds[screw.name] != "prismatic":
            raise InputError(
                f"{origin}: joint {screw.name!r}",
                f"a joint that mimics {screw.parent!r}",
                "independent joints, slides of screws, or loops instead: gears are not supported",
            )
    return links, screws


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
    return Pose(_rotation(numbers(element.get("rpy"), 3, ZERO, f"{place}: rpy")), p)


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


def _limits(element: _Element, kind: str, place: str) -> tuple[float, float] | None:
    limit = element.find("limit")
    if limit is None or element.get("type") == "continuous" or kind not in _FREEDOMS:
        return None
    low, high = (
        numbers(limit.get(key), 1, (0.0,), f"{place}: {key}")[0] for key in ("lower", "upper")
    )
    if kind == "prismatic" and max(-low, high) >= _UNBOUNDED:
        return None
    return (low, high) if low < high else None


def _loops(root: _Element, names: Sequence[str], origin: str) -> list[Link]:
    """Loops in the URDF itself."""
    found = []
    for element in root.iter("loop", "loop_joint", "coupling"):
        name = _name(element, origin)
        place = f"{origin}, line {element.sourceline}: loop {name!r}"
        if element.tag == "coupling":
            raise InputError(place, "a <coupling>", "loops: gears are not supported")
        kind = _kind(element, place)
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
        found.append(Link(name, kind, a, b, F, M))
    return found


def _from_table(
    table: Mapping[str, Any], names: Sequence[str], links: Sequence[Link], base: str, place: str
) -> tuple[list[Link], list[Link]]:
    """Loops in a separate file, and the tree's joints as that file changes them."""
    known = {"closures", "closed_loop"} & set(table)
    if not known:
        raise InputError(place, "no loops", "closures, or closed_loop and type")
    loops: list[Link] = []
    if "closed_loop" in known:
        ends = {link.name: link.child for link in links} | {name: name for name in names}
        loops += _pairs(table, ends, place)
    if "closures" in known:
        loops += _closures(table, names, links, base, place)
    motors = _list(table.get("name_mot", table.get("independent", [])), f"{place}: motors")
    values = table.get("home", {})
    if not isinstance(values, Mapping):
        raise InputError(f"{place}: home", f"{values!r:.80}", "positions by joint")
    joints = [link.name for link in links]
    for name in [*motors, *values]:
        if name not in joints:
            raise InputError(place, f"unknown joint {name!r:.80}", nearest(str(name), joints))
    changed = _kinds_changed(table, place)
    made = []
    for link in links:
        moved = _with_kind(link, changed.pop(link.name, None))
        at = moved.values
        if link.name in values and len(at) == 1:
            at = (_number(values[link.name], f"{place}: home.{link.name}"),)
        made.append(
            Link(
                moved.name, moved.kind, moved.parent, moved.child, moved.F, moved.M, at,
                moved.limits, link.actuated or link.name in motors,
            )
        )  # fmt: skip
    if changed:
        name = next(iter(changed))
        raise InputError(f"{place}: joint_name", f"unknown joint {name!r}", nearest(name, joints))
    return loops, made


def _pairs(table: Mapping[str, Any], links: Mapping[str, str], place: str) -> list[Link]:
    """Loops from pairs of links that coincide; a joint's name stands for its child link."""
    pairs = _list(table["closed_loop"], f"{place}: closed_loop")
    kinds = _list(table.get("type", ["6d"] * len(pairs)), f"{place}: type")
    if len(kinds) != len(pairs):
        found = f"{len(kinds)} types for {len(pairs)} loops"
        raise InputError(f"{place}: type", found, "a type for each")
    loops = []
    for k, (pair, kind) in enumerate(zip(pairs, kinds, strict=True)):
        where = f"{place}: closed_loop[{k}]"
        ends = [str(name) for name in _list(pair, where)]
        if len(ends) != 2:
            raise InputError(where, f"{pair!r:.80}", "two links that coincide")
        for name in ends:
            if name not in links:
                raise InputError(where, f"unknown link {name!r}", nearest(name, links))
        if str(kind).lower() not in ("3d", "6d"):
            raise InputError(f"{place}: type[{k}]", f"{kind!r:.80}", "3d (a point) or 6d (a frame)")
        fixed = str(kind).lower() == "6d"
        loop = "fixed" if fixed else "spherical"
        name = _shared(*ends) or f"loop{k + 1}"
        loops.append(Link(name, loop, links[ends[0]], links[ends[1]]))
    return loops


def _shared(a: str, b: str) -> str:
    """What two names have in common at the start: loop1 of loop1_A and loop1_B."""
    same = [x == y for x, y in zip(a, b, strict=False)]
    return a[: [*same, False].index(False)].rstrip("_")


def _closures(
    table: Mapping[str, Any], names: Sequence[str], links: Sequence[Link], base: str, place: str
) -> list[Link]:
    poses = _poses(links, base)
    loops = []
    for k, closure in enumerate(_list(table["closures"], f"{place}: closures")):
        where = f"{place}: closures[{k}]"
        if not isinstance(closure, Mapping):
            raise InputError(where, f"{closure!r:.80}", "link_a, link_b, point and axis")
        ends = []
        for role in ("link_a", "link_b"):
            name = str(closure.get(role))
            if name not in names:
                raise InputError(f"{where}.{role}", f"unknown link {name!r}", nearest(name, names))
            ends.append(name)
        point = _triple(closure.get("point"), f"{where}.point")
        R, kind = IDENTITY, "spherical"
        if closure.get("axis") is not None:
            axis = unit(vector(_triple(closure["axis"], f"{where}.axis")), f"{where}.axis")
            R, kind = about(axis), "revolute"
        F, M = (poses[name].inverse @ Pose(R, vector(point)) for name in ends)
        loops.append(Link(f"loop{k + 1}", kind, ends[0], ends[1], F, M))
    return loops


def _poses(links: Sequence[Link], base: str) -> dict[str, Pose[float]]:
    """Every link's pose in the root's frame, all joints at zero."""
    poses = {base: IDENTITY_POSE}
    waiting = list(links)
    while waiting:
        ready = [link for link in waiting if link.parent in poses]
        if not ready:
            break
        for link in ready:
            poses[link.child] = poses[link.parent] @ link.F @ link.M.inverse
        waiting = [link for link in waiting if link.child not in poses]
    return poses


def _kinds_changed(table: Mapping[str, Any], place: str) -> dict[str, str]:
    """The kinds that the file changes joints to, by name."""
    names = _list(table.get("joint_name", []), f"{place}: joint_name")
    kinds = _list(table.get("joint_type", []), f"{place}: joint_type")
    if len(names) != len(kinds):
        found = f"{len(kinds)} types for {len(names)} joints"
        raise InputError(f"{place}: joint_type", found, "a type for each")
    for kind in map(str, kinds):
        axes = kind.removeprefix("UJOINT_").lower()
        universal = (
            kind.startswith("UJOINT_") and len(axes) == 2 and len(set(axes) & set(AXES)) == 2
        )
        if kind not in ("SPHERICAL", "FIXED") and not universal:
            raise InputError(f"{place}: joint_type", kind, "SPHERICAL, FIXED or UJOINT_XY")
    return {str(name): str(kind) for name, kind in zip(names, kinds, strict=True)}


def _with_kind(link: Link, kind: str | None) -> Link:
    """A joint with its kind as in the file of loops, and its frame as in the URDF."""
    if kind is None:
        return link
    F = link.F @ link.M.inverse  # without the frame of its own axis
    if kind == "FIXED":
        return Link(link.name, "fixed", link.parent, link.child, F)
    if kind == "SPHERICAL":
        return Link(link.name, "spherical", link.parent, link.child, F, IDENTITY_POSE, (0.0,) * 3)
    first, second = (np.eye(3)[AXES[letter]] for letter in kind[-2:].lower())
    rows = (second, np.cross(first, second), first)
    R = Matrix((vector(rows[0]), vector(rows[1]), vector(rows[2]))).T
    M = Pose(R @ THETA, ZERO)
    F = Pose(F.R @ R, F.p)
    return Link(link.name, "universal", link.parent, link.child, F, M, (0.0,) * 2)


def _list(value: object, place: str) -> list[Any]:
    if not isinstance(value, list):
        raise InputError(place, f"{value!r:.80}", "a list")
    return value


def _triple(value: object, place: str) -> tuple[float, float, float]:
    values = _list(value, place)
    if len(values) != 3:
        raise InputError(place, f"{value!r:.80}", "three numbers")
    a, b, c = (_number(item, place) for item in values)
    return (a, b, c)


def _number(value: object, place: str) -> float:
    try:
        number = float(value)  # type: ignore[arg-type]
        if isinstance(value, bool) or not abs(number) < 1e100:
            raise ValueError
    except (TypeError, ValueError, OverflowError):
        raise InputError(place, f"{value!r:.80}", "a number") from None
    return number
