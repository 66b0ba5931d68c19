"""Dimensions left open: what a kernel costs that takes them as inputs, as ratios to a fixed one.

    python -m benchmarks.designs

A hexapod whose joints' places are parameters, ten of them or all 24 left open, and the flight
simulator with its ten lengths. One thread, batches of 1,000; nothing else should run. `open/fixed`
is the median of ratios of runs by turns.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from rich.console import Console
from rich.table import Table

import parakin
from benchmarks.timing import best, machine
from parakin import Mechanism, Solver
from parakin.analysis.sensitivities import Asked
from parakin.arrays import FloatArray
from parakin.model.evaluation import graph_of

BATCH, TURNS = 1_000, 15
LEGS = [f"P{i}" for i in range(1, 7)]
PLACES = [f"{axis}{i}" for i in range(1, 7) for axis in ("x", "y", "u", "v")]
LENGTHS = ["d1", "d2", "d3", "d4", "d5", "l1", "l2", "l3", "b", "h"]


def hexapod() -> Mechanism:
    """The catalogue's, the joints' places on base (x, y) and platform (u, v) being parameters."""
    mechanism = parakin.load("gough-stewart")
    joints = {joint.name: joint for joint in mechanism.joints}
    values = dict(mechanism.parameters)
    for made in graph_of(mechanism).joints:
        kind, number = made.name[0], made.name[1:]
        side = {"U": "on_parent", "S": "on_child"}.get(kind)
        if side is None:
            continue
        p = made.F.p if kind == "U" else made.M.p
        names = [f"{axis}{number}" for axis in ("xy" if kind == "U" else "uv")]
        values |= dict(zip(names, p[:2], strict=True))
        frame = getattr(joints[made.name], side).model_copy(update={"at": (*names, 0.0)})
        joints[made.name] = joints[made.name].model_copy(update={side: frame})
    return mechanism.model_copy(update={"joints": tuple(joints.values()), "parameters": values})


def poses(solver: Solver) -> FloatArray:
    """Positions near home with rates and second rates, as a kernel takes them."""
    rng = np.random.default_rng(0)
    home = np.array([[solver.home[name]] for name in solver.driven])
    y = home + 0.02 * rng.uniform(-1, 1, (len(home), BATCH))
    rates = 0.1 * rng.normal(size=(solver.derivatives * len(home), BATCH))
    return np.concatenate([y, rates])


def runs(solver: Solver) -> tuple[Callable[[], object], Callable[[], object]]:
    """The fixed kernel and the open one on the same poses, from home as a guess."""
    inputs, opened = poses(solver), solver.opened
    designs = solver.designs
    given = designs.given(designs.designs.own[:, None], BATCH)
    told = given.rows(opened.plan, opened.outputs.coordinates)
    at_home = [solver.plan.home[k] - solver.plan.offset(k) for k in solver.plan.iterated]
    guess = np.repeat(np.array(at_home).reshape(-1, 1), BATCH, axis=1)
    fixed = np.ascontiguousarray(np.concatenate([inputs, guess]))
    open_ = np.ascontiguousarray(np.concatenate([inputs, told, guess]))
    return partial(solver.chart.run, fixed), partial(opened.run, open_)


def row(label: str, solver: Solver) -> tuple[str, ...]:
    fixed, open_ = runs(solver)
    fixed(), open_()
    pairs = np.array([(best(fixed), best(open_)) for _ in range(TURNS)]) / BATCH * 1e9
    ratio = float(np.median(pairs[:, 1] / pairs[:, 0]))
    least = pairs.min(axis=0)
    return label, str(len(solver.free)), f"{least[0]:.1f}", f"{least[1]:.1f}", f"{ratio:.2f}"


def sensitivities(label: str, solver: Solver) -> tuple[str, ...]:
    """The kernel of sensitivities alone, which those of all poses come from."""
    y = poses(solver)[: len(solver.driven)]
    asked = Asked.of(solver, y, solver.at(y, parameters={}), {}, 0)
    spent = min(best(asked.run) for _ in range(TURNS)) / BATCH * 1e9
    return label, str(len(solver.free)), "", f"{spent:.1f}", ""


def by_at(solver: Solver) -> list[tuple[str, ...]]:
    """Through `Solver.at`: a batch of the file's own design, of another, and of a new one each."""
    y, name = poses(solver)[: len(solver.driven)], solver.free[0]
    own, rng = float(solver.designs.designs.own[0]), np.random.default_rng(2)

    def new() -> None:
        solver.at(y, parameters={name: own * (1.0 + 0.01 * rng.uniform(size=BATCH))})

    fixed = best(partial(solver.at, y)) / BATCH * 1e9
    other = best(partial(solver.at, y, parameters={name: 1.01 * own})) / BATCH * 1e9
    each = best(new) / BATCH * 1e9
    named = {"one other design": other, "a new design each": each}
    return [
        (f"`at`, {label}", "1", f"{fixed:.0f}", f"{spent:.0f}", f"{spent / fixed:.1f}")
        for label, spent in named.items()
    ]


def main(arguments: Sequence[str] = ()) -> None:
    del arguments
    table = Table("ns a pose", "open", "fixed", "open", "open/fixed", title=machine())
    ten, all_ = PLACES[:10], PLACES
    mechanism = hexapod()
    compiled = partial(parakin.compile, mechanism)
    for free in (ten, all_):
        table.add_row(
            *row("six lengths", compiled(free=free, coordinates=LEGS, derivatives=0, checks=False))
        )
        table.add_row(*row("hexapod by its pose", compiled(free=free)))
        table.add_row(*row("hexapod by its legs", compiled(LEGS, free=free)))
    flight = partial(parakin.compile, "flight-simulator", free=LENGTHS)
    table.add_row(*row("flight simulator", flight()))
    table.add_row(*row("flight simulator by its sliders", flight(["A2", "B3", "C3"])))
    for told in by_at(parakin.compile("gough-stewart", free=["r_base"])):
        table.add_row(*told)
    lengths = compiled(free=ten, coordinates=LEGS, derivatives=0, checks=False)
    table.add_row(*sensitivities("six lengths, by driven and open", lengths))
    pose = parakin.compile(mechanism, LEGS, free=ten, coordinates=mechanism.driven, derivatives=0)
    table.add_row(*sensitivities("pose from lengths, by driven and open", pose))
    Console().print(table)


if __name__ == "__main__":
    main()
