"""The text of a page, as Markdown."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from parakin.solving.forces import Forces
from parakin.solving.modes import Search
from parakin.solving.status import Status
from parakin.views.browser.drive import Stop
from parakin.views.force_text import figure
from parakin.views.units import unit_of

if TYPE_CHECKING:
    import xarray as xr

HOME = "home"  # the branch of home


@dataclass(frozen=True)
class PoseState:
    """What a page reports about the pose it shows.

    title: the motion and its time, or that the mechanism is driven by hand; stop: why it goes no
    further; limits: how many are declared; beyond_limits: those exceeded, with the numbers of their
    joints; because: by how much the worst of them is.
    """

    title: str
    conditioning: float
    residual: float
    stop: Stop | None = None
    beyond_limits: Mapping[str, int] = field(default_factory=dict)
    branch: str = HOME
    limits: int = 0
    because: str = ""

    @property
    def highlighted(self) -> frozenset[int]:
        """The joints to highlight, by number."""
        stopping = frozenset[int]() if self.stop is None else self.stop.joints
        return stopping | frozenset(self.beyond_limits.values())


def pose_message(state: PoseState) -> str:
    """The lines that are always in view."""
    stop, status = state.stop, "converged"
    limits = "limits kept" if state.limits else "no limits declared"
    if stop is not None:
        status = f"**stopped: {escaped(stop.words)}**"
        limits = "limits reached" if stop.status == Status.LIMIT_EXCEEDED else limits
    if state.beyond_limits:
        limits = f"limits exceeded: {escaped(', '.join(state.beyond_limits))}"
        words = escaped(": ".join(filter(None, ("limit exceeded", state.because))))
        status = status if stop is not None else f"**{words}**"
    return (
        f"{escaped(state.title)}  \n{status}  \n"
        f"conditioning {state.conditioning:.3f} · residual {state.residual:.1e} m  \n"
        f"{limits} · branch {escaped(state.branch)}"
    )


def efforts_message(forces: Forces | None) -> str:
    """Which efforts hold a pose; "" if none are known."""
    if forces is None or not np.isfinite(forces.effort).any():
        return ""
    each = (
        f"{escaped(name)} {escaped(figure(effort) or 'unknown')} {unit}"
        for name, effort, unit in zip(
            forces.actuators, forces.effort.tolist(), forces.units, strict=True
        )
    )
    return f"**Efforts that hold it here:** {' · '.join(each)}"


def range_message(found: xr.Dataset | None) -> str:
    """How far each driven coordinate still goes alone, and what stops it; "" if not known."""
    if found is None:
        return ""
    lines = ["**Range left from here:**"]
    for i, name in enumerate(found["driven"].values):
        unit = unit_of(found["unit"].values[i] == "rad")
        ends = []
        for side in (0, 1):
            travel = unit.per_si * float(found["travel"].values[i, side])
            words = str(found["stopped_by"].values[i, side])
            ends.append(f"{travel:+z.1f} ({words})" if words else "free")
        lines.append(escaped(f"{name} [{unit.name}] {' .. '.join(ends)}"))
    return "  \n".join(lines)


def branch_label(number: int, search: Search) -> str:
    """The entry of a branch in the list to choose from."""
    branch = search.modes[number]
    why = [
        f", {what}: {', '.join(names)}"
        for what, names in (
            ("beyond limits", branch.limits_exceeded),
            ("turned through", branch.turned_through),
        )
        if names
    ]
    return f"{number + 1} of {len(search.modes)}{''.join(why)}"


def escaped(text: str) -> str:
    """Text from a file, escaped so that Markdown shows it verbatim."""
    return re.sub(r"([!-/:-@\[-`{-~])", r"\\\1", " ".join(text.split()))
