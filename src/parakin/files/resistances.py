"""What acts in the joints of other programs' models, where several of them become one of ours."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from parakin.model.drives import Friction, Spring
from parakin.model.dynamics import Passive

FREE = Passive()  # of what moves without any resistance


def acting(passive: Sequence[Passive]) -> tuple[Passive, ...]:
    """One for each coordinate; none if nothing acts in any."""
    return tuple(passive) if any(each != FREE for each in passive) else ()


def of_chain(parts: Sequence[tuple[Passive, ...]]) -> tuple[Passive, ...]:
    """Of several joints of one coordinate each, one after another."""
    return acting([passive[0] if passive else FREE for passive in parts])


def negated(passive: tuple[Passive, ...]) -> tuple[Passive, ...]:
    """Of a slide that counts the other way."""
    return tuple(each._replace(zero=-each.zero + 0.0) for each in passive)


def of_screw(
    hinge: tuple[Passive, ...], slide: tuple[Passive, ...], pitch: float, advance: float
) -> tuple[Passive, ...]:
    """Of the angle of a screw, whose slide stands at `advance` [m] + `pitch` [m/rad] times it."""
    turn, push = (of[0] if of else FREE for of in (hinge, slide))
    stiff = pitch * pitch * push.stiffness
    stiffness, zero = turn.stiffness + stiff, 0.0
    if stiffness:
        zero = (turn.stiffness * turn.zero + stiff * (push.zero - advance) / pitch) / stiffness
    whole = Passive(
        stiffness,
        zero,
        viscous=turn.viscous + pitch * pitch * push.viscous,
        coulomb=turn.coulomb + abs(pitch) * push.coulomb,
        armature=turn.armature + pitch * pitch * push.armature,
    )
    return acting([whole])


def tables(passive: tuple[Passive, ...]) -> dict[str, Any]:
    """A joint's tables in a mechanism, those alone in which anything is told."""
    found: dict[str, Any] = {}
    if any(each.viscous or each.coulomb for each in passive):
        found["friction"] = tuple(Friction(coulomb=p.coulomb, viscous=p.viscous) for p in passive)
    if any(each.stiffness for each in passive):
        found["spring"] = tuple(Spring(stiffness=p.stiffness, zero=p.zero) for p in passive)
    if any(each.armature for each in passive):
        found["armature"] = tuple(each.armature for each in passive)
    return found
