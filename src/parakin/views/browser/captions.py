"""What the page says, as Markdown: units, and what is always in view."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from parakin.model.graph import Graph
from parakin.solving.modes import Search
from parakin.solving.status import Status
from parakin.views.browser.drive import Stop

HOME = "that of home"


def unit_of(graph: Graph, name: str) -> tuple[str, float]:
    """In which unit a coordinate is shown, and how many of it make one SI unit."""
    angle = graph.coordinates[graph.index(name, "driven")].angle
    return ("deg", math.degrees(1.0)) if angle else ("mm", 1e3)


@dataclass(frozen=True)
class Standing:
    """How a pose stands. stop: why it goes no further; beyond: joints outside their limits, their
    numbers by name; branch: on which it is.
    """

    what: str
    conditioning: float
    residual: float
    stop: Stop | None = None
    beyond: Mapping[str, int] = field(default_factory=dict)
    branch: str = HOME

    @property
    def lit(self) -> frozenset[int]:
        """Joints to be lit."""
        stopping = frozenset[int]() if self.stop is None else self.stop.joints
        return stopping | frozenset(self.beyond.values())


def words(standing: Standing) -> str:
    """What is always in view."""
    stop, limits, status = standing.stop, "kept", "converged"
    if stop is not None:
        status = f"**stopped: {plain(stop.words)}**"
        limits = "reached" if stop.status == Status.LIMIT_EXCEEDED else "kept"
    if standing.beyond:
        limits = f"beyond: {plain(', '.join(standing.beyond))}"
        status = status if stop is not None else "**limit exceeded**"
    return (
        f"{plain(standing.what)}  \n{status}  \n"
        f"conditioning {standing.conditioning:.3f} · residual {standing.residual:.1e} m  \n"
        f"limits {limits} · branch {plain(standing.branch)}"
    )


def branch_words(number: int, search: Search) -> str:
    """A branch that was found, as it is chosen."""
    branch = search.modes[number]
    beyond = f", beyond limits: {', '.join(branch.beyond)}" if branch.beyond else ""
    return f"{number + 1} of {len(search.modes)}{beyond}"


def plain(text: str) -> str:
    """Text from a file as Markdown shows it, letter by letter."""
    return re.sub(r"([!-/:-@\[-`{-~])", r"\\\1", " ".join(text.split()))
