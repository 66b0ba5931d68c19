"""Efforts by d'Alembert's principle, and energies, from nothing but poses: an oracle for dynamics.

Bodies' poses are asked for at Chebyshev's nodes, along the motion and along each driven coordinate;
velocities, accelerations and virtual displacements are derivatives of the polynomials through them.
Neither the recursion's rates nor its wrenches come in.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from parakin.solving.solver import Solver

Array = NDArray[np.float64]

NODES = 21
_T = np.cos(np.pi * (np.arange(NODES) + 0.5) / NODES)  # on [-1, 1]


@dataclass(frozen=True)
class Lump:
    """A body's mass, centre of mass in its frame, and inertia tensor about that in its axes."""

    mass: float
    com: Array
    inertia: Array


def derivative(values: Array, span: float, order: int) -> Array:
    """At the middle of an interval of half-width `span`, from values (NODES, ...) at its nodes."""
    coefficients = chebyshev.chebfit(_T, values.reshape(NODES, -1), NODES - 1)
    found = chebyshev.chebval(0.0, chebyshev.chebder(coefficients, order)) / span**order
    return np.asarray(found, dtype=float).reshape(values.shape[1:])


@dataclass(frozen=True)
class Poses:
    """Centres of mass (bodies, 3), rotations (bodies, 3, 3) and actuated positions (m,)."""

    p: Array
    R: Array
    q: Array


def _poses(solver: Solver, lumps: Mapping[str, Lump], actuated: Sequence[str], y: Array) -> Poses:
    tick = solver.at(y)
    assert tick.status == 0, tick.why()
    origins, quaternions = solver.poses(y, tick)
    names = [b.name for b in solver.mechanism.bodies if b.name != solver.mechanism.base]
    R = Rotation.from_quat(quaternions, scalar_first=True).as_matrix()
    rows = [names.index(name) for name in lumps]
    com = np.array([lump.com for lump in lumps.values()])
    q = np.array([tick.value(name) for name in actuated], dtype=float)
    return Poses(origins[rows] + np.einsum("bij,bj->bi", R[rows], com), R[rows], q)


def _vee(S: Array) -> Array:
    return 0.5 * np.array([S[2, 1] - S[1, 2], S[0, 2] - S[2, 0], S[1, 0] - S[0, 1]])


def efforts(
    solver: Solver,
    lumps: Mapping[str, Lump],
    gravity: Array,
    actuated: Sequence[str],
    state: tuple[Array, Array, Array],
    span: float,
    reach: float,
) -> Array:
    """Efforts of the actuated coordinates at driven positions, velocities and accelerations.

    span: half the time that poses are asked for in [s]; reach: half the virtual displacement.
    """
    y, yd, ydd = state
    time = span * _T
    moving = [
        _poses(solver, lumps, actuated, y + t * yd + 0.5 * t * t * ydd) for t in time.tolist()
    ]
    here = _poses(solver, lumps, actuated, y)
    a = derivative(np.array([each.p for each in moving]), span, 2)
    R1 = derivative(np.array([each.R for each in moving]), span, 1)
    R2 = derivative(np.array([each.R for each in moving]), span, 2)
    forces, moments = [], []
    for k, lump in enumerate(lumps.values()):
        R = here.R[k]
        w, alpha = _vee(R1[k] @ R.T), _vee(R2[k] @ R.T)
        inertia = R @ lump.inertia @ R.T
        forces.append(lump.mass * (a[k] - gravity))
        moments.append(inertia @ alpha + np.cross(w, inertia @ w))
    needed, rates = np.zeros(len(y)), np.zeros((len(y), len(actuated)))
    for j in range(len(y)):
        step = reach * np.eye(len(y))[j]
        aside = [_poses(solver, lumps, actuated, y + t * step) for t in _T.tolist()]
        dp = derivative(np.array([each.p for each in aside]), reach, 1)
        dR = derivative(np.array([each.R for each in aside]), reach, 1)
        rates[j] = derivative(np.unwrap([each.q for each in aside], axis=0), reach, 1)
        for k in range(len(lumps)):
            needed[j] += forces[k] @ dp[k] + moments[k] @ _vee(dR[k] @ here.R[k].T)
    return np.asarray(np.linalg.solve(rates, needed), dtype=float)


@dataclass(frozen=True)
class Energies:
    """Kinetic and potential energy at the middle of the time, and how fast their sum grows."""

    kinetic: float
    potential: float
    rate: float


def energies(
    solver: Solver,
    lumps: Mapping[str, Lump],
    gravity: Array,
    state: tuple[Array, Array, Array],
    span: float,
) -> Energies:
    """Of the bodies, from nothing but their poses near driven values with these rates."""
    y, yd, ydd = state
    poses = [
        _poses(solver, lumps, (), y + t * yd + 0.5 * t * t * ydd) for t in (span * _T).tolist()
    ]
    p, R = np.array([each.p for each in poses]), np.array([each.R for each in poses])
    v, R1 = _rates(p, span), _rates(R, span)
    kinetic, potential = np.zeros(NODES), np.zeros(NODES)
    for k, lump in enumerate(lumps.values()):
        for node in range(NODES):
            w = R[node, k].T @ _vee(R1[node, k] @ R[node, k].T)  # in the body's axes
            kinetic[node] += 0.5 * lump.mass * v[node, k] @ v[node, k] + 0.5 * w @ lump.inertia @ w
        potential -= lump.mass * p[:, k] @ gravity
    middle = [float(derivative(each, span, 0)) for each in (kinetic, potential)]
    return Energies(middle[0], middle[1], float(derivative(kinetic + potential, span, 1)))


def _rates(values: Array, span: float) -> Array:
    """Derivatives at all nodes, from values (NODES, ...) there."""
    coefficients = chebyshev.chebfit(_T, values.reshape(NODES, -1), NODES - 1)
    found = chebyshev.chebval(_T, chebyshev.chebder(coefficients)) / span
    return np.asarray(found, dtype=float).T.reshape(values.shape)
