"""Small motions about a pose of equilibrium: mass, damping and stiffness, as control design and
modal analysis want them.

The derivatives are those of `kernel.forward` on dual numbers, and so exact.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from parakin.algebra.dual import dual, dual_functions, rate_of
from parakin.algebra.spatial import FLOATS, Scalar, as_float
from parakin.arrays import ComplexArray, FloatArray
from parakin.caching import cached_property
from parakin.errors import InputError
from parakin.kernel.forward import accelerations
from parakin.kinematics.configuration import Configuration, coordinate_scales
from parakin.solving.forces import is_finite
from parakin.solving.forward import Forward
from parakin.solving.solver import Solver
from parakin.solving.status import SOLVED
from parakin.solving.tick import Tick

_AWAY = 1e-6  # rad, or characteristic lengths: as far as a pose may be from equilibrium
_ROUNDING = 1e-12  # of all forces: what need not be balanced
_ALIKE = 1e-9  # of a matrix: by how much one that is symmetric may not be


@dataclass(frozen=True)
class Linearisation:
    """About a pose at rest, in deviations from it: M ydd + D yd + K y = Gᵀ τ.

    driven, actuators: names, of y (n,) and τ (m,). mass, damping, stiffness: M, D, K (n, n) [SI].
    actuation: G (m, n), the rates of the actuators by those of the driven coordinates. efforts:
    those that hold the pose (m,) [N or N m], which K counts as constant.
    """

    driven: tuple[str, ...]
    actuators: tuple[str, ...]
    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    actuation: FloatArray
    efforts: FloatArray

    @property
    def state_space(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """A, B, C, D of x' = A x + B τ, q = C x + D τ: x is y, then yd, (2n,); q the positions of
        the actuators.
        """
        n, m = len(self.driven), len(self.actuators)
        right = np.hstack([-self.stiffness, -self.damping, self.actuation.T])
        below = np.linalg.solve(self.mass, right)
        A = np.vstack([np.eye(n, 2 * n, n), below[:, : 2 * n]])
        B = np.vstack([np.zeros((n, m)), below[:, 2 * n :]])
        return A, B, np.hstack([self.actuation, np.zeros((m, n))]), np.zeros((m, m))

    @property
    def poles(self) -> ComplexArray:
        """The eigenvalues of A [1/s], (2n,), by their magnitude."""
        found = np.linalg.eigvals(self.state_space[0]).astype(complex)
        return np.asarray(found[np.argsort(np.abs(found))], dtype=complex)

    def modes(self) -> tuple[FloatArray, FloatArray]:
        """Undamped: natural frequencies [Hz] (n,), the lowest first, negative where the pose is not
        stable (of the square, the sign of its root); and shapes of y in columns (n, n), of
        a modal mass of one. NaN where forces that follow bodies make it flutter: see `poles`.
        """
        lower = np.linalg.cholesky(self.mass)
        half = np.linalg.solve(lower, self.stiffness)
        matrix = np.linalg.solve(lower, half.T).T
        if np.linalg.norm(matrix - matrix.T) <= _ALIKE * np.linalg.norm(matrix):
            squares, shapes = np.linalg.eigh((matrix + matrix.T) / 2)
        else:
            found, vectors = (part.astype(complex) for part in np.linalg.eig(matrix))
            order = np.argsort(found.real)
            found, vectors = found[order], vectors[:, order]
            real = np.abs(found.imag) <= _ALIKE * np.abs(found).max()
            squares = np.where(real, found.real, np.nan)
            shapes = np.where(real, vectors.real, np.nan)
        sizes = np.sqrt(np.abs(squares)) / (2 * math.pi)
        return np.copysign(sizes, squares), np.linalg.solve(lower.T, shapes)


def linearise(
    solver: Solver,
    y: ArrayLike | None = None,
    *,
    efforts: Mapping[str, float] | None = None,
    loads: Mapping[str, ArrayLike] | None = None,
    guess: Tick | None = None,
) -> Linearisation:
    """Small motions about a pose at rest.

    y: driven positions (k,), home's by default. efforts: by actuator, that hold it; by default
    found by inverse dynamics, or none where no joint is actuated. loads: as of `Solver.solve`.
    Coulomb friction is left out. Raises InputError on a pose that is not solved or not in
    equilibrium, and as `Solver.simulate` does.
    """
    where = np.array([solver.home[name] for name in solver.driven]) if y is None else y
    if np.shape(where) != (len(solver.driven),):
        raise InputError("y", f"shape {np.shape(where)}", f"({len(solver.driven)},), one pose")
    tick = solver.at(where, guess=guess)
    if tick.status not in SOLVED:
        raise InputError("y", f"a pose that is not solved: {tick.why()}", "one within reach")
    position = np.asarray(where, dtype=float)
    forward = Forward.of(solver.chart, math.inf)
    actuators = tuple(solver.graph.coordinates[k].name for k in forward.rows.actuated)
    taken = solver.mechanics.loads(None, 1, loads)[:, 0]
    at = solver.configuration(position, tick)
    forward.check_masses(at, taken)
    _refuse_kinks(solver, at)
    held = _held(solver, actuators, position, tick, efforts, loads)
    pose = _Pose(forward, forward.state(at, np.zeros(len(position))), held, taken)
    mass = forward.mass_matrix(at, taken)
    n = len(position)
    columns = [mass @ pose.derivative(k) for k in range(2 * n)]
    found = -np.array(columns).T
    _refuse_unbalanced(solver, mass @ pose.accelerations(pose.state), found[:, :n], pose)
    return Linearisation(
        solver.driven, actuators, mass, found[:, n:], found[:, :n], pose.actuation, held
    )


def _refuse_kinks(solver: Solver, at: Configuration) -> None:
    """Raises InputError where a coordinate is just at its stop, whose force has a kink there."""
    for k, passive in solver.graph.dynamics.passive.items():
        value = float(at.q[k]) - solver.plan.offset(k)
        for end in (passive.low, passive.high):
            if passive.stop and abs(value - end) <= _ALIKE * (1.0 + abs(end)):
                found = f"{solver.graph.coordinates[k].name} just at its stop, {end:g}"
                raise InputError("y", found, "a pose clear of it, or pressed against it")


def _held(
    solver: Solver,
    actuators: tuple[str, ...],
    y: FloatArray,
    tick: Tick,
    efforts: Mapping[str, float] | None,
    loads: Mapping[str, ArrayLike] | None,
) -> FloatArray:
    if efforts is not None:
        for name in efforts:
            if name not in actuators:
                raise InputError("efforts", f"{name!r}, not actuated", ", ".join(actuators))
            if not is_finite(efforts[name]):
                raise InputError(f"efforts of {name}", repr(efforts[name]), "a finite number")
        return np.array([float(efforts.get(name, 0.0)) for name in actuators])
    if not any(c.actuated for c in solver.graph.coordinates):
        return np.zeros(len(actuators))
    if len(actuators) != len(solver.driven):
        found = f"{len(actuators)} actuated coordinates for {len(solver.driven)} freedoms"
        raise InputError("efforts", found, "those that hold the pose, by name; {} for none")
    forces = solver.at(y, guess=tick, forces=True, loads=loads).forces
    assert forces is not None
    return forces.effort


@dataclass(frozen=True, eq=False)
class _Pose:
    """A state (s,) at rest, with the efforts (m,) and loads there."""

    forward: Forward
    state: FloatArray
    efforts: FloatArray
    loads: FloatArray

    def _run(self, state: list[Scalar], *, told: bool = False) -> list[Scalar]:
        rows = replace(self.forward.rows, told=told)
        inputs = [*state, *self.efforts.tolist(), *self.loads.tolist()]
        return accelerations(rows, inputs, dual_functions(FLOATS))

    def accelerations(self, state: FloatArray) -> FloatArray:
        """Of the driven coordinates, (n,)."""
        return np.array([as_float(a) for a in self._of_driven(self._run(state.tolist()))])

    def _of_driven(self, results: list[Scalar]) -> list[Scalar]:
        n = len(self.forward.rows.plan.driven)
        first = self.forward.rows.state - 2 * n - 1
        return results[first : first + n]

    @cached_property
    def _unit_motions(self) -> list[tuple[FloatArray, FloatArray]]:
        return [self._moving(k) for k in range(len(self.forward.rows.plan.driven))]

    def _moving(self, k: int) -> tuple[FloatArray, FloatArray]:
        """At a rate of one in driven coordinate k: the rates of a state's positions, and of the
        actuators.
        """
        n, m = len(self.forward.rows.plan.driven), len(self.forward.rows.actuated)
        state = self.state.copy()
        state[-1 - n + k] = 1.0
        results = np.array([as_float(a) for a in self._run(state.tolist(), told=True)])
        own = np.zeros(n)
        own[k] = 1.0
        positions = len(self.state) - n - 1
        actuators = results[-m - 5 : -5] if m else results[:0]
        return np.concatenate([own, results[: positions - n]]), actuators

    @property
    def actuation(self) -> FloatArray:
        """The actuators' rates by those of the driven coordinates, (m, n)."""
        n, m = len(self.forward.rows.plan.driven), len(self.forward.rows.actuated)
        return np.array([actuators for _, actuators in self._unit_motions]).T.reshape(m, n)

    def derivative(self, k: int) -> FloatArray:
        """Of the accelerations (n,) by driven position k or, from n on, by its rate."""
        n = len(self.forward.rows.plan.driven)
        change = np.zeros(len(self.state))
        if k < n:
            change[: len(self.state) - n - 1] = self._unit_motions[k][0]
        else:
            change[-1 - n + k - n] = 1.0
        state = [dual(x, rate) for x, rate in zip(self.state, change.tolist(), strict=True)]
        return np.array([as_float(rate_of(a)) for a in self._of_driven(self._run(state))])


def _refuse_unbalanced(
    solver: Solver, missing: FloatArray, stiffness: FloatArray, pose: _Pose
) -> None:
    """missing: forces in the driven coordinates that nothing balances, (n,): no more than rounding,
    or so little that the equilibrium is next to the pose.
    """
    graph = solver.plan.graph
    try:
        with np.errstate(all="ignore"):
            away = np.linalg.solve(stiffness, missing)
    except np.linalg.LinAlgError:
        away = np.full(len(missing), np.inf)
    near = np.abs(away) <= _AWAY * coordinate_scales(graph)[list(solver.plan.driven)]
    level = np.abs(missing) <= _ROUNDING * _exerted(solver, pose)
    if not (near.all() or level.all()):
        k = int(np.nan_to_num(np.abs(missing) * ~level, nan=np.inf).argmax())
        name = solver.driven[k]
        unit = "N m" if graph.is_angle(name) else "N"
        found = f"a pose with {missing[k]:.4g} {unit} in {name} that nothing balances"
        raise InputError("y", found, "a pose of equilibrium, or efforts that hold it")


def _exerted(solver: Solver, pose: _Pose) -> float:
    """How large the forces may be that balance each other: of efforts, weight and springs."""
    graph = solver.plan.graph
    dynamics, length = graph.dynamics, graph.length
    size = float((np.abs(pose.actuation).T @ np.abs(pose.efforts)).max(initial=0.0))
    masses = [*dynamics.masses.values(), *(load.mass for load in dynamics.loads)]
    weight = sum(mass.mass for mass in masses) * math.hypot(*dynamics.gravity)
    stretched = sum(spring.stiffness for spring in dynamics.springs) * length
    size += (weight + stretched) * length
    for k, passive in dynamics.passive.items():
        size += passive.stiffness * (1.0 if graph.coordinates[k].angle else length**2)
    return size
