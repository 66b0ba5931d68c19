"""Cone angles and their rates, against directions worked out from rotation matrices."""

from __future__ import annotations

import math

import numpy as np
import pytest
from loops_of_every_kind import loop_of
from scipy.spatial.transform import Rotation

import parakin
from parakin import Body, Frame, Joint, Mechanism, Platform
from parakin.algebra.spatial import FLOATS, as_float
from parakin.kinematics.cones import Cone, cone_angle, cones_of
from parakin.kinematics.configuration import circuits_at
from parakin.kinematics.recursion import Circuits
from parakin.model.evaluation import graph_of
from parakin.model.mechanism import Kind


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kind", ["spherical", "universal"])
def test_the_angle_and_its_rates_are_those_of_two_directions(kind: str, seed: int) -> None:
    graph, _, joint = loop_of(kind)
    tree = graph.tree_of([k for k in range(len(graph.joints)) if k != graph.platform])
    rng = np.random.default_rng(seed)
    q, rates, second = rng.uniform(-1.2, 1.2, (3, len(graph.coordinates)))
    cone = cones_of(graph, rng.uniform(-0.1, 0.1, len(q)).tolist())[
        f"{graph.joints[joint].name}.cone"
    ]

    def at(time: float) -> Circuits:
        return circuits_at(graph, tree, q + time * rates + 0.5 * time**2 * second)

    def angle(time: float) -> float:
        circuits = at(time)
        z = [
            np.array(circuits.pose(body).R, dtype=float) @ np.array(direction, dtype=float)
            for body, direction in ((cone.parent, cone.z_P), (cone.child, cone.z_C))
        ]
        return math.acos(float(z[0] @ z[1]))

    circuits = at(0.0)
    circuits.rates |= dict(enumerate(rates.tolist()))
    circuits.second |= dict(enumerate(second.tolist()))
    found = cone_angle(circuits, cone, FLOATS, derivatives=2)
    h = 1e-3  # central differences of order four
    steps = [angle(k * h) for k in (-2, -1, 0, 1, 2)]
    first = (steps[0] - 8 * steps[1] + 8 * steps[3] - steps[4]) / (12 * h)
    bend = (-steps[0] + 16 * steps[1] - 30 * steps[2] + 16 * steps[3] - steps[4]) / (12 * h**2)
    assert as_float(found[0]) == pytest.approx(steps[2], abs=1e-14)
    assert as_float(found[1]) == pytest.approx(first, abs=1e-9)
    assert as_float(found[2]) == pytest.approx(bend, abs=1e-6)


def ball(
    on_parent: Frame, *, kind: Kind = "spherical", reverse: bool = False, platform: bool = True
) -> Mechanism:
    """A limb that hangs on the base by a ball joint (the base its child, if reversed)."""
    parent, child = ("limb", "base") if reverse else ("base", "limb")
    return Mechanism(
        name="ball",
        bodies=(Body(name="limb"), Body(name="plate")),
        joints=(
            Joint(name="B", kind=kind, parent=parent, child=child, on_parent=on_parent),
            Joint(name="W", kind="fixed", parent="limb", child="plate"),
        ),
        platform=Platform(body="plate") if platform else None,
    )


def measured(mechanism: Mechanism, home: np.ndarray, now: np.ndarray) -> float:
    """The cone angle of joint B at coordinates `now`, home being at others."""
    graph = graph_of(mechanism)
    count = len(graph.coordinates)
    cone = cones_of(graph, [*home, *[0.0] * (count - len(home))])["B.cone"]
    tree = graph.tree_of([k for k in range(len(graph.joints)) if k != graph.platform])
    circuits = circuits_at(graph, tree, np.append(now, np.zeros(count - len(now))))
    return as_float(cone_angle(circuits, cone, FLOATS, derivatives=0)[0])


HOME, NOW = np.array([0.3, -0.2, 0.9]), np.array([0.7, 0.4, -0.5])
R_HOME, R_NOW = (Rotation.from_euler("XYZ", q).as_matrix() for q in (HOME, NOW))


def test_a_ball_joint_that_the_file_orients_is_measured_between_its_z_axes() -> None:
    found = measured(ball(Frame(axis=(0, 0, 1))), HOME, NOW)
    assert found == pytest.approx(math.acos(R_NOW[2, 2]), abs=1e-14)


def test_one_that_it_does_not_orient_is_measured_from_home() -> None:
    assert measured(ball(Frame(at=(1, 2, 3))), HOME, HOME) == pytest.approx(0.0, abs=1e-15)
    found = measured(ball(Frame(at=(1, 2, 3))), HOME, NOW)
    assert found == pytest.approx(math.acos(R_HOME[:, 2] @ R_NOW[:, 2]), abs=1e-14)


def test_a_limb_counts_by_its_own_axis_whichever_end_of_the_joint_it_is() -> None:
    # Seen from the base, the limb's z axis is row 2 of R_FM, as the limb is the parent.
    found = measured(ball(Frame(at=(1, 2, 3)), reverse=True), HOME, NOW)
    assert found == pytest.approx(math.acos(R_HOME[2] @ R_NOW[2]), abs=1e-14)


def test_a_universal_joint_is_measured_from_the_normal_of_its_axes_at_home() -> None:
    # cos = cos(a - a0) cos(b - b0): of a right spherical triangle.
    home, now = np.array([0.3, 1.1]), np.array([-0.4, 1.6])
    joint = ball(Frame(axis=(1, 2, 3)), kind="universal")
    assert measured(joint, home, home) == pytest.approx(0.0, abs=1e-15)
    away = now - home
    assert measured(joint, home, now) == pytest.approx(math.acos(np.cos(away).prod()), abs=1e-14)


def test_the_twist_about_the_limb_does_not_count() -> None:
    joint = ball(Frame(at=(1, 2, 3)))
    twisted = Rotation.from_matrix(R_HOME) * Rotation.from_rotvec([0, 0, 1.3])
    found = measured(joint, HOME, twisted.as_euler("XYZ"))
    assert found == pytest.approx(0.0, abs=1e-7)  # acos near 1


def test_an_axis_near_zero_has_all_digits() -> None:
    joint, small = ball(Frame(at=(1, 2, 3))), 1e-9
    tilted = Rotation.from_matrix(R_HOME) * Rotation.from_rotvec([small, 0, 0])
    found = measured(joint, HOME, tilted.as_euler("XYZ"))
    assert found == pytest.approx(small, rel=1e-5)


def test_limbs_between_passive_bodies_count_by_the_child() -> None:
    found = measured(ball(Frame(at=(1, 2, 3)), platform=False, reverse=True), HOME, NOW)
    assert found == pytest.approx(math.acos(R_HOME[2] @ R_NOW[2]), abs=1e-14)


def test_home_is_the_files_own_on_every_branch() -> None:
    hexapod = parakin.compile("gough-stewart", coordinates="all")
    mirrored = {**hexapod.home, "platform.z": -hexapod.home["platform.z"]}
    near = {name: mirrored[name] for name in hexapod.driven}
    other = parakin.compile("gough-stewart", coordinates="all", near=near)
    names = [f"U{k}.cone" for k in range(1, 7)]
    assert max(abs(hexapod.home[name]) for name in names) < 1e-12
    assert min(other.home[name] for name in names) > 0.5
    assert isinstance(other.plan.cones["U1.cone"], Cone)
