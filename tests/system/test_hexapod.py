"""The Gough-Stewart platform both ways, at random poses of its workspace."""

from __future__ import annotations

import numpy as np
import pytest
from replays import replayed
from scipy.spatial.transform import Rotation

import parakin
from parakin import Status
from parakin.kernel.backends import has_machine_code

LEGS = [f"P{i}" for i in range(1, 7)]
COUNT = 50_000 if has_machine_code() else 2_000


@pytest.fixture(scope="module")
def solvers() -> tuple[parakin.Solver, parakin.Solver]:
    return (
        parakin.compile("gough-stewart", coordinates=LEGS, derivatives=0),
        parakin.compile("gough-stewart", driven=LEGS, derivatives=0),
    )


def random_poses(rng: np.random.Generator, count: int) -> np.ndarray:
    low = np.array([-0.25, -0.25, 0.9, -0.35, -0.35, -0.35])
    high = np.array([0.25, 0.25, 1.3, 0.35, 0.35, 0.35])
    poses: np.ndarray = (low + (high - low) * rng.uniform(size=(count, 6))).T.copy()
    return poses


def leg_lengths(poses: np.ndarray) -> np.ndarray:
    """Distances between the joints of each leg, from their places on base and platform."""
    half = np.radians(10)
    base = np.radians([0, 0, 120, 120, 240, 240]) + half * np.array([-1, 1, -1, 1, -1, 1])
    top = np.radians([-60, 60, 60, 180, 180, -60]) + half * np.array([1, -1, 1, -1, 1, -1])
    a = 1.2 * np.stack([np.cos(base), np.sin(base), 0 * base], axis=1)
    b = 0.7 * np.stack([np.cos(top), np.sin(top), 0 * top], axis=1)
    turned = np.einsum("nij,kj->nki", Rotation.from_euler("XYZ", poses[3:].T).as_matrix(), b)
    legs: np.ndarray = np.linalg.norm(turned + poses[:3].T[:, None] - a, axis=2).T
    return legs


def test_lengths_from_poses(solvers: tuple[parakin.Solver, parakin.Solver]) -> None:
    poses = random_poses(np.random.default_rng(1), COUNT)
    tick = solvers[0].at(poses)
    assert not np.any(tick.status)
    np.testing.assert_allclose(tick.position + 1.0, leg_lengths(poses), rtol=0, atol=1e-14)


def test_poses_come_back_from_lengths_or_are_flagged(
    solvers: tuple[parakin.Solver, parakin.Solver],
) -> None:
    inverse, forward = solvers
    rng = np.random.default_rng(2)
    poses = random_poses(rng, COUNT)
    lengths = inverse.at(poses).position
    platform = [forward.coordinates.index(n) for n in inverse.driven]
    start = np.zeros((len(forward.coordinates), COUNT))
    start[platform] = poses + rng.uniform(-0.05, 0.05, poses.shape)
    tick = forward.at(lengths, guess=start, within=0.1)
    good = np.asarray(tick.status) == Status.CONVERGED
    assert np.abs(tick.position[platform][:, good] - poses[:, good]).max() < 1e-9
    assert np.isnan(tick.position[:, ~good]).all()
    assert (~good).mean() <= 1e-3


def test_lengths_a_little_off_still_close_the_loops(
    solvers: tuple[parakin.Solver, parakin.Solver],
) -> None:
    inverse, forward = solvers
    rng = np.random.default_rng(3)
    poses = random_poses(rng, 2_000)
    lengths = inverse.at(poses).position + rng.uniform(-1e-5, 1e-5, (6, 2_000))
    start = np.zeros((len(forward.coordinates), 2_000))
    start[[forward.coordinates.index(n) for n in inverse.driven]] = poses
    tick = forward.at(lengths, guess=start)
    assert not np.any(tick.status)
    assert np.max(tick.residual) < 1e-13


def test_an_answer_too_far_from_its_guess_is_a_branch_change(
    solvers: tuple[parakin.Solver, parakin.Solver],
) -> None:
    inverse, forward = solvers
    pose = np.array([0.05, 0.0, 1.1, 0.1, 0.0, 0.0])
    lengths = inverse.at(pose).position
    guess = np.zeros(len(forward.coordinates))
    guess[[forward.coordinates.index(n) for n in inverse.driven]] = pose + 0.02
    assert forward.at(lengths, guess=guess, within=0.1).status == Status.CONVERGED
    refused = forward.at(lengths, guess=guess, within=0.01)
    assert refused.status == Status.BRANCH_CHANGE
    assert np.isnan(refused.position).all()


def test_unordered_poses_need_no_guess(solvers: tuple[parakin.Solver, parakin.Solver]) -> None:
    inverse, forward = solvers
    poses = random_poses(np.random.default_rng(4), COUNT // 10)
    tick = forward.at(inverse.at(poses).position)
    assert not np.any(tick.status)
    platform = [forward.coordinates.index(n) for n in inverse.driven]
    assert np.abs(tick.position[platform] - poses).max() < 1e-9


def test_a_batch_that_walks_from_home_stays_on_its_branch_or_is_flagged(
    solvers: tuple[parakin.Solver, parakin.Solver],
) -> None:
    """Lengths of poses beyond a type 2 singularity (the platform turned by up to half a turn about
    the vertical) have another answer on home's branch, if any.
    """
    inverse, forward = solvers
    rng = np.random.default_rng(5)
    poses = random_poses(rng, 500)
    poses[5] = rng.uniform(np.radians(110), np.pi, 500)
    tick = forward.at(leg_lengths(poses) - 1.0)
    good = np.asarray(tick.status) == Status.CONVERGED
    assert good.any()
    assert np.isnan(tick.position[:, ~good]).all()
    platform = [forward.coordinates.index(n) for n in inverse.driven]
    found = tick.position[platform][:, good]
    np.testing.assert_allclose(leg_lengths(found), leg_lengths(poses)[:, good], atol=1e-11)
    assert (np.abs(found - poses[:, good]).max(axis=0) > 0.1).all()
    assert (np.asarray(tick.conditioning)[good] > 0).all()


def test_lengths_out_of_reach_are_flagged(solvers: tuple[parakin.Solver, parakin.Solver]) -> None:
    """A leg longer than its neighbour and all that lies between their ends."""
    lengths = np.zeros((6, 3))
    lengths[0] = [2.0, 5.0, 1e6]
    tick = solvers[1].at(lengths)
    assert np.all(np.asarray(tick.status) > 0)
    assert np.isnan(tick.position).all()


def test_a_loop_of_joints_that_are_all_driven_opens_within_one_of_them() -> None:
    """Platform, universal joint, leg and ball of one limb, a coordinate of each: none can be cut
    whole. The motion is that of the platform driven.
    """
    driven = ["platform.x", "U1.1", "P1", "S1.1", "P2", "P3"]
    inverse = parakin.compile("gough-stewart", coordinates="all", machine_code=False)
    result = inverse.solve(inverse.motion("tour", rate=50))
    names = [c.name for c in inverse.graph.coordinates]
    mixed = parakin.compile("gough-stewart", driven, coordinates="all", machine_code=False)
    assert set(names) <= set(mixed.coordinates)
    again = parakin.require_solved(mixed.solve(replayed(result, driven), bodies=True))
    assert again.body.values.tolist() == [
        b.name for b in inverse.mechanism.bodies if b.name != "base"
    ]
    for quantity in ("position", "velocity", "acceleration"):
        ours = again[quantity].sel(coordinate=names).values
        np.testing.assert_allclose(ours, result[quantity].sel(coordinate=names).values, atol=1e-12)
