"""A mechanism made from the links and loops of a MJCF or URDF file."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

from parakin.algebra.spatial import IDENTITY, IDENTITY_POSE, Pose, Vector
from parakin.errors import InputError
from parakin.files import link_masses, resistances
from parakin.files.link_springs import LinkSpring, Springs
from parakin.files.links import (
    Link,
    Owners,
    Range,
    merge_chains,
    merge_rigid,
    split_off_platform,
    turns_in_order,
)
from parakin.files.screws import merge_screws
from parakin.files.vocabulary import listed
from parakin.model.bodies import Body, Frame
from parakin.model.drives import Drive
from parakin.model.masses import Mass
from parakin.model.mechanism import MAX_JOINTS, Joint, Mechanism, Platform
from parakin.model.placement import vector

WORLD = "world"  # MuJoCo's name for what does not move
_NOTHING = 1e-14  # [m]: a coordinate this small is round-off


def mechanism_of(
    name: str,
    base: str,
    bodies: Sequence[str],
    links: Sequence[Link],
    loops: Sequence[Link],
    origin: str,
    notes: str,
    masses: Mapping[str, Mass] | None = None,
    gravity: tuple[float, float, float] | None = None,
    springs: Sequence[LinkSpring] = (),
) -> Mechanism:
    """The mechanism of a tree of links and of the loops that close it.

    bodies: names of all links, the base's among them, in the order of the file. origin: the file,
    for messages. masses: of those links that weigh something. springs: between points of them.
    Raises InputError.
    """
    if len(links) + len(loops) > MAX_JOINTS:
        raise InputError(origin, f"{len(links) + len(loops)} joints", f"at most {MAX_JOINTS}")
    masses = masses or {}
    screws = [link for link in loops if link.kind == "screw"]
    closing = [link for link in loops if link.kind != "screw"]
    whole = merge_screws(links, screws, closing, origin)
    moving, owner = merge_rigid(base, [*whole, *closing], origin)
    held = {owner[link][0] for spring in springs for link, _ in spring.ends if link in owner}
    kept = {base} | link_masses.massive(masses, owner) | held
    joints, pose = _moving(base, moving, kept, origin)
    names = _body_names(base, bodies, [*joints, *([pose] if pose else [])], owner)
    used = {} if pose is None else {"platform": ""}  # the pose's own name
    titled = [(link, _fit(link.name, used)) for link in joints]
    points, weights = _points(owner, names, pose), link_masses.by_body(masses, owner)
    named = [spring._replace(name=_fit(spring.name, {})) for spring in springs]
    between = Springs(named, owner, names, points)
    notes += (
        between.notes + link_masses.not_weighed(masses, owner) + _not_resisting([*joints, pose])
    )
    return Mechanism(
        name=_fit(name, {}),
        title=name,
        notes=notes,
        base=names[base],
        bodies=tuple(
            Body(name=label, points=points[body], **weights.get(body, {}))
            for body, label in names.items()
        ),
        joints=tuple(_joint(link, title, names) for link, title in titled),
        platform=None if pose is None else _platform(pose, names),
        driven=_driven(titled),
        guess={
            coordinate: value
            for link, title in titled
            for coordinate, value in zip(_coordinates(link, title), link.values, strict=True)
        }
        | _pose_values(pose),
        limits=_limits(titled) | _pose_limits(pose) | _speeds(titled),
        gravity=gravity,
        forces=between.forces,
        origin=origin,
    )


def _moving(
    base: str, links: Sequence[Link], kept: set[str], origin: str
) -> tuple[list[Link], Link | None]:
    """The joints, chains of which are one, and the platform's pose. Raises InputError if there are
    none.
    """
    joints, pose = split_off_platform(base, merge_chains(links, kept))
    if not all(map(turns_in_order, joints)):
        joints, pose = split_off_platform(base, merge_chains(links, kept, in_order=True))
    if not joints:
        raise InputError(
            origin, "no joints that move", "at least one hinge, slide or other moving joint"
        )
    return joints, pose


def _body_names(
    base: str,
    bodies: Sequence[str],
    joints: Sequence[Link],
    owner: Owners,
) -> dict[str, str]:
    """Our names of the bodies that joints connect, by the file's; the base comes first."""
    ends = {body for link in joints for body in (link.parent, link.child)}
    joined = [body for body in (*bodies, *sorted(ends)) if body in ends]
    used: dict[str, str] = {}
    return {
        body: _fit(_called(body, base, bodies, owner), used)
        for body in dict.fromkeys([base, *joined])
    }


def _called(body: str, base: str, bodies: Sequence[str], owner: Owners) -> str:
    """A body's name in the file; for the world, that of the first body whose frame is the world's,
    if any: one that stands elsewhere would lend its name to another frame.
    """
    if body == base == WORLD:
        known = (b for b in bodies if b != base and b in owner)  # not so bodies inside a screw
        return next((b for b in known if owner[b] == (base, IDENTITY_POSE)), base)
    return body


def _joint(link: Link, title: str, names: Mapping[str, str]) -> Joint:
    return Joint(
        name=title,
        kind="helical" if link.pitch else link.kind,  # type: ignore[arg-type]
        parent=names[link.parent],
        child=names[link.child],
        on_parent=_frame(link.F),
        on_child=_frame(link.M),
        actuated=link.actuated,
        pitch=link.pitch or None,
        drive=Drive(ratio=link.gear) if link.gear != 1.0 else None,
        **(resistances.tables(link.passive) if link.kind != "free" else {}),
    )


def _not_resisting(links: Sequence[Link | None]) -> str:
    """A sentence on what resists free joints, which have no axes here; "" if nothing does."""
    free = [link for link in links if link is not None and link.kind == "free"]
    return listed(
        "Not used: what resists free joints", [link.name for link in free if link.passive]
    )


def _frame(at: Pose[float]) -> Frame:
    p = vector(0.0 if abs(a) < _NOTHING else a for a in at.p)
    if at.R == IDENTITY:
        return Frame(at=p)
    return Frame(at=p, axis=at.R.column(2), x=at.R.column(0))


def _platform(pose: Link, names: Mapping[str, str]) -> Platform:
    return Platform(
        body=names[pose.child],
        point="origin",
        angles=pose.angles,  # type: ignore[arg-type]
    )


def _coordinates(link: Link, title: str) -> list[str]:
    """Names of a joint's coordinates."""
    count = len(link.values)
    return [title] if count == 1 else [f"{title}.{k + 1}" for k in range(count)]


def _driven(titled: Sequence[tuple[Link, str]]) -> tuple[str, ...]:
    """The coordinates that motors move."""
    return tuple(
        coordinate
        for link, title in titled
        if link.actuated
        for number, coordinate in enumerate(_coordinates(link, title), start=1)
        if isinstance(link.actuated, bool) or number in link.actuated
    )


def _limits(titled: Sequence[tuple[Link, str]]) -> dict[str, Range]:
    """Limits by coordinate."""
    return {
        coordinate: limits
        for link, title in titled
        for coordinate, limits in zip(_coordinates(link, title), link.limits, strict=False)
        if limits is not None
    }


def _speeds(titled: Sequence[tuple[Link, str]]) -> dict[str, Range]:
    """Limits of velocities, by their names."""
    return {
        f"{coordinate}.velocity": (-speed, speed)
        for link, title in titled
        for coordinate, speed in zip(_coordinates(link, title), link.speeds, strict=False)
        if speed < math.inf
    }


def _pose_coordinates(pose: Link) -> list[str]:
    return [f"platform.{label}" for label in ("x", "y", "z", *(name for name, _ in pose.angles))]


def _pose_values(pose: Link | None) -> dict[str, float]:
    """The platform's coordinates in the file's own pose."""
    if pose is None:
        return {}
    return dict(zip(_pose_coordinates(pose), pose.values, strict=True))


def _pose_limits(pose: Link | None) -> dict[str, Range]:
    """The platform's limits, by coordinate."""
    if pose is None or not pose.limits:
        return {}
    named = zip(_pose_coordinates(pose), pose.limits, strict=True)
    return {coordinate: limits for coordinate, limits in named if limits is not None}


def _points(
    owner: Owners, names: Mapping[str, str], pose: Link | None
) -> dict[str, dict[str, Vector[float]]]:
    """Points by body: the links fixed to it, and the platform's reference point."""
    points: dict[str, dict[str, Vector[float]]] = {body: {} for body in names}
    for name, (body, at) in owner.items():
        if name != body and body in points:
            point = _fit(name, {p: p for p in points[body]})
            points[body][point] = at.p
    if pose is not None:
        points[pose.child]["origin"] = pose.M.p
    return points


def _fit(name: str, known: dict[str, str]) -> str:
    """A valid name made from another program's, different from all `known` ones; adds it there."""
    fit = re.sub(r"[^A-Za-z0-9_ '-]", "_", name)[:56].strip()
    if not re.match(r"[A-Za-z]", fit):
        fit = f"n{fit}"
    made, count = fit, 1
    while made in known:
        count += 1
        made = f"{fit}_{count}"
    known[made] = name
    return made
