"""The motion of bodies and of points on them, worked out from a solved motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from parakin.algebra.spatial import ZERO, Vector
from parakin.arrays import FloatArray
from parakin.errors import InputError, nearest
from parakin.kernel.backends import Kernel, make_kernel
from parakin.kernel.outputs import Outputs
from parakin.model.graph import Graph
from parakin.motion.motion import Samples
from parakin.planning.plan import Plan
from parakin.solving import columns

Points = dict[str, tuple[int, Vector]]


def points_of(graph: Graph, bodies: bool | Sequence[str]) -> Points:
    """Body and place on it by name: of all bodies' origins, or of the bodies and points named.

    Raises InputError on unknown names.
    """
    if bodies is False:
        return {}
    mechanism = graph.mechanism
    named = [body.name for body in mechanism.bodies if body.name != mechanism.base]
    places = {name: k for k, name in enumerate(graph.bodies)}
    origins: Points = {n: (places[n], ZERO) for n in (mechanism.base, *named)}
    if bodies is True:
        return {name: origins[name] for name in named}
    known = origins | dict(graph.points)
    for name in bodies:
        if name not in known:
            raise InputError("bodies", f"unknown body or point {name!r}", nearest(name, known))
    return {name: known[name] for name in bodies}


@dataclass(frozen=True)
class Figures:
    """What the kernel knows of these points (`parakin.kernel.outputs`), from solved samples."""

    points: Points
    kernel: Kernel
    rows: int

    @classmethod
    def of(cls, plan: Plan, points: Points, *, machine_code: bool) -> Figures:
        outputs = Outputs((), derivatives=2, checks=False, points=tuple(points.values()))
        kernel = make_kernel(plan, outputs, machine_code=machine_code, steps=1)
        return cls(points, kernel, outputs.count)

    def at(self, samples: Samples, found: FloatArray, parallel: bool) -> FloatArray:
        """`POINT` figures a point, (rows, n); `found` are the iterated coordinates (m, n)."""
        driven = (samples.position, samples.velocity, samples.acceleration)
        inputs = np.concatenate([*driven, found])
        return columns.run(self.kernel, inputs, self.rows, parallel=parallel)
