"""A driven pendulum whose forces are known in closed form."""

from __future__ import annotations

import tomllib

import numpy as np

from parakin.files.mechanism_toml import mechanism_from_table
from parakin.model.mechanism import Mechanism

MASS, RADIUS, INERTIA, GRAVITY = 2.0, 0.5, 0.01, 9.80665  # of the arm, about its centre of mass
COULOMB = 0.1  # [N m]
RATIO, EFFICIENCY, ROTOR, TORQUE_CONSTANT = 50.0, 0.8, 1e-5, 0.05
AMPLITUDE, RATE = np.radians(30.0), 2 * np.pi
LIMIT = "30 N m"

TEXT = f"""
name = "pendulum"
up = "y"
driven = ["A"]

[bodies.arm]
mass = "{MASS} kg"
com = ["{RADIUS} m", 0, 0]
inertia = [0, "{INERTIA} kg m^2", "{INERTIA} kg m^2"]

[joints.A]
kind = "revolute"
parent = "base"
child = "arm"
actuated = true
friction = {{ coulomb = "{COULOMB} N m" }}

[joints.A.drive]
ratio = {RATIO}
efficiency = {EFFICIENCY}
rotor = "{ROTOR} kg m^2"
torque_constant = "{TORQUE_CONSTANT} N m/A"
max_effort = "{LIMIT}"
max_torque = "0.2 N m"

[motions.swing]
duration = "2 s"
laws = {{ A = {{ law = "sine", amplitude = "30 deg", frequency = "1 Hz" }} }}

[motions.rest]
duration = "1 s"
laws = {{ A = {{ law = "constant", value = "0 deg" }} }}
"""


def pendulum(limit: str = LIMIT) -> Mechanism:
    """Horizontal at home. limit: of the effort."""
    return mechanism_from_table(tomllib.loads(TEXT.replace(LIMIT, limit)), "pendulum")


def efforts(time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Effort [N m], power [W] and motor torque [N m] of `swing`."""
    q = AMPLITUDE * np.sin(RATE * time)
    qd = AMPLITUDE * RATE * np.cos(RATE * time)
    qdd = -(RATE**2) * q
    gravity = MASS * GRAVITY * RADIUS * np.cos(q)
    effort = gravity + (MASS * RADIUS**2 + INERTIA) * qdd + COULOMB * np.sign(qd)
    power = effort * qd
    geared = np.where(power > 0, effort / EFFICIENCY, effort * EFFICIENCY) / RATIO
    return effort, power, geared + ROTOR * RATIO * qdd
