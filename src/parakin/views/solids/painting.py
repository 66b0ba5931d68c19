"""Pictures of a mechanism by matplotlib: its solids, shaded, the farthest first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from parakin.arrays import FloatArray, IntArray
from parakin.views.solids.drawing import Drawing
from parakin.views.solids.shapes import Bar, Form, Plate, mesh, perpendicular

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

_LIGHT = np.array([0.35, 0.55, 0.75])  # right, up, towards the eye
_AMBIENT = 0.45
_SIDES = 12  # of round solids: fewer than in a scene that one can zoom into
_MARGIN = 0.04  # of the width or height
_LONG = 1 / 12  # of the size: longer triangles cannot be sorted by their centres


@dataclass(frozen=True)
class Painter:
    """A drawing's triangles, ready to be painted at any pose.

    `bodies` (m,): the body of each triangle; rods are numbered after the bodies.
    """

    drawing: Drawing
    triangles: FloatArray  # (m, 3, 3), in their body's frame
    bodies: IntArray
    colours: FloatArray  # (m, 3)
    behind: FloatArray  # (m,) [m], added to the depth that triangles are sorted by

    @classmethod
    def of(cls, drawing: Drawing) -> Painter:
        """The painter of a drawing."""
        triangles, bodies, colours, behind = [], [], [], []
        # By the centres of triangles alone, a piston would show through its tube, and a plate
        # would cover parts of what lies in it.
        plates = {id(p.form): 3.0 for p in drawing.pieces if isinstance(p.form, Plate)}
        farther = plates | {id(p.form): 2.0 for p in drawing.pieces if p.part == "piston"}
        pieces: list[tuple[int, Form, tuple[int, int, int]]] = [
            (p.body, p.form, drawing.colour(p)) for p in drawing.pieces
        ]
        for k, rod in enumerate(drawing.rods):
            R, p = drawing.arrangement.poses[rod.parent]
            there = drawing.arrangement.world(rod.child, rod.end)[0]
            along = float(np.linalg.norm(there - (R @ rod.start + p)))
            bar = Bar(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, along]]), rod.radius)
            pieces.append((len(drawing.arrangement.poses) + k, bar, (150, 158, 168)))
        for body, form, colour in pieces:
            solid = mesh(form, _SIDES)
            small = _divided(solid.vertices[solid.faces], _LONG * drawing.arrangement.size)
            triangles.append(small)
            bodies.append(np.full(len(small), body))
            behind.append(
                np.full(len(small), drawing.arrangement.radius * farther.get(id(form), 0.0))
            )
            colours.append(np.tile(np.array(colour) / 255, (len(small), 1)))
        return cls(
            drawing,
            np.concatenate(triangles),
            np.concatenate(bodies),
            np.concatenate(colours),
            np.concatenate(behind),
        )

    def frame(self) -> FloatArray:
        """The picture's axes as rows: right, up, and towards the eye."""
        eye = self.drawing.view.eye
        right = np.cross(self.drawing.view.up, eye)
        right /= np.linalg.norm(right)
        return np.array([right, np.cross(eye, right), eye])

    def corners(self, R: FloatArray, p: FloatArray) -> FloatArray:
        """The triangles (m, 3, 3), in the picture's axes from the middle of the view."""
        starts = [R[rod.parent] @ rod.start + p[rod.parent] for rod in self.drawing.rods]
        ends = [R[rod.child] @ rod.end + p[rod.child] for rod in self.drawing.rods]
        turned = [_towards(b - a) for a, b in zip(starts, ends, strict=True)]
        R, p = np.array([*R, *turned]), np.array([*p, *starts])
        seen = self.frame()
        R, p = seen @ R, (p - self.drawing.view.middle) @ seen.T
        turned_triangles = np.einsum("mij,mkj->mki", R[self.bodies], self.triangles)
        return np.asarray(turned_triangles + p[self.bodies][:, None])

    def seen(self, places: FloatArray) -> FloatArray:
        """Points in the world (n, 3), in the picture (n, 2)."""
        return np.asarray((places - self.drawing.view.middle) @ self.frame()[:2].T)

    def window(self, R: FloatArray, p: FloatArray) -> FloatArray:
        """The bounds over poses (n, bodies, ...): left, right, bottom and top, with a margin."""
        seen = [self.corners(*pose)[:, :, :2].reshape(-1, 2) for pose in zip(R, p, strict=True)]
        low = np.min([corners.min(axis=0) for corners in seen], axis=0)
        high = np.max([corners.max(axis=0) for corners in seen], axis=0)
        margin = _MARGIN * (high - low).max()
        return np.column_stack([low - margin, high + margin]).ravel()

    def polygons(self, R: FloatArray, p: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The visible triangles (m, 3, 2) with bodies at R (bodies, 3, 3) and p (bodies, 3),
        farthest first, and their colours (m, 3).
        """
        corners = self.corners(R, p)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        facing = normals[:, 2] > 0
        corners, normals, colours = corners[facing], normals[facing], self.colours[facing]
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        light = _LIGHT / np.linalg.norm(_LIGHT)
        shade = _AMBIENT + (1 - _AMBIENT) * np.clip(normals @ light, 0, 1)
        depth = corners[:, :, 2].mean(axis=1) - self.behind[facing]
        order = np.argsort(depth, kind="stable")
        return corners[order, :, :2], np.clip(colours * shade[:, None] * 1.1, 0, 1)[order]

    def paint(self, axes: Axes, R: FloatArray, p: FloatArray) -> PolyCollection:
        """Paint bodies at R (bodies, 3, 3) and p (bodies, 3) into empty axes."""
        from matplotlib.collections import PolyCollection

        polygons, colours = self.polygons(R, p)
        painted = PolyCollection(
            list(polygons), facecolors=colours, edgecolors=colours, linewidths=0.5
        )
        axes.add_collection(painted)
        left, right, bottom, top = self.window(R[None], p[None])
        axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
        axes.set_axis_off()
        return painted


def picture(drawing: Drawing) -> Figure:
    """A figure of a mechanism at home."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5, 5), layout="constrained")
    R = np.array([pose[0] for pose in drawing.arrangement.poses])
    p = np.array([pose[1] for pose in drawing.arrangement.poses])
    Painter.of(drawing).paint(figure.subplots(), R, p)
    return figure


def _divided(triangles: FloatArray, longest: float) -> FloatArray:
    """Triangles (m, 3, 3) halved across their longest edges until none is longer than `longest`."""
    done = []
    while len(triangles):
        edges = np.linalg.norm(np.roll(triangles, -1, axis=1) - triangles, axis=2)
        long = edges.max(axis=1) > longest
        done.append(triangles[~long])
        first = edges[long].argmax(axis=1)[:, None]
        turned = np.take_along_axis(triangles[long], ((first + np.arange(3)) % 3)[:, :, None], 1)
        a, b, c = turned.transpose(1, 0, 2)
        middle = (a + b) / 2
        triangles = np.concatenate([np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)])
    return np.concatenate(done)


def _towards(along: FloatArray) -> FloatArray:
    """A rotation whose z axis has a direction."""
    z = along / np.linalg.norm(along)
    x = perpendicular(z)
    return np.column_stack([x, np.cross(z, x), z])
