"""A mechanism painted without a browser: its solids, shaded, farthest first, by matplotlib."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from parakin.drawing import Drawing
from parakin.shapes import Bar, FloatArray, IntArray, mesh

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PolyCollection

_LIGHT = np.array([0.35, 0.55, 0.75])  # right, up, towards the eye
_AMBIENT = 0.45
_ROOM = 0.62  # of the span, from the middle to the edges of the picture


@dataclass(frozen=True)
class Painter:
    """A drawing's triangles, ready to be seen at any pose.

    Each triangle `bodies` (m,) belongs to a body, or, numbered after these, to a rod.
    """

    drawing: Drawing
    triangles: FloatArray  # (m, 3, 3), in their body's frame
    bodies: IntArray
    colours: FloatArray  # (m, 3)

    @classmethod
    def of(cls, drawing: Drawing) -> Painter:
        """The painter of a drawing."""
        triangles, bodies, colours = [], [], []
        pieces = [(p.body, p.form, drawing.colour(p)) for p in drawing.pieces]
        for k, rod in enumerate(drawing.rods):
            R, p = drawing.poses[rod.parent]
            there = drawing.world(rod.child, rod.end)[0]
            along = float(np.linalg.norm(there - (R @ rod.start + p)))
            form = Bar(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, along]]), rod.radius)
            pieces.append((len(drawing.poses) + k, form, (150, 158, 168)))
        for body, form, colour in pieces:
            solid = mesh(form)
            triangles.append(solid.vertices[solid.faces])
            bodies.append(np.full(len(solid.faces), body))
            colours.append(np.tile(np.array(colour) / 255, (len(solid.faces), 1)))
        return cls(
            drawing, np.concatenate(triangles), np.concatenate(bodies), np.concatenate(colours)
        )

    def frame(self) -> FloatArray:
        """The picture's axes as rows: right, up, and towards the eye."""
        eye = self.drawing.view.eye
        right = np.cross(self.drawing.view.up, eye)
        right /= np.linalg.norm(right)
        return np.array([right, np.cross(eye, right), eye])

    def polygons(self, R: FloatArray, p: FloatArray) -> tuple[FloatArray, FloatArray]:
        """What is seen with bodies at R (bodies, 3, 3) and p (bodies, 3): triangles (m, 3, 2) in
        the picture, farthest first, and their colours (m, 3).
        """
        starts = [R[rod.parent] @ rod.start + p[rod.parent] for rod in self.drawing.rods]
        ends = [R[rod.child] @ rod.end + p[rod.child] for rod in self.drawing.rods]
        turned = [_towards(b - a) for a, b in zip(starts, ends, strict=True)]
        R, p = np.array([*R, *turned]), np.array([*p, *starts])
        seen = self.frame()
        R, p = seen @ R, (p - self.drawing.view.middle) @ seen.T
        corners = (
            np.einsum("mij,mkj->mki", R[self.bodies], self.triangles) + p[self.bodies][:, None]
        )
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        facing = normals[:, 2] > 0
        corners, normals, colours = corners[facing], normals[facing], self.colours[facing]
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        light = _LIGHT / np.linalg.norm(_LIGHT)
        shade = _AMBIENT + (1 - _AMBIENT) * np.clip(normals @ light, 0, 1)
        order = np.argsort(corners[:, :, 2].mean(axis=1), kind="stable")
        return corners[order, :, :2], np.clip(colours * shade[:, None] * 1.1, 0, 1)[order]

    def paint(self, axes: Axes, R: FloatArray, p: FloatArray) -> PolyCollection:
        """Paint bodies at R (bodies, 3, 3) and p (bodies, 3) into empty axes."""
        from matplotlib.collections import PolyCollection

        polygons, colours = self.polygons(R, p)
        painted = PolyCollection(
            list(polygons), facecolors=colours, edgecolors=colours, linewidths=0.3
        )
        axes.add_collection(painted)
        room = _ROOM * self.drawing.view.span
        axes.set(xlim=(-room, room), ylim=(-room, room), aspect="equal")
        axes.set_axis_off()
        return painted


def _towards(along: FloatArray) -> FloatArray:
    """A rotation whose z axis has a direction."""
    from parakin.shapes import perpendicular

    z = along / np.linalg.norm(along)
    x = perpendicular(z)
    return np.column_stack([x, np.cross(z, x), z])
