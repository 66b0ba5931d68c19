"""Closure rows of every kind, and their formulas against automatic differentiation of their value.

What is differentiated is positions alone, on jets of 40 digits or on dual numbers: it knows
nothing of twists, arms, or which terms vanish on a closed loop.
"""

from __future__ import annotations

from itertools import chain

import numpy as np
import pytest
from closed_form import MP, Jet, jet
from jets import jet_functions
from loops_of_every_kind import KINDS, closed, differentiated, opened

from parakin.algebra.dual import rate_of
from parakin.algebra.spatial import as_array, as_float
from parakin.arrays import FloatArray
from parakin.kinematics import loops
from parakin.kinematics.closure import (
    CentreDistance,
    Gap,
    Perpendicular,
    RodLength,
    Row,
    candidate_rows,
    canonical_rows,
    cosines,
)
from parakin.kinematics.recursion import Circuits, Turn

ROWS = {  # six less the joint's freedom, after Grübler
    "revolute": 5,
    "prismatic": 5,
    "cylindrical": 4,
    "universal": 4,
    "spherical": 3,
    "planar": 3,
    "fixed": 6,
    "rod": 1,
}


def rows_of(circuits: Circuits, cut: int) -> list[Row]:
    return candidate_rows(circuits.graph, cut, list(loops.sides(circuits, cut)))


def jets(circuits: Circuits) -> Circuits:
    """The same motion as positions over time, in 40 digits."""
    functions = jet_functions()
    turns = {}
    for k, at in circuits.turns.items():
        value = float(as_float(at.amount))
        motion = Jet(*(MP.mpf(a) for a in (value, circuits.rates[k], circuits.second[k])))
        angle = circuits.graph.coordinates[k].angle
        turns[k] = Turn(
            motion,
            functions.cos(motion) if angle else 1.0,
            functions.sin(motion) if angle else 0.0,
        )
    other = Circuits(circuits.graph, circuits.graph.tree_of(kept(circuits)))
    other.turns |= turns
    return other


def kept(circuits: Circuits) -> list[int]:
    names = {circuits.graph.coordinates[k].joint for k in circuits.turns}
    return sorted(names)


@pytest.mark.parametrize("kind", KINDS)
def test_a_joint_has_as_many_rows_as_it_takes_freedoms(kind: str) -> None:
    circuits, cut = opened(kind)
    rows = canonical_rows(circuits.graph.joints[cut], cut)
    assert len(rows) == ROWS[kind]
    assert all(row.cut == cut for row in rows)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_rows_vanish_where_the_joint_closes_the_loop(kind: str, seed: int) -> None:
    circuits, cut = closed(kind, seed)
    end = loops.ends(circuits, cut)
    for row in rows_of(circuits, cut):
        assert abs(as_float(row.value(circuits, end))) < 1e-14, row
    for cosine in cosines(circuits, cut, end):
        assert abs(as_float(cosine) - 1.0) < 1e-14


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_derivatives_on_open_loops(kind: str, seed: int) -> None:
    circuits, cut = opened(kind, seed)
    end, sides = loops.ends(circuits, cut), loops.sides(circuits, cut)
    for row in rows_of(circuits, cut):
        for k, side in sides.items():
            there = differentiated(circuits, {k: 1.0})
            exact = as_float(rate_of(row.value(there, loops.ends(there, cut))))
            ours = as_float(row.derivative(circuits, end, k, side, open_=True))
            assert abs(ours - exact) < 1e-14, (row, k)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_derivatives_on_closed_loops_need_no_more(kind: str, seed: int) -> None:
    circuits, cut = closed(kind, seed)
    end = loops.ends(circuits, cut)
    for row in rows_of(circuits, cut):
        for k, side in loops.sides(circuits, cut).items():
            there = differentiated(circuits, {k: 1.0})
            exact = as_float(rate_of(row.value(there, loops.ends(there, cut))))
            assert abs(as_float(row.derivative(circuits, end, k, side)) - exact) < 1e-14, (row, k)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_rates_and_accelerations(kind: str, seed: int) -> None:
    """Of a motion that keeps the loop closed; rows of a rod hold for any."""
    circuits, cut = closed(kind, seed)
    end = loops.ends(circuits, cut)
    exact = jets(circuits)
    there = loops.ends(exact, cut)
    for row in rows_of(circuits, cut):
        value = jet(row.value(exact, there))
        assert abs(as_float(row.rate(circuits, end)) - float(value.rate)) < 1e-14, row
        assert abs(as_float(row.acceleration(circuits, end)) - float(value.accel)) < 1e-13, row


@pytest.mark.parametrize("kind", KINDS)
def test_a_rows_rate_is_the_power_of_its_wrench(kind: str) -> None:
    """Of any motion, at a closed loop: the wrench knows how the bodies' twists change the row."""
    circuits, cut = closed(kind)
    rng = np.random.default_rng(3)
    moving = circuits.with_coordinates(rates={k: float(rng.normal()) for k in circuits.rates})
    end = loops.ends(moving, cut)
    joint = moving.graph.joints[cut]

    def at_origin(body: int) -> FloatArray:
        w, v = moving.twist(body)
        r = as_array(moving.pose(body).p)
        return np.concatenate([as_array(w), as_array(v) - np.cross(as_array(w), r)])

    twist = at_origin(joint.child) - at_origin(joint.parent)
    axes = {**moving.axes(joint.parent), **moving.axes(joint.child)}
    rates = {k: as_float(rate) for k, rate in moving.rates.items()}
    for row in rows_of(moving, cut):
        power = as_array([*chain(*row.wrench(end, lambda k: axes[k][0]))]) @ twist
        there = differentiated(moving, rates)
        exact = as_float(rate_of(row.value(there, loops.ends(there, cut))))
        assert abs(power - exact) < 1e-13, row


def test_every_kind_of_row_has_been_tried() -> None:
    tried = {type(row) for kind in KINDS for row in rows_of(*opened(kind))}
    assert tried == {Gap, CentreDistance, RodLength, Perpendicular}
