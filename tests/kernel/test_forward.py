"""Forward dynamics is inverse dynamics the other way round; the mass matrix gives the energy."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import parakin
from parakin.algebra.spatial import FLOATS
from parakin.kernel.backends import make_forward_kernel
from parakin.kernel.forward import ForwardRows, mass_matrix
from parakin.kernel.motion import motion_at, unit_motions
from parakin.model.drives import Spring

NAMES = ["flight-simulator", "gough-stewart", "delta", "seat-3dof", "agile-eye", "five-bar", "rssr"]
Floats = NDArray[np.float64]


def heavy(name: str) -> parakin.Mechanism:
    """With a mass on each body, a spring, an armature and a payload."""
    mechanism = parakin.load(name)
    told = {"mass": 2.0, "com": (0.03, -0.02, 0.05), "inertia": (0.02, 0.03, 0.04)}
    bodies = tuple(
        body if body.name == mechanism.base else body.model_copy(update={**told, "solid": ()})
        for body in mechanism.bodies
    )
    joints = list(mechanism.joints)
    place = next(k for k, joint in enumerate(joints) if joint.kind in ("revolute", "prismatic"))
    acting = {"armature": (0.7,), "spring": (Spring(stiffness=30.0, zero=0.1),)}
    joints[place] = joints[place].model_copy(update=acting)
    loaded = mechanism.model_copy(update={"bodies": bodies, "joints": tuple(joints)})
    return loaded.with_payload(f"5 kg at {bodies[-1].name}")


def moving(solver: parakin.Solver, seed: int) -> tuple[Floats, Floats, Floats]:
    rng = np.random.default_rng(seed)
    home = np.array([solver.home[name] for name in solver.driven])
    k = len(home)
    return home + rng.uniform(-0.02, 0.02, k), rng.normal(size=k), rng.normal(size=k)


def unknowns(solver: parakin.Solver, tick: parakin.Tick, quantity: str = "position") -> Floats:
    names = [solver.graph.coordinates[k].name for k in solver.plan.unknowns]
    return np.array([tick.value(name, quantity) for name in names])


@pytest.mark.parametrize("machine_code", [False, True])
@pytest.mark.parametrize("name", NAMES)
def test_the_forces_behind_a_motion_make_it(name: str, machine_code: bool) -> None:
    if machine_code:
        pytest.importorskip("heyoka")
    solver = parakin.compile(heavy(name), coordinates="all", machine_code=machine_code)
    y, yd, ydd = moving(solver, seed=3)
    behind = solver.at(y, yd, ydd, forces=True, energies=True)
    assert behind.status == 0
    assert behind.forces is not None
    rows = ForwardRows(solver.plan, solver.mechanics.actuated, (), 1e-3, told=True)
    kernel = make_forward_kernel(rows, machine_code=machine_code)
    loads = solver.mechanics.loads(np.zeros(1), 1)[:, 0]
    state = np.concatenate([y, unknowns(solver, behind), yd, [0.0]])
    out = np.empty(rows.count)
    kernel(np.concatenate([state, behind.forces.effort, loads]), out, False)
    m, k = len(solver.plan.unknowns), len(y)
    assert out[:m] == pytest.approx(unknowns(solver, behind, "velocity"), rel=1e-10, abs=1e-12)
    assert out[m : m + k] == pytest.approx(ydd, rel=1e-9, abs=1e-9)
    power = behind.forces.power.sum() + behind.forces.applied - behind.forces.lost
    assert out[m + k] == pytest.approx(power, rel=1e-9)
    told = out[m + k + 1 + len(solver.plan.blocks) :]
    a = len(rows.actuated)
    assert told[:a] == pytest.approx(behind.forces.effort, abs=0.0)
    told = told[a:]
    assert told[:a] * behind.forces.effort == pytest.approx(behind.forces.power)
    assert told[a] == pytest.approx(behind.forces.kinetic)
    assert told[a + 1] == pytest.approx(behind.forces.potential)
    assert told[-1] < 1e-12  # the pose is closed


@pytest.mark.parametrize("name", NAMES)
def test_the_mass_matrix_gives_the_kinetic_energy(name: str) -> None:
    solver = parakin.compile(heavy(name), coordinates="all", machine_code=False)
    y, yd, _ = moving(solver, seed=5)
    tick = solver.at(y, yd, energies=True)
    assert tick.forces is not None
    known = (y.tolist(), unknowns(solver, tick).tolist(), [0.0] * len(y))
    moved = motion_at(solver.plan, *known, FLOATS)
    units = unit_motions(solver.plan, moved, FLOATS)
    loads = solver.mechanics.loads(np.zeros(1), 1)[:, 0].tolist()
    matrix = np.array(mass_matrix(solver.plan, moved, units, loads), dtype=float)
    assert matrix == pytest.approx(matrix.T, abs=0.0)
    assert yd @ matrix @ yd / 2 == pytest.approx(tick.forces.kinetic, rel=1e-10)
