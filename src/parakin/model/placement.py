"""Frames on bodies, in numbers: a pose X_BF each."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from parakin.algebra.spatial import IDENTITY, Matrix, Pose, S, Vector, cross, dot, matrix, turned
from parakin.algebra.varied import as_number, cos, hypot, sin
from parakin.errors import InputError
from parakin.model.bodies import Frame
from parakin.model.expressions import Parameters
from parakin.model.units import ANGLE, LENGTH, Dimension

AXES = {"x": 0, "y": 1, "z": 2}
_ZERO = 1e-12  # an axis must be longer
_PARALLEL = 1 - 1e-9  # cosine of the angle between axes that count as parallel
_ROUNDING = 4e-16


def vector(values: Iterable[float]) -> Vector[float]:
    """Three numbers of any kind as floats, unless they vary."""
    a, b, c = (as_number(value) for value in values)
    return Vector((a, b, c))


def about(axis: Vector[float]) -> Matrix[float]:
    """The axes of a frame with z along a unit vector, x and y any two that fit."""
    k = min(range(3), key=lambda k: abs(axis[k]))
    x = [-axis[k] * a for a in axis]
    x[k] += 1.0
    size = dot(vector(x), vector(x)) ** 0.5
    x_axis = vector(a / size for a in x)
    return Matrix((x_axis, cross(axis, x_axis), axis)).T


def unit(a: Vector[float], place: str) -> Vector[float]:
    """`a` scaled to length one. Raises InputError, naming `place`, if it is zero."""
    norm = hypot(*a)
    if not norm > _ZERO:
        raise InputError(place, f"the axis {list(a)}", "an axis that is not zero")
    return Vector((a[0] / norm, a[1] / norm, a[2] / norm))


def snapped(m: Matrix[S]) -> Matrix[S]:
    """`m` with entries within rounding of 0 and ±1 exact, so that the recursion can drop them.
    What is no plain number stays as it is.
    """

    def entry(a: S) -> S:
        if not isinstance(a, float):
            return a
        near = float(round(a))
        return near + 0.0 if abs(a - near) < _ROUNDING else a  # type: ignore[return-value]

    return matrix([entry(a) for a in row] for row in m)


def placement_of(frame: Frame, parameters: Parameters, place: str) -> Pose[float]:
    """A frame in numbers: z along its `axis`, x as close to the given one as z allows.

    Raises InputError on expressions that fail, and on axes that are zero or parallel.
    """
    p = evaluated(frame.at, parameters, f"{place}.at", LENGTH)
    if frame.axis is None and frame.x is None:
        R = IDENTITY
        for number, (axis, angle) in enumerate(frame.turns):
            q = parameters.evaluate(angle, ANGLE, f"{place}.turns[{number}]")
            R = turned(R, AXES[axis], cos(q), sin(q))
        return Pose(snapped(R), p)
    if frame.turns:
        raise InputError(f"{place}.turns", "both turns and an axis", "one of them")
    along = frame.axis if frame.axis is not None else (0.0, 0.0, 1.0)
    z = unit(evaluated(along, parameters, f"{place}.axis", LENGTH), f"{place}.axis")
    if frame.x is not None:
        x = unit(evaluated(frame.x, parameters, f"{place}.x", LENGTH), f"{place}.x")
        if abs(dot(x, z)) > _PARALLEL:
            raise InputError(f"{place}.x", f"{list(frame.x)} along the axis", "another direction")
    else:
        x = vector((1.0, 0.0, 0.0) if abs(z[0]) < _PARALLEL else (0.0, 1.0, 0.0))
    x = unit(x - z * dot(x, z), f"{place}.x")
    return Pose(snapped(Matrix((x, cross(z, x), z)).T), p)


def evaluated(
    triple: Sequence[float | int | str], parameters: Parameters, place: str, dimension: Dimension
) -> Vector[float]:
    """Three expressions in numbers. Raises InputError on one that fails."""
    a, b, c = (
        parameters.evaluate(value, dimension, f"{place}[{k}]") for k, value in enumerate(triple)
    )
    return Vector((a, b, c))
