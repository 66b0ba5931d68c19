"""What acts in a mechanism and another program's model cannot hold, told in a comment in it."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import Any

from parakin.model.forces import AppliedWrench
from parakin.model.graph import Graph
from parakin.model.masses import Mass, combined

DRIVES = "drives"
ARMATURES = "armatures"
SPRINGS = "springs in joints"
POINT_SPRINGS = "springs between points"
GRAVITY = "gravity"


def left_out(graph: Graph, held: Collection[str]) -> list[str]:
    """Lines on what the model leaves out. held: of the kinds above, those that it has."""
    dynamics, found = graph.dynamics, dict[str, Iterable[str]]()

    def of(key: str) -> list[str]:
        return [graph.coordinates[k].name for k, p in dynamics.passive.items() if getattr(p, key)]

    found["the velocities at which dampers rest, in"] = of("zero_speed")
    found["damping in spherical joints:"] = _balls(graph)
    found["how stiff limits are, in"] = of("stop")
    if ARMATURES not in held:
        found["armatures of"] = of("armature")
    if SPRINGS not in held:
        found["springs in"] = of("stiffness")
    if POINT_SPRINGS not in held:
        found["springs between points:"] = [spring.name for spring in dynamics.springs]
    wrenches = [n for n, f in graph.mechanism.forces.items() if isinstance(f, AppliedWrench)]
    found["wrenches:"] = wrenches
    if DRIVES not in held:
        motors = [graph.coordinates[k].name for k in dynamics.motors]
        found["drives (gears, screws, efficiencies, rotors, limits) of"] = motors
    lines = [f"{what} {', '.join(names)}" for what, names in found.items() if names]
    if GRAVITY not in held and _weighs(graph):
        x, y, z = dynamics.gravity
        lines.append(f"gravity: {x:.9g}, {y:.9g}, {z:.9g} m/s2")
    return lines


def masses_of(graph: Graph) -> dict[int, Mass]:
    """Masses by body, with its payloads."""
    dynamics = graph.dynamics
    found = dict(dynamics.masses)
    for load in dynamics.loads:
        own = found.get(load.body)
        found[load.body] = load.mass if own is None else combined([own, load.mass])
    return found


def _weighs(graph: Graph) -> bool:
    return bool(graph.dynamics.masses or graph.dynamics.loads)


def _balls(graph: Graph) -> list[str]:
    damped = {(ball.parent, ball.child) for ball in graph.dynamics.balls}
    return [
        joint.name
        for joint in graph.joints
        if joint.kind == "spherical" and (joint.parent, joint.child) in damped
    ]


def comment(root: Any, lines: Sequence[str], loads: Sequence[str]) -> None:
    """Puts a comment at the beginning of an XML document: what is left out, and which payloads are
    part of their bodies' masses. None if there is nothing to be told.
    """
    from lxml import etree

    told = ["Not in this model:", *(f"  {line}" for line in lines)] if lines else []
    if loads:
        told.append(f"Payloads are part of the masses of their bodies: {', '.join(loads)}")
    if told:
        text = "".join(f"\n  {line}" for line in told)
        while "--" in text:
            text = text.replace("--", "- -")
        root.insert(0, etree.Comment(f"{text}\n  "))
