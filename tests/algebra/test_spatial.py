"""Vectors, matrices and poses against NumPy's and SciPy's."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from parakin.algebra.spatial import (
    IDENTITY,
    IDENTITY_POSE,
    ZERO,
    Matrix,
    Pose,
    Scalar,
    Vector,
    add,
    as_array,
    as_float,
    cross,
    dot,
    matrix,
    mul,
    sub,
    turned,
)

NUMBERS = st.floats(-1e3, 1e3)
VECTORS = st.tuples(NUMBERS, NUMBERS, NUMBERS).map(Vector)
TURNS = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(
    lambda v: matrix(Rotation.from_rotvec(v).as_matrix().tolist())
)


@given(VECTORS, VECTORS, NUMBERS)
def test_vectors_are_those_of_numpy(a: Vector[float], b: Vector[float], factor: float) -> None:
    x, y = np.array(a), np.array(b)
    np.testing.assert_array_equal(as_array(a + b), x + y)
    np.testing.assert_array_equal(as_array(a - b), x - y)
    np.testing.assert_array_equal(as_array(factor * a), factor * x)
    np.testing.assert_array_equal(as_array(a * factor), factor * x)
    np.testing.assert_allclose(as_array(cross(a, b)), np.cross(x, y), rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(dot(a, b), x @ y, rtol=1e-12, atol=1e-9)


@given(TURNS, TURNS, VECTORS)
def test_matrices_are_those_of_numpy(m: Matrix[float], n: Matrix[float], a: Vector[float]) -> None:
    np.testing.assert_allclose(as_array(m @ n), as_array(m) @ as_array(n), atol=1e-14)
    np.testing.assert_allclose(as_array(m @ a), as_array(m) @ as_array(a), atol=1e-11)
    np.testing.assert_array_equal(as_array(m.T), as_array(m).T)
    for k in range(3):
        np.testing.assert_array_equal(as_array(m.column(k)), as_array(m)[:, k])


@given(TURNS, VECTORS, TURNS, VECTORS)
def test_poses_compose_as_homogeneous_matrices(
    R_AB: Matrix[float], p_AB: Vector[float], R_BC: Matrix[float], p_BC: Vector[float]
) -> None:
    def homogeneous(X: Pose) -> np.ndarray:
        whole = np.eye(4)
        whole[:3, :3], whole[:3, 3] = as_array(X.R), as_array(X.p)
        return whole

    X_AB, X_BC = Pose(R_AB, p_AB), Pose(R_BC, p_BC)
    there = homogeneous(X_AB) @ homogeneous(X_BC)
    np.testing.assert_allclose(homogeneous(X_AB @ X_BC), there, atol=1e-9)
    inverse = np.linalg.inv(homogeneous(X_AB))
    np.testing.assert_allclose(homogeneous(X_AB.inverse), inverse, atol=1e-9)


@given(TURNS, st.integers(0, 2), st.floats(-3.0, 3.0))
def test_a_turn_is_about_the_frames_own_axis(R: Matrix[float], axis: int, angle: float) -> None:
    own = Rotation.from_rotvec(angle * np.eye(3)[axis])
    expected = (Rotation.from_matrix(as_array(R)) * own).as_matrix()
    found = turned(R, axis, float(np.cos(angle)), float(np.sin(angle)))
    np.testing.assert_allclose(as_array(found), expected, atol=1e-14)


class Noticed:
    """A scalar that must not be computed with."""

    def __getattr__(self, name: str) -> Scalar:
        raise AssertionError(name)


def test_literal_zeros_and_ones_fold() -> None:
    x: Scalar = Noticed()  # type: ignore[assignment]
    assert mul(0.0, x) == 0.0
    assert mul(x, 1.0) is x
    assert add(x, 0.0) is x
    assert sub(x, 0.0) is x
    a = Vector((x, x, x))
    assert tuple(a + ZERO) == (x, x, x)
    assert tuple(a * 0.0) == (0.0, 0.0, 0.0)
    assert tuple(IDENTITY @ a) == (x, x, x)
    assert tuple((IDENTITY_POSE @ Pose(IDENTITY, a)).p) == (x, x, x)


def test_a_numpy_zero_is_a_value_and_does_not_fold() -> None:
    assert np.isnan(as_float(mul(np.float64(0.0), np.nan)))


def test_a_numpy_factor_gives_a_vector_on_either_side() -> None:
    a = Vector((1.0, 2.0, 3.0))
    factor = np.array([1.0, 10.0])
    for product in (a * factor, factor * a, np.float64(2.0) * a):
        assert type(product) is Vector
    np.testing.assert_array_equal(as_array(a * factor), [[1, 10], [2, 20], [3, 30]])


def test_a_vector_does_not_mix_with_arrays_unnoticed() -> None:
    with pytest.raises(TypeError):
        np.zeros(3) + ZERO
    with pytest.raises(TypeError):
        np.subtract(ZERO, ZERO)


def test_vectors_can_be_sent() -> None:
    pose = Pose(IDENTITY, Vector((1.0, 2.0, 3.0)))
    for other in (pickle.loads(pickle.dumps(pose)), copy.deepcopy(pose)):
        assert other == pose
        assert type(other.p) is Vector
        assert type(other.R) is Matrix


def test_what_is_not_a_number_is_no_float() -> None:
    with pytest.raises(TypeError):
        as_float(np.zeros(2))
