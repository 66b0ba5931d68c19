"""Types of arrays, and the names of a motion's orders, used everywhere."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]
IndexArray = NDArray[np.intp]
StatusArray = NDArray[np.int8]

ORDERS = ("position", "velocity", "acceleration", "jerk")
PER_TIME = ("", "/s", "/s²", "/s³")  # their units, per that of position

# Variables of results about forces: of each actuator, of each joint, of the whole.
PER_ACTUATOR = (
    *("effort", "effort_band", "power"),
    *("motor_torque", "motor_torque_band", "motor_speed", "motor_power", "motor_current"),
)
PER_JOINT = ("reaction_force", "reaction_moment")
OF_MECHANISM = (
    *("force_imbalance", "kinetic_energy", "potential_energy", "power_lost", "power_applied"),
    *("energy_drift", "closure_drift"),
)
