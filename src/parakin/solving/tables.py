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
    forced = solver.graph.dynamics.any
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
            efforts=f"none: {solver.no_forces}" if forced and solver.no_forces else "",
        )
        + notebook.table(("coordinate", "home", "solved"), rows)
        + (notebook.table(("body", "mass", "centre of mass, on the body"), _masses(solver.graph)))
        * forced
    )


def _masses(graph: Graph) -> list[tuple[str, ...]]:
    """Name, mass and its centre of each body that has one, of payloads, and in all."""
    dynamics = graph.dynamics
    found = [(graph.bodies[body], mass) for body, mass in sorted(dynamics.masses.items())]
    found += [(f"{load.name} on {graph.bodies[load.body]}", load.mass) for load in dynamics.loads]
    rows = [
        (name, f"{mass.mass:.6g} kg", f"{', '.join(f'{x:z.6g}' for x in mass.com)} m")
        for name, mass in found
    ]
    return [*rows, ("total", f"{sum(mass.mass for _, mass in found):.6g} kg", "")]
