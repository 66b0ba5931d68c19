"""A solver bound to arrays of its own says what `at` says, pose after pose."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import parakin
from parakin.solving.solver import Solver
from parakin.solving.status import SOLVED, Status

RIG = Path(__file__).parents[2] / "examples" / "rig.toml"
LEGS = [f"P{k}" for k in range(1, 7)]
CASES = [
    ("flight-simulator", None, {}),
    (str(RIG), None, {}),
    ("gough-stewart", LEGS, {}),
    ("gough-stewart", LEGS, {"coordinates": ["platform.z"], "derivatives": 0}),
    ("3-rps", None, {}),
    ("agile-eye", None, {}),
    ("flight-simulator", None, {"coordinates": ["A2", "B3"], "derivatives": 1, "checks": False}),
]


def poses(solver: Solver, count: int) -> np.ndarray:
    """Poses in small steps from home, some of them out of reach, and not numbers (count, k)."""
    home = np.array([solver.home[name] for name in solver.driven])
    draw = np.random.default_rng(5)
    size = np.array([0.2 if solver.graph.is_angle(n) else 0.1 for n in solver.driven])
    way = (
        np.cumsum(draw.normal(size=(count, len(home))), axis=0) * 0.02 * size * solver.graph.length
    )
    found = home + way
    found[7, 0], found[11, -1], found[13], found[17] = np.nan, np.inf, home + 50.0, home
    return np.asarray(found)


@pytest.mark.parametrize("machine_code", [True, False])
@pytest.mark.parametrize(("name", "driven", "options"), CASES)
def test_it_says_what_at_says(
    name: str, driven: list[str] | None, options: dict[str, object], machine_code: bool
) -> None:
    if machine_code:
        pytest.importorskip("heyoka")
    solver = parakin.compile(name, driven, machine_code=machine_code, **options)  # type: ignore[arg-type]
    bound, last = solver.bound(), None
    draw = np.random.default_rng(6)
    statuses = set()
    for y in poses(solver, 60):
        yd, ydd = draw.normal(size=(2, len(y)))
        bound.y[:] = y
        bound.yd[:], bound.ydd[:] = yd[: len(bound.yd)], ydd[: len(bound.ydd)]
        status = bound.solve()
        statuses.add(status)
        tick = solver.at(y, yd, ydd, last if solver.iterated else None)
        assert status == tick.status
        assert np.array_equal(bound.position, tick.position, equal_nan=True)
        assert np.array_equal(bound.velocity, tick.velocity, equal_nan=True)
        assert np.array_equal(bound.acceleration, tick.acceleration, equal_nan=True)
        assert bound.why == tick.why()
        if status in SOLVED:
            last = tick
    assert Status.CONVERGED in statuses
    assert len(statuses) > 1


def test_arrays_are_its_own() -> None:
    solver = parakin.compile("flight-simulator", machine_code=False)
    one, other = solver.bound(), solver.bound()
    home = [solver.home[name] for name in solver.driven]
    one.y[:], other.y[:] = home, np.array(home) + 0.01
    one.solve()
    kept = one.position.copy()
    other.solve()
    assert np.array_equal(one.position, kept)
    assert not np.array_equal(other.position, kept)
    assert np.array_equal(one.y, home)


def test_numbers_that_overflow_are_flagged() -> None:
    solver = parakin.compile("flight-simulator", machine_code=False)
    bound = solver.bound()
    bound.y[:] = [solver.home[name] for name in solver.driven]
    bound.yd[:] = 1e200
    assert bound.solve() == Status.OUT_OF_REACH
    assert np.isnan(bound.acceleration).all()
