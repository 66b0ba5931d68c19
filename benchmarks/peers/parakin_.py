"""parakin's own script; the mechanisms are files of its catalogue."""

from __future__ import annotations

import parakin
from benchmarks.peers.ways import POSE, SLIDERS, VARIABLES, Both, Floats, Way, others


def flight_simulator() -> Both:
    def way(driven: list[int]) -> Way:
        solver = parakin.compile(
            "flight-simulator",
            driven=[VARIABLES[i] for i in driven],
            # A4 is phi, and what the iteration starts from
            coordinates=[VARIABLES[i].replace("platform.phi", "A4") for i in others(driven)],
        )

        def solve(given: Floats, guess: Floats) -> tuple[Floats, ...]:
            tick = solver.at(given[0], given[1], given[2], guess=guess)
            return tick.position, tick.velocity, tick.acceleration

        return Way(solve, solve)

    return Both(way(POSE), way(SLIDERS))


def hexapod() -> Both:
    pose = [f"platform.{name}" for name in ("x", "y", "z", "roll", "pitch", "yaw")]
    lengths = [f"P{i}" for i in range(1, 7)]
    joints = [name for i in range(1, 7) for name in (f"U{i}.1", f"U{i}.2", f"P{i}")]

    def way(driven: list[str], coordinates: list[str]) -> Way:
        solver = parakin.compile("gough-stewart", driven, coordinates=coordinates, derivatives=0)

        def solve(given: Floats, guess: Floats) -> tuple[Floats]:
            return (solver.at(given[0], guess=guess).position,)

        return Way(solve, solve)

    return Both(way(pose, joints), way(lengths, pose))
