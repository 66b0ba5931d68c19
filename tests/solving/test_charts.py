"""Charts: plans compiled, how firmly they hold a pose, and others elsewhere."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin.kinematics.configuration import configure
from parakin.solving.atlas import Atlas
from parakin.solving.charts import Chart, also_known
from parakin.solving.grip import least_singular_value

LEGS = tuple(f"P{i}" for i in range(1, 7))


def chart_of(solver: parakin.Solver) -> Chart:
    plan = solver.plan
    outputs = solver.reported
    return Chart(plan, outputs, len(outputs.coordinates), machine_code=False)


def test_home_is_held_as_firmly_as_home() -> None:
    solver = parakin.compile("flight-simulator", coordinates="all", machine_code=False)
    chart = chart_of(solver)
    at = configure(solver.plan.graph, solver.plan.tree, solver.plan.home)
    assert chart.regularity(at) == pytest.approx(1.0)
    assert chart.digits_factor == pytest.approx(1.0)


def test_the_least_singular_value_of_a_four_bar_vanishes_in_line() -> None:
    """Driven at the rocker, where crank and coupler are in line: the crank's dead point."""
    a, b, c, d = 0.04, 0.12, 0.08, 0.1
    plan = parakin.compile("four-bar", ["D"], machine_code=False).plan
    graph, tree = plan.graph, plan.tree
    crank = float(np.arccos(((a + b) ** 2 + d**2 - c**2) / (2 * (a + b) * d)))
    rocker = float(np.arctan2((a + b) * np.sin(crank), (a + b) * np.cos(crank) - d))
    q = np.zeros(len(graph.coordinates))
    for name, value in {"A": crank, "B": 0.0, "D": rocker, "C": rocker - crank}.items():
        q[graph.index(name, "test")] = value
    dead = least_singular_value(plan, configure(graph, tree, q))
    home = least_singular_value(plan, configure(graph, tree, plan.home))
    assert dead < 1e-14 < home


def test_a_pose_that_is_no_number_is_not_held() -> None:
    solver = parakin.compile("four-bar", machine_code=False)
    chart = chart_of(solver)
    at = configure(solver.plan.graph, solver.plan.tree, solver.plan.home)
    at.q[0] = np.nan
    assert chart.regularity(at) == 0.0


def test_a_chart_made_elsewhere_gives_the_same_pose() -> None:
    solver = parakin.compile("gough-stewart", LEGS, coordinates="all", machine_code=False)
    chart = chart_of(solver)
    y = np.array([solver.home[name] for name in LEGS]) + 0.02
    tick = solver.at(y)
    there = chart.configuration(y, np.concatenate([tick.position, np.zeros(100)]))
    other = chart.replanned_at(there, there)
    assert other is not None
    assert other is not chart
    k = solver.graph.index("platform.z", "test")
    assert other.plan.home[k] == pytest.approx(tick.value("platform.z"), abs=1e-12)


def test_what_is_needed_besides_is_what_is_solved_for() -> None:
    plan = parakin.compile("gough-stewart", LEGS, machine_code=False).plan
    assert set(also_known(plan, [], plan.iterated)) >= set(plan.iterated)
    assert also_known(plan, plan.unknowns, plan.iterated) == []


def test_an_atlas_offers_home_first_and_keeps_what_served() -> None:
    solver = parakin.compile("four-bar", coordinates="all", machine_code=False)
    chart = chart_of(solver)
    atlas = Atlas(chart, chart.outputs)
    at = configure(solver.plan.graph, solver.plan.tree, solver.plan.home)
    for made in atlas.others(chart, at, at):
        assert made is not chart
        break  # it served
    assert next(iter(atlas.others(chart, at, at))) is made
    for _ in atlas.others(made, at, at):
        pass  # none serves: what is made in vain is not kept
    assert list(atlas._made) == [made]
    assert atlas.units.tolist() == [1.0]
