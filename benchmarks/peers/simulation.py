"""A spatial four-bar falling and turning for 5 s, on parakin and on engines of multibody dynamics.

    python -m benchmarks.peers.simulation

The mechanism and its equation of motion, which all are compared with, are in `four_bar`, the
engines' models in `four_bar_engines`, written as a user of that engine would. Each way tells the
crank's angle and rate 100 times a second. Errors are those of the angle, in radians; the drift of
the energy is that of what is told, by `four_bar.energy`. Nothing else should run.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

import parakin
from benchmarks.peers.four_bar import (
    COUPLER,
    CRANK,
    DURATION,
    GRAVITY,
    MASSES,
    PIVOT,
    ROCKER,
    SPEED,
    TILT,
    Floats,
    energy,
    reference,
)
from benchmarks.peers.four_bar_engines import (
    RATE,
    Run,
    Told,
    of_exudyn,
    of_mujoco,
    of_pinocchio_dop853,
    of_pinocchio_rk4,
    sampled,
)
from benchmarks.peers.four_bar_others import of_drake, of_opensim
from benchmarks.timing import best, machine


class Way(NamedTuple):
    """`build` makes what runs a simulation of so many seconds, again and again."""

    engine: str
    distribution: str
    module: str
    how: str
    build: Callable[[float], Run]


def parakin_file() -> str:
    def listed(values: Any) -> str:
        return str([float(x) for x in values])

    bodies = "\n".join(
        f"{name} = {{ mass = {mass}, com = {listed(com)}, inertia = {listed(inertia)} }}"
        for name, (mass, com, inertia) in MASSES.items()
    )
    return f"""
name = "spatial-four-bar"
up = "y"
gravity = {listed(GRAVITY)}
driven = ["A"]
[home]
A = 0
[guess]
D = "-53 deg"
S.1 = "45 deg"
S.2 = "-15 deg"
S.3 = "-20 deg"
U.1 = "124 deg"
U.2 = "-106 deg"
[bodies]
{bodies}
[joints.A]
kind = "revolute"
parent = "base"
child = "crank"
[joints.D]
kind = "revolute"
parent = "base"
child = "rocker"
on_parent = {{ at = {listed(PIVOT)}, turns = [["x", {TILT}]] }}
[joints.S]
kind = "spherical"
parent = "crank"
child = "coupler"
on_parent = {{ at = [{CRANK}, 0, 0] }}
[joints.U]
kind = "universal"
parent = "rocker"
child = "coupler"
on_parent = {{ at = [{ROCKER}, 0, 0] }}
on_child = {{ at = [{COUPLER}, 0, 0], axis = [0, 1, 0] }}
"""


def solver() -> parakin.Solver:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "four-bar.toml"
        path.write_text(parakin_file())
        return parakin.compile(path)


def of_parakin(duration: float, rtol: float, method: str = "dop853") -> Run:
    bars = solver()

    def run() -> Told:
        result = bars.simulate(duration, velocity={"A": SPEED}, rate=RATE, rtol=rtol, method=method)
        crank = parakin.require_solved(result).sel(coordinate="A")
        sides = result.attrs["evaluations"] or None
        return Told(crank.position.values, crank.velocity.values, result.attrs["steps"], sides)

    return run


def of_batch(duration: float, step: float, runs: int) -> Run:
    """The first of so many runs, all of which go through it."""
    bars, speeds = solver(), SPEED + 1e-3 * np.arange(runs)

    def run() -> Told:
        result = parakin.simulate_batch(
            bars, duration, velocity={"A": speeds}, step=step, rate=RATE
        )
        crank = result.isel(run=0).sel(coordinate="A")
        steps = runs * round(duration / step)
        return Told(crank.position.values, crank.velocity.values, steps, 4 * steps)

    return run


PARAKIN = "parakin", "parakin", "parakin"
MUJOCO = "MuJoCo", "mujoco", "mujoco"
EXUDYN = "exudyn", "exudyn", "exudyn"
PINOCCHIO = "Pinocchio", "pin", "pinocchio"
DRAKE = "Drake", "drake", "pydrake"
OPENSIM = "OpenSim", "opensim", "opensim"
HEADINGS = (
    "four-bar, 5 s",
    "error at the end [rad]",
    "largest [rad]",
    "drift of energy [J]",
    "steps",
    "wall time",
    "1,000 steps/s",
    "1,000 right-hand sides/s",
    "first after",
)
WAYS = (
    Way(*PARAKIN, "DOP853, rtol 1e-9", lambda t: of_parakin(t, 1e-9)),
    Way(*PARAKIN, "DOP853, rtol 1e-11", lambda t: of_parakin(t, 1e-11)),
    Way(*PARAKIN, "Taylor, rtol 1e-15", lambda t: of_parakin(t, 1e-15, "taylor")),
    Way(*PARAKIN, "RK4, 1 ms, alone", lambda t: of_batch(t, 1e-3, 1)),
    Way(*PARAKIN, "RK4, 1 ms, 512 at once", lambda t: of_batch(t, 1e-3, 512)),
    Way(*MUJOCO, "RK4, 1 ms, constraints as they come", lambda t: of_mujoco(t, 1e-3, False)),
    Way(*MUJOCO, "RK4, 1 ms, stiff", lambda t: of_mujoco(t, 1e-3, True)),
    Way(*MUJOCO, "RK4, 0.1 ms, stiff", lambda t: of_mujoco(t, 1e-4, True)),
    Way(*EXUDYN, "generalised alpha, 1 ms", lambda t: of_exudyn(t, 1e-3)),
    Way(*EXUDYN, "generalised alpha, 0.1 ms", lambda t: of_exudyn(t, 1e-4)),
    Way(*PINOCCHIO, "RK4, 1 ms", lambda t: of_pinocchio_rk4(t, 1e-3)),
    Way(*PINOCCHIO, "DOP853, rtol 1e-9", lambda t: of_pinocchio_dop853(t, 1e-9)),
    Way(*PINOCCHIO, "DOP853, rtol 1e-11", lambda t: of_pinocchio_dop853(t, 1e-11)),
    Way(*DRAKE, "SAP, 1 ms", lambda t: of_drake(t, 1e-3)),
    Way(*DRAKE, "SAP, 0.1 ms", lambda t: of_drake(t, 1e-4)),
    Way(*OPENSIM, "Runge-Kutta-Merson, 1e-7", lambda t: of_opensim(t, 1e-7)),
    Way(*OPENSIM, "Runge-Kutta-Merson, 1e-9", lambda t: of_opensim(t, 1e-9)),
)


def row(way: Way, truth: Floats) -> str:
    try:
        import_module(way.module)
    except ImportError:
        return f"| {way.engine}, {way.how} | not installed |" + " |" * (len(HEADINGS) - 2)
    start = time.perf_counter()
    run = way.build(DURATION)
    told = run()
    first = time.perf_counter() - start
    seconds = best(run, repeats=3, calls=1)
    off = np.abs(told.angle - truth)
    energies = np.array([energy(q, qd) for q, qd in zip(told.angle, told.rate, strict=True)])
    drift = np.abs(energies - energy(0.0, SPEED)).max()
    pace = f"{told.steps / seconds / 1e3:.1f}"
    sides = "" if told.sides is None else f"{told.sides / seconds / 1e3:.0f}"
    return (
        f"| {way.engine} {version(way.distribution)}, {way.how} "
        f"| {off[-1]:.0e} | {off.max():.0e} | {drift:.0e} | {f'{told.steps:,}' * bool(told.steps)} "
        f"| {1e3 * seconds:.0f} ms | {pace * bool(told.steps)} | {sides} | {first:.2f} s |"
    )


def main() -> None:
    times = sampled(DURATION)
    truth, rates = reference(times, max_step=2e-3)
    other, _ = reference(times, max_step=4e-3)
    off = np.abs(other - truth).max()
    kept = np.ptp([energy(q, qd) for q, qd in zip(truth, rates, strict=True)])
    print(f"{machine()}\n\nThe crank turns by {truth[-1]:.1f} rad.")
    print(f"The reference keeps its energy within {kept:.0e} J,")
    print(f"and with twice the longest step ends up to {off:.0e} rad away.\n")
    print("| " + " | ".join(HEADINGS) + " |\n|" + "---|" * len(HEADINGS))
    for way in WAYS:
        print(row(way, truth), flush=True)


if __name__ == "__main__":
    main()
