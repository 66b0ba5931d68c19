"""Motors: what drives need of their motors where actuators exert efforts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from parakin.arrays import FloatArray
from parakin.mechanics.resistance import AT_REST
from parakin.model.motors import Motor


def at_motors(
    motors: Sequence[Motor | None],
    effort: FloatArray,
    band: FloatArray,
    velocity: FloatArray,
    acceleration: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Torque, its band, speed and current of motors. A screw or gear takes more torque where it is
    driven, and less where it drives back; at rest anything between.
    """
    torque, width, speed, current = (np.full_like(effort, np.nan) for _ in range(4))
    for k, motor in enumerate(motors):
        if motor is None:
            continue
        ideal = effort[k] / motor.ratio
        rate = velocity[k]
        power = effort[k] * rate
        resting = np.abs(rate) < AT_REST
        through = np.where(power > 0.0, ideal / motor.efficiency, ideal * motor.back_efficiency)
        lossy = np.where(resting, ideal, through)
        torque[k] = np.where(np.isfinite(power), lossy, np.nan)
        torque[k] += motor.rotor * motor.ratio * acceleration[k]
        ends = [(effort[k] + end * band[k]) / motor.ratio for end in (-1.0, 1.0)]
        losses = (1.0 / motor.efficiency, motor.back_efficiency)
        widest = np.max([np.abs(loss * end - ideal) for end in ends for loss in losses], axis=0)
        width[k] = np.where(resting, widest, band[k] / abs(motor.ratio) / motor.efficiency)
        speed[k] = motor.ratio * rate
        if motor.torque_constant is not None:
            current[k] = torque[k] / motor.torque_constant
    return torque, width, speed, current
