"""Efforts of open chains, by parakin and by other engines; a mechanism with all that acts in it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import parakin
from parakin.model.evaluation import graph_of
from parakin.model.graph import Graph

Array = NDArray[np.float64]


def all_actuated(mechanism: parakin.Mechanism) -> parakin.Mechanism:
    """With a motor on every joint that has coordinates, and without limits."""
    joints = tuple(
        joint.model_copy(update={"actuated": joint.kind not in ("fixed", "rod")})
        for joint in mechanism.joints
    )
    return mechanism.model_copy(update={"joints": joints, "limits": {}})


def weightless(mechanism: parakin.Mechanism) -> parakin.Mechanism:
    """Without masses, drives and payloads."""
    keys = ("mass", "com", "inertia")
    bodies = tuple(
        body.model_copy(update={**dict.fromkeys(keys), "solid": ()}) for body in mechanism.bodies
    )
    joints = tuple(joint.model_copy(update={"drive": None}) for joint in mechanism.joints)
    return mechanism.model_copy(update={"bodies": bodies, "joints": joints, "forces": {}})


def efforts(mechanism: parakin.Mechanism, q: Array, qd: Array, qdd: Array) -> Array:
    """Those of all coordinates of an open chain, each actuated and driven."""
    moved = all_actuated(mechanism)
    names = [c.name for c in graph_of(moved).coordinates]
    solver = parakin.compile(moved, names, machine_code=False)
    answer = solver.at(q, qd, qdd, forces=True)
    assert not np.any(answer.status)
    assert answer.forces is not None
    found: Array = np.asarray(answer.forces.effort, dtype=float)
    return found.reshape(len(names))


def of_mujoco(model: Any, q: Array, qd: Array, qdd: Array) -> Array:
    """Inverse dynamics, without what only MuJoCo has: contacts, limits."""
    import mujoco

    bits = mujoco.mjtDisableBit
    model.opt.disableflags |= bits.mjDSBL_CONTACT | bits.mjDSBL_LIMIT
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.qacc[:] = q, qd, qdd
    mujoco.mj_inverse(model, data)
    found: Array = data.qfrc_inverse.copy()
    return found


def masses(graph: Graph) -> dict[str, Any]:
    """By body: mass, first and second moments in its own frame; what weighs nothing is left out."""
    found = {}
    for k, mass in graph.dynamics.masses.items():
        if mass.mass:
            com = np.array(mass.com)
            found[graph.bodies[k]] = np.hstack([mass.mass, com, np.ravel(mass.inertia)])
    return found
