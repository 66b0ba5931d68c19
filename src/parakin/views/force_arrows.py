"""Where arrows stand for efforts, on their joints along their axes, and for forces in joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from parakin.arrays import BoolArray, FloatArray
from parakin.mechanics.reactions import JointAt
from parakin.model.graph import Graph

COLOURS = {"N": (200, 30, 70), "N m": (120, 60, 190)}  # of forces and of moments
REACTIONS = (20, 110, 190)  # the colour of forces in joints
LONGEST = 0.3  # of a mechanism's size: the arrow of the largest effort


@dataclass(frozen=True, eq=False)
class ForceArrows:
    """Arrows of actuators, by name, of a mechanism of this `size` [m]: they begin at the joint on
    its child, and an arrow of a moment is along its axis, by the right hand.

    Only pairs that come first or last in their joint are shown: the axes of others are between its
    bodies.
    """

    graph: Graph
    actuators: tuple[str, ...]
    size: float
    shown: tuple[int, ...] = field(init=False)  # of the actuators
    _bodies: tuple[int, ...] = field(init=False)  # that an axis is fixed to
    _axes: FloatArray = field(init=False)  # on these
    _children: tuple[int, ...] = field(init=False)
    _places: FloatArray = field(init=False)  # on the children

    def __post_init__(self) -> None:
        shown, bodies, axes, children, places = [], [], [], [], []
        for k, name in enumerate(self.actuators):
            number = self.graph.index(name, "actuators")
            joint = self.graph.joints[self.graph.coordinates[number].joint]
            i = number - joint.first
            along = np.eye(3)[joint.pairs[i].axis]
            if i == 0:
                bodies.append(joint.parent)
                axes.append(np.array(joint.F.R, dtype=float) @ along)
            elif i == len(joint.pairs) - 1:
                bodies.append(joint.child)
                tail = np.array(joint.tail, dtype=float)
                axes.append(np.array(joint.M.R, dtype=float) @ tail.T @ along)
            else:
                continue
            shown.append(k)
            children.append(joint.child)
            places.append(np.array(joint.M.p, dtype=float))
        for name, value in (
            ("shown", tuple(shown)),
            ("_bodies", tuple(bodies)),
            ("_axes", np.array(axes).reshape(-1, 3)),
            ("_children", tuple(children)),
            ("_places", np.array(places).reshape(-1, 3)),
        ):
            object.__setattr__(self, name, value)

    def at(
        self, R: FloatArray, p: FloatArray, efforts: FloatArray, largest: FloatArray
    ) -> FloatArray:
        """Starts and ends (shown, 2, 3) of arrows, given all bodies' R (bodies, 3, 3) and p
        (bodies, 3), the base's too; efforts of all actuators; largest: those that the longest
        arrows are for. Unknown efforts have arrows of no length.
        """
        kept = list(self.shown)
        parts = np.divide(
            efforts[kept], largest[kept], out=np.zeros(len(kept)), where=largest[kept] > 0.0
        )
        parts = np.nan_to_num(parts, nan=0.0, posinf=0.0, neginf=0.0)
        children, bodies = list(self._children), list(self._bodies)
        start = p[children] + np.einsum("nij,nj->ni", R[children], self._places)
        along = np.einsum("nij,nj->ni", R[bodies], self._axes)
        return np.stack([start, start + LONGEST * self.size * parts[:, None] * along], axis=1)


@dataclass(frozen=True, eq=False)
class JointArrows:
    """Arrows of what joints exert on their children, of a mechanism of this `size` [m]: they begin
    at the joint's origin on its child.
    """

    joints: tuple[JointAt, ...]
    size: float

    def at(self, R: FloatArray, p: FloatArray, forces: FloatArray, largest: float) -> FloatArray:
        """Starts and ends (joints, 2, 3) of arrows, given all bodies' R (bodies, 3, 3) and p
        (bodies, 3), the base's too; forces (joints, 3) along the joints' axes on their parents;
        largest: what the longest arrow is for. Unknown forces have arrows of no length.
        """
        children = [joint.child for joint in self.joints]
        parents = [joint.parent for joint in self.joints]
        places = np.array([joint.M.p for joint in self.joints], dtype=float)
        axes = np.array([joint.F.R for joint in self.joints], dtype=float)
        start = p[children] + np.einsum("nij,nj->ni", R[children], places)
        along = np.einsum("nij,njk,nk->ni", R[parents], axes, np.nan_to_num(forces))
        unknown = ~np.isfinite(forces).all(axis=1)
        along[unknown] = 0.0
        scale = LONGEST * self.size / largest if largest > 0.0 else 0.0
        return np.stack([start, start + scale * along], axis=1)


def largest_of(efforts: FloatArray, units: Sequence[str]) -> FloatArray:
    """For each actuator, the largest effort (n, actuators) of those with its unit."""
    known = np.where(np.isfinite(efforts), np.abs(efforts), 0.0)
    most = known.max(axis=0, initial=0.0)
    return np.array([most[_alike(units, unit)].max() for unit in units])


def _alike(units: Sequence[str], unit: str) -> BoolArray:
    return np.array([each == unit for each in units])
