"""Indeterminacy: which reactions of rigid bodies cannot be known, and what would change that."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr

from parakin.arrays import BoolArray, FloatArray
from parakin.kinematics.assembly import home_and_around
from parakin.kinematics.configuration import Configuration
from parakin.mechanics.reactions import JointAt, indeterminate, joints_at, stressed
from parakin.model.graph import Graph

COMPONENTS = (*(f"force {axis}" for axis in "xyz"), *(f"moment {axis}" for axis in "xyz"))
_INDEPENDENT = 1e-6  # of the first: what a self-stress must be to count as another one


@dataclass(frozen=True)
class Indeterminacy:
    """components: of all reactions, six less its freedom for each joint. unknown: by joint, those
    that are indeterminate, along its axes on its parent. releases: by joint, the components
    without which all others would be determinate, in as few joints as possible.
    """

    components: int
    unknown: Mapping[str, tuple[str, ...]]
    releases: Mapping[str, tuple[str, ...]]

    @property
    def count(self) -> int:
        """How many components are indeterminate."""
        return sum(map(len, self.unknown.values()))


def indeterminacy(graph: Graph, home: Configuration) -> Indeterminacy:
    """Of a mechanism at home and at closed configurations around it."""
    declared = [joint for joint in graph.joints if joint.name != "platform"]
    joints, tree = joints_at(graph, declared), graph.tree()
    samples = home_and_around(graph, tree, home, 3)
    unknown = indeterminate(graph, tree, joints, samples)
    stresses = [stressed(graph, tree, joints, at) for at in samples]
    generic = min(stresses, key=lambda each: each.shape[2])
    return Indeterminacy(
        sum(6 - joint.freedom for joint in declared),
        _named(joints, unknown),
        _named(joints, _released(generic)),
    )


def _named(joints: Sequence[JointAt], chosen: BoolArray) -> dict[str, tuple[str, ...]]:
    return {
        joint.name: tuple(COMPONENTS[k] for k in np.flatnonzero(row))
        for joint, row in zip(joints, chosen, strict=True)
        if row.any()
    }


def _released(stresses: FloatArray) -> BoolArray:
    """Components (joints, 6) that together know every self-stress (joints, 6, n): joint by joint,
    always the one that knows most of those left.
    """
    left = stresses.copy()
    chosen = np.zeros(stresses.shape[:2], dtype=bool)
    size = np.abs(stresses).max(initial=0.0)
    while left.shape[2]:
        sizes = np.linalg.svd(left, compute_uv=False)
        known = (sizes > _INDEPENDENT * size).sum(axis=1)
        best = int(np.argmax(known))
        if not known[best]:
            break
        order = qr(left[best].T, mode="r", pivoting=True)[1][: known[best]]
        chosen[best, order] = True
        rest = np.linalg.svd(left[best, order])[2][known[best] :]
        left = left @ rest.T
    return chosen
