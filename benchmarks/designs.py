"""Dimensions left open: what a kernel costs that takes them as inputs, as ratios to a fixed one.

    python -m benchmarks.designs

A hexapod whose joints' places are parameters, ten of them or all 24 left open, and the flight
simulator with its ten lengths. One thread, batches of 8,192; nothing else should run. `open/fixed`
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

BATCH, TURNS = 8192, 7
LEGS = [f"P{i}" for i in range(1, 7)]
PLACES = [f"{axis}{i}" for i in range(1, 7) for axis in ("x", "y", "u", "v")]
LENGTHS = ["d1", "d2", "d3", "d4", "d5", "l1", "l2", "l3", "b", "h"]


def hexapod() -> Mechanism:
    """The catalogue's, the joints' places on base (x, y) and platform (u, v) being parameters."""
    mechanism = parakin.load("gough-stewart")
    values = dict(mechanism.parameters)
    joints = []
    for joint in mechanism.joints:
        kind, number = joint.name[0], joint.name[1:]
        if kind == "U":
            values[f"x{number}"], values[f"y{number}"] = joint.on_parent.at[:2]
            at = (f"x{number}", f"y{number}", 0.0)
            joint = joint.model_copy(
                update={"on_parent": joint.on_parent.model_copy(update={"at": at})}
            )
        elif kind == "S":
            values[f"u{number}"], values[f"v{number}"] = joint.on_child.at[:2]
            at = (f"u{number}", f"v{number}", 0.0)
            joint = joint.model_copy(
                update={"on_child": joint.on_child.model_copy(update={"at": at})}
            )
        joints.append(joint)
    fixed = {name: value for name, value in values.items() if name not in PLACES}
    numbers = parakin.compile(mechanism, machine_code=False).graph
    for joint, made in zip(mechanism.joints, numbers.joints, strict=False):
        if joint.name[0] == "U":
            fixed[f"x{joint.name[1:]}"], fixed[f"y{joint.name[1:]}"] = made.F.p[:2]
        elif joint.name[0] == "S":
            fixed[f"u{joint.name[1:]}"], fixed[f"v{joint.name[1:]}"] = made.M.p[:2]
    return mechanism.model_copy(update={"joints": tuple(joints), "parameters": fixed})


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
    lengths = compiled(free=ten, coordinates=LEGS, derivatives=0, checks=False)
    table.add_row(*sensitivities("six lengths, by driven and open", lengths))
    pose = parakin.compile(mechanism, LEGS, free=ten, coordinates=mechanism.driven, derivatives=0)
    table.add_row(*sensitivities("pose from lengths, by driven and open", pose))
    Console().print(table)


if __name__ == "__main__":
    main()
