"""How compilation grows with a mechanism: scissor lifts of more and more stages.

    python -m benchmarks.scaling
    python -m benchmarks.scaling --angle    # driven by the angle of its first bar

Seconds of processor time, heyoka's cache on disk left out; at the end the exponent fitted.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

import parakin
from benchmarks.timing import machine

sys.path.append(str(Path(__file__).parents[1] / "tests" / "oracles"))
from scissor_lift import scissor_lift

STAGES = (10, 20, 40, 80)


class Timed:
    """A function of a module, and the processor time spent in it."""

    def __init__(self, module: Any, name: str) -> None:
        self.spent, self._inner = 0.0, getattr(module, name)
        setattr(module, name, self)

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        start = time.process_time()
        try:
            return self._inner(*arguments, **named)
        finally:
            self.spent += time.process_time() - start


def parts() -> dict[str, Timed]:
    """What a compilation consists of."""
    import heyoka as hy

    from parakin.kernel import backends
    from parakin.solving import compiler, recipes

    hy.llvm_state.set_diskcache_enabled(False)
    return {
        "assembly": Timed(compiler, "assembled"),
        "planning": Timed(recipes, "plan_of"),
        "tracing": Timed(backends, "_traced"),
        "machine code": Timed(hy, "cfunc"),
    }


def seconds(work: Callable[[], object]) -> float:
    start = time.process_time()
    work()
    return time.process_time() - start


def main() -> None:
    options = argparse.ArgumentParser(prog="python -m benchmarks.scaling")
    options.add_argument("--angle", action="store_true", help="drive the angle of the first bar")
    by_slide = not options.parse_args().angle
    parakin.compile("four-bar")  # imports
    timed = parts()
    table = Table("stages", "processor time [s]", *timed, title=machine())
    totals = []
    for stages in STAGES:
        mechanism = scissor_lift(stages, by_slide=by_slide)
        before = [each.spent for each in timed.values()]
        totals.append(seconds(partial(parakin.compile, mechanism)))
        spent = [each.spent - old for each, old in zip(timed.values(), before, strict=True)]
        table.add_row(str(stages), *(f"{x:.2f}" for x in (totals[-1], *spent)))
    exponent = np.polyfit(np.log(STAGES), np.log(totals), 1)[0]
    console = Console(width=120)
    console.print(table)
    console.print(f"exponent {exponent:.2f}")


if __name__ == "__main__":
    main()
