"""Null spaces and shortest steps loop by loop, against dense decompositions."""

from __future__ import annotations

import numpy as np

from parakin.arrays import FloatArray
from parakin.kinematics import chains


def _ladder(loops: int, *, spoilt: float = 0.0) -> FloatArray:
    """Six rows of rank two for each loop, which knows four coordinates, two of them the next's."""
    rng = np.random.default_rng(0)
    J = np.zeros((6 * loops, 2 * loops + 2))
    for k in range(loops):
        J[6 * k : 6 * k + 6, 2 * k : 2 * k + 4] = rng.normal(size=(6, 2)) @ rng.normal(size=(2, 4))
    J[0, 0] += spoilt
    return J


def test_the_null_space_is_that_of_the_whole_matrix() -> None:
    J = _ladder(30)
    found = chains.kernel(J)
    assert found is not None
    assert found.shape[1] == 2
    np.testing.assert_allclose(found.T @ found, np.eye(2), atol=1e-13)
    np.testing.assert_allclose(J @ found, 0.0, atol=1e-12)


def test_the_step_is_the_shortest_of_the_nearest() -> None:
    J = _ladder(30)
    gaps = np.random.default_rng(1).normal(size=len(J))
    found = chains.least_step(J, gaps)
    assert found is not None
    exact = np.linalg.lstsq(J, gaps, rcond=1e-8)[0]
    np.testing.assert_allclose(found, exact, atol=1e-9 * np.abs(exact).max())


def test_what_is_small_or_in_doubt_is_left_to_dense_matrices() -> None:
    assert chains.kernel(_ladder(3)) is None
    doubtful = _ladder(30, spoilt=1e-8)  # is its first loop of rank two or three?
    assert chains.kernel(doubtful) is None
    assert chains.least_step(doubtful, np.ones(len(doubtful))) is None


def test_loops_that_say_the_same_are_left_to_dense_matrices() -> None:
    J = _ladder(30)
    assert chains.least_step(np.vstack([J, J[:6]]), np.ones(len(J) + 6)) is None
