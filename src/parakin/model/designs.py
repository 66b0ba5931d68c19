"""Designs of a mechanism: parameters left open, and its graph for any values of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, cast

import numpy as np

from parakin.algebra.spatial import Functions, Matrix, Pose, Scalar, Vector
from parakin.algebra.varied import Condition, Record, Varied, scalar_of
from parakin.arrays import FloatArray
from parakin.errors import InputError, nearest
from parakin.model.evaluation import graph_of
from parakin.model.expressions import Parameters
from parakin.model.graph import Graph
from parakin.model.joints import GraphJoint
from parakin.model.mechanism import Mechanism

_OTHERS = 3  # designs by which it is told what varies
_FROM, _TO = 0.02, 0.06  # how far a parameter differs in them, of itself
_WHERE_ZERO = 0.1  # of the largest parameter of its dimension, or of one, instead: if that is more


class Opened(NamedTuple):
    """A graph whose numbers are scalars where they depend on what is left open, and the decisions
    on the way to it, which every design has to take alike.
    """

    graph: Graph
    conditions: tuple[Condition, ...]


@dataclass(frozen=True)
class Designs:
    """A mechanism with parameters left open.

    values (m, 1 + others): of these parameters [SI], in the file's own design and in others near
    it.
    """

    mechanism: Mechanism
    names: tuple[str, ...]
    values: FloatArray

    @staticmethod
    def of(mechanism: Mechanism, names: Sequence[str]) -> Designs:
        """Raises InputError on unknown names, on repetition, and where none is given."""
        for name in names:
            if name not in mechanism.parameters:
                expected = nearest(name, mechanism.parameters)
                raise InputError("free", f"unknown parameter {name!r}", expected)
        if not names or len(set(names)) < len(names):
            found = "one twice" if names else "no parameters"
            raise InputError("free", found, "names of parameters, each once")
        parameters = Parameters(mechanism.parameters, mechanism.where)
        own = parameters.all()
        dimensions = {name: parameters.dimension(name) for name in own}
        rng = np.random.default_rng(11)
        sizes = []
        for name in names:
            alike = [abs(own[k]) for k in own if dimensions[k] == dimensions[name]]
            sizes.append(max(abs(own[name]), _WHERE_ZERO * max(alike)) or _WHERE_ZERO)
        count = (len(names), _OTHERS)
        away = rng.uniform(_FROM, _TO, count) * rng.choice([-1.0, 1.0], count)
        first = np.array([[own[name]] for name in names])
        others = first + away * np.array(sizes)[:, None]
        return Designs(mechanism, tuple(names), np.concatenate([first, others], axis=1))

    @property
    def count(self) -> int:
        """How many parameters are left open."""
        return len(self.names)

    @property
    def own(self) -> FloatArray:
        """The file's own design (m,)."""
        return self.values[:, 0]

    def graph_at(self, values: Sequence[float] | FloatArray) -> Graph:
        """One design in numbers, without what acts on it. Raises InputError where it has none."""
        return graph_of(self.mechanism, free=dict(zip(self.names, map(float, values), strict=True)))

    def opened(self, values: Sequence[Scalar], functions: Functions) -> Opened:
        """The graph for scalar values of the parameters (m,)."""
        record = Record(functions)
        free = {
            name: Varied(inside, scalar, record)
            for name, inside, scalar in zip(self.names, self.values, values, strict=True)
        }
        graph = graph_of(self.mechanism, free=free)
        return Opened(_stripped(graph), tuple(record.conditions))

    def followed(
        self,
        given: Mapping[str, FloatArray],
        functions: Functions,
        texts: Mapping[str, str] | None = None,
    ) -> list[Any]:
        """All parameters left open, from those of them that are given; the others follow from
        these as the file says. given: values (n,), or numbers; texts: expressions, in the others.
        Raises InputError on texts that cannot be evaluated, or are of another dimension.
        """
        record = Record(functions)
        free = {
            name: Varied(self.values[self.names.index(name)], cast(Scalar, value), record)
            for name, value in given.items()
        }
        texts = texts or {}
        own = Parameters(self.mechanism.parameters, self.mechanism.where)
        known = Parameters({**self.mechanism.parameters, **texts}, "", None, free)
        for name, text in texts.items():
            known.evaluate(text, own.dimension(name), f"parameters.{name}")
        return [scalar_of(known.value(name)) for name in self.names]


def alike(graph: Graph, other: Graph) -> Graph:
    """`other`, of the same joints as declared, with the twins and split joints of `graph`."""
    for number in graph.splits:
        other = other.split(number)
    for number, twin in graph.twins.items():
        other = other.recentred(number, graph.joints[twin].tail)
    return other


def _stripped(graph: Graph) -> Graph:
    """The graph with scalars instead of numbers that vary."""

    def positions(table: Mapping[int, Any]) -> dict[int, Any]:
        return {k: scalar_of(value) for k, value in table.items()}

    return replace(
        graph,
        points={name: (body, _vector(p)) for name, (body, p) in graph.points.items()},
        joints=tuple(_joint(joint) for joint in graph.joints),
        cones={name: _joint(joint) for name, joint in graph.cones.items()},
        limited=tuple(
            limit._replace(low=scalar_of(limit.low), high=scalar_of(limit.high))
            for limit in graph.limited
        ),
        home=positions(graph.home),
        stated=positions(graph.stated),
        guess=positions(graph.guess),
    )


def _joint(joint: GraphJoint) -> GraphJoint:
    return replace(
        joint,
        F=_pose(joint.F),
        M=_pose(joint.M),
        pairs=tuple(pair._replace(pitch=scalar_of(pair.pitch)) for pair in joint.pairs),
        length=scalar_of(joint.length),
    )


def _pose(X: Pose[Any]) -> Pose[Any]:
    return Pose(Matrix(_vector(row) for row in X.R), _vector(X.p))


def _vector(a: Vector[Any]) -> Vector[Any]:
    return Vector(scalar_of(x) for x in a)
