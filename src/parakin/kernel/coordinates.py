"""Coordinates of a pose that has been solved: values and derivatives, of cut joints too."""

from __future__ import annotations

from parakin.algebra.dual import dual_functions, rate_of
from parakin.algebra.spatial import Scalar, sub
from parakin.kernel.motion import Moved
from parakin.kinematics import loops
from parakin.kinematics.cones import cone_angle
from parakin.kinematics.readings import read, read_rates
from parakin.planning.plan import Plan


def coordinate(plan: Plan, moved: Moved, name: int | str, derivatives: int) -> tuple[Scalar, ...]:
    """Value and derivatives of a coordinate, by number, or of a cone angle, by name."""
    circuits, moving, angles = moved.circuits, moved.moving, moved.angles
    graph, functions = plan.graph, angles.functions
    if isinstance(name, str):
        cone = plan.cones[name]
        found: tuple[Scalar, ...] = cone_angle(circuits, cone, functions, derivatives=derivatives)
        if derivatives > 2:
            changing = cone_angle(moving, cone, dual_functions(functions), derivatives=2)[2]
            return *found, rate_of(changing)
        return found
    if name in circuits.turns:
        value = sub(angles.value(name), plan.offset(name))
        orders = [circuits.rates, circuits.second][:derivatives]
        found = (value, *(order[name] for order in orders))
        return (*found, rate_of(moving.second[name])) if derivatives > 2 else found
    cut = graph.coordinates[name].joint
    end = loops.ends(circuits, cut)
    reading = read(circuits, cut, end, functions)
    angles.values.update(reading.slides)
    angles.found.update(reading.turns)
    value = sub(angles.value(name), plan.offset(name))
    if derivatives == 0:
        return (value,)
    rates, second = read_rates(circuits, cut, end, reading, accelerations=derivatives > 1)
    found = (value, rates[name], second.get(name, 0.0))
    if derivatives > 2:
        end = loops.ends(moving, cut)
        reading = read(moving, cut, end, dual_functions(functions))
        changing = read_rates(moving, cut, end, reading, accelerations=True)[1][name]
        return *found, rate_of(changing)
    return found
