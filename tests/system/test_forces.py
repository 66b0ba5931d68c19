"""Forces against d'Alembert on bare poses, on the catalogue with masses thrown at random."""

from __future__ import annotations

import numpy as np
import pytest
from virtual_work import Lump, efforts

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
        told = {
            "mass": lump.mass,
            "com": tuple(lump.com.tolist()),
            "inertia": {key: float(lump.inertia[at]) for key, at in keys.items()},
        }
        bodies.append(Body(**body.model_dump(exclude_defaults=True) | told))
    told_bodies = {"bodies": tuple(bodies), "gravity": tuple(GRAVITY.tolist())}
    return mechanism.model_copy(update=told_bodies), lumps


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
        truth = efforts(solver, lumps, GRAVITY, actuated, (y, yd, ydd), 0.02, 0.01)
        assert tick.forces.effort == pytest.approx(truth, rel=1e-9, abs=1e-9 * np.abs(truth).max())
