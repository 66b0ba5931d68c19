"""A MuJoCo model beside the mechanism that parakin reads from the same file, compared."""

from __future__ import annotations

import math
import re

import mujoco
import numpy as np
from numpy.typing import NDArray
from random_mjcf import compiled, follow
from scipy.spatial.transform import Rotation
from weighty import efforts, of_mujoco

import parakin
from parakin.errors import AssemblyError
from parakin.kinematics.assembly import assembled
from parakin.kinematics.configuration import Configuration, configure
from parakin.kinematics.free_motions import free_motions
from parakin.model.evaluation import graph_of
from parakin.model.graph import Graph

Array = NDArray[np.float64]
SAME = 1e-9  # [m, rad]
_HINGE, _SLIDE = int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)
_FREE, _BALL = int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_BALL)


def adapted(name: str) -> str:
    """A name by parakin's rules, unless another has it already."""
    fit = re.sub(r"[^A-Za-z0-9_ '-]", "_", name)[:56].strip()
    return fit if fit[:1].isascii() and fit[:1].isalpha() else f"n{fit}"


def euler_rates(q: Array, qd: Array) -> tuple[Array, Array]:
    """From rates of angles about moving x, y, z to a body's angular velocity along its own axes,
    and how that changes (by a complex step).
    """
    a, b, c = q + 1e-30j * qd
    del a
    E = np.array(
        [
            [np.cos(b) * np.cos(c), np.sin(c), 0.0],
            [-np.cos(b) * np.sin(c), np.cos(c), 0.0],
            [np.sin(b), 0.0, 1.0],
        ]
    )
    return E.real, E.imag / 1e-30


class Twin:
    """A model in MuJoCo beside the mechanism read from the same file."""

    def __init__(self, graph: Graph, text: str) -> None:
        self.graph, self.model = graph, compiled(text)
        self.data = mujoco.MjData(self.model)
        self.numbers = {c.name: k for k, c in enumerate(graph.coordinates)}
        self.equations = [
            i for i in range(self.model.neq)
            if self.model.eq_active0[i] and self.model.eq_type[i] != mujoco.mjtEq.mjEQ_JOINT
        ]  # fmt: skip
        self.held = {
            int(self.model.eq_obj1id[i])
            for i in range(self.model.neq)
            if self.model.eq_active0[i]
            and self.model.eq_type[i] == mujoco.mjtEq.mjEQ_JOINT
            and self.model.eq_obj2id[i] < 0
        }

    def name(self, joint: int) -> str:
        return self.model.joint(joint).name or f"joint{joint}"

    def _six(self, joint: int) -> tuple[list[int], str] | None:
        """The coordinates of a free joint and the order of its angles."""
        name = adapted(self.name(joint))
        if f"{name}.1" in self.numbers:
            return [self.numbers[f"{name}.{k}"] for k in range(1, 7)], "XYZ"
        platform = self.graph.mechanism.platform
        if platform is None:
            return None
        labels = ["x", "y", "z", *(label for label, _ in platform.angles)]
        order = "".join(axis.upper() for _, axis in platform.angles)
        return [self.numbers[f"platform.{label}"] for label in labels], order

    def single(self, joint: int) -> int | None:
        """The coordinate that a hinge or slide is; None for a slide of a screw and held ones."""
        name = self.name(joint)
        platform = self.graph.mechanism.platform
        for known in (name, adapted(name)):
            if known in self.numbers:
                return self.numbers[known]
        stem, _, label = name.rpartition(".")
        if platform is not None and stem and label in "123":
            return self.numbers[f"platform.{'xyz'[int(label) - 1]}"]
        return self.numbers.get(f"platform.{label}") if stem else None

    def qpos(self, q: Array) -> Array:
        """parakin's coordinates as MuJoCo counts them."""
        qpos: Array = self.model.qpos0.copy()
        for j in range(self.model.njnt):
            k, kind = self.model.jnt_qposadr[j], self.model.jnt_type[j]
            if kind == _FREE:
                numbers, order = self._six(j) or ([], "")
                qpos[k : k + 3] = q[numbers[:3]]
                qpos[k + 3 : k + 7] = Rotation.from_euler(order, q[numbers[3:]]).as_quat()[
                    [3, 0, 1, 2]
                ]
            elif kind == _BALL:
                angles = [q[self.numbers[f"{adapted(self.name(j))}.{n}"]] for n in (1, 2, 3)]
                qpos[k : k + 4] = Rotation.from_euler("XYZ", angles).as_quat()[[3, 0, 1, 2]]
            elif (number := self.single(j)) is not None:
                qpos[k] = q[number]
        follow(self.model, qpos)
        return qpos

    def rates(self, q: Array, qd: Array) -> tuple[Array, Array]:
        """How MuJoCo's velocities follow from parakin's: J, and its derivative times these."""
        model = self.model
        J, onward = np.zeros((model.nv, len(q))), np.zeros(model.nv)
        for j in range(model.njnt):
            k, kind = int(model.jnt_dofadr[j]), model.jnt_type[j]
            if kind in (_FREE, _BALL):
                six = (self._six(j) or ([], ""))[0] if kind == _FREE else []
                turns = six[3:] or [self.numbers[f"{adapted(self.name(j))}.{n}"] for n in (1, 2, 3)]
                if six:
                    J[range(k, k + 3), six[:3]] = 1.0
                    k += 3
                E, E_dot = euler_rates(q[turns], qd[turns])
                J[k : k + 3, turns] = E
                onward[k : k + 3] = E_dot @ qd[turns]
            elif (number := self.single(j)) is not None:
                J[k, number] = 1.0
        for i in range(model.neq):  # screws
            one, two = int(model.eq_obj1id[i]), int(model.eq_obj2id[i])
            if model.eq_type[i] == mujoco.mjtEq.mjEQ_JOINT and two >= 0:
                ratio = model.eq_data[i][1]
                a, b = model.jnt_dofadr[one], model.jnt_dofadr[two]
                if model.jnt_type[one] == _SLIDE:
                    J[a] = ratio * J[b]
                else:
                    J[b] = J[a] / ratio
        return J, onward

    def compare(self, at: Configuration) -> None:
        """Poses of all bodies, and the gaps that MuJoCo finds in the loops."""
        self.data.qpos[:] = self.qpos(at.q)
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_makeConstraint(self.model, self.data)
        seen = 0
        for body in range(1, self.model.nbody):
            name = adapted(self.model.body(body).name or f"body{body}")
            p, R = self.data.xpos[body], self.data.xmat[body].reshape(3, 3)
            if name in self.graph.bodies:
                pose = at.pose(self.graph.bodies.index(name))
                np.testing.assert_allclose(pose.p, p, atol=SAME, err_msg=name)
                np.testing.assert_allclose(pose.R, R, atol=SAME, err_msg=name)
                seen += 1
            else:
                seen += self._point(at, name, p)
        assert seen == self.model.nbody - 1, "a body was lost"
        rows = self.data.efc_type[: self.data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        assert np.abs(self.data.efc_pos[: self.data.nefc][rows]).max(initial=0.0) < SAME

    def compare_masses(self, at: Configuration) -> None:
        """What MuJoCo's bodies weigh, gathered on those that they are rigid with here."""
        data, model = self.data, self.model
        gathered: dict[int, list[int]] = {}
        for body in range(1, model.nbody):
            name = adapted(model.body(body).name or f"body{body}")
            if name in self.graph.bodies:
                owner = self.graph.bodies.index(name)
            else:
                points = self.graph.points.items()
                owner = next(b for key, (b, _) in points if key.rpartition(".")[2] == name)
            gathered.setdefault(owner, []).append(body)
        for owner, parts in gathered.items():
            if owner == 0:
                continue
            mass, pose = self.graph.dynamics.masses[owner], at.pose(owner)
            m, R = model.body_mass[parts], np.array(pose.R)
            com = m @ data.xipos[parts] / m.sum()
            tensor = np.zeros((3, 3))
            for part in parts:
                r, turn = data.xipos[part] - com, data.ximat[part].reshape(3, 3)
                tensor += turn @ np.diag(model.body_inertia[part]) @ turn.T
                tensor += model.body_mass[part] * (r @ r * np.eye(3) - np.outer(r, r))
            np.testing.assert_allclose(mass.mass, m.sum(), rtol=SAME)
            np.testing.assert_allclose(pose.p + pose.R @ mass.com, com, atol=SAME)
            ours = R @ np.array(mass.inertia) @ R.T
            np.testing.assert_allclose(ours, tensor, atol=SAME * np.abs(tensor).max())

    def _point(self, at: Configuration, name: str, p: Array) -> bool:
        """Whether a body that is rigid with another is where it should be on it."""
        for key, (body, local) in self.graph.points.items():
            if key.rpartition(".")[2] == name:
                pose = at.pose(body)
                np.testing.assert_allclose(pose.R @ local + pose.p, p, atol=SAME, err_msg=name)
                return True
        return False

    def freedom(self) -> int:
        """In how many directions MuJoCo's equations let the model move from where it is."""
        size = self.model.nv
        J = np.zeros((self.data.nefc, size))
        for k in range(size):
            unit, row = np.zeros(size), np.zeros(self.data.nefc)
            unit[k] = 1.0
            mujoco.mj_mulJacVec(self.model, self.data, row, unit)
            J[:, k] = row
        rows = self.data.efc_type[: self.data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        free: int = size - int(np.linalg.matrix_rank(J[rows], tol=1e-7)) if rows.any() else size
        return free


def judge_read(mechanism: parakin.Mechanism, text: str, rng: np.random.Generator) -> str:
    """Compares a mechanism with its MJCF, and says what it is. AssertionError if they differ."""
    graph = graph_of(mechanism)
    twin = Twin(graph, text)
    _compare_home(twin, mechanism)
    _compare_limits(twin)
    if not twin.equations:
        for _ in range(3):
            twin.compare(configure(graph, graph.tree(), rng.normal(size=len(graph.coordinates))))
        compare_efforts(twin, mechanism, rng)
        assert twin.freedom() == len(graph.coordinates)
        return "tree"
    home = assembled(graph)
    twin.compare(home)
    twin.compare_masses(home)
    motions = free_motions(graph, graph.posed_tree(), configure(graph, graph.posed_tree(), home.q))
    assert twin.freedom() == motions.shape[1], "another mobility"
    other = elsewhere(mechanism, home, rng)
    if other is None:
        return "loops, at home only"
    twin.compare(other)
    return "loops"


def compare_efforts(twin: Twin, mechanism: parakin.Mechanism, rng: np.random.Generator) -> None:
    """Inverse dynamics of an open chain, by parakin and by MuJoCo."""
    if mechanism.platform is not None:
        return  # of the freedoms of its pose nobody asks for efforts
    q, qd, qdd = rng.normal(size=(3, len(twin.graph.coordinates)))
    J, onward = twin.rates(q, qd)
    model, kinds = twin.model, twin.model.jnt_type[twin.model.dof_jntid]
    for values in (model.dof_armature, model.dof_frictionloss):
        values[(kinds == _BALL) | (kinds == _FREE)] = 0.0  # of which a note tells
    model.dof_damping[kinds == _FREE] = 0.0
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_EQUALITY
    found = J.T @ of_mujoco(model, twin.qpos(q), J @ qd, J @ qdd + onward)
    ours = efforts(mechanism, q, qd, qdd)
    size = max(1.0, float(np.abs(found).max()))
    np.testing.assert_allclose(ours / size, found / size, rtol=0, atol=SAME)


def elsewhere(
    mechanism: parakin.Mechanism, home: Configuration, rng: np.random.Generator
) -> Configuration | None:
    """Another closed configuration near home, if assembly finds one."""
    aside = home.q + rng.normal(size=len(home.q)) * 0.1
    names = [c.name for c in home.circuits.graph.coordinates]
    guess = {name: float(q) for name, q in zip(names, aside, strict=True)}
    try:
        return assembled(graph_of(mechanism.model_copy(update={"guess": guess})))
    except AssemblyError:
        return None


def _compare_home(twin: Twin, mechanism: parakin.Mechanism) -> None:
    """The guess is the key frame's pose, or the model's first; what follows is where it has to."""
    model, q = twin.model, np.zeros(len(twin.graph.coordinates))
    for k, value in twin.graph.guess.items():
        q[k] = value
    keys = [k for k in range(model.nkey) if model.key(k).name == "home"]
    home = (model.key_qpos[keys[0]] if keys else model.qpos0).copy()
    follow(model, home)
    found = twin.qpos(q)
    for j in range(model.njnt):
        k, kind = model.jnt_qposadr[j], model.jnt_type[j]
        if kind in (_FREE, _BALL):
            k += 3 * (kind == _FREE)
            same = abs(float(np.dot(found[k : k + 4], home[k : k + 4])))
            assert same > 1 - SAME, "another home"
        else:
            assert abs(found[k] - home[k]) < SAME, "another home"
    assert set(mechanism.driven) <= set(twin.numbers)


def _compare_limits(twin: Twin) -> None:
    """Every range of a hinge or slide is the coordinate's, and every motor moves its own."""
    model, graph = twin.model, twin.graph
    single = model.actuator_trntype <= int(mujoco.mjtTrn.mjTRN_JOINTINPARENT)
    moved = {int(k) for k in model.actuator_trnid[single, 0]} - twin.held
    driven = set()
    for j in range(model.njnt):
        number = twin.single(j) if model.jnt_type[j] in (_HINGE, _SLIDE) else None
        if number is None:
            continue
        driven |= {graph.coordinates[number].name} if j in moved else set()
        limits = graph.limits(graph.coordinates[number].name)
        expected = tuple(model.jnt_range[j]) if model.jnt_limited[j] else (-math.inf, math.inf)
        if graph.joints[graph.coordinates[number].joint].kind == "helical":
            assert limits[0] >= expected[0] - SAME, "a lost limit"
            assert limits[1] <= expected[1] + SAME, "a lost limit"
        elif not graph.coordinates[number].name.startswith("platform."):
            np.testing.assert_allclose(limits, expected, atol=SAME)
    assert driven == set(graph.mechanism.driven), f"{driven} and not {graph.mechanism.driven}"
