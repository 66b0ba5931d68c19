"""Exported models in other engines: poses by Newton on their gaps, rates by their Jacobians.

Only the model file is shared with parakin. Gaps of the loops, Jacobians and the Jacobians'
derivatives in time are the engine's own, the least squares NumPy's.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

import parakin
from parakin.motion.motion import Motion, Samples

Array = NDArray[np.float64]


class Moving(NamedTuple):
    """A body's place, orientation, velocities and accelerations in the world."""

    p: Array
    R: Array
    v: Array
    w: Array
    a: Array
    alpha: Array


class MujocoTwin:
    """A model whose loops are pairs of sites, as `parakin export` writes them."""

    def __init__(self, model: Any) -> None:
        import mujoco

        self.mj, self.model, self.data = mujoco, model, mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, self.data, 0)
        kinds = mujoco.mjtEq
        pairs = list(zip(model.eq_obj1id, model.eq_obj2id, model.eq_type, strict=True))
        self.loops = [
            (int(a), int(b), kind == kinds.mjEQ_WELD)
            for a, b, kind in pairs
            if kind != kinds.mjEQ_JOINT
        ]
        self.screws = [  # slide, hinge and how far the one goes as the other turns
            (int(pair[0]), int(pair[1]), float(data[1]))
            for pair, data in zip(pairs, model.eq_data, strict=True)
            if pair[2] == kinds.mjEQ_JOINT
        ]

    def place(self, name: str) -> int:
        return int(self.model.jnt_qposadr[self.model.joint(name).id])

    def _forward(self) -> None:
        self.mj.mj_kinematics(self.model, self.data)
        self.mj.mj_comPos(self.model, self.data)
        self.mj.mj_comVel(self.model, self.data)  # what the Jacobians' derivatives need

    def _gaps(self) -> Array:
        gaps: list[Array] = []
        for a, b, frames in self.loops:
            gaps.append(self.data.site_xpos[a] - self.data.site_xpos[b])
            if frames:
                turn = (
                    np.array(self.data.site_xmat[a]).reshape(3, 3)
                    @ np.array(self.data.site_xmat[b]).reshape(3, 3).T
                )
                gaps.append(0.5 * (turn[[2, 0, 1], [1, 2, 0]] - turn[[1, 2, 0], [2, 0, 1]]))
        off = self.data.qpos - self.model.qpos0  # every joint is a hinge or a slide
        gaps += [np.array([off[slide] - ratio * off[hinge]]) for slide, hinge, ratio in self.screws]
        return np.concatenate(gaps)

    def _rows(self, of: Any) -> Array:
        """Rows of the loops' Jacobian, or of its derivative, from those of the sites."""
        rows = []
        for a, b, frames in self.loops:
            (p, r), (q, s) = of(a), of(b)
            rows.append(p - q)
            if frames:
                rows.append(r - s)
        for slide, hinge, ratio in self.screws:
            row = np.zeros((1, self.model.nv))
            if of == self._jacobian:
                row[0, slide], row[0, hinge] = 1.0, -ratio
            rows.append(row)
        return np.concatenate(rows)

    def _jacobian(self, site: int) -> tuple[Array, Array]:
        p, r = np.zeros((3, self.model.nv)), np.zeros((3, self.model.nv))
        self.mj.mj_jacSite(self.model, self.data, p, r, site)
        return p, r

    def _derivative(self, site: int) -> tuple[Array, Array]:
        body = int(self.model.site_bodyid[site])
        return self._dot(self.data.site_xpos[site], body)

    def _dot(self, point: Array, body: int) -> tuple[Array, Array]:
        p, r = np.zeros((3, self.model.nv)), np.zeros((3, self.model.nv))
        self.mj.mj_jacDot(self.model, self.data, p, r, point, body)
        return p, r

    def solve(self, y: dict[str, float], yd: dict[str, float], ydd: dict[str, float]) -> None:
        """The pose near the one before, then rates and second rates of every coordinate."""
        given = [self.place(name) for name in y]
        free = [k for k in range(self.model.nq) if k not in given]
        data = self.data
        data.qpos[given], data.qvel[:], data.qacc[:] = list(y.values()), 0.0, 0.0
        for _ in range(50):
            self._forward()
            J = self._rows(self._jacobian)
            step = np.linalg.lstsq(J[:, free], self._gaps(), rcond=1e-9)[0]
            data.qpos[free] -= step
            if np.abs(step).max() < 1e-13:
                break
        else:
            raise RuntimeError("Newton's iteration did not settle")
        self._forward()
        J = self._rows(self._jacobian)
        data.qvel[given] = list(yd.values())
        data.qvel[free] = np.linalg.lstsq(J[:, free], -J[:, given] @ data.qvel[given], 1e-9)[0]
        self._forward()
        bias = self._rows(self._derivative) @ data.qvel
        data.qacc[given] = list(ydd.values())
        right = -J[:, given] @ data.qacc[given] - bias
        data.qacc[free] = np.linalg.lstsq(J[:, free], right, 1e-9)[0]

    def body(self, name: str) -> Moving:
        body, data = self.model.body(name).id, self.data
        J, r = np.zeros((3, self.model.nv)), np.zeros((3, self.model.nv))
        self.mj.mj_jacBody(self.model, data, J, r, body)
        J_dot, r_dot = self._dot(data.xpos[body], body)
        return Moving(
            np.array(data.xpos[body]),
            np.array(data.xmat[body]).reshape(3, 3),
            J @ data.qvel,
            r @ data.qvel,
            J @ data.qacc + J_dot @ data.qvel,
            r @ data.qacc + r_dot @ data.qvel,
        )


class PinocchioTwin:
    """The same file with the constraint models that Pinocchio makes of its equalities."""

    def __init__(self, path: Path) -> None:
        import pinocchio as pin

        self.pin = pin
        self.model, points, frames = pin.buildModelAndConstraintsFromMJCF(str(path))
        self.data = self.model.createData()
        self.loops = [*points, *frames]
        self.states = [loop.createData() for loop in self.loops]
        self.q = np.array(self.model.referenceConfigurations["home"])
        self.qd, self.qdd = np.zeros(self.model.nv), np.zeros(self.model.nv)
        # A body's hinges and slides are one composite joint, in the order of the file.
        names = [
            str(element.get("name"))
            for element in ElementTree.parse(path).getroot().iterfind("worldbody//joint")
        ]
        self._places = {name: k for k, name in enumerate(names)}

    def place(self, name: str) -> int:
        return self._places[name]

    def _loops(self, qd: Array, qdd: Array) -> tuple[Array, Array, Array]:
        """Gaps, Jacobian and accelerations of the gaps at the present pose."""
        pin, model, data = self.pin, self.model, self.data
        pin.forwardKinematics(model, data, self.q, qd, qdd)
        pin.computeJointJacobians(model, data, self.q)
        gaps, rows, drifts = [], [], []
        for loop, state in zip(self.loops, self.states, strict=True):
            loop.calc(model, data, state)
            gaps.append(np.ravel(state.constraint_position_error))
            rows.append(loop.jacobian(model, data, state))
            drifts.append(np.ravel(state.constraint_acceleration_error))
        return np.concatenate(gaps), np.concatenate(rows), np.concatenate(drifts)

    def solve(self, y: dict[str, float], yd: dict[str, float], ydd: dict[str, float]) -> None:
        """The pose near the one before, then rates and second rates of every coordinate."""
        given = [self.place(name) for name in y]
        free = [k for k in range(self.model.nv) if k not in given]
        still = np.zeros(self.model.nv)
        self.q[given] = list(y.values())
        for _ in range(50):
            gaps, J, _ = self._loops(still, still)
            step = np.linalg.lstsq(J[:, free], gaps, rcond=1e-9)[0]
            self.q[free] -= step
            if np.abs(step).max() < 1e-13:
                break
        else:
            raise RuntimeError("Newton's iteration did not settle")
        _, J, _ = self._loops(still, still)
        self.qd[given], self.qdd[given] = list(yd.values()), list(ydd.values())
        self.qd[free] = np.linalg.lstsq(J[:, free], -J[:, given] @ self.qd[given], 1e-9)[0]
        _, J, drift = self._loops(self.qd, still)
        right = -J[:, given] @ self.qdd[given] - drift
        self.qdd[free] = np.linalg.lstsq(J[:, free], right, 1e-9)[0]
        self.pin.forwardKinematics(self.model, self.data, self.q, self.qd, self.qdd)
        self.pin.updateFramePlacements(self.model, self.data)

    def body(self, name: str) -> Moving:
        pin, model, data = self.pin, self.model, self.data
        frame = model.getFrameId(name, pin.FrameType.BODY)
        there, aligned = data.oMf[frame], pin.LOCAL_WORLD_ALIGNED
        v = pin.getFrameVelocity(model, data, frame, aligned)
        a = pin.getFrameClassicalAcceleration(model, data, frame, aligned)
        return Moving(
            *(np.array(x) for x in (there.translation, there.rotation)),
            *(np.array(x) for x in (v.linear, v.angular, a.linear, a.angular)),
        )


def along(solver: parakin.Solver, count: int) -> Motion:
    """So many samples of the mechanism's last motion, or of a swing about home where its driven
    coordinates are not the solver's.
    """
    if set(solver.driven) == set(solver.mechanism.driven):
        name = list(solver.mechanism.motions)[-1]
        motion = solver.motion(name)
        first, last = (motion.window(i, i + 1).time[0] for i in (0, motion.count - 1))
        return solver.motion(name, rate=(count - 1) / float(last - first))
    time = np.linspace(0.0, 1.0, count)
    home = np.array([[solver.home[name]] for name in solver.driven])
    swing = 0.01 * np.array([np.sin(6 * time), 6 * np.cos(6 * time), -36 * np.sin(6 * time)])

    def window(start: int, stop: int) -> Samples:
        y, yd, ydd = swing[:, start:stop]
        return Samples(time[start:stop], home + y, 0 * home + yd, 0 * home + ydd)

    return Motion("swing", solver.driven, count, window, "given")


def rotation(quaternion: Array) -> Array:
    """The matrix of a quaternion, w first."""
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
