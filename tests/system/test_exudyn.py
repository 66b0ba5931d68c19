"""Three mechanisms of the catalogue, built once more in the multibody code exudyn.

Nothing of parakin's equations is used: every body has its six coordinates in exudyn, joints are
exudyn's, placed where the catalogue's dimensions put them, and its own Newton iteration closes the
loops at each pose of a motion. Its Jacobian of the constraints then gives velocities, and the
change of that Jacobian along the velocities gives accelerations. All are compared body by body.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import closed_form
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import parakin

exudyn = pytest.importorskip("exudyn")
rigid = pytest.importorskip("exudyn.rigidBodyUtilities")

Floats = NDArray[np.floating[Any]]
X, Y, Z = np.eye(3)

# Where Newton's iteration stops: the root of the sum of squares of all constraints [m or rad].
# Rounding leaves 1e-15 of them.
CLOSED = 2e-14
# Found: positions and rotations apart by up to 5e-14, velocities by 8e-14 (the Delta's platform,
# which turns a little where it is not quite level). Both are what the last iteration left, times a
# Jacobian of condition 10 to 60.
POSITION, VELOCITY = 1e-12, 1e-12
# Found: 8e-12 (the Delta's arms, at 6 rad/s²). The Jacobian's change comes from four of its values
# around the pose: cut off at the fourth power of STEP, while rounding is divided by STEP. The
# engine's own `computeInitialAccelerations` is 2e-8 away from this, having one step to difference
# with, and takes no account of what prescribed motions contribute.
ACCELERATION = 1e-10
STEP = 3e-4  # [s]


class Part(NamedTuple):
    number: Any
    origin: Floats  # of the catalogue's body, in exudyn's


class Model:
    """A system of exudyn; `turned` takes the catalogue's axes to its own."""

    def __init__(self, turned: Floats | None = None) -> None:
        exudyn.config.printToConsole = False
        self.turned = np.eye(3) if turned is None else turned
        self.container = exudyn.SystemContainer()  # owns the system
        self.system = self.container.AddSystem()
        self.ground = self.system.CreateGround()
        self.parts: dict[str, Part] = {}
        self.drives: list[tuple[Any, float]] = []
        self.settings = exudyn.SimulationSettings()
        self.settings.solution.file.write = self.settings.solution.sensors.active = False
        self.settings.staticSolver.verboseMode = 0
        newton = self.settings.staticSolver.newton
        newton.absoluteTolerance = newton.relativeTolerance = CLOSED

    def body(self, name: str, at: Floats, origin: Floats | None = None, angle: float = 0.0) -> Any:
        """A body whose point `at` carries its coordinates; `angle` turns it about exudyn's x.

        `origin` is where the catalogue's body has its own, if elsewhere.
        """
        turn = Rotation.from_euler("x", angle).as_matrix()
        number = self.system.CreateRigidBody(
            referencePosition=self.turned @ at,
            referenceRotationMatrix=turn,
            inertia=rigid.RigidBodyInertia(mass=1, inertiaTensor=np.eye(3)),
            nodeType=exudyn.NodeType.RotationRxyz,
        )
        arm = np.zeros(3) if origin is None else turn.T @ self.turned @ (origin - at)
        self.parts[name] = Part(number, arm)
        return number

    def revolute(self, one: Any, other: Any, at: Floats, axis: Floats) -> None:
        self.system.CreateRevoluteJoint(
            itemNumbers=[one, other], position=self.turned @ at, axis=self.turned @ axis
        )

    def prismatic(self, one: Any, other: Any, at: Floats, axis: Floats) -> None:
        self.system.CreatePrismaticJoint(
            itemNumbers=[one, other], position=self.turned @ at, axis=self.turned @ axis
        )

    def universal(self, one: Any, other: Any, at: Floats, first: Floats, second: Floats) -> None:
        """`first` is fixed in the one body, `second` in the other."""
        axes = np.column_stack((first, np.cross(second, first), second))
        self.system.CreateGenericJoint(
            itemNumbers=[one, other],
            position=self.turned @ at,
            rotationMatrixAxes=self.turned @ axes,
            constrainedAxes=[1, 1, 1, 0, 1, 0],
        )

    def spherical(self, one: Any, other: Any, at: Floats, held: Sequence[int] = (1, 1, 1)) -> None:
        self.system.CreateSphericalJoint(
            itemNumbers=[one, other], position=self.turned @ at, constrainedAxes=list(held)
        )

    def drive(self, body: Any, coordinate: int, at_reference: float) -> None:
        constraint = self.system.CreateCoordinateConstraint(
            itemNumbers=[None, body], coordinates=[None, coordinate]
        )
        self.drives.append((constraint, at_reference))

    def assemble(self) -> None:
        self.system.Assemble()
        self.solver = exudyn.MainSolverStatic()
        assert self.solver.InitializeSolver(self.system, self.settings)
        self.unknowns = self.solver.GetODE2size()
        # Joints also carry equations for the multipliers of what they leave free.
        rows = self.all_rows(self.coordinates())
        self.holding = np.abs(rows).max(axis=1) > 0
        assert self.holding.sum() == self.unknowns

    def coordinates(self) -> Floats:
        return np.array(self.system.systemData.GetODE2Coordinates())

    def all_rows(self, coordinates: Floats) -> Floats:
        self.system.systemData.SetODE2Coordinates(coordinates)
        # The first call clears what the second one adds to.
        self.solver.ComputeJacobianODE2RHS(self.system)
        self.solver.ComputeJacobianAE(self.system)
        n = self.unknowns
        return np.array(self.solver.GetSystemJacobian())[n:, :n]

    def jacobian(self, coordinates: Floats) -> Floats:
        rows: Floats = self.all_rows(coordinates)[self.holding]
        return rows

    def move(self, position: Floats, velocity: Floats, acceleration: Floats) -> None:
        """To where the driven coordinates are as said, with all rates."""
        for (constraint, at_reference), value in zip(self.drives, position, strict=True):
            self.system.SetObjectParameter(constraint, "offset", float(value - at_reference))
        assert self.system.SolveStatic(self.settings, updateInitialValues=True)
        q = self.coordinates()
        driven = np.zeros((self.unknowns, 2))
        driven[-len(self.drives) :] = np.column_stack((velocity, acceleration))
        jacobian = self.jacobian(q)
        qd = np.linalg.solve(jacobian, driven[:, 0])
        near, far = (
            self.jacobian(q + step * qd) - self.jacobian(q - step * qd) for step in (STEP, 2 * STEP)
        )
        change = (8 * near - far) / (12 * STEP)
        qdd = np.linalg.solve(jacobian, driven[:, 1] - change @ qd)
        data = self.system.systemData
        data.SetODE2Coordinates(q)
        data.SetODE2Coordinates_t(qd)
        data.SetODE2Coordinates_tt(qdd)

    def vector(self, name: str, quantity: str) -> Floats:
        """What exudyn says of a body at the catalogue's origin, along the catalogue's axes."""
        part = self.parts[name]
        kind = getattr(exudyn.OutputVariableType, quantity)
        found: Floats = self.turned.T @ self.system.GetObjectOutputBody(
            part.number, kind, localPosition=part.origin
        )
        return found

    def rotation(self, name: str) -> Floats:
        kind = exudyn.OutputVariableType.RotationMatrix
        matrix = self.system.GetObjectOutputBody(self.parts[name].number, kind)
        turned: Floats = self.turned.T @ np.reshape(matrix, (3, 3)) @ self.turned
        return turned


def flight_simulator(p: dict[str, float]) -> Model:
    """The paper's mechanism at its central configuration, its angles from the closed form.

    The axes are z0, x0, y0 here, so that exudyn's three angles of a body, about x, y, z in this
    order, begin with the platform's psi and phi. A crank holds its far end within the plane only:
    across it, the loop is closed already.
    """
    home = closed_form.home(closed_form.Parameters())
    gamma, leg, s = float(home.gamma0), float(home.alpha1), float(home.s)
    model = Model(turned=np.eye(3)[[2, 0, 1]])
    F, G = (p["d2"] + p["d3"] + p["d4"]) * X, (p["d2"] + p["d3"] + p["d4"]) * X + p["h_G"] * Y
    along = np.cos(gamma) * X + np.sin(gamma) * Y
    up = np.cos(leg) * X + np.sin(leg) * Y
    A3 = G - p["h"] * along
    D2 = A3 + p["d1"] * along
    cylinder, piston = (
        model.body("cylinder-A", 0 * X),
        model.body("piston-A", A3, A3 - p["l1"] * up),
    )
    rod = model.body("rod", A3)
    platform = model.body("platform", G, angle=gamma)
    model.revolute(model.ground, cylinder, 0 * X, Z)
    model.prismatic(cylinder, piston, A3, up)
    model.revolute(piston, rod, A3, Z)
    model.revolute(rod, platform, A3, along)
    for name, side in (("B", 1), ("C", -1)):
        foot, top = F + side * p["d5"] * Z, G + side * p["b"] / 2 * Z
        line = (top - foot) / np.linalg.norm(top - foot)
        cylinder = model.body(f"cylinder-{name}", foot)
        piston = model.body(f"piston-{name}", top, top - p["l2"] * line)
        model.universal(model.ground, cylinder, foot, Z, X)
        model.prismatic(cylinder, piston, top, line)
        model.spherical(piston, platform, top)
    slider = model.body("slider-E", D2 + s * along)
    model.prismatic(rod, slider, D2, along)
    D1, E1 = (p["d2"] + p["d3"]) * X, p["d2"] * X
    for name, pivot, tip, held in (("D", D1, D2, rod), ("E", E1, D2 + s * along, slider)):
        crank = model.body(f"crank-{name}", pivot)
        model.revolute(model.ground, crank, pivot, Z)
        model.spherical(crank, held, tip, held=(0, 1, 1))
    for coordinate, at_reference in ((1, G[0]), (2, G[1]), (4, 0.0)):
        model.drive(platform, coordinate, at_reference)
    return model


def hexapod(p: dict[str, float]) -> Model:
    """The 6-UPS with all its cylinders and pistons."""
    model = Model()
    centre = p["height"] * Z
    platform = model.body("platform", centre)
    for i in range(6):
        pair, side = 2 * np.pi / 3 * (i // 2), 2 * (i % 2) - 1
        at_base = pair + side * p["a_base"] / 2
        at_top = pair + side * (np.pi / 3 - p["a_platform"] / 2)
        foot = p["r_base"] * (np.cos(at_base) * X + np.sin(at_base) * Y)
        top = centre + p["r_platform"] * (np.cos(at_top) * X + np.sin(at_top) * Y)
        line = (top - foot) / np.linalg.norm(top - foot)
        first = -np.sin(at_base) * X + np.cos(at_base) * Y
        second = np.cross(first, line)
        cylinder = model.body(f"cylinder{i + 1}", foot)
        piston = model.body(f"piston{i + 1}", top)
        model.universal(model.ground, cylinder, foot, first, second / np.linalg.norm(second))
        model.prismatic(cylinder, piston, top, line)
        model.spherical(piston, platform, top)
    for coordinate, at_reference in enumerate((*centre, 0.0, 0.0, 0.0)):
        model.drive(platform, coordinate, at_reference)
    return model


def delta(p: dict[str, float]) -> Model:
    """Rods as prescribed distances; the arms start level, exudyn finds where they stand."""
    model = Model()
    centre = -p["height"] * Z
    platform = model.body("platform", centre)
    for i in range(3):
        angle = 2 * np.pi / 3 * i
        out = np.cos(angle) * X + np.sin(angle) * Y
        axis = -np.sin(angle) * X + np.cos(angle) * Y
        shaft = p["r_base"] * out
        arm = model.body(f"arm{i + 1}", shaft)
        model.revolute(model.ground, arm, shaft, axis)
        for half in (p["width"] / 2, -p["width"] / 2):
            model.system.CreateDistanceConstraint(
                itemNumbers=[arm, platform],
                localPosition0=p["arm"] * out + half * axis,
                localPosition1=p["r_platform"] * out + half * axis,
                distance=p["rod"],
            )
    for coordinate, at_reference in enumerate(centre):
        model.drive(platform, coordinate, at_reference)
    return model


@pytest.mark.parametrize(
    ("name", "motion", "rate", "build"),
    [
        ("flight-simulator", "general", 5.0, flight_simulator),
        ("gough-stewart", "tour", 1.5, hexapod),
        ("delta", "spiral", 8.0, delta),
    ],
)
def test_bodies_move_as_exudyn_says(
    name: str, motion: str, rate: float, build: Callable[[dict[str, float]], Model]
) -> None:
    solver = parakin.compile(name)
    result = parakin.require_solved(solver.solve(solver.motion(motion, rate=rate), bodies=True))
    assert result.sizes["time"] >= 10
    model = build(dict(solver.graph.parameters))
    model.assemble()
    assert set(model.parts) == set(result.body.values)
    driven = result.sel(coordinate=list(solver.driven))
    start: dict[str, tuple[Floats, Floats]] = {}
    for i in range(result.sizes["time"]):
        model.move(*(driven[q].values[i] for q in ("position", "velocity", "acceleration")))
        for part in model.parts:
            ours = result.isel(time=i).sel(body=part)
            for quantity, theirs, bound in (
                ("body_position", "Position", POSITION),
                ("body_velocity", "Velocity", VELOCITY),
                ("body_angular_velocity", "AngularVelocity", VELOCITY),
                ("body_acceleration", "Acceleration", ACCELERATION),
                ("body_angular_acceleration", "AngularAcceleration", ACCELERATION),
            ):
                np.testing.assert_allclose(
                    ours[quantity], model.vector(part, theirs), rtol=0, atol=bound, err_msg=part
                )
            # Frames are laid into bodies differently; from the first sample on they turn alike.
            turned = Rotation.from_quat(ours.body_orientation.values, scalar_first=True).as_matrix()
            rotation = model.rotation(part)
            first, theirs_first = start.setdefault(part, (turned, rotation))
            np.testing.assert_allclose(
                turned @ first.T, rotation @ theirs_first.T, rtol=0, atol=POSITION, err_msg=part
            )
