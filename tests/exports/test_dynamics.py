"""Masses, friction, springs and gravity in exported models: other engines find our efforts, and
what comes back when read is what went out.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from weighty import Array, efforts, masses, of_mujoco, weightless

import parakin
from parakin.exports import export as exports
from parakin.files.mechanism_toml import mechanism_from_table
from parakin.model.evaluation import graph_of
from parakin.model.graph import Graph

mujoco = pytest.importorskip("mujoco")
pytest.importorskip("lxml")
pytest.importorskip("yaml")

# Every body has a mass, as MuJoCo needs it, and every joint one coordinate.
ARM = """name = "arm"
gravity = [0.5, -1.0, -9.0]
from_home = ["B"]
home = {A = 0.1, B = 0.4}
[bodies.a]
mass = 3
com = [0.1, 0.2, 0.3]
inertia = {xx = 1, yy = 1.2, zz = 1.4, xy = 0.1, xz = 0.05, yz = -0.1}
[bodies.b]
mass = 2
com = [0.0, 0.1, 0.0]
inertia = [0.1, 0.2, 0.15]
[bodies.c]
solid = {kind = "box", to = [1, 1, 0], width = 0.1, height = 0.2, across = [0, 0, 1], density = 70}
points.tip = [0.5, 0.0, 0.0]
[joints.A]
kind = "revolute"
parent = "base"
child = "a"
on_parent = {at = [0, 0, 1], axis = [0, 1, 1]}
friction = {coulomb = 0.3, viscous = 0.4}
spring = {stiffness = 5, zero = 0.3}
armature = 0.2
[joints.B]
kind = "prismatic"
parent = "b"
child = "a"
on_parent = {at = [0, 0.5, 0], axis = [1, 0, 0]}
spring = {stiffness = 7, zero = 0.1}
damper = {damping = 2}
[joints.C]
kind = "revolute"
parent = "b"
child = "c"
on_parent = {at = [0.2, 0.1, 0], axis = [1, 0, 1]}
friction = {viscous = 1, coulomb = 2}
[forces.load]
kind = "payload"
at = "c.tip"
mass = 0.7
inertia = [0.01, 0.02, 0.03]
"""
PULL = """[forces.pull]
kind = "spring"
between = ["base", "c.tip"]
stiffness = 11
damping = 0.6
length = 0.3
"""


def arm(more: str = "") -> parakin.Mechanism:
    return mechanism_from_table(tomllib.loads(ARM + more), "arm")


def moving(names: list[str]) -> tuple[Array, Array, Array]:
    q, qd, qdd = np.random.default_rng(0).normal(size=(3, len(names)))
    return q, qd, qdd


def test_mujoco_finds_our_efforts_in_the_exported_model(tmp_path: Path) -> None:
    """All that acts, a spring between points too; MuJoCo counts from B's zero, not from home."""
    mechanism = arm(PULL)
    path = exports.export(mechanism, tmp_path / "arm.xml")[0]
    model: Any = mujoco.MjModel.from_xml_path(str(path))
    names = [c.name for c in graph_of(mechanism).coordinates]
    q, qd, qdd = moving(names)
    at, v, a = np.zeros(model.nq), np.zeros(model.nv), np.zeros(model.nv)
    rows = [int(model.joint(name).dofadr[0]) for name in names]
    at[rows], v[rows], a[rows] = q + np.array([0.0, 0.4, 0.0]), qd, qdd
    expected = of_mujoco(model, at, v, a)[rows]
    found = efforts(mechanism, q, qd, qdd)
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_pinocchio_finds_our_efforts_in_the_exported_urdf(tmp_path: Path) -> None:
    """But for what URDF cannot hold: armatures and springs."""
    pinocchio = pytest.importorskip("pinocchio")
    mechanism = arm()
    joints = tuple(j.model_copy(update={"spring": (), "armature": ()}) for j in mechanism.joints)
    mechanism = mechanism.model_copy(update={"joints": joints})
    path = exports.export(mechanism, tmp_path / "arm.urdf")[0]
    model = pinocchio.buildModelFromUrdf(str(path))
    model.gravity.linear = np.array([0.5, -1.0, -9.0])
    names = [c.name for c in graph_of(mechanism).coordinates]
    q, qd, qdd = moving(names)
    at, v, a = pinocchio.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
    rows = []
    for name, value, rate, second in zip(names, q, qd, qdd, strict=True):
        joint = model.joints[model.getJointId(name)]
        place = value + 0.4 * (name == "B")
        at[joint.idx_q : joint.idx_q + joint.nq] = (
            [np.cos(place), np.sin(place)] if joint.nq == 2 else [place]
        )
        v[joint.idx_v], a[joint.idx_v] = rate, second
        rows.append(joint.idx_v)
    expected = pinocchio.rnea(model, model.createData(), at, v, a)
    expected = (expected + model.damping * v + model.friction * np.sign(v))[rows]
    np.testing.assert_allclose(efforts(mechanism, q, qd, qdd), expected, rtol=1e-9)


# Joints of several coordinates, and bodies that weigh nothing or are points.
CHAIN = """name = "chain"
gravity = [0, 1, -9]
[bodies.c]
mass = 1
com = [0.4, 0.3, 0.0]
[bodies.d]
[bodies.e]
mass = 2
inertia = [1, 1, 2]
[joints.U]
kind = "universal"
parent = "base"
child = "c"
on_parent = {at = [0, 0.5, 0.2]}
armature = [0.1, 0.3]
spring = [{stiffness = 2, zero = 0.5}, {stiffness = 3}]
friction = [{viscous = 1}, {coulomb = 2}]
[joints.C]
kind = "cylindrical"
parent = "c"
child = "d"
on_parent = {at = [1, 0.5, 0.2]}
armature = [0.5, 0.7]
[joints.H]
kind = "helical"
pitch = 0.1
parent = "d"
child = "e"
friction = {viscous = 3}
"""


@pytest.mark.parametrize("suffix", ["xml", "urdf"])
def test_what_comes_back_weighs_and_resists_alike(suffix: str, tmp_path: Path) -> None:
    """URDF keeps neither armatures nor springs nor gravity, and says so."""
    for mechanism in (arm(PULL), mechanism_from_table(tomllib.loads(CHAIN), "chain")):
        path, *loops = exports.export(mechanism, tmp_path / f"model.{suffix}")
        again = parakin.load(path, loops=loops[0] if loops else None)
        ours, theirs = graph_of(mechanism), graph_of(again)
        text = path.read_text()
        if suffix == "xml":
            assert again.gravity == mechanism.gravity
            _same_springs(ours, theirs)
            expected = {k: v for k, v in _with_loads(mechanism).items() if v[0]}
            found = masses(theirs)
            assert found.keys() == expected.keys()
            for name, values in expected.items():
                np.testing.assert_allclose(found[name], values, rtol=1e-9, atol=1e-10)
        else:
            assert "Not in this model:" in text
            assert "armatures of " in text
            assert "springs in " in text
        for k, c in enumerate(ours.coordinates):
            one = ours.dynamics.passive.get(k)
            two = theirs.dynamics.passive.get(theirs.index(c.name, ""))
            home = ours.home.get(k, 0.0) if k in ours.from_home else 0.0
            assert _told(two, 0.0, suffix) == pytest.approx(_told(one, home, suffix), rel=1e-12)


def _same_springs(ours: Graph, theirs: Graph) -> None:
    """Between the same points of bodies of the same names."""
    for one, two in zip(ours.dynamics.springs, theirs.dynamics.springs, strict=True):
        assert (one.name, *one[2:]) == (two.name, *two[2:])
        for (body, p), (other, q) in zip(one.ends, two.ends, strict=True):
            assert ours.bodies[body] == theirs.bodies[other]
            np.testing.assert_allclose(p, q, atol=1e-14)


def _told(passive: Any, home: float, suffix: str) -> list[float]:
    if passive is None:
        return [0.0] * (5 if suffix == "xml" else 2)
    damping = passive.viscous + passive.damping
    zero = passive.zero + home if passive.stiffness else 0.0
    more = [passive.armature, passive.stiffness, zero] if suffix == "xml" else []
    return [passive.coulomb, damping, *more]


def _with_loads(mechanism: parakin.Mechanism) -> dict[str, Array]:
    """By body, with the payload at c.tip: by Huygens and Steiner."""
    found = masses(graph_of(mechanism))
    if "load" in mechanism.forces:
        m, com, tensor = found["c"][0], found["c"][1:4], found["c"][4:].reshape(3, 3)
        tip = np.array([0.5, 0, 0])
        middle = (m * com + 0.7 * tip) / (m + 0.7)
        total = tensor + np.diag([0.01, 0.02, 0.03])
        for mass, at in ((m, com - middle), (0.7, tip - middle)):
            total = total + mass * (at @ at * np.eye(3) - np.outer(at, at))
        found["c"] = np.hstack([m + 0.7, middle, total.ravel()])
    return found


@pytest.mark.parametrize("name", ["flight-simulator", "delta", "tricept"])
@pytest.mark.parametrize("suffix", ["xml", "urdf"])
def test_loops_come_back_with_their_masses_or_without_any(
    name: str, suffix: str, tmp_path: Path
) -> None:
    """What MuJoCo needs and the mechanism does not have is invented, and known to be."""
    bare = weightless(parakin.load(name))
    platform = bare.platform
    assert platform is not None
    heavy = tuple(
        body.model_copy(update={"mass": 2.0 + k, "com": (0.1, 0.0, 0.2 * k)})
        if body.name != bare.base and (k % 2 or body.name == platform.body)
        else body
        for k, body in enumerate(bare.bodies)
    )
    for mechanism in (bare, bare.model_copy(update={"bodies": heavy})):
        path, *loops = exports.export(mechanism, tmp_path / f"model.{suffix}")
        again = graph_of(parakin.load(path, loops=loops[0] if loops else None))
        ours, theirs = masses(graph_of(mechanism)), masses(again)
        assert not again.dynamics.passive
        assert len(theirs) == len(ours)
        assert sorted(m[0] for m in theirs.values()) == pytest.approx(
            sorted(m[0] for m in ours.values())
        )
        for body, values in ours.items():
            if suffix == "xml":
                np.testing.assert_allclose(theirs[body], values, atol=1e-12)
        if not ours:
            assert again.mechanism.gravity is None


@pytest.mark.parametrize("name", ["tricept", "six-bar-watt", "gough-stewart", "flight-simulator"])
def test_efforts_of_closed_chains_follow_from_mujocos_of_the_tree(
    name: str, tmp_path: Path
) -> None:
    """MuJoCo's inverse dynamics of the exported tree, its loops open, through the velocities that
    a unit velocity of each driven coordinate means: virtual powers.
    """
    bare = weightless(parakin.load(name))
    bodies = tuple(
        body
        if body.name == bare.base
        else body.model_copy(
            update={
                "mass": 1.0 + k,
                "com": (0.02 * k, 0.1, -0.05),
                "inertia": (0.3, 0.2 + 0.01 * k, 0.25),
            }
        )
        for k, body in enumerate(bare.bodies)
    )
    mechanism = bare.model_copy(update={"bodies": bodies, "limits": {}})
    driven = [c.name for c in graph_of(mechanism).coordinates if c.actuated]
    solver = parakin.compile(mechanism, driven, coordinates="all", machine_code=False)
    rng = np.random.default_rng(0)
    y = np.array([solver.home[n] for n in driven]) + 0.01 * rng.normal(size=len(driven))
    yd, ydd = 0.3 * rng.normal(size=(2, len(driven)))
    tick = solver.at(y, yd, ydd, forces=True)
    assert tick.forces is not None
    model: Any = mujoco.MjModel.from_xml_path(str(exports.export(mechanism, tmp_path / "m.xml")[0]))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_EQUALITY
    model.dof_damping[:] = 0.0  # invented where nothing weighs anything, and so is armature
    model.dof_armature[:] = np.maximum(model.dof_armature, 1.0)  # for MuJoCo's sake alone
    light = model.body_mass < 0.5
    model.body_mass[light], model.body_inertia[light] = 0.0, 0.0  # so small bodies in joints
    at, v, a = np.zeros(model.nq), np.zeros(model.nv), np.zeros(model.nv)
    columns = np.zeros((model.nv, len(driven)))
    units = [solver.at(y, unit).velocity for unit in np.eye(len(driven))]
    graph, known = solver.graph, {model.joint(j).name: j for j in range(model.njnt)}
    for k, coordinate in enumerate(solver.coordinates):
        if coordinate not in known:
            continue  # of a ball that closes a loop
        row = int(model.joint(known.pop(coordinate)).dofadr[0])
        number = graph.index(coordinate, "")
        zero = float(model.qpos0[row]) if number in graph.from_home else 0.0
        at[row] = tick.position[k].item() + zero
        v[row], a[row] = tick.velocity[k].item(), tick.acceleration[k].item()
        columns[row] = [unit[k].item() for unit in units]
    assert not known
    expected = columns.T @ (of_mujoco(model, at, v, a) - model.dof_armature * a)
    found = np.asarray(tick.forces.effort).reshape(len(driven))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * np.abs(expected).max())


def test_what_a_model_cannot_hold_is_told_in_a_comment(tmp_path: Path) -> None:
    more = """[forces.wind]
    kind = "wrench"
    at = "c.tip"
    force = [1, 0, 0]
    """
    mechanism = arm(PULL + more)
    joints = []
    for joint in mechanism.joints:
        table = joint.model_dump(exclude_defaults=True)
        if joint.name == "C":
            table |= {"actuated": True, "drive": {"ratio": 50}}
            table["damper"] = {"damping": 1, "zero": 0.1}
        joints.append(table)
    made = mechanism.model_dump(exclude_defaults=True) | {"joints": joints}
    path = exports.export(parakin.Mechanism(**made), tmp_path / "arm.xml")[0]
    text = path.read_text()
    for said in (
        "the velocities at which dampers rest, in C",
        "wrenches: wind",
        "drives (gears, screws, efficiencies, rotors, limits) of C",
        "Payloads are part of the masses of their bodies: load",
    ):
        assert said in text
    urdf = exports.export(parakin.Mechanism(**made), tmp_path / "arm.urdf")[0].read_text()
    assert "springs between points: pull" in urdf
    assert "gravity: 0.5, -1, -9 m/s2" in urdf


def test_a_machine_with_masses_moves_in_mujoco_with_its_loops_closed(tmp_path: Path) -> None:
    """The flight simulator with a platform of 8 t: its limbs weigh next to nothing."""
    bare = weightless(parakin.load("flight-simulator"))
    assert bare.platform is not None
    heavy = {"mass": 8000.0, "inertia": (2e4, 2e4, 3e4)}
    bodies = tuple(
        body.model_copy(update=heavy if body.name == bare.platform.body else {})
        for body in bare.bodies
    )
    path = exports.export(bare.model_copy(update={"bodies": bodies}), tmp_path / "m.xml")[0]
    model: Any = mujoco.MjModel.from_xml_path(str(path))
    assert model.body_subtreemass[0] == pytest.approx(8000)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    opened = 0.0
    for _ in range(round(2.0 / model.opt.timestep)):
        mujoco.mj_step(model, data)
        opened = max(opened, float(np.abs(data.efc_pos[: data.ne]).max()))
    assert np.isfinite(data.qpos).all()
    assert opened < 1e-3
