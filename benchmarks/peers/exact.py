"""The two mechanisms' answers to 40 digits, with the poses they belong to.

The flight simulator's come from the plane geometry of tests/oracles/closed_form.py. The hexapod's
lengths and universal angles follow from its leg vectors; what its forward solution has to find is
the pose that the lengths came from.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import parakin
from benchmarks.peers.ways import COUNT, POSE, SLIDERS, VARIABLES, Answer, Floats, others

sys.path.append(str(Path(__file__).parents[2] / "tests" / "oracles"))
import closed_form

MP = closed_form.MP
Digits = NDArray[Any]  # of mpmath's numbers

OFF = 0.01  # how far guesses are from the answer [m or rad]


@dataclass(frozen=True)
class Task:
    """Driven values and rates (orders, m, n) and guesses (k, n), as doubles, and the answers."""

    given: Floats
    guess: Floats
    answers: Digits  # (orders, k, n)

    def errors(self, found: Answer) -> list[float]:
        """The largest, of positions, velocities and accelerations."""
        assert np.isfinite(found).all()
        return [
            float(np.abs(answer - values).max())
            for answer, values in zip(self.answers, found, strict=True)
        ]


def task(variables: Digits, driven: Sequence[int]) -> Task:
    """From all variables (orders, all, n), some of which are driven."""
    answers = variables[:, others(driven, variables.shape[1])]
    guess = answers[0].astype(float)
    guess += np.random.default_rng(0).uniform(-OFF, OFF, guess.shape)
    return Task(np.ascontiguousarray(variables[:, driven].astype(float)), guess, answers)


def flight_simulator() -> tuple[Task, Task]:
    """Inverse and forward, along the paper's third example."""
    paper = closed_form.Parameters()
    samples = []
    for i in range(COUNT):
        pose = closed_form.example(3, MP.mpf(3 * i) / (COUNT - 1))
        # Doubles, taken as exact from here on
        driven = [tuple(MP.mpf(float(value)) for value in order) for order in pose]
        state = closed_form.state(paper, *driven)
        joints = [state[name] for name in VARIABLES[3:]]
        samples.append([list(driven[k]) + [joint[k] for joint in joints] for k in range(3)])
    variables = np.array(samples, dtype=object).transpose(1, 2, 0)
    return task(variables, POSE), task(variables, SLIDERS)


def hexapod() -> tuple[Task, Task]:
    """Inverse and forward, along the catalogue's tour through all six freedoms."""
    solver = parakin.compile("gough-stewart", machine_code=False)
    motion = solver.motion("tour", rate=(COUNT - 1) / 10)
    order = [
        motion.coordinates.index(f"platform.{n}") for n in ("x", "y", "z", "roll", "pitch", "yaw")
    ]
    poses = [
        [MP.mpf(float(value)) for value in pose] for pose in motion.samples().position[order].T
    ]
    legs = np.array([hexapod_legs(pose) for pose in poses], dtype=object).T
    pose = np.array(poses, dtype=object).T
    inverse = task(np.concatenate((pose, legs))[None], range(6))
    forward = task(np.concatenate((legs[2::3], pose))[None], range(6))
    return inverse, forward


def hexapod_legs(pose: Sequence[Any]) -> list[Any]:
    """U.1, U.2 and the stroke of each leg.

    Along a leg is (sin U.1 sin U.2, -cos U.1 sin U.2, cos U.2) in x outwards, y downwards and z
    tangential at its foot.
    """
    x, y, z, roll, pitch, yaw = pose
    R = MP.matrix(3)
    (cr, cp, cy), (sr, sp, sy) = ([f(a) for a in (roll, pitch, yaw)] for f in (MP.cos, MP.sin))
    R[0, 0], R[0, 1] = cp * cy, -cp * sy
    R[1, 0], R[1, 1] = cr * sy + sr * sp * cy, cr * cy - sr * sp * sy
    R[2, 0], R[2, 1] = sr * sy - cr * sp * cy, sr * cy + cr * sp * sy
    found = []
    for i in range(6):
        pair, side = 120 * (i // 2), 2 * (i % 2) - 1
        base, top = (MP.pi / 180 * degrees for degrees in (pair + 10 * side, pair + 50 * side))
        a, b = MP.mpf("1.2"), MP.mpf("0.7")
        bx, by = b * MP.cos(top), b * MP.sin(top)
        wx = x + R[0, 0] * bx + R[0, 1] * by - a * MP.cos(base)
        wy = y + R[1, 0] * bx + R[1, 1] * by - a * MP.sin(base)
        wz = z + R[2, 0] * bx + R[2, 1] * by
        out = wx * MP.cos(base) + wy * MP.sin(base)
        along = wy * MP.cos(base) - wx * MP.sin(base)
        across = MP.sqrt(out**2 + wz**2)
        found += [MP.atan2(out, wz), MP.atan2(across, along), MP.hypot(across, along) - 1]
    return found
