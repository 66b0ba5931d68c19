"""Efforts of the 6-UPS along its tour: the same masses and motion on parakin and its peers.

    python -m benchmarks.peers.forces

MuJoCo and Pinocchio load what `parakin export` writes, and are given positions, velocities and
accelerations of all joints of the open tree. Their inverse dynamics know nothing of the loops: the
forces in these, and with them the efforts, are the user's, from the Jacobians that the engine
gives. exudyn is told the dimensions and masses, and given every body's motion, which it found from
the platform's before; mass matrix, forces and the constraints' Jacobian are its own, the equations
between them the user's to solve. parakin is given the platform's motion, and finds the joints' by
itself. Differences are the largest over 1,000 poses. Nothing else should run.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

import parakin
from benchmarks.peers.dimensions import FEET, TOPS
from benchmarks.peers.ways import COUNT, Floats
from benchmarks.timing import best, machine
from parakin.model.dynamics import STANDARD_GRAVITY

if TYPE_CHECKING:
    from benchmarks.peers.exudyn_ import System

NAME, MOTION = "gough-stewart", "tour"
ACTUATED = [f"P{i}" for i in range(1, 7)]
State = dict[str, Floats]  # by coordinate: position, velocity and acceleration, (3, n)
Answer = Callable[[int], Floats]  # of one sample: forces in the six loops (18), efforts (6)


def solved() -> tuple[State, Floats, float]:
    """Every coordinate's motion, parakin's efforts (6, n), and its time of one in a batch."""
    every = parakin.compile(NAME, coordinates="all")
    samples = every.motion(MOTION, rate=(COUNT - 1) / 10).samples()
    given = samples.position, samples.velocity, samples.acceleration
    tick = every.at(*given)
    orders = np.stack([tick.position, tick.velocity, tick.acceleration])
    state = {name: orders[:, row] for row, name in enumerate(every.coordinates)}
    lean = parakin.compile(NAME, coordinates=ACTUATED, checks=False)
    forces = lean.at(*given, forces=True).forces
    assert forces is not None
    return state, forces.effort, best(lambda: lean.at(*given, forces=True)) / COUNT


def balanced(needed: Floats, loops: Floats, moved: list[int]) -> Floats:
    """Forces in the loops and efforts, which together give what the tree's joints need."""
    by = np.zeros((len(needed), len(loops) + len(moved)))
    by[:, : len(loops)] = loops.T
    by[moved, range(len(loops), by.shape[1])] = 1.0
    return np.asarray(np.linalg.solve(by, needed), dtype=float)


def of_mujoco(state: State, folder: Path) -> Answer:
    import mujoco

    (path,) = parakin.export(NAME, folder / "model.xml")
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT  # soft, and so no loops
    model.dof_armature[:] = 0.0  # rotors behind screws, which efforts do without
    data = mujoco.MjData(model)
    names = [model.joint(k).name for k in range(model.njnt)]
    moved = [int(model.joint(name).dofadr[0]) for name in ACTUATED]
    sites = [(int(a), int(b)) for a, b in zip(model.eq_obj1id, model.eq_obj2id, strict=True)]
    q, qd, qdd = (np.array([state[name][k] for name in names]) for k in range(3))
    one, other = np.zeros((3, model.nv)), np.zeros((3, model.nv))

    def efforts(k: int) -> Floats:
        data.qpos[:], data.qvel[:], data.qacc[:] = q[:, k], qd[:, k], qdd[:, k]
        mujoco.mj_inverse(model, data)
        rows = []
        for a, b in sites:
            mujoco.mj_jacSite(model, data, one, None, a)
            mujoco.mj_jacSite(model, data, other, None, b)
            rows.append(one - other)
        return balanced(data.qfrc_inverse, np.concatenate(rows), moved)

    return efforts


def of_pinocchio(state: State, folder: Path) -> Answer:
    import pinocchio as pin

    path, loops = parakin.export(NAME, folder / "model.urdf")
    assert loops.exists()
    model = pin.buildModelFromUrdf(str(path))
    model.gravity.linear = np.array([0.0, 0.0, -STANDARD_GRAVITY])  # not in the file; 9.81 there
    data = model.createData()
    names = list(model.names)[1:]
    moved = [int(model.joints[model.getJointId(name)].idx_v) for name in ACTUATED]
    ends = [(f"S{i}_A", f"S{i}_B") for i in range(1, 7)]
    frames = [(model.getFrameId(a), model.getFrameId(b)) for a, b in ends]
    values, qd, qdd = (np.array([state[name][k] for name in names]) for k in range(3))
    q = np.concatenate([_configured(model, name, state[name][0]) for name in names])
    assert len(values) == model.nv
    world: Any = pin.LOCAL_WORLD_ALIGNED

    def efforts(k: int) -> Floats:
        needed = pin.rnea(model, data, q[:, k], qd[:, k], qdd[:, k])
        pin.computeJointJacobians(model, data, q[:, k])
        pin.updateFramePlacements(model, data)
        rows = [
            pin.getFrameJacobian(model, data, a, world)[:3]
            - pin.getFrameJacobian(model, data, b, world)[:3]
            for a, b in frames
        ]
        return balanced(needed, np.concatenate(rows), moved)

    return efforts


def _configured(model: Any, name: str, values: Floats) -> Floats:
    """As the engine has it: an angle without limits by its cosine and sine."""
    turns = model.joints[model.getJointId(name)].nq == 2
    return np.stack([np.cos(values), np.sin(values)]) if turns else values[None, :]


def of_exudyn(state: State, _: Path) -> Answer:
    from exudyn.rigidBodyUtilities import RigidBodyInertia

    from benchmarks.peers.exudyn_ import HOME, driven_legs, driven_platform

    def tube(along: Floats, outer: float, inner: float) -> Any:
        """A steel one of 0.7 m from its body's origin, of diameters in metres."""
        mass = 7850.0 * 0.7 * np.pi / 4 * (outer**2 - inner**2)
        axial = mass * (outer**2 + inner**2) / 8
        across = axial / 2 + mass * 0.7**2 / 12
        tensor = across * np.eye(3) + (axial - across) * np.outer(along, along)
        return RigidBodyInertia(mass, tensor, 0.35 * along, inertiaTensorAtCOM=True)

    inertias = [
        RigidBodyInertia(
            250.0, np.diag([40.0, 45.0, 60.0]), np.array([0.0, 0.0, 0.25]), inertiaTensorAtCOM=True
        )
    ]
    for foot, top in zip(FEET, HOME + TOPS, strict=True):
        along = (top - foot) / np.linalg.norm(top - foot)
        inertias += [tube(along, 0.08, 0.064), tube(-along, 0.05, 0.04)]
    platform = [f"platform.{name}" for name in ("x", "y", "z", "roll", "pitch", "yaw")]
    given = np.array([state[name] for name in platform])
    move = driven_platform().solution(lambda states: states)
    states = [np.reshape(move(each, each), (3, -1)) for each in given.T]
    strokes = np.array([state[name][0] for name in ACTUATED])
    multipliers = _multipliers(driven_legs(inertias))
    return lambda k: multipliers(states[k], strokes[:, k])


def _multipliers(system: System) -> Callable[[Floats, Floats], Floats]:
    """Those of ball joints and drives, from the bodies' coordinates with their rates, (3, n)."""
    import exudyn

    mbs, data = system.mbs, system.mbs.systemData
    solver, _, rows = system.assembled()
    n = solver.GetODE2size()
    home = np.array(data.GetODE2Coordinates(exudyn.ConfigurationType.Reference))

    def solve(states: Floats, driven: Floats) -> Floats:
        for (number, what, at_zero), value in zip(system.drives, driven, strict=True):
            mbs.SetObjectParameter(number, what, float(at_zero + value))  # scales its row
        jacobian = rows(states[0] - home)
        data.SetODE2Coordinates_t(states[1])
        solver.ComputeMassMatrix(mbs)
        solver.ComputeODE2RHS(mbs)
        acting = np.array(solver.GetSystemResidual()[:n])
        needed = np.array(solver.GetSystemMassMatrix()) @ states[2] - acting
        found = np.linalg.solve(jacobian.T, needed)
        legs = found[:72].reshape(6, 12)  # universal 4, prismatic 5, spherical 3
        return np.concatenate([legs[:, 9:].ravel(), found[72:]])

    return solve


def main() -> None:
    state, ours, seconds = solved()
    print(f"{machine()}\n")
    print("| 6-UPS, efforts | largest difference from parakin | a pose |\n|---|---|---|")
    print(f"| parakin {version('parakin')}, kinematics included | | {1e9 * seconds:.0f} ns |")
    for title, distribution, build in (
        ("MuJoCo {}, `mj_inverse`", "mujoco", of_mujoco),
        ("Pinocchio {}, `rnea`", "pin", of_pinocchio),
        ("exudyn {}, its equations solved", "exudyn", of_exudyn),
    ):
        with TemporaryDirectory() as folder:
            efforts = build(state, Path(folder))
        found = np.array([efforts(k)[-6:] for k in range(COUNT)]).T
        start = time.perf_counter()
        for k in range(COUNT):
            efforts(k)
        each = (time.perf_counter() - start) / COUNT
        off = np.abs(found - ours).max()
        print(f"| {title.format(version(distribution))} | {off:.0e} N | {1e6 * each:.0f} µs |")


if __name__ == "__main__":
    main()
