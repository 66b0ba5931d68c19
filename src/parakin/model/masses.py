"""Masses in numbers: of what a body weighs, where its centre of mass is, and its inertia tensor."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from parakin.algebra.spatial import ZERO, Matrix, Vector, cross, dot, matrix
from parakin.arrays import FloatArray
from parakin.errors import InputError
from parakin.model.bodies import (
    AnySolid,
    Body,
    Box,
    Cone,
    Inertia,
    Point,
    Sphere,
    Tube,
)
from parakin.model.expressions import Parameters
from parakin.model.fields import Quantity
from parakin.model.placement import about, evaluated, placement_of, unit
from parakin.model.units import DENSITY, INERTIA, LENGTH, MASS, Dimension

NOTHING: Matrix[float] = matrix([[0.0] * 3] * 3)
_ROUNDING = 1e-9  # of the largest moment: what an inertia may miss the triangle inequality by


class Mass(NamedTuple):
    """A rigid body's mass [kg], the centre of it in the body's frame [m], and the inertia tensor
    about that centre along the body's axes [kg m²].
    """

    mass: float
    com: Vector[float] = ZERO
    inertia: Matrix[float] = NOTHING


def mass_of(body: Body, parameters: Parameters, place: str) -> Mass | None:
    """What a body weighs, if its tables say so.

    Raises InputError on values that cannot be, on more than one of mass, solid and mesh density,
    and on a mesh that was not read.
    """
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            mass = _told(body, parameters, place)
    except (OverflowError, np.linalg.LinAlgError):
        mass = Mass(math.inf)
    if mass is not None and not np.isfinite([mass.mass, *mass.com, *np.ravel(mass.inertia)]).all():
        found = "sizes of which mass or inertia is beyond all numbers"
        raise InputError(place, found, "smaller ones; lengths are in m, unless they have a unit")
    return mass


def _told(body: Body, parameters: Parameters, place: str) -> Mass | None:
    dense = body.mesh is not None and body.mesh.density is not None
    stated = [key for key in ("mass", "solid") if getattr(body, key) not in (None, ())]
    told = [*stated, *(["mesh.density"] if dense else [])]
    if len(told) > 1:
        raise InputError(place, " and ".join(told), "one of mass, solid and mesh.density")
    for key in ("com", "inertia"):
        if getattr(body, key) is not None and told != ["mass"]:
            raise InputError(f"{place}.{key}", f"{key} without a mass", "a mass beside it")
    if told == ["mass"]:
        return _stated(body, parameters, place)
    if told == ["solid"]:
        places = [f"{place}.solid[{k}]" for k in range(len(body.solid))]
        if len(places) == 1:
            places = [f"{place}.solid"]
        solids = zip(body.solid, places, strict=True)
        return combined([_solid(solid, parameters, where) for solid, where in solids])
    return _of_mesh(body, parameters, f"{place}.mesh") if dense else None


def _stated(body: Body, parameters: Parameters, place: str) -> Mass:
    assert body.mass is not None
    mass = amount(body.mass, parameters, MASS, f"{place}.mass")
    com = evaluated(body.com or (0.0, 0.0, 0.0), parameters, f"{place}.com", LENGTH)
    if body.inertia is None:
        return Mass(mass, com)
    tensor = tensor_of(body.inertia, parameters, f"{place}.inertia")
    if mass == 0.0 and any(any(row) for row in tensor):
        raise InputError(f"{place}.inertia", "an inertia of no mass", "a mass above zero")
    return Mass(mass, com, tensor)


def amount(text: Quantity, parameters: Parameters, dimension: Dimension, place: str) -> float:
    """A value that must not be negative. Raises InputError."""
    value = parameters.evaluate(text, dimension, place)
    if not value >= 0.0:
        raise InputError(place, f"{value:g}", "zero or more")
    return value


def _size(text: Quantity, parameters: Parameters, place: str) -> float:
    value = parameters.evaluate(text, LENGTH, place)
    if not value > 0.0:
        raise InputError(place, f"{value:g} m", "a length above zero")
    return value


def tensor_of(
    inertia: tuple[Quantity, Quantity, Quantity] | Inertia, parameters: Parameters, place: str
) -> Matrix[float]:
    """An inertia tensor along the body's axes. Raises InputError where no body could have it: its
    principal moments must be positive, and none greater than the sum of the others.
    """
    if isinstance(inertia, tuple):
        a, b, c = evaluated(inertia, parameters, place, INERTIA)
        tensor = matrix([[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]])
    else:
        xx, yy, zz, xy, xz, yz = (
            parameters.evaluate(getattr(inertia, key), INERTIA, f"{place}.{key}")
            for key in ("xx", "yy", "zz", "xy", "xz", "yz")
        )
        tensor = matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        frame = placement_of(inertia.on_body, parameters, f"{place}.on_body")
        if any(frame.p):
            raise InputError(f"{place}.on_body.at", f"{list(frame.p)}", "axes alone: no `at`")
        tensor = frame.R @ tensor @ frame.R.T
    check_possible(tensor, place)
    return tensor


def check_possible(tensor: Matrix[float], place: str) -> None:
    """Raises InputError on an inertia tensor that no body could have."""
    moments = np.linalg.eigvalsh(np.array(tensor))
    shown = ", ".join(f"{moment:.6g}" for moment in moments)
    slack = _ROUNDING * abs(moments[-1])
    if not moments[0] >= -slack:
        expected = "none below zero"
        raise InputError(place, f"principal moments {shown} kg m²", expected)
    if not moments[2] <= moments[0] + moments[1] + slack:
        expected = "none greater than the sum of the others (the triangle inequality)"
        raise InputError(place, f"principal moments {shown} kg m²", expected)


def combined(masses: Iterable[Mass]) -> Mass:
    """Several rigidly joined (Huygens and Steiner)."""
    parts = list(masses)
    total = sum(part.mass for part in parts)
    if total == 0.0:
        return Mass(0.0)
    com = sum((np.array(part.com) * part.mass for part in parts), np.zeros(3)) / total
    tensor = np.zeros((3, 3))
    for part in parts:
        r = np.array(part.com) - com
        tensor += np.array(part.inertia) + part.mass * (r @ r * np.eye(3) - np.outer(r, r))
    return Mass(total, Vector(com.tolist()), matrix(tensor.tolist()))


def _solid(solid: AnySolid, parameters: Parameters, place: str) -> Mass:
    """A homogeneous solid, from its closed forms."""
    if isinstance(solid, Point):
        at = evaluated(solid.at, parameters, f"{place}.at", LENGTH)
        return Mass(amount(solid.mass, parameters, MASS, f"{place}.mass"), at)
    if isinstance(solid, Sphere):
        d = _size(solid.diameter, parameters, f"{place}.diameter")
        at = evaluated(solid.at, parameters, f"{place}.at", LENGTH)
        mass = _weighed(solid, parameters, math.pi * d**3 / 6, place)
        i = mass * d * d / 10
        return Mass(mass, at, matrix([[i, 0.0, 0.0], [0.0, i, 0.0], [0.0, 0.0, i]]))
    start = evaluated(solid.from_, parameters, f"{place}.from", LENGTH)
    end = evaluated(solid.to, parameters, f"{place}.to", LENGTH)
    axis = end - start
    length = math.hypot(*axis)
    z = unit(axis, f"{place}.to")
    if isinstance(solid, Box):
        w, h = (_size(getattr(solid, k), parameters, f"{place}.{k}") for k in ("width", "height"))
        mass = _weighed(solid, parameters, w * h * length, place)
        across = evaluated(solid.across, parameters, f"{place}.across", LENGTH)
        x = unit(across - z * dot(across, z), f"{place}.across")
        moments = [h * h + length**2, w * w + length**2, w * w + h * h]
        R = Matrix((x, cross(z, x), z)).T
        return _placed(mass, start + 0.5 * axis, R, [mass * i / 12 for i in moments])
    d = _size(solid.diameter, parameters, f"{place}.diameter")
    if isinstance(solid, Cone):
        return _cone(solid, parameters, start, axis, d, place)
    bore = _bore(solid.bore, parameters, d, place) if isinstance(solid, Tube) else 0.0
    mass = _weighed(solid, parameters, math.pi * (d * d - bore * bore) / 4 * length, place)
    round_ = mass * (d * d + bore * bore) / 8
    bend = round_ / 2 + mass * length**2 / 12
    return _placed(mass, start + 0.5 * axis, about(z), [bend, bend, round_])


def _bore(text: Quantity, parameters: Parameters, diameter: float, place: str) -> float:
    bore = amount(text, parameters, LENGTH, f"{place}.bore")
    if not bore < diameter:
        raise InputError(f"{place}.bore", f"{bore:g} m", f"less than the diameter, {diameter:g} m")
    return bore


def _cone(
    solid: Cone,
    parameters: Parameters,
    start: Vector[float],
    axis: Vector[float],
    diameter: float,
    place: str,
) -> Mass:
    """A frustum: integrals of powers of its radius a (1 - s) + b s over s from 0 to 1."""
    a, length = diameter / 2, math.hypot(*axis)
    b = amount(solid.diameter_to, parameters, LENGTH, f"{place}.diameter_to") / 2
    radius = np.polynomial.Polynomial([a, b - a])
    s = np.polynomial.Polynomial([0.0, 1.0])

    def integral(of: np.polynomial.Polynomial) -> float:
        return float(of.integ()(1.0))

    area = integral(radius**2)
    mass = _weighed(solid, parameters, math.pi * area * length, place)
    centre = integral(radius**2 * s) / area
    spread = integral(radius**2 * s**2) / area - centre**2
    round_ = mass * integral(radius**4) / (2 * area)
    bend = round_ / 2 + mass * length**2 * spread
    z = unit(axis, f"{place}.to")
    return _placed(mass, start + centre * axis, about(z), [bend, bend, round_])


def _placed(mass: float, com: Vector[float], R: Matrix[float], moments: list[float]) -> Mass:
    a, b, c = moments
    tensor = R @ matrix([[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]]) @ R.T
    return Mass(mass, com, _symmetric(np.array(tensor)))


def _symmetric(tensor: FloatArray) -> Matrix[float]:
    """Without what rounding left where zeros belong."""
    mean = (tensor + tensor.T) / 2
    mean[np.abs(mean) < 1e-15 * np.abs(mean).max(initial=0.0)] = 0.0
    return matrix(mean.tolist())


def _weighed(solid: AnySolid, parameters: Parameters, volume: float, place: str) -> float:
    assert not isinstance(solid, Point)
    if (solid.density is None) == (solid.mass is None):
        found = "neither density nor mass" if solid.mass is None else "both density and mass"
        raise InputError(place, found, "one of them")
    if solid.mass is not None:
        return amount(solid.mass, parameters, MASS, f"{place}.mass")
    assert solid.density is not None
    return volume * amount(solid.density, parameters, DENSITY, f"{place}.density")


def _of_mesh(body: Body, parameters: Parameters, place: str) -> Mass:
    mesh = body.mesh
    assert mesh is not None
    assert mesh.density is not None
    density = amount(mesh.density, parameters, DENSITY, f"{place}.density")
    moments = mesh.moments
    if moments is None:
        expected = "a mechanism from `parakin.load` or `compile`, which read it"
        raise InputError(f"{place}.file", "a mesh that was not read", expected)
    scale, frame = float(mesh.scale), placement_of(mesh.on_body, parameters, f"{place}.on_body")
    xx, yy, zz, xy, xz, yz = (density * abs(scale) ** 5 * i for i in moments.inertia)
    tensor = frame.R @ matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ frame.R.T
    com = frame.p + frame.R @ Vector(tuple(scale * x for x in moments.centroid))
    return Mass(density * abs(scale) ** 3 * moments.volume, com, _symmetric(np.array(tensor)))
