"""Verdicts on samples."""

from __future__ import annotations

import numpy as np
import pytest

import parakin
from parakin import Status
from parakin.arrays import FloatArray
from parakin.solving.status import (
    RESIDUAL,
    SINGULAR,
    SOLVED,
    Layout,
    blank_undefined,
    classify,
    converged,
)


def layout_of(name: str) -> Layout:
    return parakin.compile(name, machine_code=False).layout


def outputs(layout: Layout, residual: list[float], conditioning: list[float]) -> FloatArray:
    """Samples with these figures, two metres being subtracted."""
    out = np.zeros((layout.outputs.count, len(residual)))
    out[layout.outputs.residual] = residual
    out[layout.outputs.conditioning] = conditioning
    out[layout.outputs.size] = 2.0
    return out


@pytest.mark.parametrize(
    ("residual", "conditioning", "status"),
    [
        (0.0, 1.0, Status.CONVERGED),
        (2 * RESIDUAL, SINGULAR, Status.CONVERGED),
        (2.1 * RESIDUAL, 1.0, Status.ITERATION_LIMIT),
        (0.0, 0.9 * SINGULAR, Status.SINGULAR),
        (0.0, -0.5, Status.BRANCH_CHANGE),
        (np.nan, 1.0, Status.OUT_OF_REACH),
        (np.nan, np.nan, Status.OUT_OF_REACH),
        (0.0, np.nan, Status.SINGULAR),
        (np.inf, 1.0, Status.ITERATION_LIMIT),
    ],
)
def test_each_figure_has_its_verdict(residual: float, conditioning: float, status: Status) -> None:
    layout = layout_of("four-bar")
    out = outputs(layout, [residual], [conditioning])
    assert converged(out, layout).tolist() == [status == Status.CONVERGED]
    assert classify(out, layout).tolist() == [status]


def test_a_batch_is_judged_sample_by_sample() -> None:
    layout = layout_of("four-bar")
    out = outputs(layout, [0.0, np.nan, 1.0, 0.0], [1.0, 1.0, 1.0, -1.0])
    expected = [
        Status.CONVERGED,
        Status.OUT_OF_REACH,
        Status.ITERATION_LIMIT,
        Status.BRANCH_CHANGE,
    ]
    assert classify(out, layout).tolist() == expected


def test_what_is_solved_has_numbers() -> None:
    assert set(SOLVED) == {Status.CONVERGED, Status.LIMIT_EXCEEDED, Status.ANGLES_UNDEFINED}
    assert Status.NOT_REACHED.words == "not reached"


def test_angles_are_blank_where_they_are_not_defined_and_only_there() -> None:
    """Pitch at a right angle: roll and yaw turn about the same axis."""
    drives = [f"P{i}" for i in range(1, 7)]
    solver = parakin.compile("gough-stewart", drives, machine_code=False)
    layout = solver.layout
    assert layout.triples
    rows, second, same = layout.triples[0]
    assert not same
    out = np.ones((layout.outputs.count, 3))
    out[second] = [0.3, np.pi / 2, -np.pi / 2]
    assert blank_undefined(out, layout).tolist() == [False, True, True]
    assert not np.isnan(out[:, 0]).any()
    orders = range(1 + layout.outputs.derivatives)
    blank = sorted(row for order in orders for row in layout.outputs.derivative(rows, order))
    assert np.flatnonzero(np.isnan(out[:, 1])).tolist() == blank
    assert np.flatnonzero(np.isnan(out[:, 2])).tolist() == blank


@pytest.mark.parametrize("name", ["agile-eye", "gough-stewart", "6-rus"])
def test_what_is_plainly_defined_is_not_blanked(name: str) -> None:
    """And what is about to be blanked is never plainly defined."""
    solver = parakin.compile(name, machine_code=False)
    layout, draw = solver.layout, np.random.default_rng(2)
    plain = 0
    for _ in range(2000):
        out = draw.uniform(-4.0, 4.0, layout.outputs.count)
        for triple in layout.triples:
            out[triple.second] = draw.choice([0.0, np.pi / 2, -np.pi / 2, np.pi, 1.0])
            out[triple.second] += draw.normal() * 10.0 ** draw.uniform(-12.0, 0.0)
        for row in layout.cones:
            out[row] = draw.choice([0.0, np.pi, 1.0]) + abs(draw.normal()) * 10.0 ** draw.uniform(
                -9, 0
            )
        before = out.copy()
        undefined = blank_undefined(out[:, None], layout)
        if layout.plainly_defined(before):
            plain += 1
            assert not undefined
            assert np.array_equal(before, out)
    assert plain > 0
    assert not layout.undefined or not layout.plainly_defined(np.full(layout.outputs.count, np.nan))
