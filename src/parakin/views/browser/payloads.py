"""Sliders of a page for the masses of payloads."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from parakin.model.graph import Graph

_MOST = 3.0  # times the file's mass
_STEPS = 60
_OF_NONE = 1.0  # [kg]: in place of a payload without mass


class Page(Protocol):
    """What the sliders need of their page."""

    client: Any

    def on(self, event: Callable[[Any], Any], act: Callable[[], None]) -> None:
        """Call `act` when the user operates a control."""


class Payloads:
    """One slider for each payload; `masses` are those that are shown [kg].

    While a slider is dragged, calls for it wait for each other: all but those that find another
    mass than the last are passed over.
    """

    def __init__(self, page: Page, changed: Callable[[], None]) -> None:
        self._page, self._changed = page, changed
        self._folder = page.client.gui.add_folder("Payloads", visible=False)
        self._sliders: dict[str, Any] = {}
        self.masses: dict[str, float] = {}

    def show(self, graph: Graph | None) -> None:
        """Offer a mechanism's payloads, with the file's masses; none if it has no forces."""
        for slider in self._sliders.values():
            slider.remove()
        self._sliders.clear()
        loads = () if graph is None else graph.dynamics.loads
        self.masses = {load.name: load.mass.mass for load in loads}
        self._folder.visible = bool(loads)
        for load in loads:
            most = _MOST * (load.mass.mass or _OF_NONE)
            with self._folder:
                slider = self._page.client.gui.add_slider(
                    f"{load.name} [kg]", 0.0, most, most / _STEPS, load.mass.mass
                )
            self._page.on(slider.on_update, self._moved)
            self._sliders[load.name] = slider

    def _moved(self) -> None:
        found = {name: float(slider.value) for name, slider in self._sliders.items()}
        if found != self.masses:
            self.masses = found
            self._changed()
