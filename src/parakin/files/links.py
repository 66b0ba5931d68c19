"""Links: the joints of MJCF and URDF files, and how several of them make one joint of ours.

Such files have single hinges and slides, fixed links and, apart from the tree, loops. Here links
that are fixed to one another become one body; and hinges and slides that `parakin export` has
split, one joint again.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from parakin.algebra.spatial import (
    IDENTITY,
    IDENTITY_POSE,
    ZERO,
    Matrix,
    Pose,
    Vector,
    cross,
    dot,
    matrix,
)
from parakin.errors import InputError
from parakin.files import resistances
from parakin.model.dynamics import Passive
from parakin.model.joints import PAIRS, THETA
from parakin.model.placement import about

Range = tuple[float, float]
Owners = Mapping[str, tuple[str, Pose[float]]]  # of links: the body that each is part of, its place
TINY = 1e-12  # a ratio of coupled joints that is less is none that anybody meant
_UPSIDE_DOWN = Pose(matrix(((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0))), ZERO)
_BARE = ("spherical", "free")  # kinds whose coordinates have no axes of their own to resist along
_APART = 1e-6  # directions and positions that differ by less are the same


@dataclass(frozen=True)
class Link:
    """A joint in such a file: frame `F` on its parent and `M` on its child, which coincide when
    its coordinates are zero.

    values: its coordinates in the file's own pose [m, rad]. limits: their ranges, if there are any;
    speeds: their greatest speeds. passive: what they meet, if anything; a spherical joint has one,
    of damping alone. gear: a motor's turns for one of the joint.
    actuated: whether a motor moves it, or which of its coordinates, the first being 1. place: where
    in the file it is told, for messages. A screw is the coupling of a hinge, its parent, and a
    slide, its child, which stands at `advance` [m] plus `pitch` [m/rad] times the hinge's angle.
    """

    name: str
    kind: str
    parent: str
    child: str
    F: Pose[float] = IDENTITY_POSE
    M: Pose[float] = IDENTITY_POSE
    values: tuple[float, ...] = ()
    limits: tuple[Range | None, ...] = ()
    speeds: tuple[float, ...] = ()
    actuated: bool | tuple[int, ...] = False
    pitch: float = 0.0
    advance: float = 0.0
    angles: tuple[tuple[str, str], ...] = (("roll", "x"), ("pitch", "y"), ("yaw", "z"))
    place: str = ""
    passive: tuple[Passive, ...] = ()
    gear: float = 1.0

    def where(self, origin: str) -> str:
        """What messages call it: its place, or its name in the file `origin`."""
        return self.place or f"{origin}: {self.name}"


def moved(slides: bool, by: float) -> Pose[float]:
    """A slide along z, or a turn about it [m, rad]."""
    if slides:
        return Pose(IDENTITY, Vector((0.0, 0.0, by)))
    c, s = math.cos(by), math.sin(by)
    return Pose(matrix(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0))), ZERO)


def negated(slide: Link) -> Link:
    """A slide that counts the other way."""
    return replace(
        slide,
        F=slide.F @ _UPSIDE_DOWN,
        M=slide.M @ _UPSIDE_DOWN,
        values=tuple(-value for value in slide.values),
        limits=tuple(limits and (-limits[1], -limits[0]) for limits in slide.limits),
        passive=resistances.negated(slide.passive),
    )


def merge_rigid(
    base: str, links: Sequence[Link], origin: str
) -> tuple[list[Link], dict[str, tuple[str, Pose[float]]]]:
    """Links with those that are fixed to one another made one body.

    Returns the joints that move, and for every link the body it belongs to and its place there.
    Raises InputError on joints within one body.
    """
    names = dict.fromkeys([base, *(n for link in links for n in (link.parent, link.child))])
    owner = {n: (n, IDENTITY_POSE) for n in names}
    moving = [link for link in links if link.kind != "fixed"]
    joined = Counter(n for link in moving for n in (link.parent, link.child))
    for link in links:
        if link.kind != "fixed":
            continue
        (a, at_a), (b, at_b) = owner[link.parent], owner[link.child]
        here, there = at_a @ link.F, at_b @ link.M
        if a == b:
            gap = here.p - there.p
            apart = max(abs(x) for x in gap)
            turned = max(
                abs(x - y)
                for row, other in zip(here.R, there.R, strict=True)
                for x, y in zip(row, other, strict=True)
            )
            if max(apart, turned) > _APART:
                raise InputError(
                    link.where(origin),
                    "links that are already rigid, welded in another place",
                    "a loop",
                )
            continue
        if b == base or (
            a != base and joined[b] > joined[a]
        ):  # the body with more joints keeps its name
            a, b, here, there = b, a, there, here
        joined[a] += joined[b]
        shift = here @ there.inverse
        owner = {n: (a, shift @ at) if of == b else (of, at) for n, (of, at) in owner.items()}
    found = []
    for link in moving:
        (a, at_a), (b, at_b) = owner[link.parent], owner[link.child]
        if a == b:
            raise InputError(
                link.where(origin),
                f"a joint between {link.parent!r} and {link.child!r}, which are one rigid body",
                "a joint between bodies that can move",
            )
        found.append(replace(link, parent=a, child=b, F=at_a @ link.F, M=at_b @ link.M))
    return found, owner


def merge_chains(links: Sequence[Link], kept: set[str], in_order: bool = False) -> list[Link]:
    """Links with each chain of hinges and slides X.1, X.2, ... replaced by the joint X.

    kept: bodies that are not internal to a joint. in_order: a free joint's angles have to turn
    about x, then y, then z, as those of free joints do that are not the platform's pose.
    """
    ends: dict[str, int] = {}
    onward: dict[tuple[str, str], Link] = {}
    for link in links:
        for body in (link.parent, link.child):
            ends[body] = ends.get(body, 0) + 1
        onward[link.parent, _stem(link)] = link
    alike = Counter(_stem(link) for link in links)
    result: list[Link] = []
    inside: set[str] = set()
    for link in links:
        chain = [link]
        while (through := chain[-1].child) not in kept and ends[through] == 2:
            more = onward.get((through, _stem(link)))
            if more is None or not _stem(link) or len(chain) == 6:
                break
            chain.append(more)
        complete = len(chain) > 1 and len(chain) == alike[_stem(link)]
        apart = chain[0].parent != chain[-1].child  # where a loop is welded, it may be the same
        whole = _joint_of(chain) if complete and apart else None
        if in_order and whole is not None and not turns_in_order(whole):
            whole = None
        if whole is not None:
            inside |= {part.name for part in chain}
        result.append(whole or link)
    return [link for link in result if link.name not in inside]


def turns_in_order(link: Link) -> bool:
    """Whether a free link turns about x, then y, then z; true of any other link."""
    return link.kind != "free" or [axis for _, axis in link.angles] == ["x", "y", "z"]


def _stem(link: Link) -> str:
    return link.name.rpartition(".")[0]


def _joint_of(chain: Sequence[Link]) -> Link | None:
    """The joint that a chain of single ones makes, or None if it is of no known kind."""
    labels = [link.name.rpartition(".")[2] for link in chain]
    if all(label.isdecimal() for label in labels) and labels == sorted(labels, reverse=True):
        chain = [_reversed(link) for link in reversed(chain)]  # built from its child to its parent
    slides = tuple(link.kind == "prismatic" for link in chain)
    if not all(link.kind in ("prismatic", "revolute") and not link.pitch for link in chain):
        return None
    passive = resistances.of_chain([link.passive for link in chain])
    if any(link.gear != 1.0 for link in chain):
        return None  # a joint has one drive
    at = IDENTITY_POSE
    frames = []  # of the joints, all at zero
    for link in chain:
        at = at @ link.F
        frames.append(at)
        at = at @ link.M.inverse
    turning = [frame for frame, sliding in zip(frames, slides, strict=True) if not sliding]
    origin = turning[0].p if turning else frames[0].p
    if any(differ(frame.p, origin) for frame in turning):
        return None
    for kind, pairs in PAIRS.items():
        if passive and kind in _BARE and _stem(chain[0]) != "platform":
            continue
        if len(pairs) < 2 or tuple(pair.slides for pair in pairs) != slides:
            continue
        axes: dict[int, Vector[float]] = {}
        angles = []
        for link, frame, pair in zip(chain, frames, pairs, strict=True):
            direction, axis = frame.R.column(2), pair.axis
            if kind == "free" and not pair.slides:  # its angles may come in any order
                close = [k for k in axes if not differ(axes[k], direction)]
                axis = close[0] if close else axis
                angles.append((link.name.rpartition(".")[2], "xyz"[axis]))
            if differ(axes.setdefault(axis, direction), direction):
                break
        else:
            R = _frame_with(axes)
            if R is None:
                continue
            F = Pose(R, origin)
            tail = THETA if kind == "universal" else IDENTITY
            return Link(
                _stem(chain[0]),
                kind,
                chain[0].parent,
                chain[-1].child,
                F,
                at.inverse @ (F @ Pose(tail, ZERO)),
                tuple(value for link in chain for value in link.values),
                _limits_of_chain(chain),
                _speeds_of_chain(chain),
                _actuated_of_chain(chain),
                angles=tuple(angles),
                passive=passive,
            )
    return None


def _limits_of_chain(chain: Sequence[Link]) -> tuple[Range | None, ...]:
    limits = tuple(link.limits[0] if link.limits else None for link in chain)
    return limits if any(limits) else ()


def _speeds_of_chain(chain: Sequence[Link]) -> tuple[float, ...]:
    speeds = tuple(link.speeds[0] if link.speeds else math.inf for link in chain)
    return speeds if min(speeds) < math.inf else ()


def _actuated_of_chain(chain: Sequence[Link]) -> bool | tuple[int, ...]:
    moved = tuple(k for k, link in enumerate(chain, start=1) if link.actuated)
    return len(moved) == len(chain) or (moved or False)


def _reversed(link: Link) -> Link:
    """A hinge or slide with parent and child exchanged, its coordinate unchanged."""
    F, M = link.M @ _UPSIDE_DOWN, link.F @ _UPSIDE_DOWN
    return replace(link, parent=link.child, child=link.parent, F=F, M=M)


def differ(a: Vector[float], b: Vector[float]) -> bool:
    return bool(max(abs(x) for x in a - b) > _APART)


def _frame_with(axes: Mapping[int, Vector[float]]) -> Matrix[float] | None:
    """The frame with these axes, or None if they are not perpendicular and right-handed."""
    if len(axes) == 1 and 2 in axes:
        return about(axes[2])
    known = dict(axes)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        if k not in known and i in known and j in known:
            known[k] = cross(known[i], known[j])
    if len(known) < 3:
        return None
    R = Matrix((known[0], known[1], known[2])).T
    product = R.T @ R
    off = max(abs(product[i][j] - (i == j)) for i in range(3) for j in range(3))
    hand = dot(cross(known[0], known[1]), known[2])
    return R if off < _APART and hand > 0 else None


def split_off_platform(base: str, links: Sequence[Link]) -> tuple[list[Link], Link | None]:
    """The joints, and separately the free one that only gives the platform's pose, if any."""
    free = [link for link in links if link.kind == "free" and not link.actuated]
    upright = [
        link
        for link in free
        if link.parent == base
        and not differ(link.F.p, ZERO)
        and not any(differ(*rows) for rows in zip(link.F.R, IDENTITY, strict=True))
        and not any(differ(*rows) for rows in zip(link.M.R, IDENTITY, strict=True))
    ]
    if len(upright) != 1:
        return list(links), None
    rest = [link for link in links if link is not upright[0]]
    reached, before = {base}, 0
    while len(reached) > before:
        before = len(reached)
        for link in rest:
            if {link.parent, link.child} & reached:
                reached |= {link.parent, link.child}
    if upright[0].child in reached:
        return rest, upright[0]
    return list(links), None
