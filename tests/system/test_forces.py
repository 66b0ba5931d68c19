"""Forces against d'Alembert on bare poses, on the catalogue with masses thrown at random."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, event, given, settings
from random_mechanisms import Example, examples
from virtual_work import Lump, efforts, energies

import parakin
from parakin import Body, Mechanism

GRAVITY = np.array([1.0, -9.0, 3.5])  # askew, so that no direction is spared
NAMES = [name for name in parakin.catalogue() if name != "flight-simulator-upu"]


def thrown(mechanism: Mechanism, seed: int) -> tuple[Mechanism, dict[str, Lump]]:
    """The mechanism with random masses, centres and inertias."""
    rng = np.random.default_rng(seed)
    lumps: dict[str, Lump] = {}
    bodies: list[Body] = []
    for body in mechanism.bodies:
        if body.name == mechanism.base:
            bodies.append(body)
            continue
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        a, b, c = rng.uniform(0.5, 2.0, 3)
        principal = np.array([b + c, c + a, a + b])  # of three positive second moments
        lump = Lump(
            float(rng.uniform(1.0, 20.0)),
            rng.uniform(-0.3, 0.3, 3),
            turn @ np.diag(principal) @ turn.T,
        )
        lumps[body.name] = lump
        keys = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
        told: dict[str, Any] = {
            "mass": lump.mass,
            "com": tuple(lump.com.tolist()),
            "inertia": {key: float(lump.inertia[at]) for key, at in keys.items()},
        }
        bodies.append(Body(name=body.name, points=body.points, **told))
    instead = {"bodies": tuple(bodies), "gravity": tuple(GRAVITY.tolist()), "forces": {}}
    return mechanism.model_copy(update=instead), lumps


@pytest.mark.parametrize("name", NAMES)
def test_efforts_are_those_of_virtual_work_on_bare_poses(name: str) -> None:
    mechanism, lumps = thrown(parakin.load(name), seed=len(name))
    solver = parakin.compile(mechanism, coordinates="all")
    actuated = [c.name for c in solver.graph.coordinates if c.actuated]
    rng = np.random.default_rng(1)
    home = np.array([solver.home[c] for c in solver.driven])
    unit = np.array(
        [1.0 if solver.graph.is_angle(c) else solver.graph.length for c in solver.driven]
    )
    for _ in range(3):
        y = home + 0.01 * unit * rng.uniform(-1.0, 1.0, len(home))
        yd, ydd = (unit * rng.uniform(-1.0, 1.0, len(home)) for _ in range(2))
        tick = solver.at(y, yd, ydd, forces=True)
        assert tick.forces is not None
        assert tick.forces.actuators == tuple(actuated)
        truth = efforts(solver, lumps, GRAVITY, actuated, (y, yd, ydd), 0.05, 0.01)
        assert tick.forces.effort == pytest.approx(truth, rel=1e-9, abs=1e-9 * np.abs(truth).max())


@pytest.mark.parametrize("name", NAMES)
def test_power_is_what_the_energies_of_bare_poses_gain(name: str) -> None:
    mechanism, lumps = thrown(parakin.load(name), seed=2 * len(name))
    solver = parakin.compile(mechanism, coordinates="all")
    rng = np.random.default_rng(4)
    home = np.array([solver.home[c] for c in solver.driven])
    graph = solver.graph
    unit = np.array([1.0 if graph.is_angle(c) else graph.length for c in solver.driven])
    y = home + 0.01 * unit * rng.uniform(-1.0, 1.0, len(home))
    yd, ydd = (unit * rng.uniform(-1.0, 1.0, len(home)) for _ in range(2))
    forces = solver.at(y, yd, ydd, energies=True).forces
    assert forces is not None
    truth = energies(solver, lumps, GRAVITY, (y, yd, ydd), 0.05)
    size = np.abs(forces.power).sum()
    assert forces.power.sum() == pytest.approx(truth.rate, abs=1e-9 * size)
    assert forces.kinetic == pytest.approx(truth.kinetic, rel=1e-9)
    assert forces.potential == pytest.approx(truth.potential, rel=1e-9)
    assert forces.lost == forces.applied == 0.0


def moved_by(mechanism: Mechanism, names: Sequence[str]) -> Mechanism:
    """The mechanism with motors at these coordinates, joints' or numbered ones of joints."""
    joints = []
    for joint in mechanism.joints:
        numbers = tuple(
            int(name.rpartition(".")[2]) for name in names if name.rpartition(".")[0] == joint.name
        )
        joints.append(joint.model_copy(update={"actuated": numbers or joint.name in names}))
    return mechanism.model_copy(update={"joints": tuple(joints)})


@settings(
    max_examples=25,
    deadline=None,
    derandomize=True,
    database=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=list(HealthCheck),
)
@given(example=examples())
def test_random_mechanisms_too(example: Example) -> None:
    """Driven by some coordinates and moved by others, forces are those of virtual work, and every
    body is in balance.
    """
    mechanism, lumps = thrown(example.mechanism, seed=7)
    for actuated in (example.other, example.driven):
        if any(name.startswith("platform.") for name in actuated) or not actuated:
            continue
        try:
            solver = parakin.compile(
                moved_by(mechanism, actuated), example.driven, coordinates="all", machine_code=False
            )
        except (parakin.AssemblyError, parakin.DrivenError):
            return
        _check_forces(solver, lumps, tuple(actuated))


def _check_forces(solver: parakin.Solver, lumps: dict[str, Lump], actuated: Sequence[str]) -> None:
    home = np.array([solver.home[c] for c in solver.driven])
    graph = solver.graph
    unit = np.array([1.0 if graph.is_angle(c) else graph.length for c in solver.driven])
    rng = np.random.default_rng(5)
    yd, ydd = (unit * rng.uniform(-1.0, 1.0, len(home)) for _ in range(2))
    tick = solver.at(home, yd, ydd, reactions=True)
    if tick.status or float(tick.conditioning) < 0.1 or tick.forces is None:
        return
    forces = tick.forces
    order = [c.name for c in graph.coordinates if c.actuated]
    if sorted(order) != sorted(actuated):
        return  # of a joint of several freedoms, split
    try:
        truth = efforts(solver, lumps, GRAVITY, order, (home, yd, ydd), 0.004, 0.004)
    except (AssertionError, np.linalg.LinAlgError):
        event("too near an end of reach")
        return
    size = np.abs(truth).max()
    if not size < 1e5 or abs(float(forces.conditioning)) < 1e-2:
        event("actuators hardly hold it")
        return
    event("compared")
    assert forces.effort == pytest.approx(truth, rel=1e-6, abs=1e-6 * size)
    if not len(forces.idle_effort):
        assert float(forces.imbalance) < 1e-8 * (1.0 + size)


@pytest.mark.repository
@pytest.mark.parametrize(
    ("engine", "within"), [("mujoco", 1e-4), ("pinocchio", 1e-9), ("exudyn", 1e-7)]
)
def test_other_engines_agree_once_the_loops_are_added(
    engine: str, within: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """MuJoCo's bodies without mass have some 1e-7 kg, as it takes none.

    exudyn's accelerations are differences, right to 1e-11; it is told dimensions and masses alone.
    """
    pytest.importorskip(engine)
    pytest.importorskip("lxml")
    monkeypatch.syspath_prepend(Path(__file__).parents[2])
    from benchmarks.peers import forces

    state, ours, _ = forces.solved()
    build = getattr(forces, f"of_{engine}")
    theirs = build(state, tmp_path)
    solver = parakin.compile(forces.NAME)
    given = [np.array([state[name][k] for name in solver.driven]) for k in range(3)]
    balls = [f"S{k}" for k in range(1, 7)]
    carried = solver.at(*given, reactions=balls).forces
    assert carried is not None
    in_balls = np.linalg.norm(carried.reaction_force, axis=1)
    for k in range(0, ours.shape[1], 50):
        loops, efforts_ = theirs(k)[:18].reshape(6, 3), theirs(k)[18:]
        assert efforts_ == pytest.approx(ours[:, k], abs=within)
        assert np.linalg.norm(loops, axis=1) == pytest.approx(in_balls[:, k], abs=within)
