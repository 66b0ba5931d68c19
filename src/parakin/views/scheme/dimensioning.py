"""Dimensions of a mechanism: its parameters with units, and the lengths they are in a drawing."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import NamedTuple

import numpy as np

from parakin.arrays import FloatArray
from parakin.errors import InputError
from parakin.model.evaluation import graph_of
from parakin.model.expressions import Parameters
from parakin.model.graph import Graph
from parakin.model.mechanism import Mechanism
from parakin.model.units import ANGLE, LENGTH
from parakin.views.solids.drawing import Drawing
from parakin.views.units import DEGREES, MILLIMETRES

_STEP = 1.0 / 64.0  # relative change of a parameter, to see which lengths follow
_EQUAL = 1e-9


class Length(NamedTuple):
    """A parameter's length between two points (3,), at home."""

    name: str
    start: FloatArray
    end: FloatArray


class Parameter(NamedTuple):
    """A parameter: its value with a unit, and the text in the file."""

    name: str
    value: str
    as_given: str


def parameters(mechanism: Mechanism) -> list[Parameter]:
    """The mechanism's parameters in millimetres and degrees; plain numbers without a unit."""
    known = Parameters(mechanism.parameters, mechanism.where)
    rows = []
    for name, value in known.all().items():
        dimension = known.dimension(name)
        shown = f"{value:z.6g}"
        if dimension == LENGTH:
            shown = MILLIMETRES.typeset(value, ".6g")
        elif dimension == ANGLE:
            shown = DEGREES.typeset(value, ".6g")
        rows.append(Parameter(name, shown, str(mechanism.parameters[name])))
    return rows


def lengths(drawing: Drawing) -> dict[str, list[Length]]:
    """By parameter, the pairs of points that it is the distance of: on one body, or the ends of a
    rod.

    The distance must also follow when the parameter changes, lest it be equal by chance.
    """
    graph = drawing.arrangement.graph
    pairs = list(_pairs(graph))
    apart = np.array([_distance(graph, pair) for pair in pairs])
    found: dict[str, list[Length]] = {}
    for name, value in graph.parameters.items():
        equal = np.flatnonzero(np.abs(apart - value) <= _EQUAL * graph.length)
        if not value > _EQUAL * graph.length or not len(equal):
            continue
        try:
            other = graph_of(graph.mechanism.with_parameters({name: (1 + _STEP) * value}))
        except InputError:  # the changed value contradicts another part of the file
            continue
        follows = [
            pairs[i]
            for i in equal
            if abs(_distance(other, pairs[i]) - (1 + _STEP) * value) <= _EQUAL * graph.length
        ]
        if follows:
            found[name] = [
                Length(
                    name, *(drawing.arrangement.world(p.body, _place(graph, p))[0] for p in pair)
                )
                for pair in follows
            ]
    return found


class _Place(NamedTuple):
    """The place of a joint or of a named point on a body or, with neither, its origin."""

    body: int
    joint: int | None = None
    point: str = ""


def _pairs(graph: Graph) -> Iterator[tuple[_Place, _Place]]:
    for body in range(len(graph.bodies)):
        places = [
            _Place(body, joint=k)
            for k, j in enumerate(graph.joints)
            if body in (j.parent, j.child) and not (j.name == "platform" and body == 0)
        ]
        places += [_Place(body, point=p) for p, (of, _) in graph.points.items() if of == body]
        yield from combinations([_Place(body), *places], 2)
    for k, joint in enumerate(graph.joints):
        if joint.kind == "rod":
            yield _Place(joint.parent, joint=k), _Place(joint.child, joint=k)


def _place(graph: Graph, place: _Place) -> FloatArray:
    if place.joint is not None:
        joint = graph.joints[place.joint]
        return np.array((joint.F if joint.parent == place.body else joint.M).p, dtype=float)
    return np.array(graph.points[place.point][1] if place.point else np.zeros(3), dtype=float)


def _distance(graph: Graph, pair: tuple[_Place, _Place]) -> float:
    a, b = pair
    if a.body != b.body:  # the ends of a rod
        assert a.joint is not None
        return graph.joints[a.joint].length
    return float(np.linalg.norm(_place(graph, a) - _place(graph, b)))
