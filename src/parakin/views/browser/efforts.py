"""Arrows in a scene for the efforts of actuators and for the forces in joints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from parakin.arrays import FloatArray
from parakin.mechanics.reactions import JointAt
from parakin.model.graph import Graph
from parakin.views.force_arrows import (
    COLOURS,
    LONGEST,
    REACTIONS,
    ForceArrows,
    JointArrows,
    largest_of,
)

_SHORTEST = 0.02  # of the longest: what is shorter is not shown
_SHAFT, _HEAD, _HEAD_LENGTH = 0.006, 0.015, 0.04  # of the mechanism's size


class Efforts:
    """The node, below `root`. Arrows are to the scale of the largest efforts shown so far."""

    def __init__(self, api: Any, root: str, graph: Graph, size: float) -> None:
        self._node = _Arrows(api, f"{root}/.efforts", size)
        self._graph, self._size = graph, size
        self._arrows: ForceArrows | None = None
        self._largest: dict[str, float] = {}

    def scale_to(self, efforts: FloatArray, units: Sequence[str]) -> None:
        """Let the longest arrows be for efforts (n, actuators) if these are larger than before."""
        for unit, most in zip(units, largest_of(efforts, units).tolist(), strict=True):
            self._largest[unit] = max(most, self._largest.get(unit, 0.0))

    def show(
        self,
        position: FloatArray,
        wxyz: FloatArray,
        actuators: tuple[str, ...],
        units: Sequence[str],
        efforts: FloatArray,
    ) -> None:
        """Show efforts (actuators,) at a pose of all bodies but the base."""
        if self._arrows is None or self._arrows.actuators != actuators:
            self._arrows = ForceArrows(self._graph, actuators, self._size)
        self.scale_to(efforts[None], units)
        R, p = _placed(position, wxyz)
        largest = np.array([self._largest[unit] for unit in units])
        points = self._arrows.at(R, p, efforts, largest)
        numbers = self._arrows.shown
        self._node.show(points, numbers, [COLOURS[units[k]] for k in numbers])

    @property
    def points(self) -> FloatArray:
        """Starts and ends of the arrows shown."""
        return self._node.points

    def hide(self) -> None:
        """Show no arrows."""
        self._node.hide()


class Reactions:
    """The node of the forces in joints, below `root`, to the scale of the largest shown so far."""

    def __init__(self, api: Any, root: str, size: float) -> None:
        self._node = _Arrows(api, f"{root}/.reactions", size)
        self._size, self._largest = size, 0.0

    @property
    def points(self) -> FloatArray:
        """Starts and ends of the arrows shown."""
        return self._node.points

    def scale_to(self, forces: FloatArray) -> None:
        """Let the longest arrow be for forces (..., 3) if these are larger than before."""
        sizes = np.linalg.norm(np.nan_to_num(forces), axis=-1)
        self._largest = max(float(sizes.max(initial=0.0)), self._largest)

    def show(
        self,
        position: FloatArray,
        wxyz: FloatArray,
        joints: tuple[JointAt, ...],
        forces: FloatArray,
    ) -> None:
        """Show forces (joints, 3) at a pose of all bodies but the base."""
        self.scale_to(forces)
        R, p = _placed(position, wxyz)
        points = JointArrows(joints, self._size).at(R, p, forces, self._largest)
        self._node.show(points, range(len(joints)), [REACTIONS] * len(joints))

    def hide(self) -> None:
        """Show no arrows."""
        self._node.hide()


def _placed(position: FloatArray, wxyz: FloatArray) -> tuple[FloatArray, FloatArray]:
    """R (bodies, 3, 3) and p (bodies, 3) of all bodies, the base's too."""
    R = Rotation.from_quat(wxyz, scalar_first=True).as_matrix()
    return np.concatenate([np.eye(3)[None], R]), np.concatenate([np.zeros((1, 3)), position])


class _Arrows:
    """Arrows in one node, so that a pose takes one message."""

    def __init__(self, api: Any, name: str, size: float) -> None:
        self._api, self._name, self._size = api, name, size
        self._node: Any = None
        self._shown: tuple[int, ...] = ()
        self.points = np.zeros((0, 2, 3))

    def show(
        self, points: FloatArray, numbers: Sequence[int], colours: Sequence[tuple[int, int, int]]
    ) -> None:
        """Show arrows (n, 2, 3), those that are long enough; numbers tell them apart."""
        length = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
        long = np.flatnonzero(length > _SHORTEST * LONGEST * self._size)
        shown = tuple(numbers[k] for k in long.tolist())
        if shown != self._shown:
            self.hide()
            if shown:
                self._add(points[long], [colours[k] for k in long.tolist()])
                self._shown = shown
        elif self._node is not None:
            self._node.points = points[long].astype(np.float32)
        self.points = points[long]

    def _add(self, points: FloatArray, colours: Sequence[tuple[int, int, int]]) -> None:
        self._node = self._api.add_arrows(
            self._name,
            points.astype(np.float32),
            np.array(colours, dtype=np.uint8),
            shaft_radius=_SHAFT * self._size,
            head_radius=_HEAD * self._size,
            head_length=_HEAD_LENGTH * self._size,
        )

    def hide(self) -> None:
        """Show no arrows."""
        if self._node is not None:
            self._node.remove()
            self._node = None
        self._shown, self.points = (), self.points[:0]
