"""MuJoCo and Pinocchio, on exported models, find what parakin finds."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from engines import Moving, MujocoTwin, PinocchioTwin, along, rotation

import parakin
from parakin.exports import export as exports
from parakin.solving.status import Status

if TYPE_CHECKING:
    import xarray as xr

mujoco = pytest.importorskip("mujoco")

DRIVEN = {"flight-simulator-upu": ("A2",)}  # of one freedom only
NAMES = parakin.catalogue()


@cache
def solver_of(name: str) -> parakin.Solver:
    return parakin.compile(name, DRIVEN.get(name), machine_code=False)


@cache
def solved(name: str, count: int) -> xr.Dataset:
    result = solver_of(name).solve(along(solver_of(name), count), bodies=True)
    assert (result.status == Status.CONVERGED).all()
    return result


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("models")
    for name in NAMES:
        exports.export(parakin.load(name), folder / f"{name}.xml")
    return folder


def driven_at(solver: parakin.Solver, result: xr.Dataset, i: int) -> list[dict[str, float]]:
    rows = [solver.coordinates.index(name) for name in solver.driven]
    orders = (result.position, result.velocity, result.acceleration)
    return [dict(zip(solver.driven, order.values[i, rows], strict=True)) for order in orders]


def ours(result: xr.Dataset) -> dict[str, Moving]:
    """Every body of a result as an engine tells it, arrays over time."""
    columns = [
        result[f"body_{what}"].transpose("body", "time", ...).values
        for what in (
            *("position", "orientation", "velocity", "angular_velocity"),
            *("acceleration", "angular_acceleration"),
        )
    ]
    return {
        str(name): Moving(p, np.array([rotation(q) for q in turn]), *rates)
        for name, p, turn, *rates in zip(result.body.values, *columns, strict=True)
    }


def apart(a: Moving, b: Moving) -> list[float]:
    """The largest differences of poses, velocities and accelerations."""
    off = [float(np.abs(x - y).max()) for x, y in zip(a, b, strict=True)]
    return [max(off[k : k + 2]) for k in (0, 2, 4)]


@pytest.mark.parametrize("name", NAMES)
def test_mujoco_finds_the_same_bodies_at_a_hundred_poses(name: str, models: Path) -> None:
    """MuJoCo's Newton settles where a step is below 1e-13 m or rad, and bodies are a few metres
    and joints away from what drives them. Rates are as good as the loops' Jacobian is conditioned
    (100 at worst), times the rates themselves (up to 10); accelerations take in their squares.
    Asked for were 1e-9, 1e-8 and 1e-6; found, at worst, 3e-14, 6e-13 and 2e-11.
    """
    solver, result = solver_of(name), solved(name, 100)
    twin = MujocoTwin(mujoco.MjModel.from_xml_path(str(models / f"{name}.xml")))
    # MuJoCo counts from the joint's zero, parakin some coordinates from home.
    zero = {n: twin.data.qpos[twin.place(n)] - solver.home[n] for n in solver.driven}
    bodies = ours(result)
    worst = np.zeros(3)
    for i in range(100):
        y, yd, ydd = driven_at(solver, result, i)
        twin.solve({n: q + zero[n] for n, q in y.items()}, yd, ydd)
        for body, moving in bodies.items():
            at = Moving(*(figures[i] for figures in moving))
            worst = np.fmax(worst, apart(at, twin.body(body)))
    print(f"\n{name}: {worst[0]:.0e} {worst[1]:.0e} {worst[2]:.0e}")  # with -s
    assert (worst < [1e-12, 1e-10, 1e-9]).all(), worst


@pytest.mark.parametrize("name", NAMES)
def test_pinocchio_finds_the_same_bodies(name: str, models: Path) -> None:
    """The exported model with the constraints that Pinocchio makes of it: its own Jacobians, and
    the drift of its own constraints at no acceleration. Bounds as above.
    """
    pytest.importorskip("pinocchio")
    solver, result = solver_of(name), solved(name, 100)
    twin = PinocchioTwin(models / f"{name}.xml")
    zero = {n: twin.q[twin.place(n)] - solver.home[n] for n in solver.driven}
    bodies = ours(result)
    worst = np.zeros(3)
    for i in range(30):  # from pose to pose, as Newton must not lose its branch
        y, yd, ydd = driven_at(solver, result, i)
        twin.solve({n: q + zero[n] for n, q in y.items()}, yd, ydd)
        for body, moving in bodies.items():
            at = Moving(*(figures[i] for figures in moving))
            worst = np.fmax(worst, apart(at, twin.body(body)))
    print(f"\n{name}: {worst[0]:.0e} {worst[1]:.0e} {worst[2]:.0e}")  # with -s
    assert (worst < [1e-12, 1e-10, 1e-9]).all(), worst
