"""What the hexapod costs on MuJoCo and on Pinocchio.

Both engines give frames and Jacobians of open chains, and know loops as constraints of a dynamic
simulation; Newton's iteration on them is the user's. It is written here as someone at home in the
engine would: one model of platform and legs, a few calls of the engine a step, a Python loop over
the poses, since neither engine takes batches. The inverse solves the 18 joint coordinates of the
six U-P chains from their 18 loop equations, each pose starting from the one before; the forward
solves the pose from the six distances between the ends of the legs, as it needs no passive joint.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

import parakin

Floats: TypeAlias = NDArray[np.floating[Any]]
System: TypeAlias = Callable[[Floats, Floats], tuple[Floats, Floats]]

CLOSED = 1e-12  # [m], parakin's own tolerance for this mechanism


class Peer(NamedTuple):
    """Seconds a pose, and the largest difference from parakin's answers [m or rad]."""

    version: str
    inverse_seconds: float
    forward_seconds: float
    error: float


def newton(system: System, given: Floats, unknowns: Floats) -> Floats:
    """The unknowns at which the system's residual vanishes; it gives its Jacobian by them too."""
    for _ in range(20):
        residual, jacobian = system(given, unknowns)
        if np.abs(residual).max() < CLOSED:
            return unknowns
        unknowns = unknowns - np.linalg.solve(jacobian, residual)
    raise RuntimeError("Newton's iteration did not settle")


def best(solve: Callable[[], list[Floats]], repeats: int = 7) -> tuple[float, Floats]:
    """Seconds a pose, the best of several runs, and the answers as columns."""
    found = np.inf
    for _ in range(repeats):
        start = time.perf_counter()
        answers = solve()
        found = min(found, time.perf_counter() - start)
    return float(found) / len(answers), np.array(answers).T


class Hexapod:
    """The catalogue's dimensions, and parakin's answers to compare with."""

    def __init__(self) -> None:
        names = [name for i in range(1, 7) for name in (f"U{i}.1", f"U{i}.2", f"P{i}")]
        self.solver = parakin.compile("gough-stewart", coordinates=names, derivatives=0)
        self.home = np.array([self.solver.home[name] for name in names])
        self.stroke_0 = self.solver.graph.parameters["stroke_0"]
        joints = {joint.name: joint for joint in self.solver.graph.joints}
        self.axes = np.array([joints[f"U{i}"].F.R for i in range(1, 7)])
        self.feet = np.array([joints[f"U{i}"].F.p for i in range(1, 7)])
        self.tops = np.array([joints[f"S{i}"].M.p for i in range(1, 7)])

    def peer(
        self,
        version: str,
        loops: System,
        distances: System,
        poses: Floats,
        lengths: Floats,
        guesses: Floats,
    ) -> Peer:
        """Time joints by the loops at a pose, and poses by the distances from foot to top."""

        def inverse() -> list[Floats]:
            answers = [self.home]
            for pose in poses.T:
                answers.append(newton(loops, pose, answers[-1]))
            return answers[1:]

        def forward() -> list[Floats]:
            given = zip((self.stroke_0 + lengths).T, guesses.T, strict=True)
            return [newton(distances, six, guess) for six, guess in given]

        inverse_seconds, joints = best(inverse)
        forward_seconds, found = best(forward)
        answers = self.solver.at(poses).position
        differences = np.vstack((joints - answers, joints[2::3] - lengths, found - poses))
        return Peer(version, inverse_seconds, forward_seconds, float(np.abs(differences).max()))


def mujoco_hexapod(poses: Floats, lengths: Floats, guesses: Floats) -> Peer | None:
    """Loops as connect constraints, distances as spatial tendons; None without MuJoCo."""
    try:
        import mujoco  # type: ignore[import, unused-ignore]
    except ImportError:
        return None
    hexapod = Hexapod()
    hinge, slide = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE
    connect, site = mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtObj.mjOBJ_SITE
    x, y, z = np.eye(3)
    spec = mujoco.MjSpec()
    spec.compiler.boundmass = spec.compiler.boundinertia = 1  # it takes no body without mass
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    base, platform = spec.worldbody, spec.worldbody.add_body(name="platform")
    for kind in (slide, hinge):
        for axis in (x, y, z):
            platform.add_joint(type=kind, axis=axis)
    for i in range(6):
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, hexapod.axes[i].ravel())
        body = base.add_body(pos=hexapod.feet[i], quat=quaternion)
        for kind, axis in ((hinge, z), (hinge, x), (slide, z)):
            body.add_joint(type=kind, axis=axis)
        body.add_site(name=f"tip{i}", pos=hexapod.stroke_0 * z)
        base.add_site(name=f"foot{i}", pos=hexapod.feet[i])
        platform.add_site(name=f"top{i}", pos=hexapod.tops[i])
        spec.add_equality(type=connect, objtype=site, name1=f"top{i}", name2=f"tip{i}")
        tendon = spec.add_tendon()
        tendon.wrap_site(f"foot{i}")
        tendon.wrap_site(f"top{i}")
    model = spec.compile()
    data = mujoco.MjData(model)

    def loops(pose: Floats, joints: Floats) -> tuple[Floats, Floats]:
        data.qpos[:6], data.qpos[6:] = pose, joints
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)  # what Jacobians are made from
        mujoco.mj_makeConstraint(model, data)
        return data.efc_pos, data.efc_J.reshape(18, 24)[:, 6:]

    def distances(given: Floats, pose: Floats) -> tuple[Floats, Floats]:
        data.qpos[:6] = pose
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_tendon(model, data)
        return data.ten_length - given, data.ten_J.reshape(6, 6)  # stored without its zeros

    return hexapod.peer(mujoco.__version__, loops, distances, poses, lengths, guesses)


def pinocchio_hexapod(poses: Floats, lengths: Floats, guesses: Floats) -> Peer | None:
    """Loops and distances between frames; None without Pinocchio."""
    try:
        import pinocchio as pin  # type: ignore[import, unused-ignore]
    except ImportError:
        return None
    hexapod = Hexapod()
    x, _, z = np.eye(3)
    here = pin.SE3.Identity()
    model = pin.Model()
    platform = model.addJoint(0, pin.JointModelTranslation(), here, "xyz")
    for turn in (pin.JointModelRX(), pin.JointModelRY(), pin.JointModelRZ()):
        platform = model.addJoint(platform, turn, here, turn.shortname())

    def frame(name: str, joint: int, at: Floats) -> int:
        added = pin.Frame(name, joint, pin.SE3(np.eye(3), at), pin.FrameType.OP_FRAME)
        return int(model.addFrame(added))

    tops, tips = [], []
    for i in range(6):
        foot = pin.SE3(hexapod.axes[i], hexapod.feet[i])
        cylinder = model.addJoint(0, pin.JointModelUniversal(z, x), foot, f"U{i}")
        piston = model.addJoint(cylinder, pin.JointModelPZ(), here, f"P{i}")
        tops.append(frame(f"top{i}", platform, hexapod.tops[i]))
        tips.append(frame(f"tip{i}", piston, hexapod.stroke_0 * z))
    data = model.createData()
    # Views of the engine's memory, since reading through data.oMf costs more than the kinematics
    top_at, tip_at = ([data.oMf[k].translation for k in frames] for frames in (tops, tips))
    q = np.zeros(model.nq)

    def jacobians(frames: list[int]) -> list[Floats]:
        return [pin.getFrameJacobian(model, data, k, pin.LOCAL_WORLD_ALIGNED)[:3] for k in frames]

    def loops(pose: Floats, joints: Floats) -> tuple[Floats, Floats]:
        q[:6], q[6:] = pose, joints
        pin.computeJointJacobians(model, data, q)  # and the kinematics
        pin.updateFramePlacements(model, data)
        residual = np.concatenate(tip_at) - np.concatenate(top_at)
        return residual, np.concatenate(jacobians(tips))[:, 6:]

    def distances(given: Floats, pose: Floats) -> tuple[Floats, Floats]:
        q[:6] = pose
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        rods = np.array(top_at) - hexapod.feet
        lengths = np.sqrt(np.vecdot(rods, rods))
        by_pose = np.array(jacobians(tops))[:, :, :6]
        return lengths - given, np.einsum("ij,ijk->ik", rods, by_pose) / lengths[:, None]

    return hexapod.peer(pin.__version__, loops, distances, poses, lengths, guesses)
