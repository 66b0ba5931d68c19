"""Cone angles: how far a spherical or universal joint is bent, whatever the twist about its axis.

Each is the angle between two directions, one fixed on the joint's parent and one on its child.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from parakin.algebra.spatial import (
    FLOATS,
    IDENTITY,
    ZERO,
    Functions,
    Matrix,
    Pose,
    Scalar,
    Vector,
    as_float,
    cross,
    dot,
    turned,
)
from parakin.kinematics.closure import Perpendicular
from parakin.kinematics.loops import Ends
from parakin.kinematics.recursion import Circuits
from parakin.model.graph import Graph
from parakin.model.joints import GraphJoint
from parakin.model.placement import about, snapped

_AXES = Perpendicular(0, 2, 2)  # of whatever joint, as it measures what its ends are


class Cone(NamedTuple):
    """An angle between the z axes of frame C on body `parent` and frame D on body `child`."""

    parent: int
    child: int
    R_PC: Matrix[float]
    R_CD: Matrix[float]


def cones_of(graph: Graph, home: Sequence[float]) -> dict[str, Cone]:
    """By name, how the cone angles of a graph are measured. home: all coordinates at the
    mechanism's own home.

    A spherical joint whose frames the file orients: between their two z axes. Where it gives no
    orientation: from home's direction of the z axis of the child or, where only the child is base
    or platform, of the parent. A universal joint, whose z axes are always at right angles: from
    home's direction of the normal to both.
    """
    return {name: _cone(graph, joint, home) for name, joint in graph.cones.items()}


def _cone(graph: Graph, joint: GraphJoint, home: Sequence[float]) -> Cone:
    R_FC, R_MD = _directions(graph, joint, _orientation(joint, home))
    return Cone(joint.parent, joint.child, joint.F.R @ R_FC, joint.M.R @ R_MD)


def _directions(
    graph: Graph, joint: GraphJoint, R_FM: Matrix[float]
) -> tuple[Matrix[float], Matrix[float]]:
    """R_FC and R_MD, from the orientation at home."""
    if joint.kind == "spherical":
        if joint.oriented:
            return IDENTITY, IDENTITY
        if _is_limb(graph, joint.parent) and not _is_limb(graph, joint.child):
            return IDENTITY, _along(R_FM.T.column(2))
        return _along(R_FM.column(2)), IDENTITY
    normal = cross(Vector((0.0, 0.0, 1.0)), R_FM.column(2))
    return _along(normal), _along(R_FM.T @ normal)


def _is_limb(graph: Graph, body: int) -> bool:
    """Whether a body is neither base nor platform."""
    platform = graph.platform
    return body != 0 and (platform is None or body != graph.joints[platform].child)


def _along(z: Vector[float]) -> Matrix[float]:
    return snapped(about(z))


def _orientation(joint: GraphJoint, home: Sequence[float]) -> Matrix[float]:
    """R_FM for a joint's coordinates."""
    R: Matrix[float] = IDENTITY
    for k, pair in zip(joint.coordinates, joint.pairs, strict=True):
        if not pair.slides:
            q = float(home[k])
            R = turned(R, pair.axis, FLOATS.cos(q), FLOATS.sin(q))
    return R @ joint.tail


def cone_angles(circuits: Circuits, cones: Mapping[str, Cone]) -> dict[str, float]:
    """Every cone angle by name, of circuits in numbers."""
    return {
        name: as_float(cone_angle(circuits, cone, FLOATS, derivatives=0)[0])
        for name, cone in cones.items()
    }


def cone_angle(
    circuits: Circuits, cone: Cone, functions: Functions, *, derivatives: int
) -> tuple[Scalar, Scalar, Scalar]:
    """A cone angle and its derivatives (undefined at 0)."""
    X_WC = circuits.pose(cone.parent) @ Pose(cone.R_PC, ZERO)
    X_WD = circuits.pose(cone.child) @ Pose(cone.R_CD, ZERO)
    end, row = Ends(cone.parent, cone.child, X_WC, X_WD, ZERO), _AXES
    z, cosine = cross(X_WC.R.column(2), X_WD.R.column(2)), row.value(circuits, end)
    square = dot(z, z)
    sine = functions.sqrt(square)
    angle = functions.atan2(sine, cosine)
    if derivatives < 1 or (type(square) is float and square == 0.0):  # zero in every pose
        return angle, 0.0, 0.0
    first = -row.rate(circuits, end) / sine
    if derivatives < 2:
        return angle, first, 0.0
    second = -(row.acceleration(circuits, end) + cosine * first * first) / sine
    return angle, first, second
