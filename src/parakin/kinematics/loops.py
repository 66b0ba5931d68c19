"""Loops: what the bodies of a joint left out of the tree carry to it, and by which coordinates."""

from __future__ import annotations

from typing import NamedTuple

from parakin.algebra.spatial import Pose, Vector
from parakin.kinematics.recursion import Circuits, point_acceleration, point_velocity


class Ends(NamedTuple):
    """A cut joint's frames as its two bodies carry them (X_WF on the parent, X_WM on the child),
    and the gap between their points, d = p_WM - p_WF.
    """

    parent: int
    child: int
    F: Pose
    M: Pose
    d: Vector


def ends(circuits: Circuits, cut: int) -> Ends:
    """The two ends of the loop that a joint closes."""
    joint = circuits.graph.joints[cut]
    F = circuits.pose(joint.parent) @ joint.F
    M = circuits.pose(joint.child) @ joint.M
    return Ends(joint.parent, joint.child, F, M, M.p - F.p)


def sides(circuits: Circuits, cut: int) -> dict[int, float]:
    """Coordinates on the cut joint's loop: +1 on the child's side, -1 on the parent's."""
    joint = circuits.graph.joints[cut]
    ahead, behind = circuits.path[joint.child], circuits.path[joint.parent]
    signs = {k: 1.0 for k in ahead if k not in behind}
    return signs | {k: -1.0 for k in behind if k not in ahead}


def gap_velocity(circuits: Circuits, end: Ends) -> Vector:
    """The rate of the gap d."""
    C, P = end.child, end.parent
    ahead = point_velocity(circuits.pose(C), circuits.twist(C), end.M.p)
    return ahead - point_velocity(circuits.pose(P), circuits.twist(P), end.F.p)


def gap_acceleration(circuits: Circuits, end: Ends) -> Vector:
    """The second derivative of the gap d."""
    C, P = end.child, end.parent
    ahead = point_acceleration(circuits.pose(C), circuits.twist(C), circuits.accel(C), end.M.p)
    behind = point_acceleration(circuits.pose(P), circuits.twist(P), circuits.accel(P), end.F.p)
    return ahead - behind
