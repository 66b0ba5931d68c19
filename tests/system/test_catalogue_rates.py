"""Every catalogue entry: velocities, accelerations and jerks against automatic differentiation."""

from __future__ import annotations

import numpy as np
import pytest
from closed_form import MP, Jet, jet
from jets import jet_functions

import parakin
from parakin.kernel.outputs import Outputs
from parakin.kernel.pose import solve_pose
from parakin.model.evaluation import graph_of

NAMES = [name for name in parakin.catalogue() if name != "flight-simulator-upu"]


@pytest.mark.parametrize("name", NAMES)
def test_rates_agree_with_automatic_differentiation(name: str) -> None:
    graph = graph_of(parakin.load(name))
    every = [c.name for c in graph.coordinates]
    solver = parakin.compile(name, coordinates=every, derivatives=3, machine_code=False)
    plan = solver.plan
    motion = solver.motion(list(solver.mechanism.motions)[-1], rate=50)
    i = int(0.37 * motion.count)
    result = parakin.require_solved(solver.solve(motion)).isel(time=i)
    driven = [order[:, 0] for order in motion.window(i, i + 1).orders]
    place = dict(zip(motion.coordinates, range(len(motion.coordinates)), strict=True))
    jets = [Jet(*(MP.mpf(order[place[n]]) for order in driven)) for n in solver.driven]
    numbers = [graph.index(n, "test") for n in solver.coordinates]
    at = result.position.values
    started = [
        Jet(MP.mpf(at[solver.coordinates.index(graph.coordinates[k].name)])) for k in plan.iterated
    ]
    outputs = Outputs(tuple(numbers), derivatives=0)
    exact = [jet(x) for x in solve_pose(plan, [jets], started, jet_functions(), outputs, 3)]
    assert float(exact[len(numbers)].value) < 1e-12 * graph.length
    parts = {"position": "value", "velocity": "rate", "acceleration": "accel", "jerk": "jerk"}
    for order, part in parts.items():
        expected = np.array([float(getattr(x, part)) for x in exact[: len(numbers)]])
        if order == "position":  # up to whole turns
            at_home = np.round((result.position.values - expected) / (2 * np.pi))
            angles = [graph.coordinates[k].angle for k in numbers]
            expected = expected + 2 * np.pi * np.where(angles, at_home, 0.0)
        size = max(1.0, float(np.abs(expected).max()))
        np.testing.assert_allclose(result[order].values, expected, rtol=1e-9, atol=1e-9 * size)
