"""Forces on bodies, as their author describes them: springs, wrenches, payloads. Data only."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

import pydantic

from parakin.model.bodies import Inertia
from parakin.model.fields import Quantity, Triple, tupled
from parakin.model.validation import Table, Text


class SpringBetween(Table):
    """A spring and damper between two points, `between` ("body.point", or a body for its origin):
    `stiffness` [N/m] times how much longer it is than `length`, `damping` [N s/m] times how fast it
    grows. Raises InputError.
    """

    kind: Literal["spring"]
    between: Annotated[tuple[Text, Text], pydantic.BeforeValidator(tupled)]
    stiffness: Quantity = 0.0
    damping: Quantity = 0.0
    length: Quantity = 0.0


class AppliedWrench(Table):
    """A force and a moment on a body at `at`, "body.point", or a body for its origin; along the
    axes of the base or of the body. law: a law of time that both are multiplied by, as of a motion
    (`law = "sine"`, ...), dimensionless. csv: a file of `time` and `fx`, `fy`, `fz`, `mx`, `my`,
    `mz` instead. Raises InputError.
    """

    kind: Literal["wrench"]
    at: Text
    force: Triple = (0.0, 0.0, 0.0)
    moment: Triple = (0.0, 0.0, 0.0)
    axes: Literal["base", "body"] = "base"
    law: Mapping[str, Any] | None = None
    csv: Annotated[Text, pydantic.Field(min_length=1, max_length=1000)] | None = None


class Payload(Table):
    """A mass fixed to a body with its centre of mass at `at`, "body.point", or a body for its
    origin. inertia: about that centre, as a body's. Raises InputError.
    """

    kind: Literal["payload"]
    at: Text
    mass: Quantity
    inertia: Triple | Inertia | None = None


Force = Annotated[SpringBetween | AppliedWrench | Payload, pydantic.Field(discriminator="kind")]
