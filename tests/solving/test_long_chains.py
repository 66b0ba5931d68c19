"""Mechanisms of many loops, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
import scissor_lift

import parakin
from parakin.arrays import FloatArray
from parakin.kernel.backends import make_kernel
from parakin.kernel.outputs import Outputs

HEIGHT, SPEED, CHANGE = 1, 13, 19  # of the rows that tell of a point: y, its rate, its second rate


def _driven(by_slide: bool) -> tuple[list[FloatArray], list[FloatArray]]:
    """The slide with its derivatives, and what is driven to bring it there."""
    rng = np.random.default_rng(1)
    A = scissor_lift.HOME + rng.uniform(-0.3, 0.3, 50)
    turning, change = rng.normal(size=(2, 50))
    length = scissor_lift.LENGTH
    rate = -length * np.sin(A) * turning
    second = -length * (np.cos(A) * turning**2 + np.sin(A) * change)
    slide = [length * np.cos(A), rate, second]
    return slide, slide if by_slide else [A, turning, change]


@pytest.mark.parametrize("stages", [12, 24])  # the shorter one with dense matrices
@pytest.mark.parametrize("by_slide", [True, False])
def test_a_scissor_lift_is_so_many_times_as_high_as_its_first_stage(
    stages: int, by_slide: bool
) -> None:
    mechanism = scissor_lift.scissor_lift(stages, by_slide=by_slide)
    solver = parakin.compile(mechanism, coordinates=["S"])
    slide, driven = _driven(by_slide)
    tick = solver.at(*(row[None] for row in driven))
    assert not np.any(tick.status)
    np.testing.assert_allclose(tick.position[0], slide[0], rtol=1e-12)
    points = (solver.graph.points[f"p{stages}.T"],)
    outputs = Outputs((), derivatives=2, checks=False, points=points)
    found = np.empty((outputs.count, 50))
    kernel = make_kernel(solver.plan, outputs, machine_code=solver.machine_code, steps=1)
    kernel(np.array(driven), found, False)
    expected = scissor_lift.top(stages, *slide)
    for row, exact in zip((HEIGHT, SPEED, CHANGE), expected, strict=True):
        np.testing.assert_allclose(found[row], exact, rtol=1e-10, atol=1e-10 * stages)


def test_a_long_chain_falls_into_loops_that_concern_neighbours_alone() -> None:
    graph = parakin.compile(scissor_lift.scissor_lift(24), machine_code=False).plan
    assert all(len(block.unknowns) == 1 for block in graph.blocks)
    assert max(len(block.needs) for block in graph.blocks) <= 3
