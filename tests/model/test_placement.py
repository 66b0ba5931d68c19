"""Frames on bodies, compared with scipy's rotations."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from parakin import Frame, InputError
from parakin.algebra.spatial import IDENTITY_POSE, Pose, Vector, as_array, matrix
from parakin.model.expressions import Parameters
from parakin.model.placement import about, placement_of, snapped, unit, vector

angle = st.floats(-4.0, 4.0)
length = st.floats(-10.0, 10.0)
PATIENT = settings(deadline=None)


def made(angles: Sequence[float], p: Vector[float]) -> tuple[Pose[float], np.ndarray]:
    """A placement, and the same as a matrix of homogeneous coordinates."""
    R = Rotation.from_euler("XYZ", list(angles)).as_matrix()
    whole = np.eye(4)
    whole[:3, :3], whole[:3, 3] = R, p
    return Pose(matrix(R.tolist()), p), whole


def matrix_of(at: Pose[float]) -> np.ndarray:
    whole = np.eye(4)
    whole[:3, :3], whole[:3, 3] = as_array(at.R), as_array(at.p)
    return whole


@PATIENT
@given(st.tuples(*[angle] * 6), st.tuples(*[length] * 6))
def test_placements_compose_and_invert_as_homogeneous_matrices(
    angles: tuple[float, ...], lengths: tuple[float, ...]
) -> None:
    a, A = made(angles[:3], vector(lengths[:3]))
    b, B = made(angles[3:], vector(lengths[3:]))
    assert_allclose(matrix_of(a @ b), A @ B, atol=1e-13)
    assert_allclose(matrix_of(a.inverse), np.linalg.inv(A), atol=1e-12)
    assert_allclose(matrix_of(a @ a.inverse), np.eye(4), atol=1e-13)
    assert IDENTITY_POSE @ a == a


@PATIENT
@given(st.lists(st.tuples(st.sampled_from("xyz"), angle), max_size=4))
def test_turns_are_about_the_moving_axes(turns: list[tuple[str, float]]) -> None:
    frame = Frame(at=("2 m", 0, 0), turns=tuple(turns))  # type: ignore[arg-type]
    at = placement_of(frame, Parameters({}), "here")
    expected = Rotation.identity()
    for axis, turn in turns:
        expected = expected * Rotation.from_euler(axis, turn)
    assert_allclose(np.array(at.R), expected.as_matrix(), atol=1e-14)
    assert at.p == (2.0, 0.0, 0.0)


def test_an_axis_may_have_any_length_and_x_need_not_be_square_to_it() -> None:
    frame = Frame(axis=(0, "3*a", 0), x=(1, 1, 0))
    at = placement_of(frame, Parameters({"a": "20 mm"}), "here")
    assert_allclose(np.array(at.R).T, [[1, 0, 0], [0, 0, -1], [0, 1, 0]], atol=0)


def test_without_x_it_is_the_bodys_x_or_its_y_where_z_lies_along_x() -> None:
    upright = placement_of(Frame(axis=(0, 1, 1)), Parameters({}), "here")
    assert_allclose(np.array(upright.R)[:, 0], [1, 0, 0])
    lying = placement_of(Frame(axis=(-2, 0, 0)), Parameters({}), "here")
    assert_allclose(np.array(lying.R)[:, 0], [0, 1, 0])
    assert_allclose(np.linalg.det(np.array(lying.R)), 1.0)


@pytest.mark.parametrize(
    ("frame", "message"),
    [
        (Frame(axis=(0, 0, 0)), "here.axis: found the axis [0.0, 0.0, 0.0]; expected an axis"),
        (Frame(axis=(0, 0, 2), x=(0, 0, -1)), "here.x: found [0, 0, -1] along the axis"),
        (Frame(axis=(0, 0, 1), turns=(("x", 1),)), "here.turns: found both turns and an axis"),
        (Frame(at=(0, "1 s", 0)), "here.at[1]: found '1 s', a time; expected a length"),
        (Frame(turns=(("x", "1 m"),)), "here.turns[0]: found '1 m', a length; expected an angle"),
    ],
)
def test_frames_that_mean_nothing_are_refused(frame: Frame, message: str) -> None:
    with pytest.raises(InputError) as error:
        placement_of(frame, Parameters({}), "here")
    assert message in str(error.value)


@PATIENT
@given(st.tuples(length, length, length).filter(lambda a: math.hypot(*a) > 1e-3))
def test_about_gives_a_rotation_with_z_along_the_axis(a: tuple[float, float, float]) -> None:
    axis = unit(vector(a), "here")
    R: np.ndarray = np.array(about(axis))
    assert_allclose(R[:, 2], np.array(a) / np.linalg.norm(a), atol=1e-14)
    assert_allclose(R.T @ R, np.eye(3), atol=1e-14)
    assert_allclose(np.linalg.det(R), 1.0, atol=1e-14)


def test_entries_within_rounding_of_whole_numbers_become_exact() -> None:
    c, s = math.cos(math.pi / 2), math.sin(math.pi / 6)
    m = snapped(matrix(((1 - 2e-16, c, -c), (s, -1.0, 1e-15), (0.0, 0.0, 1.0))))
    assert m == ((1.0, 0.0, 0.0), (s, -1.0, 1e-15), (0.0, 0.0, 1.0))
    assert math.copysign(1.0, m[0][2]) == 1.0  # no negative zero
