"""Arrows in a scene for the efforts of actuators: one node, so that a pose takes one message."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from parakin.arrays import FloatArray
from parakin.model.graph import Graph
from parakin.views.force_arrows import COLOURS, LONGEST, ForceArrows, largest_of

_SHORTEST = 0.02  # of the longest: what is shorter is not shown
_SHAFT, _HEAD, _HEAD_LENGTH = 0.006, 0.015, 0.04  # of the mechanism's size


class Efforts:
    """The node, below `root`. Arrows are to the scale of the largest efforts shown so far."""

    def __init__(self, api: Any, root: str, graph: Graph, size: float) -> None:
        self._api, self._name, self._graph, self._size = api, f"{root}/.efforts", graph, size
        self._arrows: ForceArrows | None = None
        self._largest: dict[str, float] = {}
        self._node: Any = None
        self._shown: tuple[int, ...] = ()
        self.points = np.zeros((0, 2, 3))

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
        R = np.concatenate(
            [np.eye(3)[None], Rotation.from_quat(wxyz, scalar_first=True).as_matrix()]
        )
        p = np.concatenate([np.zeros((1, 3)), position])
        largest = np.array([self._largest[unit] for unit in units])
        points = self._arrows.at(R, p, efforts, largest)
        length = np.linalg.norm(points[:, 1] - points[:, 0], axis=1)
        long = np.flatnonzero(length > _SHORTEST * LONGEST * self._size)
        shown = tuple(self._arrows.shown[k] for k in long.tolist())
        if shown != self._shown:
            self.hide()
            if shown:
                self._add(shown, points[long], [COLOURS[units[k]] for k in shown])
        elif self._node is not None:
            self._node.points = points[long].astype(np.float32)
        self.points = points[long]

    def _add(
        self, shown: tuple[int, ...], points: FloatArray, colours: list[tuple[int, int, int]]
    ) -> None:
        self._shown = shown
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
