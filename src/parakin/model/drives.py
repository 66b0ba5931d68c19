"""What acts in a joint, as its author describes it: friction, springs, dampers, drives. Data only.

Values are per coordinate of the joint: forces [N] and lengths of a slide, torques [N m] and angles
of a turn.
"""

from __future__ import annotations

from parakin.model.fields import Quantity
from parakin.model.validation import Table


class Friction(Table):
    """Resistance to a coordinate's motion: `coulomb` [N or N m] against its direction, `viscous`
    [N s/m or N m s/rad] times its velocity, and `coefficient` times the force across the axis of a
    revolute or prismatic joint, of the former at `radius`. At rest Coulomb friction and that under
    load may take any value within a band. Raises InputError.
    """

    coulomb: Quantity = 0.0
    viscous: Quantity = 0.0
    coefficient: Quantity = 0.0
    radius: Quantity | None = None


class Spring(Table):
    """A spring along or about a coordinate: `stiffness` [N/m or N m/rad] times how far it is from
    `zero`, as the coordinate is reported. Raises InputError.
    """

    stiffness: Quantity
    zero: Quantity = 0.0


class Damper(Table):
    """A damper: `damping` [N s/m or N m s/rad] times how much faster a coordinate is than `zero`.
    Raises InputError.
    """

    damping: Quantity
    zero: Quantity = 0.0


class Stop(Table):
    """What a coordinate runs into at its declared limits, as Hunt and Crossley have it: `stiffness`
    [N/m or N m/rad] times how far it is beyond, and as much again for every 1/`dissipation`
    [1/(s/m) or 1/(s/rad)] by which it still goes on; less where it comes back, and never a pull.
    Raises InputError.
    """

    stiffness: Quantity = 0.0
    dissipation: Quantity = 0.0


class Drive(Table):
    """What moves an actuated coordinate: a motor, through a ball screw of `lead` (per turn of the
    motor) on a slide, a gear of `ratio` (turns of the motor per turn of the joint) on a turn;
    neither is a direct drive.

    efficiency, back_efficiency: of screw or gear where the motor drives, and where it is driven; by
    default the latter is the former. rotor: the motor's moment of inertia [kg m²], a direct
    linear drive's mass [kg]. torque_constant [N m/A], of a direct linear drive [N/A]. max_effort
    [N or N m], max_speed and max_power are limits of the joint's force, speed and power, max_torque
    of the motor's torque. stiffness [N/m or N m/rad]: how the drive gives way along its coordinate
    while it holds; rigid by default. Raises InputError.
    """

    lead: Quantity | None = None
    ratio: Quantity | None = None
    efficiency: Quantity = 1.0
    back_efficiency: Quantity | None = None
    rotor: Quantity = 0.0
    torque_constant: Quantity | None = None
    max_effort: Quantity | None = None
    max_speed: Quantity | None = None
    max_power: Quantity | None = None
    max_torque: Quantity | None = None
    stiffness: Quantity | None = None
