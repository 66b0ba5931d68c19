"""The spatial four-bar of `four_bar` simulated by Drake and OpenSim (Simbody), as their users do.

Neither is among the peers that CI installs: `pip install drake opensim` gives both. Each has a pin
for crank and rocker and a universal joint between rocker and coupler, whose other end a constraint
holds to the crank.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.peers.four_bar import (
    COUPLER,
    CRANK,
    GRAVITY,
    MASSES,
    PIVOT,
    ROCKER,
    Floats,
    X,
    Z,
    placed,
)
from benchmarks.peers.four_bar_engines import Run, Told, sampled, tree_rates


def of_drake(duration: float, step: float) -> Run:
    """Discrete, by its SAP solver."""
    from pydrake.math import RigidTransform, RotationMatrix
    from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlant
    from pydrake.multibody.tree import (
        FixedOffsetFrame,
        RevoluteJoint,
        RotationalInertia,
        SpatialInertia,
        UniversalJoint,
    )
    from pydrake.systems.analysis import Simulator

    plant = MultibodyPlant(step)
    plant.mutable_gravity_field().set_gravity_vector(GRAVITY)
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
    bodies = {
        name: plant.AddRigidBody(
            name,
            SpatialInertia.MakeFromCentralInertia(
                each.mass, each.com, RotationalInertia(*each.inertia)
            ),
        )
        for name, each in MASSES.items()
    }

    def frame(name: str, body: Any, axes: Floats, place: Floats) -> Any:
        at = RigidTransform(RotationMatrix(axes), place)
        return plant.AddFrame(FixedOffsetFrame(name, body, at))

    home, world = placed(0.0), plant.world_body()
    rocker, coupler = home["rocker"].axes, home["coupler"].axes
    hinges = [
        plant.AddJoint(RevoluteJoint(name, base, bodies[name].body_frame(), Z, 0.0))
        for name, base in (
            ("crank", frame("crank pin", world, home["crank"].axes, 0 * X)),
            ("rocker", frame("rocker pin", world, rocker, PIVOT)),
        )
    ]
    pins = pins_of(rocker, coupler)
    ends = (
        frame("on rocker", bodies["rocker"], rocker.T @ pins, ROCKER * X),
        frame("on coupler", bodies["coupler"], coupler.T @ pins, COUPLER * X),
    )
    bend = plant.AddJoint(UniversalJoint("universal", *ends, 0.0))
    plant.AddBallConstraint(bodies["crank"], CRANK * X, bodies["coupler"], 0 * X)
    plant.Finalize()
    crank, rates = hinges[0], tree_rates()

    def run() -> Told:
        simulator = Simulator(plant)
        context = simulator.get_mutable_context()
        for hinge, rate in zip(hinges, rates[:2], strict=True):
            hinge.set_angular_rate(context, rate)
        bend.set_angular_rates(context, rates[2:])
        simulator.Initialize()
        told = []
        for time in sampled(duration).tolist():
            simulator.AdvanceTo(time)
            told.append((crank.get_angle(context), crank.get_angular_rate(context)))
        angle, rate = np.array(told).T
        return Told(angle, rate, round(duration / step), None)

    return run


def pins_of(rocker: Floats, coupler: Floats) -> Floats:
    """Axes at home along the universal joint's pins: of the rocker, of the coupler, and across."""
    x, y = rocker[:, 2], coupler[:, 1]
    return np.column_stack([x, y, np.cross(x, y)])


def of_opensim(duration: float, accuracy: float) -> Run:
    """Simbody's Runge-Kutta-Merson."""
    import opensim
    from scipy.spatial.transform import Rotation

    opensim.Logger.setLevelString("off")

    def vec(values: Floats) -> Any:
        return opensim.Vec3(*map(float, values))

    def angles(axes: Floats) -> Any:
        return vec(Rotation.from_matrix(axes).as_euler("XYZ"))

    model = opensim.Model()
    model.setGravity(vec(GRAVITY))
    bodies = {}
    for name, each in MASSES.items():
        inertia = opensim.Inertia(*map(float, each.inertia))
        bodies[name] = opensim.Body(name, each.mass, vec(each.com), inertia)
        model.addBody(bodies[name])
    home, ground, rest = placed(0.0), model.getGround(), vec(0 * X)
    rocker, coupler = home["rocker"].axes, home["coupler"].axes
    pins = pins_of(rocker, coupler)
    on_rocker = (bodies["rocker"], vec(ROCKER * X), angles(rocker.T @ pins))
    on_coupler = (bodies["coupler"], vec(COUPLER * X), angles(coupler.T @ pins))
    crank_at = (ground, rest, angles(home["crank"].axes))
    rocker_at = (ground, vec(PIVOT), angles(rocker))
    joints = [
        opensim.PinJoint("crank_pin", *crank_at, bodies["crank"], rest, rest),
        opensim.PinJoint("rocker_pin", *rocker_at, bodies["rocker"], rest, rest),
        opensim.UniversalJoint("universal", *on_rocker, *on_coupler),
    ]
    for joint in joints:
        model.addJoint(joint)
    ends = (bodies["crank"], vec(CRANK * X), bodies["coupler"], rest)
    model.addConstraint(opensim.PointConstraint(*ends))

    def run() -> Told:
        state = model.initSystem()
        moved = [joints[j].get_coordinates(k) for j, k in ((0, 0), (1, 0), (2, 0), (2, 1))]
        for coordinate in moved:
            coordinate.setValue(state, 0.0, False)
        for coordinate, rate in zip(moved, tree_rates().tolist(), strict=True):
            coordinate.setSpeedValue(state, rate)
        manager = opensim.Manager(model)
        manager.setIntegratorMethod(opensim.Manager.IntegratorMethod_RungeKuttaMerson)
        manager.setIntegratorAccuracy(accuracy)
        manager.setWriteToStorage(False)
        state.setTime(0.0)
        manager.initialize(state)
        told = [(moved[0].getValue(state), moved[0].getSpeedValue(state))]
        for time in sampled(duration).tolist()[1:]:
            state = manager.integrate(time)
            told.append((moved[0].getValue(state), moved[0].getSpeedValue(state)))
        angle, rate = np.array(told).T
        return Told(angle, rate, 0, None)  # how many steps there were it does not tell

    return run
