"""What got slower: `python -m benchmarks --check` compares with figures kept beside this file.

Each figure is a ratio to a baseline of the same run, measured in turn with it, so that it means the
same on a slower machine: kernels to NumPy's sine of as many numbers, calls and compilations to a
loop in plain Python, commands to a Python process that does nothing. `--keep` writes them anew.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from rich.table import Table

import parakin

KEPT = Path(__file__).with_name("ratios.json")
SLOWER = 1.1  # times the ratio that is kept
_BATCH, _ROUNDS = 1_000, 25


class Case(NamedTuple):
    """What is timed, what it is compared with, and how often each is called in a round."""

    name: str
    run: Callable[[], object]
    baseline: Callable[[], object]
    calls: int
    baseline_calls: int


def sines() -> Callable[[], object]:
    """NumPy's sine of 64 numbers for each pose of a batch."""
    values = np.linspace(0.0, 3.0, 64 * _BATCH).reshape(64, _BATCH)
    out = np.empty_like(values)
    return lambda: np.sin(values, out=out)


def plain_python() -> int:
    """A loop of sums, products and look-ups."""
    table = {k: 0.5 * k for k in range(64)}
    total = 0.0
    for k in range(2_000):
        total += table[k & 63] * 1.000001 - total * 1e-6
    return int(total)


def process(*arguments: str) -> Callable[[], object]:
    command = [sys.executable, *arguments]
    return lambda: subprocess.run(command, check=True, capture_output=True)


def kernel(name: str, driven: list[str] | None = None, **options: object) -> Callable[[], object]:
    """A solver's kernel on a batch around home, with rates."""
    solver = parakin.compile(name, driven, **options)  # type: ignore[arg-type]
    chart, draw = solver.chart, np.random.default_rng(0)
    home = np.array([solver.home[coordinate] for coordinate in solver.driven])
    y = home[:, None] + 1e-3 * draw.normal(size=(len(home), _BATCH))
    rates = draw.normal(size=(chart.outputs.derivatives * len(home), _BATCH))
    found = [solver.home[coordinate] for coordinate in solver.iterated]
    guess = np.array(found).reshape(-1, 1).repeat(_BATCH, axis=1)
    inputs, out = np.concatenate([y, rates, guess]), np.empty((chart.outputs.count, _BATCH))
    return lambda: chart.kernel(inputs, out, False)


def cases() -> list[Case]:
    sine, legs = sines(), [f"P{k}" for k in range(1, 7)]
    joints = ["A1", "A2", "A3", "B1.1", "B1.2", "B3", "C1.1", "C1.2", "C3", "D1", "E1", "E2P"]
    kernels = {
        "flight simulator, all, checked": kernel("flight-simulator"),
        "flight simulator, all, unchecked": kernel("flight-simulator", checks=False),
        "flight simulator, twelve, unchecked": kernel(
            "flight-simulator", coordinates=joints, checks=False
        ),
        "gough-stewart, all": kernel("gough-stewart"),
        "gough-stewart, pose from lengths": kernel("gough-stewart", legs, derivatives=0),
        "delta, all": kernel("delta"),
        "four-bar, all": kernel("four-bar"),
        "six-bar-watt, all": kernel("six-bar-watt"),
        "hexapod-on-3rps, all": kernel("hexapod-on-3rps"),
    }
    solver = parakin.compile("flight-simulator")
    motion = solver.motion("general")
    y, yd, ydd = (a[:, 5].copy() for a in motion.samples()[1:4])
    guess, bound = solver.at(y).position, solver.bound()
    bound.y[:], bound.yd[:], bound.ydd[:] = y, yd, ydd
    plain, nothing = plain_python, process("-c", "pass")
    compiling = [parakin.load(name) for name in ("flight-simulator", "gough-stewart", "tricept")]
    readme = ("-m", "parakin", "solve", "flight-simulator", "general", "-o", "-")
    return [
        *(Case(name, run, sine, 20, 10) for name, run in kernels.items()),
        Case("at, one pose with guess", lambda: solver.at(y, yd, ydd, guess), plain, 2_000, 20),
        Case("bound, one pose", bound.solve, plain, 5_000, 20),
        Case("solve, 3,001 samples", lambda: solver.solve(motion), plain, 5, 20),
        Case(
            "planning of three mechanisms",
            lambda: [parakin.compile(m, machine_code=False) for m in compiling],
            plain,
            1,
            20,
        ),
        Case("parakin --help", process("-m", "parakin", "--help"), nothing, 1, 1),
        Case("parakin solve", process(*readme), nothing, 1, 1),
    ]


def ratio(case: Case) -> float:
    """By the least of several rounds, each of both in turn."""
    rounds = 5 if case.calls == 1 else _ROUNDS
    mine, theirs = math.inf, math.inf
    for _ in range(rounds):
        theirs = min(theirs, _seconds(case.baseline, case.baseline_calls))
        mine = min(mine, _seconds(case.run, case.calls))
    return mine / theirs


def _seconds(function: Callable[[], object], calls: int) -> float:
    start = time.perf_counter()
    for _ in range(calls):
        function()
    return (time.perf_counter() - start) / calls


def check(*, keep: bool) -> tuple[Table, list[str]]:
    """A table of all figures, and what got slower by more than a tenth."""
    before = json.loads(KEPT.read_text("utf-8")) if KEPT.exists() else {}
    table = Table("what", "ratio", "kept", "change", box=None, pad_edge=False)
    now: dict[str, float] = {}
    slower = []
    for case in cases():
        now[case.name] = found = ratio(case)
        known = before.get(case.name)
        if known is not None and not found <= SLOWER * known:
            found = now[case.name] = min(found, ratio(case))  # once more, if it was disturbed
        change = "" if known is None else f"{100.0 * (found / known - 1.0):+.0f} %"
        if known is not None and not found <= SLOWER * known:
            slower.append(f"{case.name}: {found:.3g}, {known:.3g} before")
        table.add_row(case.name, f"{found:.4g}", "" if known is None else f"{known:.4g}", change)
    if keep:
        text = json.dumps({name: float(f"{value:.4g}") for name, value in now.items()}, indent=2)
        KEPT.write_text(text + "\n", "utf-8")
    return table, slower
