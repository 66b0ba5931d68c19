"""Joints in numbers: what each kind leaves free."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from parakin.algebra.spatial import IDENTITY, IDENTITY_POSE
from parakin.model.joints import PAIRS, THETA, X_TURN, Z_SLIDE, Z_TURN, GraphJoint, Pair
from parakin.model.mechanism import Kind

# Turns and slides of the lower pairs, as in any textbook; a helical joint's pitch is its own.
FREEDOMS = {
    "revolute": (1, 0),
    "prismatic": (0, 1),
    "cylindrical": (1, 1),
    "universal": (2, 0),
    "spherical": (3, 0),
    "planar": (1, 2),
    "free": (3, 3),
    "rod": (0, 0),
    "fixed": (0, 0),
}


def joint(*pairs: Pair) -> GraphJoint:
    return GraphJoint("J", "free", 0, 1, IDENTITY_POSE, IDENTITY_POSE, pairs, IDENTITY, 5)


@pytest.mark.parametrize("kind", FREEDOMS)
def test_turns_and_slides_of_every_kind(kind: str) -> None:
    slides = [pair.slides for pair in PAIRS[kind]]
    assert (slides.count(False), slides.count(True)) == FREEDOMS[kind]


def test_no_kind_is_forgotten() -> None:
    assert {*PAIRS, "helical"} == set(get_args(Kind)) == {*FREEDOMS, "helical"}


def test_theta_turns_z_into_x() -> None:
    """A quarter turn about y: the second axis of a universal joint lies along x."""
    np.testing.assert_array_equal(np.array(THETA) @ [0, 0, 1], [1, 0, 0])
    np.testing.assert_array_equal(np.array(THETA) @ np.array(THETA).T, np.eye(3))
    assert np.linalg.det(np.array(THETA)) == 1.0


def test_coordinates_and_those_that_are_angles() -> None:
    made = joint(Z_TURN, Z_SLIDE, X_TURN)
    assert list(made.coordinates) == [5, 6, 7]
    assert made.turns == [5, 7]


@pytest.mark.parametrize(
    ("axes", "proper"), [("zxz", True), ("xyx", True), ("xyz", False), ("zx", False), ("z", False)]
)
def test_proper_euler_angles_repeat_their_first_axis(axes: str, proper: bool) -> None:
    assert joint(*(Pair(False, "xyz".index(axis)) for axis in axes)).proper is proper
