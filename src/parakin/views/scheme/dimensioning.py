"""Dimensions of a mechanism: its parameters with units, and which lengths they are in a drawing."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations
from typing import NamedTuple

import numpy as np

from parakin.arrays import FloatArray
from parakin.errors import InputError
from parakin.model.evaluation import graph_of
from parakin.model.expressions import ANGLE, LENGTH, Parameters
from parakin.model.graph import Graph
from parakin.model.mechanism import Mechanism
from parakin.views.solids.drawing import Drawing

_STEP = 1.0 / 64.0  # relative: by how much a parameter is changed to see which lengths follow
_EQUAL = 1e-9


class Length(NamedTuple):
    """A parameter's length between two places (3,), at home."""

    name: str
    start: FloatArray
    end: FloatArray


class Parameter(NamedTuple):
    """A parameter as it is told: its value with a unit, and what its file says."""

    name: str
    value: str
    said: str


def parameters(mechanism: Mechanism) -> list[Parameter]:
    """The mechanism's parameters in millimetres and degrees; bare numbers as they are."""
    known = Parameters(mechanism.parameters, mechanism.where)
    told = []
    for name, value in known.all().items():
        dimension = known.dimension(name)
        shown = f"{value:z.6g}"
        if dimension == LENGTH:
            shown = f"{1e3 * value:z.6g} mm"
        elif dimension == ANGLE:
            shown = f"{math.degrees(value):z.6g}°"
        told.append(Parameter(name, shown, str(mechanism.parameters[name])))
    return told


def lengths(drawing: Drawing) -> dict[str, list[Length]]:
    """By parameter, the pairs of places on one body, or the ends of a rod, that are apart by it.

    A pair counts whose distance also follows a change of the parameter: others are equal by
    chance.
    """
    graph = drawing.layout.graph
    pairs = list(_pairs(graph))
    apart = np.array([_distance(graph, pair) for pair in pairs])
    found: dict[str, list[Length]] = {}
    for name, value in graph.parameters.items():
        equal = np.flatnonzero(np.abs(apart - value) <= _EQUAL * graph.length)
        if not value > _EQUAL * graph.length or not len(equal):
            continue
        try:
            other = graph_of(graph.mechanism.with_parameters({name: (1 + _STEP) * value}))
        except InputError:  # too long for another part of the file
            continue
        follows = [
            pairs[i]
            for i in equal
            if abs(_distance(other, pairs[i]) - (1 + _STEP) * value) <= _EQUAL * graph.length
        ]
        if follows:
            found[name] = [
                Length(name, *(drawing.layout.world(p.body, _place(graph, p))[0] for p in pair))
                for pair in follows
            ]
    return found


class _Place(NamedTuple):
    """Of a joint's frame, of a named point or, with neither, the origin, on a body."""

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
