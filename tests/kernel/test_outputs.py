"""Every row of a kernel's output has one name."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import parakin
from parakin.algebra.spatial import ZERO
from parakin.kernel import outputs as rows
from parakin.kernel.backends import input_count, make_kernel
from parakin.kernel.outputs import Outputs


@pytest.mark.parametrize(
    ("derivatives", "checks", "points"), [*itertools.product(range(4), (False, True), (0, 2))]
)
def test_rows_cover_the_output_without_overlap(derivatives: int, checks: bool, points: int) -> None:
    outputs = Outputs((3, 5, "cone"), derivatives, checks, ((0, ZERO),) * points)
    taken: list[int] = []
    for order in range(derivatives + 1):
        taken += range(*outputs.order(order).indices(outputs.count))
    assert taken == list(range(*outputs.motion.indices(outputs.count)))
    if checks:
        figures = range(*outputs.figures.indices(outputs.count))
        named = [outputs.residual, outputs.conditioning, outputs.step, outputs.size]
        assert [*named, outputs.unsigned] == list(figures)
        taken += figures
    assert len(taken) + points * rows.POINT == outputs.count
    assert sorted(set(taken)) == taken


def test_a_points_rows_follow_one_another() -> None:
    parts = (
        rows.POSITION,
        rows.ORIENTATION,
        rows.VELOCITY,
        rows.ANGULAR_VELOCITY,
        rows.ACCELERATION,
        rows.ANGULAR_ACCELERATION,
    )
    assert [part.start for part in parts[1:]] == [part.stop for part in parts[:-1]]
    assert (parts[0].start, parts[-1].stop) == (0, rows.POINT)


def test_a_derivative_is_found_from_the_row_of_its_position() -> None:
    outputs = Outputs((7, 8, 9))
    for order in range(3):
        assert outputs.derivative(1, order) == range(9)[outputs.order(order)][1]
        found = outputs.derivative(np.array([0, 2]), order)
        np.testing.assert_array_equal(found, np.arange(9)[outputs.order(order)][[0, 2]])


@pytest.mark.parametrize("derivatives", range(4))
def test_kernels_return_what_the_rows_say(derivatives: int) -> None:
    """The crank of a four-bar is driven: its own rows are what was put in."""
    plan = parakin.compile("four-bar", machine_code=False).plan
    crank = plan.driven[0]
    outputs = Outputs((crank,), derivatives)
    kernel = make_kernel(plan, outputs, machine_code=False, steps=2)
    given = np.array([0.7, 1.5, -2.0, 4.0])[: 1 + derivatives]
    assert input_count(plan, outputs) == len(given)
    out = np.empty((outputs.count, 1))
    kernel(given[:, None], out, False)
    for order, value in enumerate(given):
        assert out[outputs.order(order), 0] == value
    assert out[outputs.residual, 0] < 1e-15
