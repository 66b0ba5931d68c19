"""What of its forces a kernel returns, and in which row."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from parakin.caching import cached_property
from parakin.kinematics.closure import Row
from parakin.mechanics.reactions import SIZE, JointAt


class Loaded(NamedTuple):
    """A coordinate whose friction grows with the force across its joint's axis: `lever` [1 or m]
    times that, its coefficient or, of a turn, this times the radius.
    """

    coordinate: int
    joint: JointAt
    lever: float


@dataclass(frozen=True)
class ForceRows:
    """Forces that a kernel returns after all else, a scalar each.

    For every coordinate of `actuated` its effort, how far friction at rest may change that, its
    velocity and its acceleration; the conditioning of the actuators, and of the plan; the effort
    that holds each of the `idle` coordinates. For each of `joints` force and moment on its child,
    at its origin on the child along its axes on the parent; with joints, how far all efforts miss
    balance [N].
    With `energies` kinetic and potential energy [J], power lost and power applied [W].

    extra: closure rows that hold what the plan need not solve for (`planning.holding`);
    least: instead, of all multipliers of all canonical rows the least in the sum of squares.
    preload: efforts that redundant actuators are to be nearest to, by actuated coordinate.
    reference: what the conditioning is at home. loaded: joints whose friction grows with what they
    carry; with them the last step of what finds it [N or N m]. wound: angles with springs, which
    the kernel takes, full turns counted, after what loads take.
    """

    actuated: tuple[int, ...]
    idle: tuple[int, ...] = ()
    joints: tuple[JointAt, ...] = ()
    extra: tuple[Row, ...] = ()
    least: bool = False
    energies: bool = False
    preload: tuple[float, ...] = ()
    reference: float = 1.0
    loaded: tuple[Loaded, ...] = ()
    wound: tuple[int, ...] = ()

    def _of_actuated(self, number: int) -> slice[int, int, None]:
        m = len(self.actuated)
        return slice(number * m, (number + 1) * m)

    @property
    def effort(self) -> slice[int, int, None]:
        """[N or N m]"""
        return self._of_actuated(0)

    @property
    def band(self) -> slice[int, int, None]:
        """How far friction at rest may change efforts [N or N m]."""
        return self._of_actuated(1)

    @property
    def velocity(self) -> slice[int, int, None]:
        """Of the actuated coordinates."""
        return self._of_actuated(2)

    @property
    def acceleration(self) -> slice[int, int, None]:
        """Of the actuated coordinates."""
        return self._of_actuated(3)

    @property
    def conditioning(self) -> int:
        """How firmly the actuators hold what is driven: compared with home, signed."""
        return self._of_actuated(4).start

    @property
    def regular(self) -> int:
        """How far the plan is from singular, squared and signed as in `Outputs.conditioning`."""
        return self.conditioning + 1

    @property
    def held(self) -> slice[int, int, None]:
        """Efforts that hold idle coordinates."""
        return slice(self.regular + 1, self.regular + 1 + len(self.idle))

    @property
    def reactions(self) -> slice[int, int, None]:
        """Six rows a joint."""
        return slice(self.held.stop, self.held.stop + SIZE * len(self.joints))

    @property
    def imbalance(self) -> int:
        """How far efforts and reactions together miss balance [N], if there are reactions."""
        return self.reactions.stop

    @cached_property
    def energy(self) -> slice[int, int, None]:
        """Kinetic and potential energy, power lost, power applied."""
        start = self.reactions.stop + bool(self.joints)
        return slice(start, start + 4 * self.energies)

    @property
    def count(self) -> int:
        """How many rows there are."""
        return self.friction_step + bool(self.loaded)

    @property
    def friction_step(self) -> int:
        """The last step to the friction under load, if there is any."""
        return self.energy.stop
