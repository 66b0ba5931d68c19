"""Virtual powers: from wrenches on bodies to efforts in the coordinates of the tree.

The recursion passed backwards: from the ends of the tree to the base, every joint carries what
the bodies beyond it need, and a coordinate's effort is the power of that at its unit rate.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

from parakin.algebra.spatial import ZERO, Scalar, add, dot
from parakin.kinematics.closure import Wrench
from parakin.kinematics.recursion import Circuits, pair_velocity
from parakin.mechanics.wrenches import Wrenches, put
from parakin.model.graph import Tree


class Carried(NamedTuple):
    """efforts: by coordinate; joints: by joint of the tree, the wrench on its child."""

    efforts: dict[int, Scalar]
    joints: dict[int, Wrench]


def carried(
    circuits: Circuits, tree: Tree, needed: Wrenches, wanted: Collection[int] | None = None
) -> Carried:
    """What joints of the tree carry, and the efforts of coordinates, or of those `wanted`, that
    give the bodies the wrenches they need. What is absent is zero.
    """
    on = dict(needed)
    efforts: dict[int, Scalar] = {}
    joints: dict[int, Wrench] = {}
    for k, reverse in reversed(tree.steps):
        joint = circuits.graph.joints[k]
        near, far = (joint.child, joint.parent) if reverse else (joint.parent, joint.child)
        if far not in on:
            continue
        wrench = on[far]
        joints[k] = wrench.times(-1.0) if reverse else wrench
        for n in joint.coordinates:
            if wanted is None or n in wanted:
                efforts[n] = power_at_unit_rate(circuits, far, n, wrench)
        put(on, near, wrench)
    return Carried(efforts, joints)


def power_at_unit_rate(circuits: Circuits, body: int, coordinate: int, wrench: Wrench) -> Scalar:
    """Of a wrench on a body, where a coordinate on its path moves alone [W per m/s or rad/s]."""
    axis, sign = circuits.axes(body)[coordinate]
    w, v = pair_velocity(axis, sign, ZERO)
    return add(dot(w, wrench.moment), dot(v, wrench.force))
