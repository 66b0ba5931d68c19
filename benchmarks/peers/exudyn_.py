"""exudyn: bodies with six coordinates each, joints between them, and its own static Newton solver.

Driven coordinates are constraints whose offsets are set pose by pose, in Python. A solution starts
from the one before, the nearest thing here to a guess. Velocities come from the engine's Jacobian
of the constraints, accelerations from its change along them by central differences, since the
engine's own solver of initial accelerations knows nothing of prescribed motions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import exudyn as exu
import numpy as np
from exudyn.rigidBodyUtilities import RigidBodyInertia, RotationMatrixX, RotationMatrixY

from benchmarks.baselines import D1, D2, D3, D4, D5, H_G, L1, L2, L3, L4, S_A, S_B, S_C, B, H
from benchmarks.peers.dimensions import AXES, FEET, STROKE_0, TOPS
from benchmarks.peers.ways import (
    CLOSED,
    POSE,
    SLIDERS,
    Answer,
    Both,
    Floats,
    Solve,
    one_by_one,
    others,
)

STEP = 1e-4  # [s]
GRAVITY = [0.0, 0.0, -9.80665]  # [m/s²]; poses do not depend on it
UNIT = RigidBodyInertia(mass=1, inertiaTensor=np.eye(3))
X, Y, Z = np.eye(3)
Read = Callable[[Floats], Floats]  # from the coordinates (orders, bodies, 6)


class System:
    """A system closed at its reference: bodies first, then joints, then drives."""

    def __init__(self) -> None:
        exu.config.printToConsole = False
        self.container = exu.SystemContainer()  # owns the system
        self.mbs = self.container.AddSystem()
        self.ground = self.mbs.CreateGround()
        self.drives: list[tuple[Any, str, float]] = []

    def body(self, at: Floats, angle: float = 0.0, bend: float = 0.0, inertia: Any = UNIT) -> Any:
        return self.mbs.CreateRigidBody(
            referencePosition=at,
            referenceRotationMatrix=RotationMatrixX(angle) @ RotationMatrixY(bend),
            inertia=inertia,
            gravity=GRAVITY,
            nodeType=exu.NodeType.RotationRxyz,
        )

    def revolute(self, one: Any, other: Any, at: Floats, axis: Floats) -> None:
        self.mbs.CreateRevoluteJoint(itemNumbers=[one, other], position=at, axis=axis)

    def prismatic(self, one: Any, other: Any, at: Floats, axis: Floats) -> None:
        self.mbs.CreatePrismaticJoint(itemNumbers=[one, other], position=at, axis=axis)

    def spherical(self, one: Any, other: Any, at: Floats, held: Sequence[int] = (1, 1, 1)) -> None:
        self.mbs.CreateSphericalJoint(
            itemNumbers=[one, other], position=at, constrainedAxes=list(held)
        )

    def universal(self, body: Any, at: Floats, first: Floats, second: Floats) -> None:
        """`first` is fixed in the base, `second` in the body."""
        self.mbs.CreateGenericJoint(
            itemNumbers=[self.ground, body],
            position=at,
            rotationMatrixAxes=np.column_stack((first, np.cross(second, first), second)),
            constrainedAxes=[1, 1, 1, 0, 1, 0],
        )

    def drive_coordinate(self, body: Any, coordinate: int, at_reference: float) -> None:
        drive = self.mbs.CreateCoordinateConstraint(
            itemNumbers=[None, body], coordinates=[None, coordinate]
        )
        self.drives.append((drive, "offset", -at_reference))

    def drive_distance(self, at: Floats, body: Any, at_zero: float, point: Floats = 0 * X) -> None:
        drive = self.mbs.CreateDistanceConstraint(
            itemNumbers=[self.ground, body], localPosition0=at, localPosition1=point
        )
        self.drives.append((drive, "distance", at_zero))

    def assembled(self) -> tuple[Any, Any, Callable[[Floats], Floats]]:
        """Its static solver, the settings, and the constraints' Jacobian at given coordinates."""
        mbs = self.mbs
        mbs.Assemble()
        settings = exu.SimulationSettings()
        settings.solution.file.write = settings.solution.sensors.active = False
        settings.staticSolver.verboseMode = 0
        settings.staticSolver.newton.absoluteTolerance = CLOSED
        settings.staticSolver.newton.relativeTolerance = CLOSED
        solver = exu.MainSolverStatic()
        solver.InitializeSolver(mbs, settings)
        n = solver.GetODE2size()

        def all_rows(q: Floats) -> Floats:
            mbs.systemData.SetODE2Coordinates(q)
            solver.ComputeJacobianODE2RHS(mbs)  # clears what the next call adds to
            solver.ComputeJacobianAE(mbs)
            return np.array(solver.GetSystemJacobian()[n:, :n])

        # Joints also have rows for the multipliers of what they leave free
        holding = all_rows(np.zeros(n)).any(axis=1)
        return solver, settings, lambda q: all_rows(q)[holding]

    def solution(self, read: Read) -> Solve:
        """Solves for what `read` makes of the bodies' coordinates and, if given, their rates."""
        mbs, data = self.mbs, self.mbs.systemData
        _, settings, rows = self.assembled()

        def rates(given: Floats) -> tuple[Floats, Floats]:
            q = np.array(data.GetODE2Coordinates())
            driven = np.zeros((2, len(q)))
            driven[:, -len(self.drives) :] = given[1:]
            jacobian = rows(q)
            qd = np.linalg.solve(jacobian, driven[0])
            change = rows(q + STEP * qd) - rows(q - STEP * qd)
            qdd = np.linalg.solve(jacobian, driven[1] - change @ qd / (2 * STEP))
            data.SetODE2Coordinates(q)
            return qd, qdd

        def solve(given: Floats, _: Floats) -> Answer:
            for (number, what, at_zero), value in zip(self.drives, given[0], strict=True):
                mbs.SetObjectParameter(number, what, float(at_zero + value))
            mbs.SolveStatic(settings, updateInitialValues=True)
            states = [np.array(data.GetODE2CoordinatesTotal())]
            if len(given) > 1:
                states.extend(rates(given))
            return read(np.array(states).reshape(len(states), -1, 6))

        return solve


def lengthening(w: Floats, zero: float) -> Floats:
    """How much longer than `zero` a vector is, given with its rates in rows, and how fast."""
    length = np.linalg.norm(w[0])
    rate = w[0] @ w[1] / length
    return np.array([length - zero, rate, (w[1] @ w[1] + w[0] @ w[2] - rate**2) / length])


def inclination(v: Floats) -> float:
    return float(np.arctan2(v[2], v[1]))


def flight_simulator() -> Both:
    """In the axes z0, x0, y0: a body's first angle is its inclination in the median plane."""
    foot, D_foot, E_foot = (D2 + D3 + D4) * Y, (D2 + D3) * Y, D2 * Y
    G = foot + H_G * Z
    to_G = G - D_foot  # the rod's place follows from two circles
    reach = (L3**2 + to_G @ to_G - (H - D1) ** 2) / (2 * L3 * np.linalg.norm(to_G))
    crank = float(inclination(to_G) + np.arccos(reach))
    D_tip = D_foot + L3 * (np.cos(crank) * Y + np.sin(crank) * Z)
    rod_along = (G - D_tip) / (H - D1)
    A3, w = G - H * rod_along, D_tip - E_foot
    E_tip = D_tip + (np.sqrt((w @ rod_along) ** 2 - w @ w + L4**2) - w @ rod_along) * rod_along
    feet = [foot + D5 * X, foot - D5 * X]
    tops = [G + B / 2 * X, G - B / 2 * X]

    def way(driven: list[int]) -> Solve:
        system = System()
        ground, gamma = system.ground, inclination(rod_along)
        cylinder, piston = system.body(0 * X, inclination(A3)), system.body(A3)
        rod, platform = system.body(A3, gamma), system.body(G, gamma)
        crank_d, crank_e = (
            system.body(D_foot, crank),
            system.body(E_foot, inclination(E_tip - E_foot)),
        )
        slider = system.body(E_tip)
        legs = []
        for side, at, top in zip((1, -1), feet, tops, strict=True):
            bend = float(side * np.arctan2((top - at)[2], side * (at - top)[0]))
            legs.append((system.body(at, 0.0, bend), system.body(top)))
        system.revolute(ground, cylinder, 0 * X, X)
        system.prismatic(cylinder, piston, A3, A3)
        system.revolute(piston, rod, A3, X)
        system.revolute(rod, platform, G, rod_along)
        system.prismatic(rod, slider, E_tip, rod_along)
        system.revolute(ground, crank_d, D_foot, X)
        system.revolute(ground, crank_e, E_foot, X)
        across = [0, 1, 1]  # out of the plane these loops are closed already
        system.spherical(crank_d, rod, D_tip, across)
        system.spherical(crank_e, slider, E_tip, across)
        for (upper, lower), at, top in zip(legs, feet, tops, strict=True):
            system.universal(upper, at, X, Y)
            system.prismatic(upper, lower, top, top - at)
            system.spherical(lower, platform, top)
        if driven == POSE:
            for coordinate, at_reference in ((1, G[1]), (2, G[2]), (4, 0.0)):
                system.drive_coordinate(platform, coordinate, at_reference)
        else:
            system.drive_distance(0 * X, piston, S_A + L1)
            system.drive_distance(feet[0], legs[0][1], S_B + L2)
            system.drive_distance(feet[1], legs[1][1], S_C + L2)

        def read(states: Floats) -> Floats:
            """Bodies as in the order of their making."""
            at, angle, bend = states[..., :3], states[..., 3], states[..., 4]
            strokes = [
                lengthening(at[:, one] - at[:, other], zero)
                for one, other, zero in (
                    (1, 0, S_A + L1),
                    (8, 7, S_B + L2),
                    (10, 9, S_C + L2),
                    (6, 2, D1),
                )
            ]
            a, b, c, e = strokes
            leg_a = (angle[:, 0], a, angle[:, 0] - angle[:, 2])
            leg_b, leg_c = (angle[:, 7], bend[:, 7], b), (angle[:, 9], -bend[:, 9], c)
            pose = (at[:, 3, 1], at[:, 3, 2], bend[:, 3])
            found = (*pose, *leg_a, *leg_b, *leg_c, angle[:, 4], angle[:, 5], e)
            return np.stack(found, axis=1)[:, others(driven)]

        return system.solution(read)

    return Both(one_by_one(way(POSE)), one_by_one(way(SLIDERS)))


HOME = 1.1 * Z


def driven_platform() -> System:
    system, platform, _ = with_legs([UNIT] * 13)
    for coordinate, at_reference in enumerate((*HOME, 0.0, 0.0, 0.0)):
        system.drive_coordinate(platform, coordinate, at_reference)
    return system


def driven_legs(inertias: Sequence[Any]) -> System:
    system, _, pistons = with_legs(inertias)
    for foot, piston in zip(FEET, pistons, strict=True):
        system.drive_distance(foot, piston, STROKE_0)
    return system


def with_legs(inertias: Sequence[Any]) -> tuple[System, Any, list[Any]]:
    """The hexapod at home, nothing driven; with its platform and pistons.

    `inertias` are the platform's, then each leg's: cylinder and piston.
    """
    system, cabin, tubes = System(), inertias[0], np.reshape(inertias[1:], (6, 2))
    platform = system.body(HOME, inertia=cabin)
    legs = [
        (system.body(foot, inertia=of_upper), system.body(HOME + top, inertia=of_lower))
        for foot, top, (of_upper, of_lower) in zip(FEET, TOPS, tubes, strict=True)
    ]
    for (upper, lower), foot, top, axes in zip(legs, FEET, HOME + TOPS, AXES, strict=True):
        second = np.cross(axes[:, 2], top - foot)
        system.universal(upper, foot, axes[:, 2], second / np.linalg.norm(second))
        system.prismatic(upper, lower, top, top - foot)
        system.spherical(lower, platform, top)
    return system, platform, [lower for _, lower in legs]


def hexapod() -> Both:
    inverse = driven_platform()

    def joints(states: Floats) -> Floats:
        x, y, z = np.einsum("kij,ki->jk", AXES, states[0, 2::2, :3] - states[0, 1::2, :3])
        across = np.hypot(x, y)
        turns = np.arctan2(x, -y), np.arctan2(across, z), np.hypot(across, z) - STROKE_0
        return np.column_stack(turns).reshape(1, -1)

    forward = System()
    platform = forward.body(HOME)
    for foot, top in zip(FEET, TOPS, strict=True):
        forward.drive_distance(foot, platform, STROKE_0, top)
    pose = forward.solution(lambda states: states[0])
    return Both(one_by_one(inverse.solution(joints)), one_by_one(pose))
