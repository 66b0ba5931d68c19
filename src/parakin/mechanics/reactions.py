"""Reactions: what a joint exerts on its child, and which of that can be known at all.

In an overconstrained loop forces can act against each other without moving anything: multipliers
that no coordinate feels. What these would change is indeterminate for rigid bodies.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from parakin.algebra.spatial import Pose, Scalar, as_float, cross
from parakin.arrays import BoolArray, FloatArray
from parakin.kinematics.closure import Row, Wrench, all_rows
from parakin.kinematics.configuration import Configuration, closure_system, loop_signs
from parakin.kinematics.recursion import Circuits
from parakin.mechanics.powers import carried
from parakin.mechanics.wrenches import Wrenches, gather, put_between
from parakin.model.graph import Graph, Tree
from parakin.model.joints import GraphJoint

SIZE = 6  # of a reaction: force, then moment
_RANK = 1e-8  # singular values below this part of the largest count as zero
_FELT = 1e-6  # of all a self-stress exerts: what a component must be to be changed by it


class JointAt(NamedTuple):
    """A joint as declared, of which a plan's graph may have split the freedoms into a chain.

    carrier: the joint of the graph that carries its child; then the bodies that it joins and its
    frames on them.
    """

    name: str
    carrier: int
    parent: int
    child: int
    F: Pose[float]
    M: Pose[float]


def joints_at(graph: Graph, declared: Sequence[GraphJoint]) -> tuple[JointAt, ...]:
    """Declared joints, as a graph has them. (Coordinates keep their numbers where it is split.)"""
    names = {joint.name: k for k, joint in enumerate(graph.joints)}
    found = []
    for joint in declared:
        carrier = names.get(joint.name, -1)
        if joint.pairs:
            carrier = graph.coordinates[joint.coordinates[-1]].joint
        found.append(JointAt(joint.name, carrier, joint.parent, joint.child, joint.F, joint.M))
    return tuple(found)


def at_joint(circuits: Circuits, joint: JointAt, wrench: Wrench | None) -> list[Scalar]:
    """Force and moment about the joint's origin on its child, along its axes on its parent."""
    if wrench is None:
        return [0.0] * SIZE
    point = (circuits.pose(joint.child) @ joint.M).p
    R_FW = (circuits.pose(joint.parent) @ joint.F).R.T
    moment = wrench.moment - cross(point, wrench.force)
    return [*(R_FW @ wrench.force), *(R_FW @ moment)]


def self_stresses(graph: Graph, tree: Tree, at: Configuration) -> FloatArray:
    """Multipliers of all canonical rows that no coordinate feels, (rows, n), in newtons."""
    _, jacobian, rows = closure_system(graph, tree, at, loop_signs(graph, tree))
    if not rows:
        return np.zeros((0, 0))
    inside = graph.tree_coordinates(tree)
    scales = np.array([1.0 if c.angle else graph.length for c in graph.coordinates])
    left, sizes, _ = np.linalg.svd(jacobian[:, inside] * scales[inside])
    rank = int((sizes > _RANK * sizes.max(initial=1.0)).sum())
    per_length = np.array([[row.per_length(graph)] for row in rows])
    found: FloatArray = left[:, rank:] * per_length
    return found


def joint_wrenches(
    at: Configuration, tree: Tree, multipliers: Mapping[Row, float]
) -> dict[int, Wrench]:
    """What all joints exert on their children where closure rows exert these and nothing else."""
    needed: Wrenches = {}
    on_cuts: dict[int, Wrench] = {}
    for row, value in multipliers.items():
        end = at.ends[row.cut]
        wrench = row.wrench(end, at.axes.__getitem__).times(value)
        gather(on_cuts, row.cut, wrench)
        put_between(needed, end.parent, end.child, wrench)
    return carried(at.circuits, tree, needed, ()).joints | on_cuts


def stressed(graph: Graph, tree: Tree, joints: Sequence[JointAt], at: Configuration) -> FloatArray:
    """What each self-stress of a closed configuration exerts in joints, (joints, 6, n) [N];
    moments count by the characteristic length.
    """
    rows = all_rows(graph, tree)
    stresses = self_stresses(graph, tree, at)
    found = np.zeros((len(joints), SIZE, stresses.shape[1]))
    units = np.array([1.0] * 3 + [1.0 / graph.length] * 3)
    for number, stress in enumerate(stresses.T):
        known = {row: float(x) for row, x in zip(rows, stress, strict=True) if x}
        on = joint_wrenches(at, tree, known)
        for k, joint in enumerate(joints):
            parts = at_joint(at.circuits, joint, on.get(joint.carrier))
            found[k, :, number] = units * [as_float(part) for part in parts]
    return found


def indeterminate(
    graph: Graph, tree: Tree, joints: Sequence[JointAt], samples: Sequence[Configuration]
) -> BoolArray:
    """Which components of joints' reactions, (joints, 6), are indeterminate in any of some closed
    configurations of a tree.
    """
    unknown = np.zeros((len(joints), SIZE), dtype=bool)
    for at in samples:
        sizes = np.abs(stressed(graph, tree, joints, at))
        most = sizes.max(axis=(0, 1), initial=0.0)
        unknown |= (sizes > _FELT * most).any(axis=2)
    return unknown
