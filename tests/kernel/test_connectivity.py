"""The matrix conditions of connectivity against the textbook's four-bar."""

from __future__ import annotations

import math

import pytest

import parakin
from parakin.algebra.spatial import FLOATS, as_float
from parakin.kernel.connectivity import (
    System,
    jacobian,
    signed_square,
    solve_blocks,
    unsolved_volume,
)
from parakin.kinematics.configuration import circuits_at
from parakin.kinematics.recursion import Circuits
from parakin.planning.plan import Plan


def four_bar(rate: float) -> tuple[Plan, Circuits]:
    plan = parakin.compile("four-bar", machine_code=False).plan
    circuits = circuits_at(plan.graph, plan.tree, plan.home)
    circuits.rates |= dict.fromkeys([*plan.affine, *plan.unknowns], 0.0)
    circuits.rates[plan.driven[0]] = rate
    return plan, circuits


def test_velocities_are_those_of_the_textbook() -> None:
    """Norton, Design of Machinery, eq. 6.18: w3 and w4 from the angles of the links."""
    rate = 1.7
    plan, circuits = four_bar(rate)
    systems = [System.of(circuits, block) for block in plan.blocks]
    drifts = [system.rates(circuits) for system in systems]
    found, _ = solve_blocks(plan, systems, drifts, FLOATS)
    at = {c.name: float(plan.home[k]) for k, c in enumerate(plan.graph.coordinates)}
    rates = {plan.graph.coordinates[k].name: as_float(value) for k, value in found.items()}
    a, b, c = 0.04, 0.12, 0.08
    crank, coupler, rocker = at["A"], at["A"] + at["B"], at["D"]
    w3 = rate * a / b * math.sin(rocker - crank) / math.sin(coupler - rocker)
    w4 = rate * a / c * math.sin(crank - coupler) / math.sin(rocker - coupler)
    for name, expected in {"B": w3 - rate, "D": w4}.items():
        if name in rates:
            assert rates[name] == pytest.approx(expected, rel=1e-12)
    assert rates


def test_a_blocks_own_columns_are_its_jacobian() -> None:
    plan, circuits = four_bar(0.0)
    for block in plan.blocks:
        system = System.of(circuits, block)
        assert system.jacobian == jacobian(circuits, block)
        assert all(set(columns) <= set(block.needs) for columns in system.coupling)


@pytest.mark.parametrize(("a", "square"), [(3.0, 9.0), (-2.0, -4.0), (0.0, 0.0)])
def test_a_signed_square(a: float, square: float) -> None:
    assert signed_square(a, FLOATS) == square


def test_coordinates_that_are_not_solved_for_are_held_where_the_loop_is_regular() -> None:
    """A parallelogram's rocker turns with its crank, and is not solved for; flat, it might not."""
    sides = {"a": 0.08, "b": 0.1, "c": 0.08, "d": 0.1}
    mechanism = parakin.load("four-bar", sides)
    mechanism = mechanism.model_copy(update={"guess": {"B": "-40 deg", "D": "40 deg"}})
    plan = parakin.compile(mechanism, machine_code=False).plan
    assert plan.unsolved
    volumes = []
    for crank in (float(plan.home[plan.driven[0]]), 1e-3):
        q = plan.home.copy()
        for k, rule in plan.affine.items():
            q[k] = rule.constant + sum(factor * crank for _, factor in rule.factors)
        circuits = circuits_at(plan.graph, plan.tree, q)
        volumes.append(as_float(unsolved_volume(plan, circuits, FLOATS)))
    assert volumes[0] > 1e4 * volumes[1] > 0.0
