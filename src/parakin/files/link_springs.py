"""Springs between points of the links of other programs' models, on the bodies they become."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from parakin.algebra.spatial import Vector
from parakin.files.links import Owners
from parakin.files.vocabulary import listed, unused
from parakin.model.forces import SpringBetween


class LinkSpring(NamedTuple):
    """A spring and damper between points of two links, in their own frames."""

    name: str
    ends: tuple[tuple[str, Vector[float]], tuple[str, Vector[float]]]
    stiffness: float
    damping: float
    length: float


class Springs:
    """Springs of a mechanism: `forces` by name, and the points that they need by body."""

    def __init__(
        self,
        springs: Sequence[LinkSpring],
        owner: Owners,
        names: Mapping[str, str],
        points: Mapping[str, dict[str, Vector[float]]],
    ) -> None:
        """owner: the body and place of every link. names: ours of the bodies. points: by body, to
        which those of the springs are added.
        """
        self.forces: dict[str, SpringBetween] = {}
        lost = []
        for spring in springs:
            if not all(link in owner and owner[link][0] in names for link, _ in spring.ends):
                lost.append(spring.name)
                continue
            label = unused(spring.name, self.forces)
            between = []
            for number, (link, p) in enumerate(spring.ends, start=1):
                body, at = owner[link]
                point = unused(f"{label} {number}", points[body])
                points[body][point] = at.p + at.R @ p
                between.append(f"{names[body]}.{point}")
            self.forces[label] = SpringBetween(
                kind="spring",
                between=(between[0], between[1]),
                stiffness=spring.stiffness,
                damping=spring.damping,
                length=spring.length,
            )
        self.notes = listed("Springs left out, at links within joints", lost)
