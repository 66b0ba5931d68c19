"""Joints in numbers.

Every joint is a chain of revolute and prismatic pairs, each about or along one axis of a moving
frame; these two carry the whole theory.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from parakin.algebra.spatial import Matrix, Pose, matrix


class Pair(NamedTuple):
    """One degree of freedom: a slide along, or a turn about, the moving frame's axis.

    `pitch` is how far a turn advances along its axis [m/rad].
    """

    slides: bool
    axis: int
    pitch: float = 0.0


X_TURN, Y_TURN, Z_TURN = (Pair(False, axis) for axis in range(3))
X_SLIDE, Y_SLIDE, Z_SLIDE = (Pair(True, axis) for axis in range(3))

# Theta of eq. (2), active: it turns z into x, the second axis of a universal joint.
THETA: Matrix[float] = matrix(((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)))

PAIRS: dict[str, tuple[Pair, ...]] = {
    "revolute": (Z_TURN,),
    "prismatic": (Z_SLIDE,),
    "cylindrical": (Z_TURN, Z_SLIDE),
    "universal": (Z_TURN, X_TURN),
    "spherical": (X_TURN, Y_TURN, Z_TURN),
    "planar": (X_SLIDE, Y_SLIDE, Z_TURN),
    "free": (X_SLIDE, Y_SLIDE, Z_SLIDE, X_TURN, Y_TURN, Z_TURN),
    "rod": (),
    "fixed": (),
}


@dataclass(frozen=True)
class GraphJoint:
    """A joint in numbers: frame F on its parent and M on its child, with pairs and tail between.

    R_FM = turn(pair 1) turn(pair 2) ... tail. parent, child: numbers of bodies. first: the number
    of its first coordinate. length: a rod's [m]. oriented: whether F or M has axes of its own, and
    not those of its body.
    """

    name: str
    kind: str
    parent: int
    child: int
    F: Pose[float]
    M: Pose[float]
    pairs: tuple[Pair, ...]
    tail: Matrix[float]
    first: int
    actuated: bool = False
    length: float = 0.0
    oriented: bool = True

    @property
    def coordinates(self) -> range:
        """The numbers of its coordinates."""
        return range(self.first, self.first + len(self.pairs))

    @property
    def freedom(self) -> int:
        """How many freedoms it leaves its child. A rod has five, and an idle spin that is none."""
        return 5 if self.kind == "rod" else len(self.pairs)

    @property
    def proper(self) -> bool:
        """Whether the first and last of three turns share an axis (proper Euler angles)."""
        axes = [pair.axis for pair in self.pairs if not pair.slides]
        return len(axes) == 3 and axes[0] == axes[-1]

    @property
    def turns(self) -> list[int]:
        """The numbers of its coordinates that are angles."""
        return [k for k, pair in zip(self.coordinates, self.pairs, strict=True) if not pair.slides]


class Coordinate(NamedTuple):
    """One coordinate of joint number `joint`."""

    name: str
    joint: int
    angle: bool
    actuated: bool

    @property
    def unit(self) -> str:
        """The SI unit: rad or m."""
        return "rad" if self.angle else "m"
