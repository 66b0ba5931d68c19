"""Forces as labelled variables of a Dataset.

Their dimension is `actuator`, as `actuated` says of every coordinate whether it is.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from parakin.arrays import FloatArray
from parakin.solving.forces import Asked, Forces

_PER_ACTUATOR = ("time", "actuator")


def force_variables(forces: Forces, asked: Asked) -> tuple[dict[str, Any], dict[str, Any]]:
    """Variables over time, and labels of their dimensions."""
    unit = " or ".join(sorted({*forces.units}))
    variables: dict[str, Any] = {
        "effort": _of_actuators(forces.effort, unit, "effort of the actuators"),
        "effort_band": _of_actuators(
            forces.band, unit, "how far friction at rest may change the effort either way"
        ),
        "power": _of_actuators(forces.power, "W", "power of the actuators"),
        "effort_conditioning": (
            "time",
            forces.conditioning,
            {"long_name": "how firmly the actuators hold the motion, home being 1", "units": "1"},
        ),
    }
    labels: dict[str, Any] = {
        "actuator": ("actuator", list(forces.actuators)),
        "effort_unit": ("actuator", list(forces.units)),
    }
    if forces.drives:
        variables |= {
            "motor_torque": _of_actuators(forces.motor_torque, "N m", "torque of the motors"),
            "motor_torque_band": _of_actuators(
                forces.motor_band, "N m", "how far friction at rest may change the motor's torque"
            ),
            "motor_speed": _of_actuators(forces.motor_speed, "rad s-1", "speed of the motors"),
            "motor_power": _of_actuators(forces.motor_power, "W", "power of the motors"),
            "motor_current": _of_actuators(forces.current, "A", "current of the motors"),
        }
    if asked.joints:
        variables |= _reactions(forces, asked)
        labels |= {"joint": ("joint", list(forces.joints)), "axis": ("axis", list("xyz"))}
    if len(forces.idle_effort):
        about = {"long_name": "effort that holds idle freedoms at home", "units": "N m or N"}
        variables["idle_effort"] = (("time", "idle"), forces.idle_effort.T, about)
        labels["idle"] = ("idle", list(forces.idle))
    if asked.energies:
        named = (
            ("kinetic_energy", forces.kinetic, "J"),
            ("potential_energy", forces.potential, "J"),
            ("power_lost", forces.lost, "W"),
            ("power_applied", forces.applied, "W"),
        )
        variables |= {name: ("time", values, {"units": unit}) for name, values, unit in named}
    return variables, labels


def _of_actuators(values: FloatArray, unit: str, about: str) -> tuple[Any, ...]:
    return _PER_ACTUATOR, np.ascontiguousarray(values.T), {"units": unit, "long_name": about}


def _reactions(forces: Forces, asked: Asked) -> dict[str, Any]:
    over = ("time", "joint", "axis")
    about = "on the joint's child, at its origin on the child, along its axes on the parent"
    comment = "NaN where it is indeterminate for rigid bodies"
    if asked.least:
        comment = "where it is indeterminate, that of minimum norm of the multipliers"

    def of_joints(values: FloatArray, unit: str, name: str) -> tuple[Any, ...]:
        attributes = {"units": unit, "long_name": f"{name} {about}", "comment": comment}
        return over, np.ascontiguousarray(np.moveaxis(values, 2, 0)), attributes

    imbalance = {"long_name": "how far efforts and reactions miss balance", "units": "N"}
    return {
        "reaction_force": of_joints(forces.reaction_force, "N", "force"),
        "reaction_moment": of_joints(forces.reaction_moment, "N m", "moment"),
        "force_imbalance": ("time", forces.imbalance, imbalance),
    }
