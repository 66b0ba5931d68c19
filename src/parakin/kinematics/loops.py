"""Loops: what the bodies of a joint left out of the tree carry to it, and by which coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from parakin.algebra.spatial import Pose, Vector
from parakin.kinematics.recursion import Circuits, point_acceleration, point_velocity


class Ends(NamedTuple):
    """A cut joint's frames, F as its parent carries it and M as its child does, and the gap between
    their points, d = p_WM - p_WF.
    """

    parent: int
    child: int
    X_WF: Pose
    X_WM: Pose
    d: Vector


def ends(circuits: Circuits, cut: int) -> Ends:
    """The two ends of the loop that a joint closes."""
    joint = circuits.graph.joints[cut]
    X_WF = circuits.pose(joint.parent) @ joint.F
    X_WM = circuits.pose(joint.child) @ joint.M
    return Ends(joint.parent, joint.child, X_WF, X_WM, X_WM.p - X_WF.p)


def sides(circuits: Circuits, cut: int) -> Mapping[int, float]:
    """Coordinates on the cut joint's loop: +1 on the child's side, -1 on the parent's."""
    if cut not in circuits.sides:
        joint = circuits.graph.joints[cut]
        ahead, behind = circuits.path[joint.child], circuits.path[joint.parent]
        common = 0  # what both ends have in common is where their paths begin
        for a, b in zip(ahead, behind, strict=False):
            if a != b:
                break
            common += 1
        signs = dict.fromkeys(ahead[common:], 1.0) | dict.fromkeys(behind[common:], -1.0)
        circuits.sides[cut] = signs
    return circuits.sides[cut]


def gap_velocity(circuits: Circuits, end: Ends) -> Vector:
    """The rate of the gap d."""
    C, P = end.child, end.parent
    ahead = point_velocity(circuits.pose(C), circuits.twist(C), end.X_WM.p)
    return ahead - point_velocity(circuits.pose(P), circuits.twist(P), end.X_WF.p)


def gap_acceleration(circuits: Circuits, end: Ends) -> Vector:
    """The second derivative of the gap d."""
    C, P = end.child, end.parent
    ahead = point_acceleration(circuits.pose(C), circuits.twist(C), circuits.accel(C), end.X_WM.p)
    behind = point_acceleration(circuits.pose(P), circuits.twist(P), circuits.accel(P), end.X_WF.p)
    return ahead - behind
