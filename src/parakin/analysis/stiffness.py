"""Statics of one pose: how it gives way under a wrench, and the largest wrench that it can hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from parakin.algebra.spatial import as_array
from parakin.arrays import FloatArray
from parakin.errors import InputError, nearest
from parakin.kinematics.configuration import Configuration
from parakin.kinematics.free_motions import free_motions
from parakin.kinematics.recursion import pair_velocity
from parakin.model.motors import Motor
from parakin.model.placement import vector
from parakin.solving.solver import Solver
from parakin.solving.status import SOLVED
from parakin.solving.tick import Tick


class Largest(NamedTuple):
    """The largest wrench along a direction: so many times that, held by `actuator` at its limit."""

    factor: float
    actuator: str


@dataclass(frozen=True)
class Stiffness:
    """A pose under wrenches on a point of a body: forces [N], then moments [N m], along the base's
    axes.

    driven, actuators: names. jacobian: the point's velocity and the body's angular velocity by the
    rates of the driven coordinates (6, n); actuation: those of the actuators by them (m, n).
    efforts: of the actuators at rest under the mechanism's own loads [N or N m]; limits on them,
    infinite where none is given. compliance (6, 6): how far point [m] and body [rad] move under a
    wrench, as actuators' and joints' springs give way. First order, about the pose: what loads do
    to the stiffness of their own is not counted.
    """

    driven: tuple[str, ...]
    actuators: tuple[str, ...]
    jacobian: FloatArray
    actuation: FloatArray
    efforts: FloatArray
    limits: FloatArray
    compliance: FloatArray

    @property
    def stiffness(self) -> FloatArray:
        """The wrench for a small displacement (6, 6) [N/m, N, N m/rad]: the inverse of the
        compliance where the body has six freedoms, else its pseudo-inverse, along those it has.
        Raises InputError where rigid drives hold one of these: it is infinitely stiff.
        """
        sizes = np.linalg.eigvalsh(self.compliance)
        gives_way = int((sizes > 1e-12 * sizes.max(initial=0.0)).sum())
        if gives_way < np.linalg.matrix_rank(self.jacobian):
            found = "a freedom that rigid drives hold, infinitely stiff"
            raise InputError("stiffness", found, "a stiffness of each drive")
        return np.asarray(np.linalg.pinv(self.compliance, rcond=1e-12, hermitian=True), dtype=float)

    @property
    def effort_per_wrench(self) -> FloatArray:
        """What each unit of a wrench on the point takes from the actuators, (m, 6)."""
        found: FloatArray = -np.linalg.pinv(self.actuation.T) @ self.jacobian.T
        return found

    def deflection(self, wrench: ArrayLike) -> FloatArray:
        """Displacement of the point [m] and rotation of the body [rad] under a wrench (6,)."""
        found: FloatArray = self.compliance @ _six(wrench)
        return found

    def largest(self, direction: ArrayLike) -> Largest:
        """How many times a wrench (6,) the actuators hold within their limits, with the
        mechanism's own loads. 0 where these alone exceed one; infinite where nothing is limited.
        """
        each = self.effort_per_wrench @ _six(direction)
        with np.errstate(divide="ignore", invalid="ignore"):
            room = np.where(each > 0.0, self.limits - self.efforts, self.limits + self.efforts)
            factors = np.where(np.abs(each) > 0.0, np.maximum(room, 0.0) / np.abs(each), np.inf)
        factors[np.abs(self.efforts) > self.limits] = 0.0
        if not np.isfinite(self.efforts).all():
            factors[:] = np.nan
        k = int(np.argmin(factors))
        return Largest(float(factors[k]), self.actuators[k])

    def ellipsoid(self) -> tuple[FloatArray, FloatArray]:
        """The wrenches whose efforts, each as a part of its limit, have squares that sum to one:
        half-axes (k,) and their directions (6, k), the largest first; beside the mechanism's own
        loads. Raises InputError where an actuator has no limit.
        """
        if not np.isfinite(self.limits).all():
            name = self.actuators[int(np.argmax(~np.isfinite(self.limits)))]
            raise InputError(f"joints.{name}.drive", "no max_effort", "one for every actuator")
        shares = self.effort_per_wrench / self.limits[:, None]
        _, sizes, right = np.linalg.svd(shares)
        felt = sizes > 1e-12 * sizes.max(initial=0.0)
        order = np.argsort(sizes[felt])
        return 1.0 / sizes[felt][order], right[: len(sizes)][felt][order].T


def _six(values: ArrayLike) -> FloatArray:
    found = np.asarray(values, dtype=float)
    if found.shape != (6,) or not np.isfinite(found).all():
        expected = "(6,), finite: three forces, then three moments"
        raise InputError("wrench", f"shape {found.shape}", expected)
    return found


def stiffness(
    solver: Solver, y: ArrayLike, at: str | None = None, guess: Tick | None = None
) -> Stiffness:
    """Statics of one pose.

    y: driven positions (k,). at: a body or a point on one, "platform.seat"; by default the
    platform's point. guess: as of `Solver.at`. Drives and joint springs give way by their
    stiffness; a drive of none is rigid. Raises InputError on a pose that is not solved, on a
    mechanism that nothing holds elastically, and where there are fewer actuators than freedoms.
    """
    tick = solver.at(y, guess=guess)
    if tick.status not in SOLVED:
        raise InputError("y", f"a pose that is not solved: {tick.why()}", "one within reach")
    mechanics, graph = solver.mechanics, solver.plan.graph
    body, place = _point(solver, at)
    there = solver.configuration(np.asarray(y, dtype=float), tick)
    rates = _rates(solver, there)
    jacobian = _jacobian(there, body, place, rates)
    actuated = list(mechanics.actuated)
    if len(actuated) < len(solver.driven):
        found = f"{len(actuated)} actuated coordinates for {len(solver.driven)} freedoms"
        raise InputError(f"{solver.mechanism.where}: joints", found, "as many, or more")
    motors = [graph.dynamics.motors.get(k) for k in actuated]
    names = tuple(graph.coordinates[k].name for k in actuated)
    return Stiffness(
        solver.driven,
        names,
        jacobian,
        rates[actuated],
        _efforts(solver, y, tick, names),
        np.array([np.inf if motor is None else motor.max_effort for motor in motors]),
        _compliance(solver, _springs(solver, there), rates, jacobian, actuated, motors),
    )


def _point(solver: Solver, at: str | None) -> tuple[int, FloatArray]:
    """The body and the place on it. Raises InputError."""
    graph, platform = solver.graph, solver.mechanism.platform
    known = {name: (k, np.zeros(3)) for k, name in enumerate(graph.bodies)}
    known |= {name: (body, as_array(p)) for name, (body, p) in graph.points.items()}
    if at is None:
        if platform is None:
            raise InputError("at", "none, of a mechanism without a platform", nearest("", known))
        at = platform.body if platform.point is None else f"{platform.body}.{platform.point}"
    if at not in known:
        raise InputError("at", f"unknown body or point {at!r}", nearest(at, known))
    return known[at]


def _rates(solver: Solver, there: Configuration) -> FloatArray:
    """The rates of all coordinates by those of the driven ones, (coordinates, n)."""
    plan = solver.plan
    motions = free_motions(plan.graph, plan.tree, there)
    given = [*plan.driven, *plan.idle]
    rates = np.linalg.solve(motions[given].T, motions.T).T[:, : len(plan.driven)]
    return np.asarray(rates, dtype=float)


def _jacobian(there: Configuration, body: int, place: FloatArray, rates: FloatArray) -> FloatArray:
    """Velocity of a point on a body and its angular velocity, by the driven rates, (6, n)."""
    X_WB = there.pose(body)
    point = X_WB.p + X_WB.R @ vector(place)
    found = np.zeros((6, rates.shape[1]))
    for k, (axis, sign) in there.circuits.axes(body).items():
        w, v = pair_velocity(axis, sign, point)
        found += np.outer([*as_array(v), *as_array(w)], rates[k])
    return found


def _efforts(solver: Solver, y: ArrayLike, tick: Tick, names: Sequence[str]) -> FloatArray:
    """At rest; zero where nothing makes forces, NaN where redundant actuators leave them open."""
    if not solver.graph.dynamics.any:
        return np.zeros(len(names))
    if len(names) > len(solver.driven):
        return np.full(len(names), np.nan)
    constant = {w.name: [0.0] * w.inputs for w in solver.graph.dynamics.wrenches if w.inputs}
    found = solver.at(y, guess=tick, forces=True, loads=constant).forces
    assert found is not None
    return found.effort


def _springs(solver: Solver, there: Configuration) -> dict[int, float]:
    """Stiffness of joints, by coordinate, that of a stop where it is run into."""
    found = {}
    for k, each in solver.graph.dynamics.passive.items():
        value = float(there.q[k]) - solver.plan.offset(k)
        stiffness = each.stiffness + each.stop * (not each.low <= value <= each.high)
        if stiffness:
            found[k] = stiffness
    return found


def _compliance(
    solver: Solver,
    springs: dict[int, float],
    rates: FloatArray,
    jacobian: FloatArray,
    actuated: Sequence[int],
    motors: Sequence[Motor | None],
) -> FloatArray:
    """J (sum of k r rᵀ)⁻¹ Jᵀ over all springs, rigid drives held. springs: of joints, by
    coordinate; drives are added. Raises InputError.
    """
    rigid: list[int] = []
    for k, motor in zip(actuated, motors, strict=True):
        if motor is None or not np.isfinite(motor.stiffness):
            rigid.append(k)
        else:
            springs[k] = springs.get(k, 0.0) + motor.stiffness
    free = np.eye(rates.shape[1])
    if rigid:  # motions that leave rigid drives where they are
        _, sizes, right = np.linalg.svd(rates[rigid])
        free = right[int((sizes > 1e-9 * sizes.max(initial=1.0)).sum()) :].T
    if not free.shape[1]:
        return np.zeros((6, 6))
    by = rates @ free
    each = [size * np.outer(by[k], by[k]) for k, size in springs.items()]
    total = sum(each, np.zeros((free.shape[1], free.shape[1])))
    if np.linalg.matrix_rank(total) < free.shape[1]:
        found = "a freedom that no drive and no spring holds"
        raise InputError(f"{solver.mechanism.where}: joints", found, "a stiffness of each drive")
    J = jacobian @ free
    compliance: FloatArray = J @ np.linalg.solve(total, J.T)
    return 0.5 * (compliance + compliance.T)
