"""Frames on bodies, in numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from parakin.algebra import spatial
from parakin.algebra.spatial import IDENTITY, ZERO, Matrix, Vector
from parakin.errors import InputError
from parakin.model.expressions import ANGLE, LENGTH, Dimension, Parameters
from parakin.model.mechanism import Frame

AXES = {"x": 0, "y": 1, "z": 2}
_ZERO = 1e-12  # an axis must be longer
_PARALLEL = 1 - 1e-9  # cosine of the angle between axes that count as parallel
_ROUNDING = 4e-16


@dataclass(frozen=True)
class Placement:
    """A frame on a body: its axes (columns of `R`) and origin `p` [m] in body components."""

    R: Matrix
    p: Vector


HERE = Placement(IDENTITY, ZERO)


def then(a: Placement, b: Placement) -> Placement:
    """The frame `b`, which is given in the frame `a`, where `a` is given."""
    return Placement(spatial.compose(a.R, b.R), spatial.plus(a.p, spatial.apply(a.R, b.p)))


def inverse(a: Placement) -> Placement:
    """The frame in which `a` is given, given in `a`."""
    R = spatial.transpose(a.R)
    return Placement(R, spatial.minus(ZERO, spatial.apply(R, a.p)))


def vector(values: Iterable[float]) -> Vector:
    """Three numbers of any kind as floats."""
    a, b, c = (float(value) for value in values)
    return (a, b, c)


def about(axis: Vector) -> Matrix:
    """The axes of a frame with z along a unit vector, x and y any two that fit."""
    k = min(range(3), key=lambda k: abs(axis[k]))
    x = [-axis[k] * a for a in axis]
    x[k] += 1.0
    size = spatial.dot(vector(x), vector(x)) ** 0.5
    x_axis = vector(a / size for a in x)
    return spatial.transpose((x_axis, spatial.cross(axis, x_axis), axis))


def unit(a: Vector, place: str) -> Vector:
    """`a` scaled to length one. Raises InputError, naming `place`, if it is zero."""
    norm = math.hypot(*a)
    if not norm > _ZERO:
        raise InputError(place, f"the axis {list(a)}", "an axis that is not zero")
    return (a[0] / norm, a[1] / norm, a[2] / norm)


def snapped(m: Matrix) -> Matrix:
    """`m` with entries within rounding of 0 and ±1 exact, so that the recursion can drop them."""

    def entry(a: float) -> float:
        near = float(round(a))
        return near + 0.0 if abs(a - near) < _ROUNDING else a

    rows = [tuple(entry(a) for a in row) for row in m]
    return (rows[0], rows[1], rows[2])  # type: ignore[return-value]


def placement_of(frame: Frame, parameters: Parameters, place: str) -> Placement:
    """A frame in numbers: z along its `axis`, x as close to the given one as z allows.

    Raises InputError on expressions that fail, and on axes that are zero or parallel.
    """
    p = evaluated(frame.at, parameters, f"{place}.at", LENGTH)
    if frame.axis is None and frame.x is None:
        R = IDENTITY
        for number, (axis, angle) in enumerate(frame.turns):
            q = parameters.evaluate(angle, ANGLE, f"{place}.turns[{number}]")
            R = spatial.turned(R, AXES[axis], math.cos(q), math.sin(q))
        return Placement(snapped(R), p)
    if frame.turns:
        raise InputError(f"{place}.turns", "both turns and an axis", "one of them")
    along = frame.axis if frame.axis is not None else (0.0, 0.0, 1.0)
    z = unit(evaluated(along, parameters, f"{place}.axis", LENGTH), f"{place}.axis")
    if frame.x is not None:
        x = unit(evaluated(frame.x, parameters, f"{place}.x", LENGTH), f"{place}.x")
        if abs(spatial.dot(x, z)) > _PARALLEL:
            raise InputError(f"{place}.x", f"{list(frame.x)} along the axis", "another direction")
    else:
        x = (1.0, 0.0, 0.0) if abs(z[0]) < _PARALLEL else (0.0, 1.0, 0.0)
    x = unit(spatial.minus(x, spatial.times(spatial.dot(x, z), z)), f"{place}.x")
    y = spatial.cross(z, x)
    return Placement(snapped(spatial.transpose((x, y, z))), p)


def evaluated(
    triple: Sequence[float | int | str], parameters: Parameters, place: str, dimension: Dimension
) -> Vector:
    """Three expressions in numbers. Raises InputError on one that fails."""
    a, b, c = (
        parameters.evaluate(value, dimension, f"{place}[{k}]") for k, value in enumerate(triple)
    )
    return (a, b, c)
