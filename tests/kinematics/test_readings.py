"""A joint's coordinates are read off as they were put in, with their derivatives."""

from __future__ import annotations

import math

import numpy as np
import pytest
from loops_of_every_kind import KINDS, loop_of

from parakin.algebra.spatial import FLOATS, as_float
from parakin.kinematics import loops
from parakin.kinematics.configuration import circuits_at
from parakin.kinematics.readings import cone, read, read_rates
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


@pytest.mark.parametrize("seed", range(4))
def test_the_cone_angle_is_that_between_the_z_axes(seed: int) -> None:
    circuits, joint = carried("spherical", seed)

    def at(time: float) -> tuple[Circuits, loops.Ends]:
        q = np.zeros(len(circuits.graph.coordinates))
        for k, turn in circuits.turns.items():
            rate, second = as_float(circuits.rates[k]), as_float(circuits.second[k])
            q[k] = as_float(turn.amount) + time * rate + 0.5 * time**2 * second
        graph = circuits.graph
        tree = graph.tree_of([k for k in range(len(graph.joints)) if k != graph.platform])
        there = circuits_at(graph, tree, q)
        return there, loops.ends(there, joint)

    def angle(time: float) -> float:
        _, end = at(time)
        z = [np.array(pose.R, dtype=float)[:, 2] for pose in (end.X_WF, end.X_WM)]
        return math.acos(float(z[0] @ z[1]))

    found = cone(circuits, joint, loops.ends(circuits, joint), FLOATS, derivatives=2)
    h = 1e-3  # central differences of order four
    steps = [angle(k * h) for k in (-2, -1, 0, 1, 2)]
    first = (steps[0] - 8 * steps[1] + 8 * steps[3] - steps[4]) / (12 * h)
    second = (-steps[0] + 16 * steps[1] - 30 * steps[2] + 16 * steps[3] - steps[4]) / (12 * h**2)
    assert as_float(found[0]) == pytest.approx(steps[2], abs=1e-14)
    assert as_float(found[1]) == pytest.approx(first, abs=1e-9)
    assert as_float(found[2]) == pytest.approx(second, abs=1e-7)
