"""Loops of a URDF in a YAML file beside it.

Either `closures` (scikit-robot's loop_closures.yaml: a hinge's point and axis in the root link's
frame, all joints at zero), or `closed_loop`, `type` and `name_mot` (Gepetto's
example-parallel-robots: pairs of links that coincide), or both.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from parakin.algebra.spatial import IDENTITY, IDENTITY_POSE, ZERO, Matrix, Pose
from parakin.errors import InputError, nearest
from parakin.files.links import Link
from parakin.files.parsing import number
from parakin.model.joints import THETA
from parakin.model.placement import AXES, about, unit, vector

_KEYS = (
    *("closures", "closed_loop", "type", "name_mot", "independent", "dependent", "home"),
    *("joint_name", "joint_type"),
)
_ROUNDED = 1e-6  # how far values in the file may be from what follows from them
_CLOSURE_KEYS = ("link_a", "link_b", "point", "axis")


def loops_of_table(
    table: Mapping[str, Any],
    names: Sequence[str],
    links: Sequence[Link],
    screws: Sequence[Link],
    base: str,
    place: str,
) -> tuple[list[Link], list[Link]]:
    """Loops in a separate file, and the tree's joints as that file changes them.

    table: its contents. names: of the URDF's links. links: its joints. screws: those that mimic
    others. base: its root link. place: the file, for messages. Raises InputError.
    """
    _check_keys(table, _KEYS, place)
    known = {"closures", "closed_loop"} & set(table)
    if not known:
        raise InputError(place, "no loops", "closures, or closed_loop and type")
    loops: list[Link] = []
    if "closed_loop" in known:
        ends = {link.name: link.child for link in links} | {name: name for name in names}
        loops += _pairs(table, ends, place)
    elif "type" in table:
        raise InputError(f"{place}: type", "types without closed_loop", "closed_loop, or no types")
    if "closures" in known:
        loops += _closures(table, names, _poses(links, base), place)
    motors = _motors(table, place)
    values = table.get("home", {})
    if not isinstance(values, Mapping):
        raise InputError(f"{place}: home", f"{values!r:.80}", "positions by joint")
    joints = [link.name for link in links]
    for name in [*motors, *values, *dependents(table, place)]:
        if name not in joints:
            raise InputError(place, f"unknown joint {name!r:.80}", nearest(str(name), joints))
    _check_followers(values, screws, place)
    changed = _kinds_changed(table, place)
    made = []
    for link in links:
        joint = _with_kind(link, changed.pop(link.name, None))
        if link.name in values:
            at = _home(values[link.name], len(joint.values), f"{place}: home.{link.name}")
            joint = replace(joint, values=at)
        if link.name in motors and joint.kind == "fixed":
            raise InputError(f"{place}: motors", f"{link.name!r:.80}", "a joint that moves")
        made.append(replace(joint, actuated=link.actuated or link.name in motors))
    if changed:
        name = next(iter(changed))
        raise InputError(f"{place}: joint_name", f"unknown joint {name!r}", nearest(name, joints))
    return loops, made


def dependents(table: Mapping[str, Any], place: str) -> list[Any]:
    """The joints whose positions follow from the loops, whatever they mimic. Raises InputError."""
    return _list(table.get("dependent", []), f"{place}: dependent")


def _check_keys(table: Mapping[Any, Any], known: Sequence[str], place: str) -> None:
    for key in table:
        if key not in known:
            raise InputError(place, f"an unknown key {key!r:.80}", nearest(str(key), known))


def _motors(table: Mapping[str, Any], place: str) -> list[Any]:
    if "name_mot" in table and "independent" in table:
        raise InputError(f"{place}: independent", "independent beside name_mot", "one of them")
    key = "name_mot" if "name_mot" in table else "independent"
    return _list(table.get(key, []), f"{place}: {key}")


def _home(value: object, count: int, place: str) -> tuple[float, ...]:
    """A joint's coordinates: a number, or a list of them where there are several."""
    if count == 1:
        return (_number(value, place),)
    if not isinstance(value, list) or len(value) != count:
        expected = f"a list of {count} numbers" if count else "none, as the joint is fixed"
        raise InputError(place, f"{value!r:.80}", expected)
    return tuple(_number(item, place) for item in value)


def _check_followers(values: Mapping[str, Any], screws: Sequence[Link], place: str) -> None:
    """Raises InputError on a home of a joint that mimics another which is not where it follows."""
    for screw in screws:
        if screw.name not in values:
            continue
        slides = screw.name == screw.child
        leader = screw.parent if slides else screw.child
        where = f"{place}: home.{screw.name}"
        told = _number(values[screw.name], where)
        q = _number(values.get(leader, 0.0), f"{place}: home.{leader}")
        at = screw.advance + screw.pitch * q if slides else (q - screw.advance) / screw.pitch
        if abs(told - at) > _ROUNDED * max(1.0, abs(at)):
            raise InputError(where, f"{told:g}", f"{at:g}, where it follows {leader!r:.80}")


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
        loops.append(Link(name, loop, links[ends[0]], links[ends[1]], place=where))
    return loops


def _shared(a: str, b: str) -> str:
    """What two names have in common at the start: loop1 of loop1_A and loop1_B."""
    same = [x == y for x, y in zip(a, b, strict=False)]
    return a[: [*same, False].index(False)].rstrip("_")


def _closures(
    table: Mapping[str, Any], names: Sequence[str], poses: Mapping[str, Pose[float]], place: str
) -> list[Link]:
    loops = []
    for k, closure in enumerate(_list(table["closures"], f"{place}: closures")):
        where = f"{place}: closures[{k}]"
        if not isinstance(closure, Mapping):
            raise InputError(where, f"{closure!r:.80}", "link_a, link_b, point and axis")
        _check_keys(closure, _CLOSURE_KEYS, where)
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
        loops.append(Link(f"loop{k + 1}", kind, ends[0], ends[1], F, M, place=where))
    return loops


def _poses(links: Sequence[Link], base: str) -> dict[str, Pose[float]]:
    """Every link's pose in the root's frame, all joints at zero, those too that mimic others."""
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
    changed = {str(name): str(kind) for name, kind in zip(names, kinds, strict=True)}
    if len(changed) < len(names):
        raise InputError(f"{place}: joint_name", "a joint twice", "each joint once")
    return changed


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
    """A number; YAML takes 1e-3 for a text."""
    if isinstance(value, (int, float, str)) and not isinstance(value, bool):
        found = number(value) if isinstance(value, str) else value
        if abs(found) < 1e100:
            return float(found)
    raise InputError(place, f"{value!r:.80}", "a number")
