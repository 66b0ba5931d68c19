"""Cycles: how joints share the shortest loops of a mechanism, and how long a tree's loops are."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence

from parakin.model.joints import GraphJoint

Edges = Mapping[int, tuple[int, int]]  # by joint, the two bodies


def edges_of(joints: Sequence[GraphJoint]) -> Edges:
    """Joints that a loop can go through: not rods, which no tree contains, and not free ones, which
    constrain nothing.
    """
    return {
        k: (joint.parent, joint.child)
        for k, joint in enumerate(joints)
        if joint.kind not in ("rod", "free")
    }


def shared(edges: Edges) -> dict[int, int]:
    """On how many of the shortest loops each joint lies. There is one such loop for each joint."""
    beside: dict[int, list[tuple[int, int]]] = {}
    for k, (a, b) in edges.items():
        beside.setdefault(a, []).append((k, b))
        beside.setdefault(b, []).append((k, a))
    loops = {frozenset(_shortest(beside, k, *ends)) for k, ends in edges.items()}
    counts = dict.fromkeys(edges, 0)
    for loop in loops:
        for k in loop:
            counts[k] += 1
    return counts


def _shortest(
    beside: Mapping[int, Sequence[tuple[int, int]]], joint: int, start: int, end: int
) -> list[int]:
    """The shortest loop through a joint between two bodies; none if it is on no loop."""
    came: dict[int, tuple[int, int]] = {start: (joint, end)}
    waiting = deque([start])
    while waiting and end not in came:
        body = waiting.popleft()
        for k, other in beside[body]:
            if k != joint and other not in came:
                came[other] = (k, body)
                waiting.append(other)
    if end not in came:
        return []
    loop, body = [joint], end
    while body != start:
        k, body = came[body]
        loop.append(k)
    return loop


def total_length(joints: Sequence[GraphJoint], steps: Sequence[tuple[int, bool]]) -> int:
    """How many joints are on the loops of a tree, from the base outwards, all together."""
    above = {0: (0, 0)}  # by body, the one before, and how many joints from the base
    for k, reverse in steps:
        joint = joints[k]
        near, far = (joint.child, joint.parent) if reverse else (joint.parent, joint.child)
        above[far] = near, above[near][1] + 1
    kept = {k for k, _ in steps}
    total = 0
    for k, joint in enumerate(joints):
        a, b = joint.parent, joint.child
        if k in kept or joint.kind == "free":
            continue
        while a != b:
            total += 1
            a, b = (above[a][0], b) if above[a][1] >= above[b][1] else (a, above[b][0])
    return total
