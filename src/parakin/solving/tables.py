"""What a solver shows of itself in a notebook."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from parakin import notebook
from parakin.model.graph import Graph
from parakin.model.mechanism import Mechanism


class Shown(Protocol):
    """What is shown of a solver."""

    mechanism: Mechanism
    graph: Graph
    coordinates: tuple[str, ...]
    driven: tuple[str, ...]
    iterated: tuple[str, ...]
    home: Mapping[str, float]
    derivatives: int
    machine_code: bool

    @property
    def no_forces(self) -> str:
        """Why there are no forces."""


def solver_html(solver: Shown, units: Sequence[str]) -> str:
    """Its mechanism, what is driven and how it is solved. units: of its coordinates."""
    how = "machine code" if solver.machine_code else "NumPy"
    roles = {"driven": solver.driven, "iterated": solver.iterated}
    rows = [
        (
            name,
            f"{solver.home.get(name, np.nan):z.6g} {unit}",
            next((role for role, names in roles.items() if name in names), "closed form"),
        )
        for name, unit in zip(solver.coordinates, units, strict=True)
    ]
    return (
        notebook.heading(solver.mechanism.name, solver.mechanism.title)
        + notebook.lines(
            driven=", ".join(solver.driven),
            iterated=", ".join(solver.iterated),
            derivatives=str(solver.derivatives),
            runs=f"as {how}",
            forces=_forces(solver),
        )
        + notebook.table(("coordinate", "home", "solved"), rows)
    )


def _forces(solver: Shown) -> str:
    """The masses, and why there are no efforts of them; "" without dynamics."""
    dynamics = solver.graph.dynamics
    if not dynamics.any:
        return ""
    total = sum(mass.mass for mass in dynamics.masses.values())
    loads = sum(load.mass.mass for load in dynamics.loads)
    words = f"{total:,.6g} kg" + (f" and payloads of {loads:,.6g} kg" if loads else "")
    return f"{words}; none: {solver.no_forces}" if solver.no_forces else words
