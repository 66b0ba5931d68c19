"""What the page says, as Markdown: units, and what is always in view."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from parakin.drive import Stop
from parakin.graph import Graph
from parakin.tracking import Status


def unit_of(graph: Graph, name: str) -> tuple[str, float]:
    """In which unit a coordinate is shown, and how many of it make one SI unit."""
    angle = graph.coordinates[graph.index(name, "driven")].angle
    return ("deg", math.degrees(1.0)) if angle else ("mm", 1e3)


def words(
    what: str, conditioning: float, residual: float, stop: Stop | None, lit: Sequence[str]
) -> str:
    """What is always in view, as Markdown."""
    limits = f"beyond: {', '.join(lit)}" if lit and stop is None else "kept"
    if stop is not None:
        status = f"**stopped: {plain(stop.words)}**"
        limits = "reached" if stop.status == Status.LIMIT_EXCEEDED else "kept"
    else:
        status = "**limit exceeded**" if lit else "converged"
    return (
        f"{plain(what)}  \n{status}  \nconditioning {conditioning:.3f} · residual {residual:.1e} m"
        f"  \nlimits {plain(limits)} · branch that of home"
    )


def plain(text: str) -> str:
    """Text from a file as Markdown shows it, letter by letter."""
    return re.sub(r"([!-/:-@\[-`{-~])", r"\\\1", " ".join(text.split()))
