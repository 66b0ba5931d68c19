"""MuJoCo: an open tree, its loops as connect constraints, lengths as spatial tendons.

The engine gives the constraints' residual and Jacobian at a configuration, and the rate of a
point's Jacobian. Newton's iteration on them is the user's, pose by pose in Python: the engine's own
solver is one of dynamics and softens its constraints.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from benchmarks.baselines import D1, D2, D3, D4, D5, L1, L2, L3, L4, S_A, S_B, S_C, B, H
from benchmarks.peers.dimensions import AXES, FEET, STROKE_0, TOPS
from benchmarks.peers.ways import (
    POSE,
    SLIDERS,
    VARIABLES,
    Both,
    Floats,
    moving,
    newton,
    one_by_one,
)

HINGE, SLIDE = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE
X, Y, Z = np.eye(3)
SIX, REST = slice(0, 6), slice(6, None)  # pose or lengths, then what is sought


def specification() -> Any:
    spec = mujoco.MjSpec()
    spec.compiler.boundmass = spec.compiler.boundinertia = 1  # it takes no body without mass
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    return spec


def connect(spec: Any, one: str, other: str) -> None:
    kind, site = mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtObj.mjOBJ_SITE
    spec.add_equality(type=kind, objtype=site, name1=one, name2=other)


def flight_simulator() -> Both:
    spec = specification()

    def body(parent: Any, at: Floats, joints: tuple[tuple[str, Any, Floats], ...]) -> Any:
        added = parent.add_body(pos=at)
        for name, kind, axis in joints:
            added.add_joint(name=name, type=kind, axis=axis)
        return added

    base, foot = spec.worldbody, (D2 + D3 + D4) * X
    target = body(base, 0 * X, (("platform.x", SLIDE, X), ("platform.y", SLIDE, Y)))
    piston = body(base, 0 * X, (("A1", HINGE, Z), ("A2", SLIDE, X)))
    rod = body(piston, (S_A + L1) * X, (("A3", HINGE, -Z),))
    platform = body(rod, 0 * X, (("platform.phi", HINGE, X),))
    slider = body(rod, D1 * X, (("E2P", SLIDE, X),))
    turns_b = ("B1.1", HINGE, Z), ("B1.2", HINGE, X)
    turns_c = ("C1.1", HINGE, Z), ("C1.2", HINGE, -X)
    leg_b = body(base, foot + D5 * Z, (*turns_b, ("B3", SLIDE, -Z)))
    leg_c = body(base, foot - D5 * Z, (*turns_c, ("C3", SLIDE, Z)))
    crank_d = body(base, (D2 + D3) * X, (("D1", HINGE, Z),))
    crank_e = body(base, D2 * X, (("E1", HINGE, Z),))
    # Where two bodies meet, on either
    meetings = (
        (platform, H * X, target, 0 * X),
        (crank_d, L3 * X, rod, D1 * X),
        (crank_e, L4 * X, slider, 0 * X),
        (leg_b, -(S_B + L2) * Z, platform, H * X + B / 2 * Z),
        (leg_c, (S_C + L2) * Z, platform, H * X - B / 2 * Z),
    )
    for k, (one, at, other, at_other) in enumerate(meetings):
        one.add_site(name=f"one{k}", pos=at)
        other.add_site(name=f"other{k}", pos=at_other)
        connect(spec, f"one{k}", f"other{k}")
    model = spec.compile()
    data = mujoco.MjData(model)
    order = [model.joint(name).qposadr[0] for name in VARIABLES]
    closing = [0, 1, 3, 4, 6, 7, *range(9, 15)]  # the first three meet in the plane anyway
    sites = [(model.site(f"one{k}"), model.site(f"other{k}")) for k in range(5)]
    ends = [[(site.id, site.bodyid[0]) for site in pair] for pair in sites]
    rates = np.zeros((2, 3, model.nv))

    def rows(q: Floats) -> tuple[Floats, Floats]:
        data.qpos[order] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)  # what Jacobians are made from
        mujoco.mj_makeConstraint(model, data)
        return data.efc_pos[closing], data.efc_J.reshape(15, -1)[closing][:, order]

    def drift(_: Floats, qd: Floats) -> Floats:
        data.qvel[order] = qd  # the configuration is that of the last rows
        mujoco.mj_comVel(model, data)
        found = []
        for pair in ends:
            for rate, (site, number) in zip(rates, pair, strict=True):
                mujoco.mj_jacDot(model, data, rate, None, data.site_xpos[site], number)
            found.append((rates[0] - rates[1]) @ data.qvel)
        return np.concatenate(found)[closing]

    inverse, forward = (one_by_one(moving(rows, drift, driven)) for driven in (POSE, SLIDERS))
    return Both(inverse, forward)


def hexapod() -> Both:
    spec = specification()
    base, platform = spec.worldbody, spec.worldbody.add_body(name="platform")
    for kind in (SLIDE, HINGE):
        for axis in (X, Y, Z):
            platform.add_joint(type=kind, axis=axis)
    for i in range(6):
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, AXES[i].ravel())
        body = base.add_body(pos=FEET[i], quat=quaternion)
        for kind, axis in ((HINGE, Z), (HINGE, X), (SLIDE, Z)):
            body.add_joint(type=kind, axis=axis)
        body.add_site(name=f"tip{i}", pos=STROKE_0 * Z)
        base.add_site(name=f"foot{i}", pos=FEET[i])
        platform.add_site(name=f"top{i}", pos=TOPS[i])
        connect(spec, f"top{i}", f"tip{i}")
        tendon = spec.add_tendon()
        tendon.wrap_site(f"foot{i}")
        tendon.wrap_site(f"top{i}")
    model = spec.compile()
    data = mujoco.MjData(model)

    def loops(q: Floats) -> tuple[Floats, Floats]:
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_makeConstraint(model, data)
        return data.efc_pos, data.efc_J.reshape(18, 24)

    by_both = np.hstack((-np.eye(6), np.empty((6, 6))))  # lengths and pose

    def distances(q: Floats) -> tuple[Floats, Floats]:
        data.qpos[:6] = q[6:]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_tendon(model, data)
        by_both[:, 6:] = data.ten_J.reshape(6, 6)  # stored without its zeros
        return data.ten_length - STROKE_0 - q[:6], by_both

    def joints(given: Floats, guess: Floats) -> tuple[Floats]:
        return (newton(loops, SIX, REST, given[0], guess)[0][6:],)

    def pose(given: Floats, guess: Floats) -> tuple[Floats]:
        return (newton(distances, SIX, REST, given[0], guess)[0][6:],)

    return Both(one_by_one(joints), one_by_one(pose))
