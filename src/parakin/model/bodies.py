"""Bodies as their author describes them: points, shapes, and what they weigh. Data only."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Literal

import pydantic
from pydantic import AfterValidator, StrictFloat, StrictInt

from parakin.model.fields import Name, OneOrMore, Quantity, Triple, Turns
from parakin.model.validation import Table, Text


class Frame(Table):
    """Where a joint sits on a body, in the body's frame; z is the joint's axis.

    at: the origin [m]. Either `axis`, the direction of z, of any length, with `x` for the
    direction of x (by default the body's x axis made perpendicular to z, or its y axis if z lies
    along x); or `turns`, rotations [rad] about the moving axes one after another; or neither,
    for the body's own axes. Raises InputError.
    """

    at: Triple = (0.0, 0.0, 0.0)
    axis: Triple | None = None
    x: Triple | None = None
    turns: Turns = ()

    @property
    def oriented(self) -> bool:
        """Whether it has axes of its own, and not those of the body."""
        return self.axis is not None or self.x is not None or bool(self.turns)


class MeshMoments(Table):
    """What a mesh encloses, in its own frame and units: volume, centroid, and the second moments
    about it (xx, yy, zz, xy, xz, yz of the inertia tensor of density 1).
    """

    volume: float
    centroid: tuple[float, float, float]
    inertia: tuple[float, float, float, float, float, float]


def _scale(value: float) -> float:
    """Negative ones turn a mesh inside out, as files of other programs may have it."""
    if not (math.isfinite(value) and value):
        raise ValueError("a finite number other than zero")
    return value


class BodyMesh(Table):
    """A body's shape from a file of triangles, placed on the body: its coordinates times `scale`
    are metres. Only its name is kept here; whoever shows the body decides whether to read it. With
    a density it tells the body's mass: the reader of files works out its `moments`.
    Raises InputError.
    """

    set_by_reader = frozenset({"moments"})

    file: Annotated[Text, pydantic.Field(min_length=1, max_length=1000)]
    scale: Annotated[StrictFloat | StrictInt, AfterValidator(_scale)] = 1.0
    on_body: Frame = Frame()
    density: Quantity | None = None
    moments: MeshMoments | None = None


class Inertia(Table):
    """A body's inertia tensor about its centre of mass [kg m²], in the body's axes or, with
    `on_body`, in those of another frame, of which only the axes count. The products are elements of
    the tensor: xy is minus the integral of x y dm. Raises InputError.
    """

    xx: Quantity
    yy: Quantity
    zz: Quantity
    xy: Quantity = 0.0
    xz: Quantity = 0.0
    yz: Quantity = 0.0
    on_body: Frame = Frame()


class _Solid(Table):
    density: Quantity | None = None
    mass: Quantity | None = None


class Point(Table):
    """A mass at a point. Raises InputError."""

    kind: Literal["point"]
    at: Triple = (0.0, 0.0, 0.0)
    mass: Quantity


class Sphere(_Solid):
    """A ball of `diameter` about `at`, of a density or a mass. Raises InputError."""

    kind: Literal["sphere"]
    at: Triple = (0.0, 0.0, 0.0)
    diameter: Quantity


class _Bar(_Solid):
    model_config = pydantic.ConfigDict(populate_by_name=True)  # `from_` in Python

    from_: Triple = pydantic.Field((0.0, 0.0, 0.0), alias="from")
    to: Triple


class Cylinder(_Bar):
    """A round bar between the centres of its ends, of a density or a mass. Raises InputError."""

    kind: Literal["cylinder"]
    diameter: Quantity


class Tube(_Bar):
    """A tube between the centres of its ends: `diameter` outside, `bore` inside. Raises
    InputError.
    """

    kind: Literal["tube"]
    diameter: Quantity
    bore: Quantity


class Cone(_Bar):
    """A round bar whose diameter changes evenly to `diameter_to`, 0 for a cone. Raises
    InputError.
    """

    kind: Literal["cone"]
    diameter: Quantity
    diameter_to: Quantity = 0.0


class Box(_Bar):
    """A square bar between the centres of its ends, `width` along the direction `across`, made
    perpendicular to the bar, and `height` across both. Raises InputError.
    """

    kind: Literal["box"]
    width: Quantity
    height: Quantity
    across: Triple


AnySolid = Annotated[
    Point | Sphere | Cylinder | Tube | Cone | Box, pydantic.Field(discriminator="kind")
]


class Body(Table):
    """A rigid body: points on it in its own frame [m], its shape for pictures, and its mass.

    mass: with `com`, the centre of mass in the body's frame, and `inertia` about it: principal
    moments along the body's axes, or an `Inertia`; none is a point mass. Or `solid`, one or more
    shapes of a density or mass; or a mesh with a density. Without any of them it weighs nothing.
    Raises InputError.
    """

    set_by_reader = frozenset({"name"})

    name: Name
    points: Mapping[Name, Triple] = {}
    mesh: BodyMesh | None = None
    mass: Quantity | None = None
    com: Triple | None = None
    inertia: Triple | Inertia | None = None
    solid: OneOrMore[AnySolid] = ()
