"""Instantaneous motions in words: what moves, and how the platform does.

Rates are those of all coordinates, slides in characteristic lengths.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from parakin.algebra.spatial import ARRAYS, IDENTITY, Matrix, Vector, as_array, turned
from parakin.arrays import FloatArray
from parakin.kinematics.recursion import Turn, turn
from parakin.model.graph import Graph

_STILL = 1e-3  # of what moves most: what rests
_PART = 0.2  # of what moves most: what is worth a name


def names(graph: Graph, numbers: Sequence[int]) -> str:
    """Names of coordinates, as a list in a sentence."""
    listed = [graph.coordinates[k].name for k in numbers]
    return listed[0] if len(listed) == 1 else f"{', '.join(listed[:-1])} and {listed[-1]}"


def moving(graph: Graph, rates: FloatArray, among: Sequence[int]) -> str:
    """Those of some coordinates that move most, the fastest first: "A and B move"."""
    sizes = np.abs(rates[list(among)])
    fast = [among[i] for i in np.argsort(-sizes, kind="stable") if sizes[i] > _PART * sizes.max()]
    return f"{names(graph, fast)} move{'s' if len(fast) == 1 else ''}"


def platform_motion(
    graph: Graph, rates: FloatArray, q: FloatArray, outputs: Sequence[int], verb: str = ""
) -> str:
    """How the platform moves, or with `verb` "cannot" how it cannot; "" where it is no output.

    Where only its point is an output, along which of the base's directions that moves; otherwise
    the axis of the instantaneous screw, in the platform's own axes, from its point.
    """
    joint = None if graph.platform is None else graph.joints[graph.platform]
    if joint is None or not set(outputs) <= set(joint.coordinates):
        return ""
    slides, turns = joint.coordinates[:3], joint.coordinates[3:]
    v = graph.length * rates[slides]
    if not set(outputs) & set(turns):
        return f"the platform {_does('move', verb)} along {_direction(v / np.linalg.norm(v))}"
    (axes,), (R,) = platform_axes(graph, q[:, None])
    w, v = R.T @ axes @ rates[turns], R.T @ v
    speed, spin = float(np.linalg.norm(v)), float(np.linalg.norm(w))
    if spin * graph.length < _STILL * speed:
        return f"the platform {_does('slide', verb)} along its own {_direction(v / speed)}"
    axis = w / spin
    through, pitch = np.cross(axis, v) / spin, float(axis @ v) / spin
    said = f"the platform {_does('turn', verb)} about its own {_direction(axis)}"
    if np.linalg.norm(through) > _STILL * graph.length:
        said += f" through ({', '.join(f'{1e3 * x:z.1f}' for x in through)}) mm of it"
    if abs(pitch) > _STILL * graph.length:
        said += f", advancing {2e3 * np.pi * pitch:.3f} mm a turn"
    return said


def platform_axes(graph: Graph, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Axes of the platform's three angles in the base, as columns, and R_WB: (n, 3, 3) each.

    q: (coordinates, n). The axes lie in a plane where the angles are not defined (gimbal lock).
    """
    joint = graph.joints[graph.platform or 0]
    R: Matrix = IDENTITY
    axes: list[Vector] = []
    for k, pair in zip(joint.coordinates[3:], joint.pairs[3:], strict=True):
        axes.append(R.column(pair.axis))
        at: Turn = turn(q[k], ARRAYS)
        R = turned(R, pair.axis, at.cosine, at.sine)

    def stacked(rows: Sequence[Vector]) -> FloatArray:
        n = q.shape[1]
        return np.array([[np.broadcast_to(as_array(x), n) for x in row] for row in rows]).transpose(
            2, 0, 1
        )

    return stacked(axes).transpose(0, 2, 1), stacked(R)


def _does(what: str, verb: str) -> str:
    return f"{verb} {what}" if verb else f"{what}s"


def _direction(axis: FloatArray) -> str:
    """A unit vector: x, y or z, or its components."""
    k = int(np.argmax(np.abs(axis)))
    if np.abs(np.delete(axis, k)).max() < _STILL:
        return "xyz"[k]
    axis = axis * np.sign(axis[k])
    return f"direction ({', '.join(f'{x:z.3f}' for x in axis)})"
