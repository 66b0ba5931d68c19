"""What is reported of pieces of a motion on different charts."""

from __future__ import annotations

import numpy as np

import parakin
from parakin.kernel.outputs import Outputs
from parakin.solving.atlas import Atlas
from parakin.solving.charts import Chart
from parakin.solving.tracking import Piece


def test_pieces_are_put_together_and_the_rest_is_nan() -> None:
    solver = parakin.compile("four-bar", coordinates="all", machine_code=False)
    outputs = solver.reported
    chart = Chart(solver.plan, outputs, len(outputs.coordinates), machine_code=False)
    other = Chart(solver.plan, outputs, len(outputs.coordinates), False, relative_regularity=0.5)
    atlas = Atlas(chart, outputs)
    first, second = np.full((outputs.count, 2), 1.0), np.full((outputs.count, 3), 2.0)
    out = atlas.reported([Piece(0, 2, chart, first), Piece(2, 5, other, second)], 7)
    assert out.shape == (outputs.count, 7)
    np.testing.assert_array_equal(out[0], [1, 1, 2, 2, 2, np.nan, np.nan])
    figures = out[outputs.conditioning]  # measured by what home is held with
    np.testing.assert_array_equal(figures, [1, 1, 1, 1, 1, np.nan, np.nan])


def test_one_piece_that_is_all_is_not_copied() -> None:
    solver = parakin.compile("four-bar", coordinates="all", machine_code=False)
    outputs = solver.reported
    chart = Chart(solver.plan, outputs, len(outputs.coordinates), machine_code=False)
    whole = np.ones((outputs.count, 4))
    assert Atlas(chart, outputs).reported([Piece(0, 4, chart, whole)], 4) is whole


def test_a_solver_of_positions_alone_is_followed_with_all_that_is_solved_for() -> None:
    solver = parakin.compile("four-bar", coordinates=["D"], derivatives=0, machine_code=False)
    outputs = Outputs(solver.reported.coordinates, 0)
    chart = Chart(solver.plan, outputs, 1, machine_code=False)
    followed = Atlas(chart, outputs).followed
    assert followed is not chart
    assert followed.outputs.derivatives == 2
    assert {*solver.plan.unknowns} <= {*followed.outputs.coordinates}
