"""The spatial four-bar of `four_bar` simulated by MuJoCo, Pinocchio and exudyn, as their users do.

MuJoCo and Pinocchio have an open tree of four hinges and a constraint where the loop closes, exudyn
three bodies of six coordinates and four joints.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from benchmarks.peers.four_bar import (
    COUPLER,
    CRANK,
    GRAVITY,
    MASSES,
    PIVOT,
    ROCKER,
    SPEED,
    Floats,
    X,
    Y,
    Z,
    placed,
)

RATE = 100  # samples a second


class Told(NamedTuple):
    """The crank's angle and rate at the samples; steps and right-hand sides, if they are known."""

    angle: Floats
    rate: Floats
    steps: int
    sides: int | None


Run = Callable[[], Told]


def sampled(duration: float) -> Floats:
    return np.linspace(0.0, duration, round(duration * RATE) + 1)


def tree_rates() -> Floats:
    """Of crank, rocker, and the universal joint's pins in the rocker and in the coupler."""
    home = placed(0.0)
    rocker, coupler = home["rocker"], home["coupler"]
    pins = np.column_stack([rocker.axes[:, 2], coupler.axes[:, 1]])
    bends = np.linalg.lstsq(pins, coupler.spin - rocker.spin)[0]
    return SPEED * np.array([1.0, rocker.spin @ rocker.axes[:, 2], *bends])


def of_mujoco(duration: float, step: float, stiff: bool) -> Run:
    import mujoco

    home = placed(0.0)
    rocker, coupler = home["rocker"], home["coupler"]
    spec = mujoco.MjSpec()
    spec.option.gravity = GRAVITY
    spec.option.timestep = step
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4

    def body(parent: Any, name: str, at: Floats, axes: Floats, hinges: list[Any]) -> Any:
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, axes.ravel())
        added = parent.add_body(name=name, pos=at, quat=quaternion, explicitinertial=True)
        added.mass, added.ipos, added.inertia = MASSES[name]
        for place, axis in hinges:
            added.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, pos=place, axis=axis)
        return added

    to = rocker.axes.T
    first = body(spec.worldbody, "crank", 0 * X, home["crank"].axes, [(0 * X, Z)])
    last = body(spec.worldbody, "rocker", PIVOT, rocker.axes, [(0 * X, Z)])
    far = COUPLER * X
    pins = [(far, coupler.axes.T @ rocker.axes[:, 2]), (far, Y)]
    middle = body(last, "coupler", to @ (coupler.origin - PIVOT), to @ coupler.axes, pins)
    first.add_site(name="one", pos=CRANK * X)
    middle.add_site(name="other", pos=0 * X)
    kind, site = mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtObj.mjOBJ_SITE
    loop = spec.add_equality(type=kind, objtype=site, name1="one", name2="other")
    if stiff:  # the shortest time constant that the engine recommends, and hardly any slip
        loop.solref, loop.solimp = [2 * step, 1], [0.9999, 0.9999, 0.001, 0.5, 2]
    model, start = spec.compile(), tree_rates()
    samples, between = round(duration * RATE), round(1 / RATE / step)

    def run() -> Told:
        data = mujoco.MjData(model)
        data.qvel[:] = start
        found = np.empty((2, samples + 1))
        found[:, 0] = data.qpos[0], data.qvel[0]
        for k in range(samples):
            mujoco.mj_step(model, data, nstep=between)
            found[:, k + 1] = data.qpos[0], data.qvel[0]
        return Told(found[0], found[1], samples * between, 4 * samples * between)

    return run


def pinocchio_accelerations() -> Callable[[Floats, Floats], Floats]:
    """From angles and rates of the tree; Baumgarte's method holds the loop together."""
    import pinocchio as pin

    home = placed(0.0)
    rocker, coupler = home["rocker"], home["coupler"]
    model = pin.Model()
    model.gravity.linear = GRAVITY

    def at(place: Floats, axes: Floats | None = None) -> Any:
        return pin.SE3(np.eye(3) if axes is None else axes, place)

    def hinge(parent: int, kind: Any, where: Any) -> int:
        return int(model.addJoint(parent, kind, where, f"joint {model.njoints}"))

    def load(joint: int, name: str, origin: Floats) -> None:
        mass, com, inertia = MASSES[name]
        model.appendBodyToJoint(joint, pin.Inertia(mass, com, np.diag(inertia)), at(origin))

    first = hinge(0, pin.JointModelRZ(), at(0 * X, home["crank"].axes))
    last = hinge(0, pin.JointModelRZ(), at(PIVOT, rocker.axes))
    pin_z = hinge(last, pin.JointModelRZ(), at(ROCKER * X))
    middle = hinge(pin_z, pin.JointModelRY(), at(0 * X, rocker.axes.T @ coupler.axes))
    load(first, "crank", 0 * X)
    load(last, "rocker", 0 * X)
    load(middle, "coupler", -COUPLER * X)
    ends = first, at(CRANK * X), middle, at(-COUPLER * X)
    point = pin.ContactType.CONTACT_3D
    loop = pin.RigidConstraintModel(point, model, *ends, pin.ReferenceFrame.LOCAL)
    loop.setBaumgarteCorrectorParameters(pin.BaumgarteCorrectorParameters(100.0, 20.0))
    loops, memory = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
    loops.append(loop)
    memory.append(loop.createData())
    data = model.createData()
    pin.initConstraintDynamics(model, data, loops, memory)
    no_effort, settings = np.zeros(model.nv), pin.ProximalSettings(1e-12, 0.0, 1)

    def accelerations(q: Floats, v: Floats) -> Floats:
        # A copy, as the engine returns a view of its memory
        found = pin.constraintDynamics(model, data, q, v, no_effort, loops, memory, settings)
        return np.array(found)

    return accelerations


def of_pinocchio_rk4(duration: float, step: float) -> Run:
    accelerations, start = pinocchio_accelerations(), tree_rates()
    samples, between = round(duration * RATE), round(1 / RATE / step)
    h = step

    def stepped(q: Floats, v: Floats) -> tuple[Floats, Floats]:
        a = accelerations(q, v)
        v2 = v + h / 2 * a
        a2 = accelerations(q + h / 2 * v, v2)
        v3 = v + h / 2 * a2
        a3 = accelerations(q + h / 2 * v2, v3)
        v4 = v + h * a3
        a4 = accelerations(q + h * v3, v4)
        return q + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a + 2 * a2 + 2 * a3 + a4)

    def run() -> Told:
        q: Floats = np.zeros(4)
        v = start
        found = np.empty((2, samples + 1))
        found[:, 0] = q[0], v[0]
        for k in range(samples):
            for _ in range(between):
                q, v = stepped(q, v)
            found[:, k + 1] = q[0], v[0]
        return Told(found[0], found[1], samples * between, 4 * samples * between)

    return run


def of_pinocchio_dop853(duration: float, rtol: float) -> Run:
    from scipy.integrate import solve_ivp

    accelerations = pinocchio_accelerations()
    start, times = np.concatenate([np.zeros(4), tree_rates()]), sampled(duration)

    def sides(_: float, state: Floats) -> Floats:
        return np.concatenate([state[4:], accelerations(state[:4], state[4:])])

    def run() -> Told:
        found = solve_ivp(
            sides, (0.0, duration), start, "DOP853", dense_output=True, rtol=rtol, atol=rtol
        )
        told = found.sol(times)
        return Told(told[0], told[4], len(found.t) - 1, found.nfev)

    return run


def of_exudyn(duration: float, step: float) -> Run:
    import exudyn as exu
    from exudyn.itemInterface import SensorBody
    from exudyn.rigidBodyUtilities import RigidBodyInertia

    from benchmarks.peers.exudyn_ import System

    system = System()
    mbs, home = system.mbs, placed(0.0)
    bodies = {
        name: mbs.CreateRigidBody(
            referencePosition=home[name].origin,
            referenceRotationMatrix=home[name].axes,
            initialVelocity=SPEED * home[name].rate,
            initialAngularVelocity=SPEED * home[name].spin,
            inertia=RigidBodyInertia(mass, np.diag(inertia), com, inertiaTensorAtCOM=True),
            gravity=GRAVITY,
        )
        for name, (mass, com, inertia) in MASSES.items()
    }
    crank, coupler, rocker = bodies["crank"], bodies["coupler"], bodies["rocker"]
    z, y = home["rocker"].axes[:, 2], home["coupler"].axes[:, 1]
    system.revolute(system.ground, crank, 0 * X, Z)
    system.revolute(system.ground, rocker, PIVOT, z)
    system.spherical(crank, coupler, home["coupler"].origin)
    mbs.CreateGenericJoint(
        itemNumbers=[rocker, coupler],
        position=PIVOT + ROCKER * home["rocker"].axes[:, 0],
        rotationMatrixAxes=np.column_stack((z, np.cross(y, z), y)),
        constrainedAxes=[1, 1, 1, 0, 1, 0],
    )
    axes, spin = (
        mbs.AddSensor(
            SensorBody(
                bodyNumber=crank, outputVariableType=kind, storeInternal=True, writeToFile=False
            )
        )
        for kind in (exu.OutputVariableType.RotationMatrix, exu.OutputVariableType.AngularVelocity)
    )
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = 1 / RATE
    settings.timeIntegration.endTime = duration
    settings.timeIntegration.numberOfSteps = steps = round(duration / step)
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.newton.useModifiedNewton = True  # the same motion in half the time

    def run() -> Told:
        mbs.SolveDynamic(settings)
        turned, rates = mbs.GetSensorStoredData(axes), mbs.GetSensorStoredData(spin)
        angle = np.unwrap(np.arctan2(turned[:, 4], turned[:, 1]))  # after the time, row by row
        return Told(angle, rates[:, 3], steps, None)

    return run
