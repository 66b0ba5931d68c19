"""Which coordinates move which end of a loop, and how its gap moves."""

from __future__ import annotations

import numpy as np
import pytest
from loops_of_every_kind import closed, differentiated, opened

from parakin.algebra.dual import rate_of
from parakin.algebra.spatial import as_array, as_float
from parakin.kinematics import loops


@pytest.mark.parametrize("kind", ["revolute", "rod"])
def test_a_coordinate_moves_the_end_on_its_own_side(kind: str) -> None:
    circuits, cut = opened(kind)
    before = loops.ends(circuits, cut)
    sides = loops.sides(circuits, cut)
    names = {circuits.graph.coordinates[k].name: side for k, side in sides.items()}
    assert {n for n, side in names.items() if side < 0} == {"A.1", "A.2"}
    assert {n.split(".")[0] for n, side in names.items() if side > 0} == {"platform"}
    for k, side in sides.items():
        there = differentiated(circuits, {k: 1.0})
        end = loops.ends(there, cut)
        moves = {
            name: any(as_float(rate_of(x)) for row in (*pose.R, pose.p) for x in row)
            for name, pose in (("F", end.X_WF), ("M", end.X_WM))
        }
        assert moves == {"F": side < 0, "M": side > 0}
    assert before.parent == circuits.graph.joints[cut].parent


@pytest.mark.parametrize("seed", range(3))
def test_the_gap_moves_as_its_position_says(seed: int) -> None:
    circuits, cut = closed("spherical", seed)
    rng = np.random.default_rng(seed)
    moving = circuits.with_coordinates(rates={k: float(rng.normal()) for k in circuits.rates})
    end = loops.ends(moving, cut)
    there = differentiated(moving, {k: as_float(rate) for k, rate in moving.rates.items()})
    exact = [as_float(rate_of(x)) for x in loops.ends(there, cut).d]
    np.testing.assert_allclose(as_array(loops.gap_velocity(moving, end)), exact, atol=1e-14)
