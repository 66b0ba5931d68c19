"""Free motions: what the closed loops still allow at a configuration."""

from __future__ import annotations

import numpy as np

from parakin.algebra.spatial import Vector, as_array
from parakin.arrays import FloatArray
from parakin.kinematics import chains
from parakin.kinematics.configuration import (
    Configuration,
    closure_system,
    coordinate_scales,
    loop_signs,
)
from parakin.kinematics.recursion import Circuits, pair_velocity
from parakin.model.graph import Graph, Tree

_RESTS = 1e-7  # rates below this, scaled, are none
_RANK = 1e-8  # singular values below this part of the largest count as zero


def free_motions(
    graph: Graph,
    tree: Tree,
    at: Configuration,
    rank: int | None = None,
) -> FloatArray:
    """The motions the closed loops allow, (n, mobility).

    They give the rate of every coordinate, those of cut joints too, and are orthonormal in scaled
    units. rank: of all closure rows; found if not given.
    """
    signs = loop_signs(graph, tree)
    scales = coordinate_scales(graph)
    _, jacobian, _ = closure_system(graph, tree, at, signs)
    inside = graph.tree_coordinates(tree)
    J = jacobian[:, inside] * scales[inside]
    found = chains.kernel(J) if rank is None else None
    free = _kernel(J, rank) if found is None else found
    motions = np.zeros((len(graph.coordinates), free.shape[1]))
    motions[inside] = free * scales[inside][:, None]
    for cut in tree.cuts:
        relative = (at.screws * signs[cut]) @ motions
        own = list(graph.joints[cut].coordinates)
        if own:
            motions[own] = np.linalg.lstsq(at.screws[:, own], relative, rcond=None)[0]
    return motions


def _kernel(J: FloatArray, rank: int | None) -> FloatArray:
    """What all rows together map to zero, if there are so many independent ones."""
    if not J.size:
        return np.eye(J.shape[1])
    _, sizes, right = np.linalg.svd(J, full_matrices=True)
    if rank is None:
        rank = int((sizes > _RANK * sizes.max(initial=1.0)).sum())
    kernel: FloatArray = right[rank:].T
    return kernel


def is_idle(at: Configuration, motions: FloatArray) -> bool:
    """Whether these motions (scaled) leave platform and actuators alone and only spin bodies: legs
    between two spherical joints, or a crossbar on a hinge and on balls, about a line on which
    all joints of theirs lie.
    """
    graph = at.circuits.graph
    moved = {k for k in range(len(motions)) if np.abs(motions[k]).max(initial=0.0) > _RESTS}
    joints = [graph.joints[j] for j in {graph.coordinates[k].joint for k in moved}]
    if any(joint.actuated or joint.name == "platform" for joint in joints):
        return False
    hinges = [joint for joint in joints if joint.kind not in ("spherical", "cylindrical")]
    if not hinges:
        return True
    on = [body for joint in graph.joints for body in (joint.parent, joint.child)]
    carried = all(on.count(body) > 1 for j in hinges for body in (j.parent, j.child) if body)
    if not carried or any(joint.kind != "revolute" for joint in hinges):
        return False
    rates = motions * coordinate_scales(graph)[:, None]
    return not any(
        np.abs(_velocities(at.circuits, body, end.p, rates)).max() > _RESTS * graph.length
        for joint, ends in zip(graph.joints, at.ends, strict=True)
        for body, end in ((joint.parent, ends.X_WF), (joint.child, ends.X_WM))
    )


def _velocities(circuits: Circuits, body: int, point: Vector, rates: FloatArray) -> FloatArray:
    """Of a point on a body, (3, n), for n sets of rates."""
    total = np.zeros((3, rates.shape[1]))
    for k, (axis, sign) in circuits.axes(body).items():
        total += np.outer(as_array(pair_velocity(axis, sign, point)[1]), rates[k])
    return total


def holders(motions: FloatArray) -> list[int]:
    """One coordinate for each motion that, held, stops it: the largest, one after the other."""
    left = motions.copy()
    held: list[int] = []
    for _ in range(motions.shape[1]):
        k = int(np.argmax(np.linalg.norm(left, axis=1)))
        held.append(k)
        direction = left[k] / np.linalg.norm(left[k])
        left -= np.outer(left @ direction, direction)
    return held
