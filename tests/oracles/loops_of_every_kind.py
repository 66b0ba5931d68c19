"""A loop closed by a joint of any kind: base, an arm on a universal joint, the platform."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from parakin.algebra.dual import dual
from parakin.algebra.spatial import FLOATS, as_array, as_float, mul
from parakin.arrays import FloatArray
from parakin.files.mechanism_toml import mechanism_from_table
from parakin.kinematics import loops
from parakin.kinematics.configuration import circuits_at
from parakin.kinematics.readings import read, read_rates
from parakin.kinematics.recursion import Circuits, Turn
from parakin.model.evaluation import graph_of
from parakin.model.graph import Graph, Tree

KINDS = (
    "revolute",
    "prismatic",
    "cylindrical",
    "universal",
    "spherical",
    "planar",
    "fixed",
    "rod",
)


def loop_of(kind: str) -> tuple[Graph, Tree, int]:
    """The graph, a tree that leaves the joint of this kind out, and the joint's number."""
    joint: dict[str, Any] = {
        "kind": kind,
        "parent": "arm",
        "child": "plate",
        "on_parent": {"at": [0.4, 0.1, -0.2], "turns": [["x", 0.3], ["y", -0.5]]},
        "on_child": {"at": [-0.1, 0.2, 0.3], "turns": [["z", 0.7], ["x", 0.2]]},
    }
    if kind == "rod":
        joint["length"] = 0.8
        for side in ("on_parent", "on_child"):
            joint[side] = {"at": joint[side]["at"]}
    table = {
        "name": kind,
        "bodies": {"arm": {}, "plate": {}},
        "platform": {"body": "plate"},
        "driven": ["platform.x"],
        "joints": {
            "A": {"kind": "universal", "parent": "base", "child": "arm"},
            "C": joint,
        },
    }
    graph = graph_of(mechanism_from_table(table, kind))
    cut = next(k for k, joint in enumerate(graph.joints) if joint.name == "C")
    tree = graph.tree_of([k for k in range(len(graph.joints)) if k != cut])
    assert tree.cuts == (cut,)
    return graph, tree, cut


def thrown(graph: Graph, seed: int = 0) -> FloatArray:
    """Coordinates anywhere, three angles well clear of where they are not defined."""
    return np.random.default_rng(seed).uniform(-0.9, 0.9, len(graph.coordinates))


def opened(kind: str, seed: int = 0) -> tuple[Circuits, int]:
    """The recursion at coordinates at which the loop is open."""
    graph, tree, cut = loop_of(kind)
    return circuits_at(graph, tree, thrown(graph, seed)), cut


def closed(kind: str, seed: int = 0) -> tuple[Circuits, int]:
    """The recursion where the joint closes the loop, at rates and accelerations that keep it so.

    The plate goes where the arm and the joint carry it; its own coordinates are read off there.
    (A rod is as long as it comes out, at rates that need not keep it so.)
    """
    graph, tree, cut = loop_of(kind)
    rng = np.random.default_rng(seed)
    platform = graph.platform
    assert platform is not None
    q, rates, second = (rng.uniform(-0.9, 0.9, len(graph.coordinates)) for _ in range(3))
    if kind == "rod":
        circuits = circuits_at(graph, tree, q)
        length = float(np.linalg.norm(as_array(loops.ends(circuits, cut).d)))
        joints = tuple(replace(j, length=length) if j.kind == "rod" else j for j in graph.joints)
        circuits = circuits_at(replace(graph, joints=joints), tree, q)
    else:
        carrying = circuits_at(
            graph, graph.tree_of([k for k in range(len(graph.joints)) if k != platform]), q
        )
        carrying.rates |= dict(enumerate(rates.tolist()))
        carrying.second |= dict(enumerate(second.tolist()))
        end = loops.ends(carrying, platform)
        reading = read(carrying, platform, end, FLOATS)
        found, changing = read_rates(carrying, platform, end, reading, accelerations=True)
        for k in graph.joints[platform].coordinates:
            s, c = reading.turns.get(k, (0.0, 1.0))
            q[k] = (
                as_float(reading.slides[k])
                if k in reading.slides
                else math.atan2(as_float(s), as_float(c))
            )
            rates[k], second[k] = as_float(found[k]), as_float(changing[k])
        circuits = circuits_at(graph, tree, q)
    circuits.rates |= dict(enumerate(rates.tolist()))
    circuits.second |= dict(enumerate(second.tolist()))
    return circuits, cut


def differentiated(circuits: Circuits, rates: Mapping[int, float]) -> Circuits:
    """The same circuits on dual numbers, their coordinates having these rates."""
    turns = {
        k: Turn(
            dual(turn.amount, rates.get(k, 0.0)),
            dual(turn.cosine, mul(-rates.get(k, 0.0), turn.sine)),
            dual(turn.sine, mul(rates.get(k, 0.0), turn.cosine)),
        )
        for k, turn in circuits.turns.items()
    }
    return circuits.with_coordinates(turns)
