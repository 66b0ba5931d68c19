"""Whether an assembly could be built: within its limits, and with no leg turned through itself."""

from __future__ import annotations

import numpy as np

from parakin.algebra.spatial import Vector
from parakin.arrays import FloatArray
from parakin.kinematics.cones import cone_angles
from parakin.kinematics.configuration import circuits_at
from parakin.model.graph import Graph
from parakin.model.joints import GraphJoint
from parakin.planning.plan import Plan
from parakin.solving.stops import beyond_limits


def limits_exceeded(plan: Plan, q: FloatArray) -> tuple[str, ...]:
    """Those on positions and cone angles, at coordinates (N,) as they are counted."""
    graph = plan.graph
    values = {c.name: float(q[k]) for k, c in enumerate(graph.coordinates)}
    if any(limit.coordinate in graph.cones for limit in graph.limited):
        counted = np.array([q[k] + plan.offset(k) for k in range(len(q))])
        values |= cone_angles(circuits_at(graph, plan.tree, counted), plan.cones)
    return beyond_limits(graph, values)


def turned_through(plan: Plan, q: FloatArray) -> tuple[str, ...]:
    """The legs that are turned through themselves at coordinates (N,), as they are counted:
    actuated slides whose two joint centres have passed one another since home.
    """
    graph = plan.graph.plain
    found = []
    for number, joint in enumerate(graph.joints):
        distance = _between_centres(graph, number)
        if distance is None or not joint.actuated:
            continue
        now = float(q[joint.first]) + plan.offset(joint.first) + distance
        if not now * (float(plan.own_home[joint.first]) + distance) > 0.0:
            found.append(joint.name)
    return tuple(found)


def _between_centres(graph: Graph, number: int) -> float | None:
    """How far the joint at the far end of a slide is ahead of that at the near end, along the
    slide, where its coordinate is zero [m]; None unless it is a slide between two bodies of a limb
    that each have one more joint.
    """
    joint = graph.joints[number]
    platform = None if graph.platform is None else graph.joints[graph.platform].child
    if joint.kind != "prismatic" or {joint.parent, joint.child} & {0, platform}:
        return None
    heights = []
    for body, X_BJ in ((joint.parent, joint.F), (joint.child, joint.M)):
        others = [
            other
            for k, other in enumerate(graph.joints)
            if body in (other.parent, other.child) and k not in (number, graph.platform)
        ]
        if len(others) != 1:
            return None
        centre = _centre(others[0], body)
        heights.append(float((X_BJ.R.T @ (centre - X_BJ.p))[2]))
    return heights[1] - heights[0]


def _centre(joint: GraphJoint, body: int) -> Vector[float]:
    """Where a joint is on one of its bodies."""
    return joint.F.p if joint.parent == body else joint.M.p
