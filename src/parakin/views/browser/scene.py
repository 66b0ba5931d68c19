"""A mechanism in a viser scene: places bodies, and knows nothing of time or equations."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from parakin.arrays import FloatArray
from parakin.views.browser.efforts import Efforts, Reactions
from parakin.views.solids.drawing import COLOURS, Drawing
from parakin.views.solids.shapes import Bar, Mesh, joined, mesh
from parakin.views.thinning import thinned

_ROOT = "/mechanism"  # of all bodies; other nodes begin with a dot, which no name of a body does
_ROD = (150, 158, 168)
_BUCKETS = 130  # of a trace


@dataclass
class Scene:
    """The nodes of one mechanism in one scene (viser's `SceneApi`).

    meshes: shapes of bodies by name, in the body's frame, to show in place of the usual solids.
    """

    api: Any
    drawing: Drawing
    meshes: Mapping[str, Mesh] = field(default_factory=dict)
    bodies: list[Any] = field(init=False)
    _rods: list[Any] = field(init=False)
    _joints: dict[int, list[tuple[Any, tuple[int, int, int]]]] = field(init=False)
    _labels: list[Any] = field(init=False)
    _highlighted: frozenset[int] = frozenset()

    def __post_init__(self) -> None:
        graph, size = self.drawing.arrangement.graph, self.drawing.arrangement.size
        self._solids = [mesh(piece.form) for piece in self.drawing.pieces]
        self._root = self.api.add_frame(_ROOT, show_axes=False)
        self.bodies, self._rods, self._joints, self._labels = [], [], {}, []
        R, position = (np.array(part) for part in zip(*self.drawing.arrangement.poses, strict=True))
        wxyz = Rotation.from_matrix(R).as_quat(scalar_first=True)
        for name, p, turn in zip(graph.bodies, position, wxyz, strict=True):
            frame = self.api.add_frame(
                self._node(name),
                show_axes=False,
                axes_length=0.12 * size,
                axes_radius=0.004 * size,
                origin_radius=0.008 * size,
                position=p,
                wxyz=turn,
            )
            self.bodies.append(frame)
        self._add_bodies()
        self._add_joints()
        self._add_rods()
        self._place_rods(position, wxyz)
        view = self.drawing.view
        self.trace_node: Any = None
        self.efforts = Efforts(self.api, _ROOT, graph, min(size, float(view.span)))
        self.reactions = Reactions(self.api, _ROOT, min(size, float(view.span)))
        self._floor(view.up)

    def _node(self, body: str, part: str = "") -> str:
        return f"{_ROOT}/{body}/{part}" if part else f"{_ROOT}/{body}"

    def _add_bodies(self) -> None:
        graph = self.drawing.arrangement.graph
        for body, name in enumerate(graph.bodies):
            parts: dict[str, list[Mesh]] = {}
            shape = self.meshes.get(name)
            if shape is not None:
                parts["mesh"] = [shape]
            for piece, solid in zip(self.drawing.pieces, self._solids, strict=True):
                if piece.body == body and piece.joint is None and shape is None:
                    parts.setdefault(piece.part, []).append(solid)
            for part, solids in parts.items():
                colour = COLOURS.get(part, COLOURS["link"])
                self._mesh(self._node(name, part), joined(solids), colour)
            label = self.api.add_label(self._node(name, "name"), name, visible=False)
            self._labels.append(label)
        for name, (body, p) in graph.points.items():
            body_name = graph.bodies[body]
            point = name.removeprefix(f"{body_name}.")
            node = self._node(body_name, f"point {point}")
            self._labels.append(self.api.add_label(node, point, position=p, visible=False))

    def _add_joints(self) -> None:
        graph = self.drawing.arrangement.graph
        named: set[int] = set()
        for k, piece in enumerate(self.drawing.pieces):
            if piece.joint is None or graph.bodies[piece.body] in self.meshes:
                continue
            joint, body = graph.joints[piece.joint], graph.bodies[piece.body]
            colour = self.drawing.colour(piece)
            node = self._mesh(self._node(body, f"joint {joint.name} {k}"), self._solids[k], colour)
            self._joints.setdefault(piece.joint, []).append((node, colour))
            if piece.joint not in named:
                named.add(piece.joint)
                place = joint.F if piece.body == joint.parent else joint.M
                node = self._node(body, f"joint {joint.name} name")
                label = self.api.add_label(node, joint.name, position=place.p, visible=False)
                self._labels.append(label)

    def _add_rods(self) -> None:
        for rod in self.drawing.rods:
            start, end = (
                self.drawing.arrangement.world(rod.parent, rod.start)[0],
                self.drawing.arrangement.world(rod.child, rod.end)[0],
            )
            along = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, float(np.linalg.norm(end - start))]])
            name = self.drawing.arrangement.graph.joints[rod.joint].name
            node = self._mesh(f"{_ROOT}/.rod {name}", mesh(Bar(along, rod.radius)), _ROD)
            self._joints.setdefault(rod.joint, []).append((node, _ROD))
            self._rods.append(node)

    def _mesh(self, name: str, solid: Mesh, colour: tuple[int, int, int]) -> Any:
        return self.api.add_mesh_simple(
            name, solid.vertices, solid.faces, color=colour, flat_shading=False, side="double"
        )

    def _floor(self, up: FloatArray) -> None:
        """A grid below the mechanism, perpendicular to the up axis."""
        view, size = self.drawing.view, self.drawing.arrangement.size
        below = min(
            float((self.drawing.arrangement.world(piece.body, solid.vertices) @ up).min())
            for piece, solid in zip(self.drawing.pieces, self._solids, strict=True)
        )
        cell = 10.0 ** np.floor(np.log10(size / 4))
        axis = int(np.argmax(np.abs(up)))
        self.api.add_grid(
            f"{_ROOT}/.floor",
            width=40 * cell,
            height=40 * cell,
            cell_size=cell,
            section_size=5 * cell,
            plane=("yz", "xz", "xy")[axis],
            position=view.middle + (below - 0.02 * size - view.middle @ up) * up,
        )

    def place(self, position: FloatArray, wxyz: FloatArray) -> None:
        """Place all bodies but the base, given as in a Dataset: (bodies, 3) [m], (bodies, 4)."""
        for handle, p, turn in zip(self.bodies[1:], position, wxyz, strict=True):
            handle.position = p
            handle.wxyz = turn
        base = np.array([[1.0, 0.0, 0.0, 0.0]])
        self._place_rods(np.concatenate([np.zeros((1, 3)), position]), np.concatenate([base, wxyz]))

    def _place_rods(self, position: FloatArray, wxyz: FloatArray) -> None:
        if not self._rods:
            return
        R = Rotation.from_quat(wxyz, scalar_first=True).as_matrix()
        for node, rod in zip(self._rods, self.drawing.rods, strict=True):
            start = position[rod.parent] + R[rod.parent] @ rod.start
            end = position[rod.child] + R[rod.child] @ rod.end
            node.position = start
            node.wxyz = _from_z((end - start) / np.linalg.norm(end - start))

    def highlight(self, joints: Collection[int]) -> None:
        """Highlight these joints and no others."""
        highlighted = frozenset(joints)
        for number in highlighted ^ self._highlighted:
            for node, colour in self._joints.get(number, ()):
                node.color = COLOURS["offending"] if number in highlighted else colour
        self._highlighted = highlighted

    def show_frames(self, shown: bool) -> None:
        """Show or hide the axes of every body."""
        for handle in self.bodies:
            handle.show_axes = shown

    def show_names(self, shown: bool) -> None:
        """Show or hide the names of bodies, joints and points."""
        for label in self._labels:
            label.visible = shown

    def trace(self, points: FloatArray | None) -> None:
        """Replace the trace by a line along points (n, 3), or by none."""
        if self.trace_node is not None:
            self.trace_node.remove()
            self.trace_node = None
        if points is None:
            return
        points = points[np.isfinite(points).all(axis=1)]
        points = points[thinned(points.T, _BUCKETS)]
        if len(points) > 1:
            pairs = np.stack([points[:-1], points[1:]], axis=1).astype(np.float32)
            self.trace_node = self.api.add_line_segments(
                f"{_ROOT}/.trace",
                pairs,
                colors=(200, 30, 120),
                thickness=2.0,
                thickness_units="screen",
            )

    def remove(self) -> None:
        """Remove everything from the scene."""
        self._root.remove()


def _from_z(direction: FloatArray) -> FloatArray:
    """The shortest turn from z to a unit vector, as a quaternion wxyz.

    SciPy's align_vectors takes sixty times as long, and this runs for every rod and pose.
    """
    x, y, z = direction.tolist()
    if z < -1 + 1e-12:
        return np.array([0.0, 1.0, 0.0, 0.0])
    turn = np.array([1.0 + z, -y, x, 0.0])
    return np.asarray(turn / np.sqrt(2.0 * (1.0 + z)))
