"""What every engine is asked for, and what engines without a solver of their own need.

A mechanism is solved both ways: inverse, joints from the pose, and forward, the pose (and, in the
flight simulator, the other joints) from the sliders or lengths. `given` holds what is driven, with
its rates where they are wanted: (1, m) or (3, m), and of many poses (1, m, n) or (3, m, n). `guess`
is where the unknowns, (k,) or (k, n), are sought from. The answer has the unknowns in the order
below, then their rates.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from benchmarks.baselines import COORDINATES

Floats: TypeAlias = NDArray[np.float64]
Answer: TypeAlias = Floats | Sequence[Floats]
Solve: TypeAlias = Callable[[Floats, Floats], Answer]
Index: TypeAlias = Sequence[int] | slice
Rows: TypeAlias = Callable[[Floats], tuple[Floats, Floats]]

# The flight simulator's fifteen variables: the pose, then the twelve joints
VARIABLES = ("platform.x", "platform.y", "platform.phi", *COORDINATES)
POSE, SLIDERS = [0, 1, 2], [VARIABLES.index(name) for name in ("A2", "B3", "C3")]

COUNT = 1_000  # poses of a batch
CLOSED = 1e-14  # [m], of the residual at which an iteration stops


class Way(NamedTuple):
    one: Solve
    many: Solve


class Both(NamedTuple):
    inverse: Way
    forward: Way


def others(driven: Sequence[int], count: int = len(VARIABLES)) -> list[int]:
    return [i for i in range(count) if i not in driven]


def newton(
    rows: Rows, driven: Index, rest: Index, given: Floats, guess: Floats
) -> tuple[Floats, Floats]:
    """All variables at which the residual vanishes, and the Jacobian there."""
    q = np.empty(len(given) + len(guess))
    q[driven], q[rest] = given, guess
    for _ in range(20):
        residual, jacobian = rows(q)
        if np.abs(residual).max() < CLOSED:
            return q, jacobian
        q[rest] -= np.linalg.solve(jacobian[:, rest], residual)
    raise RuntimeError("Newton's iteration did not settle")


def moving(rows: Rows, drift: Callable[[Floats, Floats], Floats], driven: Sequence[int]) -> Solve:
    """A solver of positions, velocities and accelerations.

    `rows` gives the residual and its Jacobian by all variables, `drift` the rate of that Jacobian
    times the velocities.
    """
    rest = others(driven)

    def solve(given: Floats, guess: Floats) -> tuple[Floats, ...]:
        q, jacobian = newton(rows, driven, rest, given[0], guess)
        by_rest, by_driven = jacobian[:, rest], jacobian[:, driven]
        qd = np.empty(len(q))
        qd[driven] = given[1]
        qd[rest] = np.linalg.solve(by_rest, -by_driven @ given[1])
        qdd = np.linalg.solve(by_rest, -by_driven @ given[2] - drift(q, qd))
        return q[rest], qd[rest], qdd

    return solve


def one_by_one(solve: Solve) -> Way:
    """For an engine that takes no batches."""

    def many(given: Floats, guess: Floats) -> list[Floats]:
        answers = [solve(given[:, :, i], guess[:, i]) for i in range(guess.shape[1])]
        return [np.array(order).T for order in zip(*answers, strict=True)]

    return Way(solve, many)
