"""Assemblies from random starts close, on all roots of closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin.kernel.outputs import Outputs
from parakin.kinematics.configuration import configure
from parakin.planning.ordering import plan_of
from parakin.planning.plan import Plan
from parakin.solving.assemblies import CLOSED, assembled_from


def everywhere(name: str, driven: list[str] | None = None) -> Plan:
    """A plan that takes nothing for granted that holds on home's branch alone."""
    solver = parakin.compile(name, driven, machine_code=False)
    graph, plan = solver.graph, solver.plan
    home = configure(graph, graph.posed_tree(), plan.home[: len(graph.coordinates)])
    return plan_of(graph, plan.driven, home, own_home=plan.own_home, everywhere=True)


@pytest.mark.parametrize(
    ("name", "driven", "least"),
    [
        ("four-bar", None, 0.9),
        ("3-rrr", None, 0.25),
        ("gough-stewart", [f"P{k}" for k in range(1, 7)], 0.5),
    ],
)
def test_most_starts_close_and_the_first_is_home(
    name: str, driven: list[str] | None, least: float
) -> None:
    plan, n = everywhere(name, driven), 256
    numbers = range(len(plan.graph.coordinates))
    home = np.array([plan.home[k] - plan.offset(k) for k in numbers])
    given = np.array([home[k] for k in plan.driven])
    outputs = Outputs(tuple(numbers), derivatives=0)
    out = assembled_from(plan, given, home, outputs, np.random.default_rng(1), n)
    residual = out[outputs.residual]
    closed = residual <= CLOSED * plan.graph.length
    assert closed[0]
    assert closed.mean() >= least
    np.testing.assert_allclose(out[: len(home), 0], home, atol=1e-9)
    # What is iterated and regular is closed to rounding, and not only near.
    regular = closed & (np.abs(out[outputs.conditioning]) > 1e-3)
    assert (residual[regular] <= 1e-12 * out[outputs.size, regular]).all()
