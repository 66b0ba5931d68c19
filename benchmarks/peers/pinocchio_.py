"""Pinocchio: an open tree with frames where its loops close.

The engine gives frames, their Jacobians and, of frames without joint accelerations, their own.
Newton's iteration on them is the user's, pose by pose in Python.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from benchmarks.baselines import D1, D2, D3, D4, D5, L1, L2, L3, L4, S_A, S_B, S_C, B, H
from benchmarks.peers.dimensions import AXES, FEET, STROKE_0, TOPS
from benchmarks.peers.ways import POSE, SLIDERS, Both, Floats, moving, newton, one_by_one

HERE = pin.SE3.Identity()
WORLD = pin.LOCAL_WORLD_ALIGNED
X, Y, Z = np.eye(3)
SIX, REST = slice(0, 6), slice(6, None)  # pose or lengths, then what is sought


def framed(model: Any, joint: int, at: Floats) -> int:
    place = pin.SE3(np.eye(3), at)
    return int(model.addFrame(pin.Frame(str(model.nframes), joint, place, pin.FrameType.OP_FRAME)))


def flight_simulator() -> Both:
    model = pin.Model()

    def joint(parent: int, kind: Any, at: Floats) -> int:
        place = pin.SE3(np.eye(3), at)
        return int(model.addJoint(parent, kind, place, f"joint {model.njoints}"))

    foot, along = (D2 + D3 + D4) * X, pin.JointModelPrismaticUnaligned
    target = joint(joint(0, pin.JointModelPX(), 0 * X), pin.JointModelPY(), 0 * X)
    piston = joint(joint(0, pin.JointModelRZ(), 0 * X), pin.JointModelPX(), 0 * X)
    rod = joint(piston, pin.JointModelRevoluteUnaligned(-Z), (S_A + L1) * X)
    platform = joint(rod, pin.JointModelRX(), 0 * X)
    leg_b = joint(joint(0, pin.JointModelUniversal(Z, X), foot + D5 * Z), along(-Z), 0 * X)
    leg_c = joint(joint(0, pin.JointModelUniversal(Z, -X), foot - D5 * Z), along(Z), 0 * X)
    crank_d = joint(0, pin.JointModelRZ(), (D2 + D3) * X)
    crank_e = joint(0, pin.JointModelRZ(), D2 * X)
    slider = joint(rod, pin.JointModelPX(), D1 * X)
    # Where two bodies meet, on either
    meetings = (
        (platform, H * X, target, 0 * X),
        (crank_d, L3 * X, rod, D1 * X),
        (crank_e, L4 * X, slider, 0 * X),
        (leg_b, -(S_B + L2) * Z, platform, H * X + B / 2 * Z),
        (leg_c, (S_C + L2) * Z, platform, H * X - B / 2 * Z),
    )
    ones = [framed(model, one, at) for one, at, _, _ in meetings]
    rest = [framed(model, other, at) for _, _, other, at in meetings]
    data = model.createData()
    # Views of the engine's memory, since reading through data.oMf costs more than the kinematics
    one_at, other_at = ([data.oMf[k].translation for k in frames] for frames in (ones, rest))
    order = [0, 1, 5, 2, 3, 4, *range(6, 15)]  # phi was added after A3
    closing = [0, 1, 3, 4, 6, 7, *range(9, 15)]  # the first three meet in the plane anyway
    still = np.zeros(model.nv)

    def rows(q: Floats) -> tuple[Floats, Floats]:
        values = np.empty(model.nq)
        values[order] = q
        pin.computeJointJacobians(model, data, values)  # and the kinematics
        pin.updateFramePlacements(model, data)
        jacobian = np.concatenate(
            [
                pin.getFrameJacobian(model, data, one, WORLD)[:3]
                - pin.getFrameJacobian(model, data, other, WORLD)[:3]
                for one, other in zip(ones, rest, strict=True)
            ]
        )
        residual = np.concatenate(one_at) - np.concatenate(other_at)
        return residual[closing], jacobian[closing][:, order]

    def drift(q: Floats, qd: Floats) -> Floats:
        values, rates = np.empty(model.nq), np.empty(model.nv)
        values[order], rates[order] = q, qd
        pin.forwardKinematics(model, data, values, rates, still)
        found = [
            pin.getFrameClassicalAcceleration(model, data, one, WORLD).linear
            - pin.getFrameClassicalAcceleration(model, data, other, WORLD).linear
            for one, other in zip(ones, rest, strict=True)
        ]
        return np.concatenate(found)[closing]

    inverse, forward = (one_by_one(moving(rows, drift, driven)) for driven in (POSE, SLIDERS))
    return Both(inverse, forward)


def hexapod() -> Both:
    model = pin.Model()
    platform = model.addJoint(0, pin.JointModelTranslation(), HERE, "xyz")
    for turn in (pin.JointModelRX(), pin.JointModelRY(), pin.JointModelRZ()):
        platform = model.addJoint(platform, turn, HERE, turn.shortname())
    tops, tips = [], []
    for i in range(6):
        foot = pin.SE3(AXES[i], FEET[i])
        cylinder = model.addJoint(0, pin.JointModelUniversal(Z, X), foot, f"U{i}")
        piston = model.addJoint(cylinder, pin.JointModelPZ(), HERE, f"P{i}")
        tops.append(framed(model, platform, TOPS[i]))
        tips.append(framed(model, piston, STROKE_0 * Z))
    data = model.createData()
    top_at, tip_at = ([data.oMf[k].translation for k in frames] for frames in (tops, tips))
    values = np.zeros(model.nq)

    def jacobians(frames: list[int]) -> list[Floats]:
        return [pin.getFrameJacobian(model, data, k, WORLD)[:3] for k in frames]

    def loops(q: Floats) -> tuple[Floats, Floats]:
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        residual = np.concatenate(tip_at) - np.concatenate(top_at)
        return residual, np.concatenate(jacobians(tips)) - np.concatenate(jacobians(tops))

    by_both = np.hstack((-np.eye(6), np.empty((6, 6))))  # lengths and pose

    def distances(q: Floats) -> tuple[Floats, Floats]:
        values[:6] = q[6:]
        pin.computeJointJacobians(model, data, values)
        pin.updateFramePlacements(model, data)
        rods = np.array(top_at) - FEET
        lengths = np.sqrt(np.vecdot(rods, rods))
        by_pose = np.array(jacobians(tops))[:, :, :6]
        by_both[:, 6:] = np.einsum("ij,ijk->ik", rods, by_pose) / lengths[:, None]
        return lengths - STROKE_0 - q[:6], by_both

    def joints(given: Floats, guess: Floats) -> tuple[Floats]:
        return (newton(loops, SIX, REST, given[0], guess)[0][6:],)

    def pose(given: Floats, guess: Floats) -> tuple[Floats]:
        return (newton(distances, SIX, REST, given[0], guess)[0][6:],)

    return Both(one_by_one(joints), one_by_one(pose))
