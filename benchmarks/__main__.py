"""Speed through the public API, of the flight simulator as ratios within one run.

    python -m benchmarks [--long] [--check [--keep]]

(a) is the same case written with NumPy and SciPy as a user would write it today, (b) the closed
form of the three strokes in plain C, (c) all twelve unknowns by hand in C, built with gcc where gcc
exists. Nothing else should run.
Timings are the best of several repeats, `at` of one pose the median. --long adds ten million
samples written to a file. --check compares with ratios that are kept (see `benchmarks.guard`).
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import matplotlib
import numpy as np
from rich.console import Console
from rich.table import Table

import parakin
from benchmarks import forces, guard
from benchmarks.baselines import COORDINATES, build_c_strokes, solve_motion_scipy
from benchmarks.by_hand import build_by_hand
from benchmarks.timing import best, machine, median
from parakin.files.datasets import write

BATCH, MILLION = 1_000, 1_000_000


def run(arguments: Sequence[str], caches: str | None = None) -> str:
    """What Python prints in a process of its own, with the caches of parakin, heyoka and others in
    this folder, but for matplotlib's list of fonts; None is a folder that is empty.
    """
    with tempfile.TemporaryDirectory() as empty:
        made = {"XDG_CACHE_HOME": caches or empty, "PARAKIN_CACHE": ""}
        fonts = {"MPLCONFIGDIR": matplotlib.get_cachedir()}
        return subprocess.run(
            [sys.executable, *arguments],
            check=True,
            capture_output=True,
            text=True,
            env={**os.environ, **made, **fonts},
        ).stdout


def fresh(*arguments: str, caches: str | None = None) -> float:
    """Seconds of a command in a process of its own, the best of three."""
    runs = []
    for _ in range(3):
        start = time.perf_counter()
        run(["-m", "parakin", *arguments], caches)
        runs.append(time.perf_counter() - start)
    return min(runs)


def compile_time(caches: str | None = None) -> float:
    """Seconds of the first compilation in a process, imports aside, the best of three."""
    script = (
        "import time, heyoka, parakin, parakin.solving.compiler; m = "
        "parakin.load('flight-simulator'); t = time.perf_counter(); parakin.compile(m); "
        "print(time.perf_counter() - t)"
    )
    return min(float(run(["-c", script], caches)) for _ in range(3))


class Report:
    """The table, row by row: what, measured, target, ratio."""

    def __init__(self) -> None:
        self.table = Table("what", "measured", "to reach", "ratio", box=None, pad_edge=False)

    def add(self, what: str, value: str, target: str = "", ratio: str = "") -> None:
        self.table.add_row(what, value, target, ratio)


def flight_simulator(report: Report) -> None:
    solver = parakin.compile("flight-simulator")
    twelve = [n for n in solver.coordinates if not n.startswith("platform.")]
    samples = solver.motion("general", rate=(BATCH - 1) / 3).samples()
    y, yd, ydd = samples.position, samples.velocity, samples.acceleration
    order = [solver.driven.index(f"platform.{n}") for n in ("x", "y", "phi")]

    count = 200
    start = time.perf_counter()
    poses, rates, second = (a[order, :count].T.copy() for a in (y, yd, ydd))
    q, _, qdd = solve_motion_scipy(poses, rates, second)
    theirs = (time.perf_counter() - start) / count
    columns = [COORDINATES.index(n) for n in ("A2", "B3", "C3")]
    rows = [solver.coordinates.index(n) for n in ("A2", "B3", "C3")]
    tick = solver.at(y, yd, ydd)
    assert not np.any(tick.status)
    assert np.abs(tick.position[rows, :count].T - q[:, columns]).max() < 1e-11
    assert np.abs(tick.acceleration[rows, :count].T - qdd[:, columns]).max() < 1e-9
    report.add("(a) NumPy + SciPy, 12 unknowns, v and a", f"{1e6 * theirs:.1f} µs a pose")

    ours = best(lambda: solver.at(y, yd, ydd)) / BATCH
    report.add(
        f"all {len(solver.coordinates)} coordinates, v and a, checked; batches of {BATCH:,}",
        f"{1e9 * ours:.0f} ns a pose",
        "150 ns",
        f"{theirs / ours:,.0f} x (a)",
    )
    lean = parakin.compile("flight-simulator", coordinates=twelve, checks=False)
    bare = best(lambda: lean.at(y, yd, ydd)) / BATCH
    report.add(
        f"the {len(twelve)} joint coordinates alone, unchecked",
        f"{1e9 * bare:.0f} ns a pose",
        "1,000 x (a)",
        f"{theirs / bare:,.0f} x (a)",
    )
    against_c(report, lean, np.concatenate([a[order] for a in (y, yd, ydd)]))
    unchecked = parakin.compile("flight-simulator", checks=False)
    without = best(lambda: unchecked.at(y, yd, ydd)) / BATCH
    report.add(
        "all coordinates, unchecked", f"{1e9 * without:.0f} ns a pose", "", f"{ours / without:.2f}"
    )
    motion = solver.motion("general")
    solve = best(lambda: solver.solve(motion), 5) / motion.count
    report.add(
        f"solve() to a Dataset, {motion.count:,} samples",
        f"{1e9 * solve:.0f} ns a pose",
        "",
        f"{theirs / solve:,.0f} x (a)",
    )
    single = y[:, 0].copy(), yd[:, 0].copy(), ydd[:, 0].copy(), tick.position[:, 0].copy()
    tock = median(lambda: solver.at(*single))
    report.add("at(), one pose with guess, median", f"{1e6 * tock:.1f} µs", "5 µs")
    bound = solver.bound()
    bound.y[:], bound.yd[:], bound.ydd[:] = single[:3]
    tock = median(bound.solve)
    report.add("bound().solve(), in arrays of its own", f"{1e6 * tock:.1f} µs", "2.5 µs")

    big = solver.motion("general", rate=(MILLION - 1) / 3)
    samples = big.samples()
    inputs = samples.position, samples.velocity, samples.acceleration
    alone = best(lambda: solver.at(*inputs), 5, 1) / MILLION
    both = best(lambda: solver.at(*inputs, parallel=True), 5, 1) / MILLION
    report.add("a million samples, one thread", f"{1e9 * alone:.0f} ns a pose")
    report.add(
        "a million samples, all cores",
        f"{1e9 * both:.0f} ns a pose",
        "near 2 x one thread",
        f"{alone / both:.2f} x one thread",
    )


def against_c(report: Report, lean: parakin.Solver, inputs: np.ndarray) -> None:
    """The kernel alone, as the C beside it: no arrays are made in either."""
    by_hand = build_by_hand()
    if by_hand is None:
        report.add("(c) the same by hand in C", "no gcc here")
        return
    out, theirs = np.empty((36, inputs.shape[1])), np.ascontiguousarray(inputs)
    by_hand(theirs, out)
    given = [lean.driven.index(f"platform.{name}") for name in ("x", "y", "phi")]
    mine = np.empty_like(theirs)
    for order in range(3):
        mine[3 * order + np.array(given)] = theirs[3 * order : 3 * order + 3]
    found = np.empty((lean.chart.outputs.count, inputs.shape[1]))
    lean.chart.kernel(mine, found, False)
    places = [lean.coordinates.index(name) for name in COORDINATES]
    rows = np.concatenate([np.array(places) + order * len(lean.coordinates) for order in range(3)])
    assert np.abs(found[rows] - out).max() < 1e-12
    seconds = best(lambda: by_hand(theirs, out), calls=200) / inputs.shape[1]
    report.add("(c) the same by hand in C, 12 unknowns, v and a", f"{1e9 * seconds:.1f} ns a pose")
    ours = best(lambda: lean.chart.kernel(mine, found, False), calls=200) / inputs.shape[1]
    report.add(
        "the kernel of these 12",
        f"{1e9 * ours:.1f} ns a pose",
        "2.2 (c)",
        f"{ours / seconds:.2f} (c)",
    )


def strokes(report: Report) -> None:
    solver = parakin.compile(
        "flight-simulator", coordinates=["A2", "B3", "C3"], derivatives=0, checks=False
    )
    y = solver.motion("general", rate=(BATCH - 1) / 3).samples().position
    ours = best(lambda: solver.at(y), calls=200) / BATCH
    figures = [f"{1e9 * ours:.1f} ns a pose"]
    out = np.empty((3, BATCH))
    x, up, phi = (np.ascontiguousarray(row) for row in y)
    for simd, label in ((False, "plain C (b)"), (True, "C arranged for gcc's SIMD")):
        compiled = build_c_strokes(simd=simd)
        if compiled is None:
            report.add(f"three strokes, {label}", "no gcc here")
            continue
        theirs = best(partial(compiled, x, up, phi, out), calls=200) / BATCH
        assert np.abs(out - solver.at(y).position).max() < 1e-14
        report.add(f"three strokes, {label}", f"{1e9 * theirs:.1f} ns a pose")
        figures.append(f"{theirs / ours:.2f}")
    report.add(
        "three strokes alone, parakin",
        figures[0],
        "(b)",
        " and ".join(f"{ratio} x" for ratio in figures[1:]) + " the speed of C",
    )


def poses_of(solver: parakin.Solver) -> np.ndarray:
    """A batch of driven values along the mechanism's last demonstration motion."""
    name = list(solver.mechanism.motions)[-1]
    motion = solver.motion(name, rate=1e6)
    stride = max(1, motion.count // BATCH)
    rows = [motion.window(i, i + 1).position[:, 0] for i in range(0, motion.count, stride)]
    values = np.array(rows[:BATCH]).T
    order = [motion.coordinates.index(n) for n in solver.driven]
    return np.ascontiguousarray(values[order])


def hexapod(report: Report) -> None:
    legs = [f"P{i}" for i in range(1, 7)]
    lengths = parakin.compile("gough-stewart", coordinates=legs, derivatives=0, checks=False)
    y = poses_of(lengths)
    seconds = best(lambda: lengths.at(y), calls=100) / BATCH
    report.add("6-UPS, lengths from poses", f"{1e9 * seconds:.1f} ns a pose", "15 ns")
    whole = parakin.compile("gough-stewart")
    rates = np.ones_like(y)
    seconds = best(lambda: whole.at(y, rates, rates)) / BATCH
    report.add(
        f"6-UPS, all {len(whole.coordinates)} coordinates, v and a",
        f"{1e9 * seconds:.0f} ns a pose",
        "300 ns",
    )
    forward = parakin.compile("gough-stewart", legs, coordinates=whole.driven, derivatives=0)
    found = lengths.at(y).position
    start = y + np.random.default_rng(0).uniform(-0.01, 0.01, y.shape)
    rows = [whole.driven.index(n) for n in forward.coordinates]
    tick = forward.at(found, guess=start[rows])
    assert not np.any(tick.status)
    assert np.abs(tick.position - y[rows]).max() < 1e-12
    seconds = best(lambda: forward.at(found, guess=start[rows])) / BATCH
    report.add(
        "6-UPS, pose from lengths, guess 10 mm and 0.6 deg off, checked",
        f"{1e9 * seconds:.0f} ns a pose",
        "150 ns",
    )
    alone = best(lambda: forward.at(found[:, 0], guess=start[rows, 0]), calls=500)
    report.add("6-UPS, the same, one pose", f"{1e6 * alone:.1f} µs")
    forward.at(found)  # compiles what walks from home
    walked = best(lambda: forward.at(found)) / BATCH
    report.add("6-UPS, pose from lengths, no guess", f"{1e9 * walked:.0f} ns a pose")


def others(report: Report) -> None:
    for name in ("3-rrr", "delta", "6-rus"):
        full = parakin.compile(name, machine_code=False)
        actuated = [c.name for c in full.graph.coordinates if c.actuated]
        solver = parakin.compile(name, coordinates=actuated, derivatives=0, checks=False)
        y = poses_of(solver)
        assert not np.any(solver.at(y).status)
        seconds = best(partial(solver.at, y), calls=100) / BATCH
        report.add(f"{name}, actuators from poses", f"{1e9 * seconds:.1f} ns a pose", "100 ns")
    start = time.perf_counter()
    parakin.compile("hexapod-on-3rps")
    report.add("hexapod-on-3rps compiles", f"{time.perf_counter() - start:.1f} s", "5 s")


def start_up(report: Report) -> None:
    report.add("parakin --help", f"{fresh('--help'):.2f} s", "0.3 s")
    with tempfile.TemporaryDirectory() as folder:
        caches, table, figure = (str(Path(folder, n)) for n in ("caches", "g.csv", "g.png"))
        command = ["solve", "flight-simulator", "general", "-o", table, "--plot", figure]
        for kept, what, limits in (
            (None, "nothing cached", ("0.5 s", "1.8 s")),
            (caches, "cached", ("0.15 s", "1.3 s")),
        ):
            if kept is not None:
                run(["-m", "parakin", *command], kept)
            seconds = compile_time(kept)
            report.add(f"first compilation, {what}", f"{seconds:.2f} s", limits[0])
            seconds = fresh(*command, caches=kept)
            report.add(f"the README's first command, {what}", f"{seconds:.2f} s", limits[1])


def ten_million(report: Report) -> None:
    solver = parakin.compile("flight-simulator")
    motion = solver.motion("general", rate=1e7 / 3)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "long.parquet"
        start = time.perf_counter()
        write(solver.stream(motion, 100_000, parallel=True), path)
        seconds = time.perf_counter() - start
        size = path.stat().st_size / 1e9
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    report.add(
        f"{motion.count:,} samples solved and written (Parquet, {size:.1f} GB)",
        f"{seconds:.0f} s",
        "bounded memory",
        f"{after - before:+.0f} MB at the peak",
    )


def main() -> None:
    options = argparse.ArgumentParser(prog="python -m benchmarks")
    options.add_argument("--long", action="store_true", help="ten million samples to a file too")
    options.add_argument("--check", action="store_true", help="what got slower than is kept")
    options.add_argument("--keep", action="store_true", help="with --check: keep the new figures")
    chosen = options.parse_args()
    console = Console(width=120)
    if chosen.check:
        table, slower = guard.check(keep=chosen.keep)
        console.print(machine(), table, "", *slower or ["nothing got slower"], sep="\n")
        sys.exit(1 if slower else 0)
    report = Report()
    flight_simulator(report)
    strokes(report)
    hexapod(report)
    others(report)
    for name in forces.CASES:
        for row in forces.rows(name):
            report.add(*row)
    start_up(report)
    if chosen.long:
        ten_million(report)
    console.print(machine())
    console.print(report.table)


if __name__ == "__main__":
    main()
