"""The flight simulator's general example and the 6-UPS, both ways, on parakin and its peers.

    python -m benchmarks.peers

Prints a table in Markdown, with the machine. Errors are the largest over 1,000 poses, against 40
digits; everything but exudyn starts from the same guesses, up to 10 mm or 0.01 rad from the answer.
One pose is the median over calls with ever new poses, a batch the best of several runs. Lines are
those of the functions that a user of the engine would write, both ways together, without comments,
imports and dimensions; parakin's with those of the mechanism's file, CasADi's with those that
generate C. Nothing else should run.
"""

from __future__ import annotations

import ast
import inspect
import io
import sys
import time
import tokenize
from collections.abc import Callable
from importlib import import_module, resources
from importlib.metadata import version
from itertools import count
from shutil import which
from types import FunctionType
from typing import Any

from benchmarks.peers.exact import Task, flight_simulator, hexapod
from benchmarks.peers.ways import COUNT, Both, Way
from benchmarks.timing import machine, median

# What it is called, with its version; the module here; the distribution; options
ENGINES: tuple[tuple[str, str, str, dict[str, bool]], ...] = (
    ("parakin {}", "parakin_", "parakin", {}),
    ("CasADi {}", "casadi_", "casadi", {"compiled": False}),
    ("CasADi {}, generated C", "casadi_", "casadi", {"compiled": True}),
    ("SymPy {}, lambdified", "sympy_", "sympy", {}),
    ("MuJoCo {}", "mujoco_", "mujoco", {}),
    ("Pinocchio {}", "pinocchio_", "pin", {}),
    ("exudyn {}", "exudyn_", "exudyn", {}),
)
HEADINGS = (
    *("", "solved with", "error of position", "of velocity", "of acceleration"),
    *("one pose", "a pose of 1,000", "ready after", "lines"),
)
PATIENCE = 1.5  # [s] for all runs of a batch
CATALOGUE = {"flight_simulator": "flight-simulator.toml", "hexapod": "gough-stewart.toml"}


def lines_of_code(source: str) -> int:
    """Lines with something on them besides comments and docstrings."""
    said = (ast.FunctionDef, ast.ClassDef, ast.Module)
    docstrings = {
        line
        for node in ast.walk(ast.parse(source))
        if isinstance(node, said) and ast.get_docstring(node) is not None
        for line in range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1)
    }
    layout = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}
    used = {
        line
        for token in tokenize.generate_tokens(io.StringIO(source).readline)
        if token.type not in layout and token.string
        for line in range(token.start[0], token.end[0] + 1)
    }
    return len(used - docstrings)


def user_code(start: Callable[..., Any]) -> int:
    """Lines of a function and of all functions and classes of these benchmarks that it needs."""
    found, waiting = {}, [start]
    while waiting:
        part = waiting.pop()
        found[part] = source = inspect.getsource(part)
        names = {node.id for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Name)}
        around = vars(sys.modules[part.__module__])
        for needed in (around[name] for name in names if name in around):
            ours = isinstance(needed, FunctionType | type)
            if ours and needed.__module__.startswith(__package__) and needed not in found:
                waiting.append(needed)
    interface = {Way, Both}  # the benchmark's, not the user's
    return sum(lines_of_code(source) for part, source in found.items() if part not in interface)


def file_lines(name: str) -> int:
    """Of a mechanism file of the catalogue, without blank lines and comments."""
    text = resources.files("parakin").joinpath("catalogue", name).read_text()
    return sum(bool(line.partition("#")[0].strip()) for line in text.splitlines())


def timed(way: Way, task: Task) -> tuple[float, float]:
    """Seconds of one pose, and of one in a batch."""
    poses = [
        (task.given[:, :, i].copy(), task.guess[:, i].copy()) for i in range(task.guess.shape[1])
    ]
    calls = count()

    def one() -> None:
        way.one(*poses[next(calls) % COUNT])

    one()
    single = median(one, COUNT)
    best, spent = float("inf"), 0.0
    while spent < PATIENCE:
        start = time.perf_counter()
        way.many(task.given, task.guess)
        best = min(best, time.perf_counter() - start)
        spent += time.perf_counter() - start
    return single, best / COUNT


def duration(seconds: float) -> str:
    if seconds < 1e-6:
        return f"{1e9 * seconds:.0f} ns"
    return f"{1e6 * seconds:.3g} µs" if seconds < 1e-3 else f"{1e3 * seconds:.2g} ms"


def table(mechanism: str, tasks: tuple[Task, Task]) -> tuple[list[list[str]], list[list[str]]]:
    """Rows of the inverse and of the forward solution, one for each engine."""
    inverse: list[list[str]] = []
    forward: list[list[str]] = []
    for name, module, distribution, options in ENGINES:
        missing = ""
        try:
            build = getattr(import_module(f"benchmarks.peers.{module}"), mechanism)
        except ModuleNotFoundError:
            missing = "not installed"
        if options.get("compiled") and which("gcc") is None:
            missing = "no gcc here"
        if missing:
            for rows in (inverse, forward):
                rows.append([name.replace(" {}", ""), missing, *[""] * 6])
            continue
        start = time.perf_counter()
        both = build(**options)
        ready = time.perf_counter() - start
        lines = str(user_code(build))
        if module == "parakin_":
            lines += f" + {file_lines(CATALOGUE[mechanism])}"
        for rows, way, task in zip((inverse, forward), both, tasks, strict=True):
            errors = [f"{error:.0e}" for error in task.errors(way.many(task.given, task.guess))]
            times = [duration(seconds) for seconds in timed(way, task)]
            missing_orders = [""] * (3 - len(errors))
            label = name.format(version(distribution))
            rows.append([label, *errors, *missing_orders, *times, f"{ready:.2f} s", lines])
    return inverse, forward


def main() -> None:
    print(f"{machine()}\n")
    print("| " + " | ".join(HEADINGS) + " |")
    print("|" + "---|" * len(HEADINGS))
    for title, mechanism, tasks in (
        ("flight simulator", "flight_simulator", flight_simulator()),
        ("6-UPS", "hexapod", hexapod()),
    ):
        for way, rows in zip(("inverse", "forward"), table(mechanism, tasks), strict=True):
            for i, row in enumerate(rows):
                print("| " + " | ".join(["" if i else f"{title}, {way}", *row]) + " |")


if __name__ == "__main__":
    main()
