"""Screws in MJCF and URDF files: a hinge and a slide that are coupled."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from parakin.algebra.spatial import Vector
from parakin.errors import InputError
from parakin.files import resistances
from parakin.files.links import Link, Range, differ, moved, negated


def merge_screws(
    links: Sequence[Link], screws: Sequence[Link], closing: Sequence[Link], origin: str
) -> list[Link]:
    """Links with each hinge and slide that a coupling makes a screw replaced by one helical joint.

    screws: couplings, which name the hinge as parent and the slide as child. closing: the links
    that close loops. Raises InputError.
    """
    result = list(links)
    ends = Counter(n for link in (*links, *closing) for n in (link.parent, link.child))
    for screw in screws:
        place = screw.where(origin)
        parts = [
            [link for link in result if link.name == name and link.kind == kind and not link.pitch]
            for name, kind in ((screw.parent, "revolute"), (screw.child, "prismatic"))
        ]
        if not all(parts):
            found = f"a joint that already belongs to a screw, {screw.parent!r} or {screw.child!r}"
            raise InputError(place, found, "one coupling for each joint")
        (hinge, *_), (slide, *_) = parts
        whole = _screw(hinge, slide, screw, place)
        inner = hinge.child if hinge.child == slide.parent else slide.child
        if whole is None:
            raise InputError(
                place,
                f"{slide.name!r} following {hinge.name!r}",
                "a slide along the axis of the hinge it is coupled to, as in a screw",
            )
        if ends[inner] != 2:
            found = f"{inner!r:.80}, inside the screw of {hinge.name!r}, joined to other links"
            raise InputError(place, found, "other links joined to the screw's ends only")
        result[result.index(hinge)] = whole
        result.remove(slide)
    return result


def _screw(hinge: Link, slide: Link, screw: Link, place: str) -> Link | None:
    """The helical joint of a hinge and a slide next to it; None if they are not parallel."""
    if hinge.child != slide.parent and slide.child != hinge.parent:
        return None
    pitch, advance = screw.pitch, screw.advance
    for _ in range(2):
        first, second = (hinge, slide) if hinge.child == slide.parent else (slide, hinge)
        onto = first.M.inverse @ second.F  # the second joint's frame in the first's, at zero
        if not differ(onto.R.column(2), Vector((0.0, 0.0, 1.0))):
            break
        slide, pitch, advance = negated(slide), -pitch, -advance  # it may point the other way
    else:
        return None
    # The helical joint is where the hinge is: a slide is the same anywhere.
    F, M = (first.F, second.M @ onto.inverse) if first is hinge else (first.F @ onto, second.M)
    return replace(
        hinge,
        parent=first.parent,
        child=second.child,
        F=F,
        M=M @ moved(True, -advance),
        limits=_limits_of_screw(hinge, slide, pitch, advance, place),
        speeds=_speeds_of_screw(hinge, slide, pitch),
        passive=resistances.of_screw(hinge.passive, slide.passive, pitch, advance),
        actuated=bool(hinge.actuated or slide.actuated),
        pitch=2 * math.pi * pitch,
    )


def _limits_of_screw(
    hinge: Link, slide: Link, pitch: float, advance: float, place: str
) -> tuple[Range | None, ...]:
    """The angles that both the hinge's and the slide's limits allow. Raises InputError if none."""
    ranges = [*hinge.limits]
    for limits in slide.limits:
        if limits is not None:
            low, high = sorted((end - advance) / pitch for end in limits)
            ranges.append((low, high))
    known = [limits for limits in ranges if limits is not None]
    if not known:
        return ()
    low, high = max(a for a, _ in known), min(b for _, b in known)
    if not low < high:
        found = f"limits of {hinge.name!r} and {slide.name!r} that exclude each other"
        raise InputError(place, found, "limits that both can be within")
    return ((low, high),)


def _speeds_of_screw(hinge: Link, slide: Link, pitch: float) -> tuple[float, ...]:
    """The greatest speed of the hinge that both allow."""
    known = [*hinge.speeds, *(speed / abs(pitch) for speed in slide.speeds)]
    return (min(known),) if known else ()
