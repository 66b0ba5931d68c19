"""Controls that show where the platform can go, around the mechanism in the scene."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any, Protocol

from parakin.arrays import FloatArray
from parakin.errors import ParakinError
from parakin.solving.solver import Solver
from parakin.views.browser.controls import tell
from parakin.views.browser.drive import Drive
from parakin.views.browser.messages import escaped
from parakin.views.browser.surface import Surface, add_surface, slides_of, surface_of

_ROOT = "/workspace"
_ASK, _WAIT = "Workspace from here", "Finding the workspace …"
_FAILED = "The workspace could not be found."


class Page(Protocol):
    """What the controls need of their page."""

    client: Any

    def on(self, event: Callable[[Any], Any], act: Callable[[], None]) -> None:
        """Call `act` when the user operates a control."""

    def locked(self, act: Callable[[], None]) -> None:
        """Call `act` when nothing else is done to the page, unless it has been closed."""


class WorkspaceControls:
    """A button that finds a workspace, one that hides it, and a legend.

    It is found by a thread of its own, while the page plays and drives on: that of the pose shown
    when it was asked for, of which the legend tells what is held. drive: what gives the drive of
    the platform there.
    """

    def __init__(self, page: Page, tab: Any, order: float, drive: Callable[[], Drive]) -> None:
        self._page, self._drive = page, drive
        self._nodes: list[Any] = []
        self._asked = 0  # times: what another than the last finds is dropped
        gui = page.client.gui
        with tab:
            self._button = gui.add_button(_ASK, visible=False)
            self._hide_button = gui.add_button("Hide the workspace", visible=False)
            self._legend = gui.add_html("", visible=False, order=order)
            self._problem = gui.add_markdown("", visible=False)
        page.on(self._button.on_click, self._ask)
        page.on(self._hide_button.on_click, self._hide)

    def offer(self, driven: tuple[str, ...]) -> None:
        """Offer it of a mechanism whose platform these coordinates drive; () for none."""
        self._asked += 1
        self._ready()
        self._hide()
        self._button.visible = bool(slides_of(driven))

    def _ready(self) -> None:
        self._button.disabled, self._button.label = False, _ASK

    def _hide(self) -> None:
        for node in self._nodes:
            node.remove()
        self._nodes.clear()
        self._hide_button.visible = False
        for control in (self._legend, self._problem):
            tell(control, "")

    def _ask(self) -> None:
        drive = self._drive()
        self._asked += 1
        self._button.disabled, self._button.label = True, _WAIT
        given = drive.solver, drive.y.copy(), self._asked
        threading.Thread(target=self._find, args=given, name=_ROOT, daemon=True).start()

    def _find(self, solver: Solver, y: FloatArray, number: int) -> None:
        """The thread."""
        found: Surface | str = _FAILED
        try:
            found = surface_of(solver, y)
        except ParakinError as error:
            found = str(error)
        finally:
            self._page.locked(lambda: self._show(found, number))

    def _show(self, found: Surface | str, number: int) -> None:
        if number != self._asked:  # of another mechanism
            return
        with self._page.client.atomic():
            self._hide()
            self._ready()
            if isinstance(found, str):
                tell(self._problem, f"**{escaped(found)}**")
                return
            self._nodes = add_surface(self._page.client.scene, found, _ROOT)
            tell(self._legend, found.told)
            self._hide_button.visible = True
