"""Configurations: a mechanism at one moment, in plain numbers.

Everything is seen as screws: each coordinate's axis where it stands in space, and each closure row
as a row_wrench on the relative twist of the two bodies it joins.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import cast

import numpy as np

from parakin.algebra.angles import nearest_angle
from parakin.algebra.spatial import ARRAYS, FLOATS, ZERO, Pose, as_float
from parakin.arrays import FloatArray
from parakin.kinematics import loops
from parakin.kinematics.closure import Row, all_rows
from parakin.kinematics.readings import read
from parakin.kinematics.recursion import Axis, Circuits, Turn, pair_velocity, slide, step_pose, turn
from parakin.model.graph import Graph, Tree


@dataclass(frozen=True)
class Configuration:
    """Every joint and body of a mechanism at one moment, closed or not.

    `q`: all coordinates; `screws` (6, n): direction of motion per coordinate, angular part then
    velocity at the base's origin, angular parts scaled by nothing; `axes` of the coordinates where
    they stand; `ends`: each joint's frames on its two bodies. `turned` keeps what has been worked
    out with one coordinate turned: by cut joint and coordinate.
    """

    q: FloatArray
    screws: FloatArray
    axes: tuple[Axis, ...]
    circuits: Circuits
    ends: tuple[loops.Ends, ...]
    turned: dict[tuple[int, int], list[tuple[Circuits, loops.Ends]]] = field(default_factory=dict)

    @property
    def design(self) -> tuple[float, ...]:
        """The parameters [SI] of the mechanism that stands so."""
        return tuple(self.circuits.graph.parameters.values())

    def pose(self, body: int) -> Pose[float]:
        """X_WB of a body."""
        return cast("Pose[float]", self.circuits.pose(body))


def circuits_at(graph: Graph, tree: Tree, q: Sequence[float] | FloatArray) -> Circuits:
    """The recursion with numbers for the tree's coordinates, or rows of many: (coordinates, n)."""
    circuits = Circuits(graph, tree)
    circuits.turns |= {k: as_turn(graph, k, q[k]) for k in graph.tree_coordinates(tree)}
    return circuits


def as_turn(graph: Graph, coordinate: int, value: float | FloatArray) -> Turn:
    """A coordinate as the recursion needs it, from a number or an array of them."""
    if np.ndim(value) == 0:
        value = float(value)  # a plain number, so that literal zeros are known for what they are
    if not graph.coordinates[coordinate].angle:
        return slide(value)
    return turn(value, ARRAYS if np.ndim(value) else FLOATS)


def configure(graph: Graph, tree: Tree, q: FloatArray) -> Configuration:
    """The configuration given by the tree's coordinates; those of cut joints are read off.

    Angles of cut joints are taken within half a turn of their values in `q`.
    """
    circuits = circuits_at(graph, tree, q)
    q = np.array(q, dtype=float)
    ends = tuple(loops.ends(circuits, k) for k in range(len(graph.joints)))
    for k in tree.cuts:
        reading = read(circuits, k, ends[k], FLOATS)
        for n, (s, c) in reading.turns.items():
            q[n] = nearest_angle(math.atan2(as_float(s), as_float(c)), to=q[n])
        for n, value in reading.slides.items():
            q[n] = as_float(value)
    axes: dict[int, Axis] = {}
    for joint in graph.joints:
        turns = {k: as_turn(graph, k, q[k]) for k in joint.coordinates}
        axes |= step_pose(circuits.pose(joint.parent), joint, False, turns)[1]
    located = tuple(axes[k] for k in range(len(q)))
    screws = [[*w, *v] for w, v in (pair_velocity(axis, 1.0, ZERO) for axis in located)]
    columns = np.ascontiguousarray(np.array(screws, dtype=float).reshape(-1, 6).T)
    return Configuration(q, columns, located, circuits, ends)


def coordinate_scales(graph: Graph) -> FloatArray:
    """Coordinates in units of like size: radians, and slides in characteristic lengths."""
    return np.array([1.0 if c.angle else graph.length for c in graph.coordinates])


def full_screws(graph: Graph, at: Configuration, held: Collection[int] = ()) -> FloatArray:
    """Screws, those of joints of three turns, none of them held, about three axes at right angles
    whatever their angles.
    """
    screws = at.screws.copy()
    for k, joint in enumerate(graph.joints):
        if len(joint.turns) == 3 and not set(joint.turns) & set(held):
            centre = np.array(at.ends[k].X_WM.p, dtype=float)
            for number, axis in zip(joint.turns, np.eye(3), strict=True):
                screws[:, number] = np.concatenate([axis, np.cross(centre, axis)])
    return screws


def loop_signs(graph: Graph, tree: Tree) -> dict[int, FloatArray]:
    """Per cut: how each coordinate's screw enters the relative twist of its two bodies."""
    circuits = Circuits(graph, tree)
    onward = np.ones(len(graph.coordinates))
    for k, reverse in tree.steps:
        if reverse:
            onward[list(graph.joints[k].coordinates)] = -1.0
    signs = {}
    for cut in tree.cuts:
        row = np.zeros(len(graph.coordinates))
        for k, side in loops.sides(circuits, cut).items():
            row[k] = side * onward[k]
        signs[cut] = row
    return signs


def loop_rank(graph: Graph, at: Configuration, numbers: Sequence[int]) -> int:
    """How many of a loop's screws, those of these coordinates, are independent."""
    screws = at.screws[:, list(numbers)] * coordinate_scales(graph)[list(numbers)]
    screws[3:] /= graph.length
    return int(np.linalg.matrix_rank(screws, tol=1e-7))


def row_wrench(at: Configuration, row: Row) -> FloatArray:
    """The row as a row_wrench on the relative twist (w, v at the base's origin), once closed."""
    wrench = row.wrench(at.ends[row.cut], at.axes.__getitem__)
    return np.array([*wrench.moment, *wrench.force], dtype=float)


def closure_system(
    graph: Graph, tree: Tree, at: Configuration, signs: Mapping[int, FloatArray]
) -> tuple[FloatArray, FloatArray, list[Row]]:
    """All canonical rows, scaled to one by the characteristic length: gaps, Jacobian, rows."""
    rows = all_rows(graph, tree)
    gaps = np.zeros(len(rows))
    jacobian = np.zeros((len(rows), len(graph.coordinates)))
    for i, row in enumerate(rows):
        end = at.ends[row.cut]
        scale = row.per_length(graph) / graph.length
        gaps[i] = scale * as_float(row.value(at.circuits, end))
        jacobian[i] = scale * (row_wrench(at, row) @ at.screws) * signs[row.cut]
    return gaps, jacobian, rows
