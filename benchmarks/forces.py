"""Speed of efforts, reactions and accelerations from forces, as ratios to the same solver's own
kinematics in the same run.
"""

import numpy as np

import parakin
from benchmarks.timing import best
from parakin.solving.forward import Forward
from parakin.solving.solver import Solver

BATCH = 4_096
CASES = {"flight-simulator": "general", "gough-stewart": "tour"}
FORWARD = {"flight-simulator": 4, "gough-stewart": 7}  # times the kinematics, to reach


def inputs(solver: Solver, motion: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Driven positions, velocities and accelerations at BATCH poses of a motion."""
    samples = solver.motion(motion).samples()
    chosen = np.linspace(0, len(samples.time) - 1, BATCH).astype(int)
    orders = (samples.position, samples.velocity, samples.acceleration)
    y, yd, ydd = (np.ascontiguousarray(order[:, chosen]) for order in orders)
    return y, yd, ydd


def rows(name: str) -> list[tuple[str, str, str, str]]:
    """What, measured, to reach, ratio: of one mechanism's kinematics, efforts and reactions."""
    every = parakin.compile(name, coordinates="all", checks=False)
    moved = [c.name for c in every.graph.coordinates if c.actuated]
    solver = parakin.compile(name, coordinates=moved, checks=False)
    driven = inputs(every, CASES[name])
    assert not np.any(every.at(*driven).status)
    kinematics = best(lambda: every.at(*driven)) / BATCH
    efforts = best(lambda: solver.at(*driven, forces=True)) / BATCH
    both = best(lambda: solver.at(*driven, reactions=True)) / BATCH
    forward, alone = forward_times(every, driven)
    return [
        (f"{name}: all coordinates, v and a, unchecked", f"{1e9 * kinematics:.0f} ns", "", ""),
        (
            f"{name}: efforts",
            f"{1e9 * efforts:.0f} ns",
            "1.2 x the kinematics",
            f"{efforts / kinematics:.2f} x the kinematics",
        ),
        (
            f"{name}: efforts and all reactions",
            f"{1e9 * both:.0f} ns",
            "1.9 x the kinematics",
            f"{both / kinematics:.2f} x the kinematics",
        ),
        (
            f"{name}: accelerations from forces (one pose alone {1e6 * alone:.1f} µs)",
            f"{1e9 * forward:.0f} ns",
            f"{FORWARD[name]} x the kinematics",
            f"{forward / kinematics:.2f} x the kinematics",
        ),
    ]


def forward_times(
    every: Solver, driven: tuple[np.ndarray, np.ndarray, np.ndarray]
) -> tuple[float, float]:
    """Seconds a pose, in a batch and alone, of what `Solver.simulate` integrates: it has no public
    name, being called step by step.
    """
    forward = Forward.of(every.chart, 1e-3)
    tick, plan = every.at(*driven), every.plan
    unknowns = [tick.value(every.graph.coordinates[k].name) for k in plan.unknowns]
    state = np.concatenate([driven[0], np.array(unknowns), driven[1], np.zeros((1, BATCH))])
    efforts = np.zeros((len(forward.rows.actuated), BATCH))
    loads = every.mechanics.loads(None, BATCH)
    batch = best(lambda: forward.run(state, efforts, loads)) / BATCH
    one = [np.ascontiguousarray(each[:, 0]) for each in (state, efforts, loads)]
    return batch, best(lambda: forward.run(*one))
