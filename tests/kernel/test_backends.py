"""Machine code against NumPy: the same kernel twice."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin.kernel.backends import has_machine_code, input_count, make_kernel
from parakin.kernel.outputs import Outputs


@pytest.mark.skipif(not has_machine_code(), reason="heyoka is not installed")
@pytest.mark.parametrize("name", ["flight-simulator", "3-rps", "bennett", "six-bar-stephenson"])
def test_both_give_the_same(name: str) -> None:
    plan = parakin.compile(name, machine_code=False).plan
    outputs = Outputs(tuple(range(len(plan.graph.plain.coordinates))), derivatives=3)
    rng = np.random.default_rng(2)
    count = input_count(plan, outputs)
    inputs = 0.1 * rng.normal(size=(count, 40))
    home = np.array([plan.home[k] - plan.offset(k) for k in plan.driven])
    inputs[: len(home)] = home[:, None] + 0.02 * rng.uniform(-1, 1, (len(home), 40))
    if plan.iterated:
        start = [plan.home[k] - plan.offset(k) for k in plan.iterated]
        inputs[-len(start) :] = np.array(start)[:, None]
    results = []
    for machine_code in (False, True):
        out = np.empty((outputs.count, 40))
        make_kernel(plan, outputs, machine_code=machine_code, steps=4)(inputs, out, False)
        results.append(out)
    np.testing.assert_allclose(results[0], results[1], rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize("derivatives", range(4))
def test_inputs_are_driven_orders_and_then_a_guess(derivatives: int) -> None:
    drives = tuple(f"P{i}" for i in range(1, 7))
    plan = parakin.compile("gough-stewart", drives, machine_code=False).plan
    outputs = Outputs((0,), derivatives)
    assert input_count(plan, outputs) == 6 * (1 + derivatives) + len(plan.iterated)
