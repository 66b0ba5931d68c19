"""Mechanisms out of other programs' files: what MJCF and URDF have in common.

Such files know single hinges and slides, fixed links and, beside the tree, loops. Here links that
are fixed to one another become one body, hinges and slides that `parakin export` has split become
one joint again, and names are made fit for expressions and tables.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from parakin.algebra.spatial import (
    IDENTITY,
    ZERO,
    Matrix,
    Vector,
    apply,
    column,
    compose,
    cross,
    dot,
    minus,
    plus,
    transpose,
)
from parakin.errors import InputError
from parakin.model.joints import PAIRS, THETA
from parakin.model.mechanism import MAX_JOINTS, Body, Frame, Joint, Mechanism, Platform
from parakin.model.placement import Placement

if TYPE_CHECKING:
    from lxml.etree import _Element

_APART = 1e-6  # directions and places that differ by less are meant to be the same
_LOCKED = 1e-12
_NOTHING = 1e-14  # [m]: a place this near to zero is round-off of it
WORLD = "world"  # MuJoCo's name for what does not move
HERE = Placement(IDENTITY, ZERO)


@dataclass(frozen=True)
class Link:
    """A joint as such a file has it: `F` on its parent, `M` on its child, which coincide where
    the coordinates are zero. `values` are those of the file's own pose.
    """

    name: str
    kind: str
    parent: str
    child: str
    F: Placement = HERE
    M: Placement = HERE
    values: tuple[float, ...] = ()
    limits: tuple[float, float] | None = None
    actuated: bool = False
    pitch: float = 0.0
    angles: tuple[tuple[str, str], ...] = (("roll", "x"), ("pitch", "y"), ("yaw", "z"))


def then(a: Placement, b: Placement) -> Placement:
    """The frame `b`, given in the frame `a`, where `a` is given in."""
    return Placement(compose(a.R, b.R), plus(a.p, apply(a.R, b.p)))


def inverse(a: Placement) -> Placement:
    R = transpose(a.R)
    return Placement(R, minus(ZERO, apply(R, a.p)))


def xml_root(text: str, origin: str) -> _Element:
    """The root of an XML document that refers to nothing outside itself. Raises InputError."""
    try:
        from lxml import etree
    except ImportError:
        raise not_installed(origin, "lxml") from None
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise InputError(origin, "a document type or entities of its own", "plain XML")
    parser = etree.XMLParser(
        encoding="utf-8",
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=False,
        remove_comments=True,
        remove_pis=True,
    )
    try:
        return etree.fromstring(text.encode(), parser)
    except etree.XMLSyntaxError as error:
        raise InputError(origin, f"a syntax error: {error.msg}", "XML") from None


def not_installed(place: str, library: str, extra: str = "exchange") -> InputError:
    return InputError(place, f"{library} is not installed", f"pip install 'parakin[{extra}]'")


def numbers(text: str | None, count: int, default: Sequence[float], place: str) -> list[float]:
    """An attribute of so many numbers. Raises InputError."""
    if text is None:
        return list(default)
    try:
        values = [float(word) for word in text.split()]
        if len(values) != count or not all(abs(a) < 1e100 for a in values):
            raise ValueError
    except ValueError:
        raise InputError(place, repr(text), f"{count} finite number{'s'[: count > 1]}") from None
    return values


def vector(values: Iterable[float]) -> Vector:
    a, b, c = (float(value) for value in values)
    return (a, b, c)


def unit_vector(values: Sequence[float], place: str) -> Vector:
    """A direction at length one. Raises InputError on zero."""
    size = math.hypot(*values)
    if not size > _LOCKED:
        raise InputError(place, f"the axis {list(values)}", "an axis that is not zero")
    return vector(value / size for value in values)


def about(axis: Vector) -> Matrix:
    """A frame whose z lies along a unit vector, x and y any two that fit."""
    k = min(range(3), key=lambda k: abs(axis[k]))
    x = [-axis[k] * a for a in axis]
    x[k] += 1.0
    size = dot(vector(x), vector(x)) ** 0.5
    x_axis = vector(a / size for a in x)
    return transpose((x_axis, cross(axis, x_axis), axis))


def angles_of(R: Matrix) -> tuple[float, float, float]:
    """The angles about moving x, then y, then z that make R; the last is zero at gimbal lock."""
    (a, b, c), (_, e, f), (_, h, g) = R
    size = math.hypot(a, b)
    if size < _LOCKED:
        return math.atan2(h, e), math.atan2(c, size), 0.0
    return math.atan2(-f, g), math.atan2(c, size), math.atan2(-b, a)


def mechanism_of(
    name: str,
    base: str,
    bodies: Sequence[str],
    links: Sequence[Link],
    loops: Sequence[Link],
    origin: str,
    notes: str,
) -> Mechanism:
    """The mechanism of a tree of links and of the loops that close it. Raises InputError."""
    if len(links) + len(loops) > MAX_JOINTS:
        raise InputError(origin, f"{len(links) + len(loops)} joints", f"at most {MAX_JOINTS}")
    screws = [link for link in loops if link.kind == "screw"]
    loops = [link for link in loops if link.kind != "screw"]
    links = _screwed(links, screws, origin)
    moving, owner = _rigid(base, [*links, *loops], origin)
    joints, platform = _posed(base, _gathered(moving, {base}))
    if not joints:
        raise InputError(origin, "no joints that move", "a hinge, a slide or the like")
    known: dict[str, str] = {}
    ends = {
        n
        for link in [*joints, *([platform] if platform else [])]
        for n in (link.parent, link.child)
    }
    inside = [n for n in (*bodies, *sorted(ends)) if n in ends]
    body_names = {
        b: _fit(_called(b, base, bodies, owner), known) for b in dict.fromkeys([base, *inside])
    }
    used: dict[str, str] = {}
    made: list[Joint] = []
    tables: dict[str, dict[str, Any]] = {"guess": {}, "limits": {}}
    driven: list[str] = []
    for link in joints:
        title = _fit(link.name, used)
        kind = "helical" if link.pitch else link.kind
        made.append(
            Joint(
                name=title,
                kind=kind,  # type: ignore[arg-type]
                parent=body_names[link.parent],
                child=body_names[link.child],
                on_parent=_frame(link.F),
                on_child=_frame(link.M),
                actuated=link.actuated,
                pitch=link.pitch or None,
            )
        )
        own = [title] if len(link.values) < 2 else [f"{title}.{k + 1}" for k in range(9)]
        tables["guess"] |= dict(zip(own, link.values, strict=False))
        if link.limits is not None and len(link.values) == 1:
            tables["limits"][title] = link.limits
        driven += own[: len(link.values)] if link.actuated else []
    pose = None
    if platform is not None:
        pose = Platform(
            body=body_names[platform.child],
            point="origin",
            angles=platform.angles,  # type: ignore[arg-type]
        )
        labels = ("x", "y", "z", *(label for label, _ in platform.angles))
        tables["guess"] |= {
            f"platform.{label}": value for label, value in zip(labels, platform.values, strict=True)
        }
    points = _points(owner, body_names, platform)
    return Mechanism(
        name=_fit(name, {}),
        title=name,
        notes=notes,
        base=body_names[base],
        bodies=tuple(
            Body(name=label, points=points.get(body, {})) for body, label in body_names.items()
        ),
        joints=tuple(made),
        platform=pose,
        driven=tuple(driven),
        **tables,
        origin=origin,
    )


def _called(
    body: str, base: str, bodies: Sequence[str], owner: Mapping[str, tuple[str, Placement]]
) -> str:
    """A body's name; the world's is that of the first body that stands on it, if one does."""
    if body == base == WORLD:
        return next((b for b in bodies if b != base and owner[b][0] == base), base)
    return body


def _screwed(links: Sequence[Link], screws: Sequence[Link], origin: str) -> list[Link]:
    """Hinge and slide, one after the other, that a coupling makes a helical joint.

    A coupling names the hinge as its parent and the slide as its child. Raises InputError.
    """
    result = list(links)
    for screw in screws:
        ends = [
            [link for link in result if link.name == name and not link.pitch]
            for name in (screw.parent, screw.child)
        ]
        if not all(ends):
            found = f"a joint of a screw made already, {screw.parent!r} or {screw.child!r}"
            raise InputError(f"{origin}: {screw.name}", found, "one coupling for each joint")
        (hinge, *_), (slide, *_) = ends
        first, second = (hinge, slide) if hinge.child == slide.parent else (slide, hinge)
        onto = then(inverse(first.M), second.F)  # the one joint's frame in the other's, at zero
        off = (onto.p[0], onto.p[1], 0.0)
        joined = [n for link in result for n in (link.parent, link.child)]
        alike = not _differ(column(onto.R, 2), (0.0, 0.0, 1.0)) and not _differ(off, ZERO)
        if first.child != second.parent or joined.count(first.child) != 2 or not alike:
            raise InputError(
                f"{origin}: {screw.name}",
                f"{slide.name!r} following {hinge.name!r}",
                "a slide along the axis of the hinge beside it, as of a screw",
            )
        whole = replace(
            hinge,
            parent=first.parent,
            child=second.child,
            F=first.F,
            M=then(second.M, inverse(onto)),
            pitch=2 * math.pi * screw.pitch,
        )
        result[result.index(hinge)] = whole
        result.remove(slide)
    return result


def _frame(at: Placement) -> Frame:
    p = vector(0.0 if abs(a) < _NOTHING else a for a in at.p)
    if at.R == IDENTITY:
        return Frame(at=p)
    return Frame(at=p, axis=column(at.R, 2), x=column(at.R, 0))


def _fit(name: str, known: dict[str, str]) -> str:
    """A name of ours for another program's, the same for the same one and for no other."""
    fit = re.sub(r"[^A-Za-z0-9_ '-]", "_", name)[:56].strip()
    if not re.match(r"[A-Za-z]", fit):
        fit = f"n{fit}"
    made, count = fit, 1
    while made in known:
        count += 1
        made = f"{fit}_{count}"
    known[made] = name
    return made


def _rigid(
    base: str, links: Sequence[Link], origin: str
) -> tuple[list[Link], dict[str, tuple[str, Placement]]]:
    """Links fixed to one another as one body: joints that move, and every link's owner and place.

    Raises InputError on links welded to themselves elsewhere.
    """
    names = dict.fromkeys([base, *(n for link in links for n in (link.parent, link.child))])
    owner = {n: (n, HERE) for n in names}
    moving = [link for link in links if link.kind != "fixed"]
    joined = Counter(n for link in moving for n in (link.parent, link.child))
    for link in links:
        if link.kind != "fixed":
            continue
        (a, at_a), (b, at_b) = owner[link.parent], owner[link.child]
        here, there = then(at_a, link.F), then(at_b, link.M)
        if a == b:
            gap = minus(here.p, there.p)
            apart = max(abs(x) for x in gap)
            turned = max(
                abs(x - y)
                for row, other in zip(here.R, there.R, strict=True)
                for x, y in zip(row, other, strict=True)
            )
            if max(apart, turned) > _APART:
                raise InputError(
                    f"{origin}: {link.name}", "links already rigid, welded elsewhere", "a loop"
                )
            continue
        if b == base or (a != base and joined[b] > joined[a]):  # the larger body keeps its name
            a, b, here, there = b, a, there, here
        joined[a] += joined[b]
        shift = then(here, inverse(there))
        owner = {n: (a, then(shift, at)) if of == b else (of, at) for n, (of, at) in owner.items()}
    found = []
    for link in moving:
        (a, at_a), (b, at_b) = owner[link.parent], owner[link.child]
        if a == b:
            raise InputError(
                f"{origin}: {link.name}",
                f"a joint between {link.parent!r} and {link.child!r}, which are one rigid body",
                "a joint between bodies that can move",
            )
        found.append(replace(link, parent=a, child=b, F=then(at_a, link.F), M=then(at_b, link.M)))
    return found, owner


def _points(
    owner: Mapping[str, tuple[str, Placement]],
    body_names: Mapping[str, str],
    platform: Link | None,
) -> dict[str, dict[str, Vector]]:
    """Links fixed to a body as points on it, and the platform's reference point."""
    points: dict[str, dict[str, Vector]] = {body: {} for body in body_names}
    for name, (body, at) in owner.items():
        if name != body and body in points:
            fitted = _fit(name, {p: p for p in points[body]})
            points[body][fitted] = at.p
    if platform is not None:
        points[platform.child]["origin"] = platform.M.p
    return points


def _gathered(links: Sequence[Link], kept: set[str]) -> list[Link]:
    """Hinges and slides named X.1, X.2, ... one after the other, as the joint X they came from.

    kept: bodies that are more than the inside of a joint.
    """
    ends: dict[str, int] = {}
    onward: dict[tuple[str, str], Link] = {}
    for link in links:
        for body in (link.parent, link.child):
            ends[body] = ends.get(body, 0) + 1
        onward[link.parent, _stem(link)] = link
    result: list[Link] = []
    inside: set[str] = set()
    for link in links:
        chain = [link]
        while (through := chain[-1].child) not in kept and ends[through] == 2:
            more = onward.get((through, _stem(link)))
            if more is None or not _stem(link) or len(chain) == 6:
                break
            chain.append(more)
        whole = _whole(chain) if len(chain) > 1 and link.name not in inside else None
        if whole is not None:
            inside |= {part.name for part in chain}
        result.append(whole or link)
    return [link for link in result if link.name not in inside]


def _stem(link: Link) -> str:
    return link.name.rpartition(".")[0]


def _whole(chain: Sequence[Link]) -> Link | None:
    """The joint made of single ones, or None where it is none that we know."""
    labels = [link.name.rpartition(".")[2] for link in chain]
    if all(label.isdecimal() for label in labels) and labels == sorted(labels, reverse=True):
        chain = [_turned_round(link) for link in reversed(chain)]  # hung from its child
    slides = tuple(link.kind == "prismatic" for link in chain)
    if not all(link.kind in ("prismatic", "revolute") and not link.pitch for link in chain):
        return None
    at = HERE
    frames = []  # of the joints, where all of them are at zero
    for link in chain:
        at = then(at, link.F)
        frames.append(at)
        at = then(at, inverse(link.M))
    turning = [frame for frame, sliding in zip(frames, slides, strict=True) if not sliding]
    origin = turning[0].p if turning else frames[0].p
    if any(_differ(frame.p, origin) for frame in turning):
        return None
    for kind, pairs in PAIRS.items():
        if len(pairs) < 2 or tuple(pair.slides for pair in pairs) != slides:
            continue
        axes: dict[int, Vector] = {}
        angles = []
        for link, frame, pair in zip(chain, frames, pairs, strict=True):
            direction, axis = column(frame.R, 2), pair.axis
            if kind == "free" and not pair.slides:  # its angles may come in any order
                close = [k for k in axes if not _differ(axes[k], direction)]
                axis = close[0] if close else axis
                angles.append((link.name.rpartition(".")[2], "xyz"[axis]))
            if _differ(axes.setdefault(axis, direction), direction):
                break
        else:
            R = _square(axes)
            if R is None:
                continue
            F = Placement(R, origin)
            tail = THETA if kind == "universal" else IDENTITY
            return Link(
                _stem(chain[0]),
                kind,
                chain[0].parent,
                chain[-1].child,
                F,
                then(inverse(at), then(F, Placement(tail, ZERO))),
                tuple(value for link in chain for value in link.values),
                actuated=all(link.actuated for link in chain),
                angles=tuple(angles),
            )
    return None


def _turned_round(link: Link) -> Link:
    """A hinge or slide from child to parent, its coordinate as before."""
    upside_down = Placement(((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0)), ZERO)
    F, M = then(link.M, upside_down), then(link.F, upside_down)
    return replace(link, parent=link.child, child=link.parent, F=F, M=M)


def _differ(a: Vector, b: Vector) -> bool:
    return bool(max(abs(x) for x in minus(a, b)) > _APART)


def _square(axes: Mapping[int, Vector]) -> Matrix | None:
    """A frame with these of its axes given, or None where they are not square to one another."""
    if len(axes) == 1 and 2 in axes:
        return about(axes[2])
    known = dict(axes)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        if k not in known and i in known and j in known:
            known[k] = cross(known[i], known[j])
    if len(known) < 3:
        return None
    R = transpose((known[0], known[1], known[2]))
    product = compose(transpose(R), R)
    off = max(abs(product[i][j] - (i == j)) for i in range(3) for j in range(3))
    hand = dot(cross(known[0], known[1]), known[2])
    return R if off < _APART and hand > 0 else None


def _posed(base: str, links: Sequence[Link]) -> tuple[list[Link], Link | None]:
    """The joints, and the one that only says where the platform is: free, and in a loop."""
    free = [link for link in links if link.kind == "free" and not link.actuated]
    upright = [
        link
        for link in free
        if link.parent == base
        and not _differ(link.F.p, ZERO)
        and not any(_differ(*rows) for rows in zip(link.F.R, IDENTITY, strict=True))
        and not any(_differ(*rows) for rows in zip(link.M.R, IDENTITY, strict=True))
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
