"""What is asked: of which design, tables by driven coordinate, how near to a singularity."""

from __future__ import annotations

from collections.abc import Mapping
from typing import cast

import numpy as np

from parakin.arrays import FloatArray
from parakin.errors import InputError, nearest
from parakin.model.expressions import Parameters, Value
from parakin.model.units import ANGLE, LENGTH, Dimension
from parakin.solving.forces import is_finite
from parakin.solving.solver import Solver


def of_design(solver: Solver, parameters: Mapping[str, Value] | None) -> Solver:
    """The solver, or that of another design. Raises InputError, AssemblyError, DrivenError."""
    return solver if parameters is None else solver.with_design(parameters)


def check_table(given: object, place: str) -> None:
    """Raises InputError on what is no table."""
    if not isinstance(given, Mapping):
        raise InputError(place, repr(given), "values by the names of driven coordinates")


def check_driven(solver: Solver, name: str, place: str) -> None:
    """Raises InputError on the name of anything but a driven coordinate."""
    if name not in solver.driven:
        expected = nearest(str(name), solver.driven)
        raise InputError(place, f"{name!r}, which is not driven", expected)


def quantity(solver: Solver, value: object, dimension: Dimension, place: str) -> float:
    """A number in SI, given as one or as text with a unit. Raises InputError."""
    if isinstance(value, str):
        mechanism = solver.mechanism
        parameters = Parameters(mechanism.parameters, mechanism.where)
        return parameters.evaluate(value, dimension, place)
    if not is_finite(value):
        raise InputError(place, repr(value), "a finite number, or text with a unit")
    return float(cast(float, value))


def dimension_of(solver: Solver, name: str, order: int = 0) -> Dimension:
    """An angle's or a length's, or of its derivative."""
    return (ANGLE if solver.graph.is_angle(name) else LENGTH)._replace(time=-float(order))


def positions(
    solver: Solver,
    given: Mapping[str, Value] | None,
    place: str,
    otherwise: FloatArray,
    order: int = 0,
) -> FloatArray:
    """Driven values (k,), or their rates (order 1), those of `otherwise` where none are given.
    Raises InputError.
    """
    found = otherwise.copy()
    if given is None:
        return found
    check_table(given, place)
    for name, value in given.items():
        check_driven(solver, name, place)
        dimension = dimension_of(solver, name, order)
        found[solver.driven.index(name)] = quantity(solver, value, dimension, f"{place} of {name}")
    return found


def two_ends(solver: Solver, name: str, ends: object) -> tuple[float, float]:
    """Both ends of what is looked at of a driven coordinate. Raises InputError."""
    place, dimension = f"within of {name}", dimension_of(solver, name)
    if not isinstance(ends, (tuple, list, np.ndarray)) or len(ends) != 2:
        raise InputError(place, repr(ends), "two finite numbers")
    low, high = (quantity(solver, end, dimension, place) for end in ends)
    return low, high


def check_conditioning(least: float | None) -> None:
    """Raises InputError on a least conditioning that is none."""
    if least is not None and not (is_finite(least) and 0.0 < least < 1.0):
        raise InputError("least_conditioning", repr(least), "a number between 0 and 1")
