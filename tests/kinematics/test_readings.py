"""A joint's coordinates are read off as they were put in, with their derivatives."""

from __future__ import annotations

import math

import numpy as np
import pytest
from loops_of_every_kind import KINDS, loop_of

from parakin.algebra.spatial import FLOATS, as_float
from parakin.kinematics import loops
from parakin.kinematics.configuration import circuits_at
from parakin.kinematics.readings import read, read_rates
from parakin.kinematics.recursion import Circuits

JOINTS = [kind for kind in KINDS if kind not in ("fixed", "rod")]


def carried(kind: str, seed: int) -> tuple[Circuits, int]:
    """The joint in the tree, at any coordinates, rates and accelerations."""
    graph, _, joint = loop_of(kind)
    tree = graph.tree_of([k for k in range(len(graph.joints)) if k != graph.platform])
    rng = np.random.default_rng(seed)
    circuits = circuits_at(graph, tree, rng.uniform(-1.2, 1.2, len(graph.coordinates)))
    circuits.rates |= dict(enumerate(rng.normal(size=len(graph.coordinates)).tolist()))
    circuits.second |= dict(enumerate(rng.normal(size=len(graph.coordinates)).tolist()))
    return circuits, joint


@pytest.mark.parametrize("kind", JOINTS)
@pytest.mark.parametrize("seed", range(4))
def test_what_is_read_is_what_was_put_in(kind: str, seed: int) -> None:
    circuits, joint = carried(kind, seed)
    end = loops.ends(circuits, joint)
    reading = read(circuits, joint, end, FLOATS)
    rates, second = read_rates(circuits, joint, end, reading, accelerations=True)
    coordinates = circuits.graph.joints[joint].coordinates
    assert {*reading.slides, *reading.turns} == {*coordinates}
    for k in coordinates:
        if k in reading.slides:
            found = as_float(reading.slides[k])
        else:
            s, c = reading.turns[k]
            found = math.atan2(as_float(s), as_float(c))
        assert abs(found - as_float(circuits.turns[k].amount)) < 1e-14
        assert abs(as_float(rates[k]) - as_float(circuits.rates[k])) < 1e-13
        assert abs(as_float(second[k]) - as_float(circuits.second[k])) < 1e-12
