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
from parakin.model.placement import snapped

_AXES = Perpendicular(0, 2, 2)  # of whatever joint, as it measures what its ends are
_Z = Vector((0.0, 0.0, 1.0))


class Cone(NamedTuple):
    """An angle between a direction on body `parent` and one on `child`, in their components."""

    parent: int
    child: int
    z_P: Vector
    z_C: Vector


def cones_of(
    graph: Graph, home: Sequence[Scalar], functions: Functions = FLOATS
) -> dict[str, Cone]:
    """By name, how the cone angles of a graph are measured. home: all coordinates at the
    mechanism's own home.

    A spherical joint whose frames the file orients: between their two z axes. Where it gives no
    orientation: from home's direction of the z axis of the child or, where only the child is base
    or platform, of the parent. A universal joint, whose z axes are always at right angles: from
    home's direction of the normal to both.
    """
    return {name: _cone(graph, joint, home, functions) for name, joint in graph.cones.items()}


def _cone(graph: Graph, joint: GraphJoint, home: Sequence[Scalar], functions: Functions) -> Cone:
    z_F, z_M = _directions(graph, joint, home, functions)
    return Cone(joint.parent, joint.child, joint.F.R @ z_F, joint.M.R @ z_M)


def _directions(
    graph: Graph, joint: GraphJoint, home: Sequence[Scalar], functions: Functions
) -> tuple[Vector, Vector]:
    """On the joint's frames F and M, from the orientation at home."""
    if joint.kind == "spherical" and joint.oriented:
        return _Z, _Z
    R_FM = _orientation(joint, home, functions)
    if joint.kind == "spherical":
        if _is_limb(graph, joint.parent) and not _is_limb(graph, joint.child):
            return _Z, _snapped(R_FM.T.column(2))
        return _snapped(R_FM.column(2)), _Z
    normal = cross(_Z, R_FM.column(2))
    return _snapped(normal), _snapped(R_FM.T @ normal)


def _is_limb(graph: Graph, body: int) -> bool:
    """Whether a body is neither base nor platform."""
    platform = graph.platform
    return body != 0 and (platform is None or body != graph.joints[platform].child)


def _snapped(z: Vector) -> Vector:
    return snapped(_frame(z)).column(2)


def _frame(z: Vector) -> Matrix:
    """What stands for a frame of which only the z axis counts."""
    return Matrix(Vector((0.0, 0.0, component)) for component in z)


def _orientation(joint: GraphJoint, home: Sequence[Scalar], functions: Functions) -> Matrix:
    """R_FM for a joint's coordinates."""
    R: Matrix = IDENTITY
    for k, pair in zip(joint.coordinates, joint.pairs, strict=True):
        if not pair.slides:
            R = turned(R, pair.axis, functions.cos(home[k]), functions.sin(home[k]))
    return R @ joint.tail


def cone_angles(circuits: Circuits, cones: Mapping[str, Cone]) -> dict[str, float]:
    """Every cone angle by name, of circuits in numbers."""
    return {
        name: as_float(cone_angle(circuits, cone, FLOATS, derivatives=0)[0])
        for name, cone in cones.items()
    }


def cone_cosine(circuits: Circuits, cone: Cone) -> Scalar:
    """The cosine of a cone angle, which is smooth at an angle of 0 too."""
    u = circuits.pose(cone.parent).R @ cone.z_P
    return dot(u, circuits.pose(cone.child).R @ cone.z_C)


def cone_angle(
    circuits: Circuits, cone: Cone, functions: Functions, *, derivatives: int
) -> tuple[Scalar, Scalar, Scalar]:
    """A cone angle and its derivatives (undefined at 0)."""
    u = circuits.pose(cone.parent).R @ cone.z_P
    v = circuits.pose(cone.child).R @ cone.z_C
    F, M = (Pose(_frame(direction), ZERO) for direction in (u, v))
    end, row = Ends(cone.parent, cone.child, F, M, ZERO), _AXES
    z, cosine = cross(u, v), row.value(circuits, end)
    square = dot(z, z)
    sine = functions.sqrt(square)
    angle = functions.atan2(sine, cosine)
    if derivatives < 1 or (type(square) is float and square == 0.0):  # zero in every pose
        return angle, 0.0, 0.0
    inverse: Scalar = functions.inverse(sine)
    first = -row.rate(circuits, end) * inverse
    if derivatives < 2:
        return angle, first, 0.0
    second = -(row.acceleration(circuits, end) + cosine * first * first) * inverse
    return angle, first, second
