"""The tab Drive of a page: a mechanism led by sliders or by a handle on its platform, on the branch
that is chosen.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, Protocol

from parakin.arrays import FloatArray
from parakin.errors import ParakinError
from parakin.solving.modes import modes
from parakin.views.browser.captions import HOME, Standing, branch_words, plain, unit_of
from parakin.views.browser.drive import Drive, Stop, choices, driven_by
from parakin.views.browser.repertoire import Shown

_ELSEWHERE = "as it stood"  # a branch that no search has named


class Page(Protocol):
    """What steering asks of the page that it is on."""

    client: Any

    def on(self, event: Callable[[Any], Any], act: Callable[[], None]) -> None:
        """Act when the user does something to a control: an event is its `on_update`, say."""

    def halt(self) -> Mapping[str, float] | None:
        """Stop what plays; all coordinates where it stands, if they are known."""

    def say(self, text: str) -> None:
        """A word while something takes its time."""

    def stand(self, poses: tuple[FloatArray, FloatArray], standing: Standing) -> None:
        """Show a pose."""


class Steering:
    """The tab's controls, and the `drive` that they lead; None while the page plays."""

    def __init__(self, page: Page, tab: Any) -> None:
        self._page, self._tab = page, tab
        self.drive: Drive | None = None
        self._shown: Shown | None = None
        self._sliders: dict[str, Any] = {}
        self._spans: dict[str, tuple[float, float]] = {}  # of the sliders [m or rad]
        self._choices: dict[str, tuple[str, ...]] = {}
        self._set = ""  # which of the choices is driven
        self._label = HOME  # and on which branch
        self._drives: dict[tuple[str, str], Drive] = {}
        self._found: dict[str, Mapping[str, float]] = {}
        self._handle: Any = None
        self._led = False
        gui = page.client.gui
        with tab:
            self._which = gui.add_dropdown("Kinematics", ["inverse", "forward"])
            self._branch = gui.add_dropdown("Branch", [HOME])
            self._search = gui.add_button("Search for branches here")
            self._result = gui.add_markdown("", visible=False)
            self._here = gui.add_button("Drive from here")
            self._home = gui.add_button("Home")
            self._handled = gui.add_checkbox("Handle in the scene", initial_value=True)
        page.on(self._which.on_update, self._switch)
        page.on(self._branch.on_update, self._choose_branch)
        page.on(self._search.on_click, self._search_branches)
        page.on(self._here.on_click, self.take_over)
        page.on(self._home.on_click, self.go_home)
        page.on(self._handled.on_update, self._place_handle)

    # What is driven

    def show(self, shown: Shown) -> None:
        """Offer what can be driven of a mechanism; nothing where nothing can."""
        self.leave()
        self._shown, self._choices = shown, {}
        self._drives.clear()
        if shown.solver is not None:
            solver = shown.solver
            self._choices = choices(solver)
            self._set = next(name for name, c in self._choices.items() if c == solver.driven)
            self._drives[self._set, HOME] = Drive(solver)  # others are compiled when asked for
            self._which.options = list(self._choices)
            self._which.value = self._set
        self._forget_branches()
        for control in (
            *(self._which, self._branch, self._search),
            *(self._here, self._home, self._handled),
        ):
            control.visible = bool(self._choices)
        self._fit_sliders(self._chosen() if self._choices else None)

    def _chosen(self) -> Drive:
        """The drive of the set and branch that are chosen; compiled when first asked for."""
        assert self._shown is not None
        key = self._set, self._label
        if key not in self._drives:
            self._page.say("compiling …")
            near = self._found.get(self._label)
            self._drives[key] = driven_by(self._shown.mechanism, self._choices[self._set], near)
        return self._drives[key]

    def _fit_sliders(self, drive: Drive | None) -> None:
        """Sliders over what is worth asking for, and where it stands; made anew if others."""
        spans: dict[str, tuple[float, float]] = {}
        if drive is not None:
            for name, value in zip(drive.solver.driven, drive.y.tolist(), strict=True):
                low, high = drive.span(name)
                spans[name] = min(low, value), max(high, value)
        if spans != self._spans:
            self._spans = spans
            for slider in self._sliders.values():
                slider.remove()
            self._sliders.clear()
        if drive is None:
            return
        for name, span in spans.items():
            if name not in self._sliders:
                unit, scale = unit_of(drive.solver.graph, name)
                step = 10.0 ** math.floor(math.log10(scale * (span[1] - span[0]) / 1000))
                low = step * math.floor(scale * span[0] / step)
                high = step * math.ceil(scale * span[1] / step)
                with self._tab:
                    slider = self._page.client.gui.add_slider(
                        f"{name} [{unit}]", low, high, step, low
                    )
                self._page.on(slider.on_update, partial(self._slid, name))
                self._sliders[name] = slider
        self._sync(drive)

    def _switch(self) -> None:
        """Drive the other set, from where the mechanism stands."""
        values, before = self._values(), (self._set, self._label)
        self._set, self._label = self._which.value, HOME
        try:
            self._chosen()
        except ParakinError:
            self._set, self._label = before
            self._which.value = self._set
            raise
        self._forget_branches()
        self._enter(values)

    # Branches

    def _forget_branches(self) -> None:
        """Only home's is known: what a search finds depends on the set and on where it is."""
        self._label = HOME
        self._found.clear()
        for key in [key for key in self._drives if key[1] != HOME]:
            del self._drives[key]
        self._branch.options, self._branch.value = [HOME], HOME
        self._result.visible = False

    def _search_branches(self) -> None:
        """Offer the other assemblies for the values that are driven now."""
        if self.drive is None:
            self._enter(self._values())
        drive = self.drive
        assert drive is not None
        self._page.say("searching …")
        values = dict(zip(drive.solver.driven, drive.y.tolist(), strict=True))
        own = self._drives[self._set, HOME]
        search = modes(own.solver, values)  # numbered from the mechanism's home
        poses = [branch.coordinates for branch in search.modes]
        labels = [branch_words(k, search) for k in range(len(poses))]
        here = home = drive.nearest(poses, search.told_by)
        if self._label != HOME:  # numbers are new with every search
            self._label = _ELSEWHERE if here is None else labels[here]
            own.home()
            home = own.nearest(poses, search.told_by) if own.to(drive.y) is None else None
        self._drives = {key: kept for key, kept in self._drives.items() if key[1] == HOME}
        self._drives[self._set, self._label] = drive
        self._found = dict(zip(labels, poses, strict=True))
        if home is not None:
            del self._found[labels[home]]
        if self._label != HOME:
            self._found[self._label] = drive.values
        self._branch.options = [HOME, *self._found]
        self._branch.value = self._label
        self._result.content = plain(search.summary)
        self._result.visible = True
        self._stand(None)

    def _choose_branch(self) -> None:
        """Stand in another assembly of the same driven values: found there, or walked to."""
        before, goal = self._label, None if self.drive is None else self.drive.y
        self._label = self._branch.value
        try:
            drive = self._chosen()
        except ParakinError:
            self._label = self._branch.value = before
            raise
        drive.home()
        self._page.halt()
        self.drive = drive
        stop = None if goal is None else drive.to(goal)
        self._fit_sliders(drive)
        self._stand(stop)

    # Where it stands

    def _values(self) -> Mapping[str, float] | None:
        """All coordinates as shown, if they are known."""
        return self.drive.values if self.drive is not None else self._page.halt()

    def _enter(self, values: Mapping[str, float] | None, *, but: str = "") -> None:
        """Start driving from a pose, or home; sliders go there, `but` the one that is held."""
        self._page.halt()
        drive = self._chosen()
        if values is None:
            drive.home()
        elif not drive.from_pose(values):
            drive = self._elsewhere(values)
        self.drive = drive
        if but:
            self._sync(drive, but)
        else:
            self._fit_sliders(drive)
        self._stand(None)

    def _elsewhere(self, values: Mapping[str, float]) -> Drive:
        """The drive for a pose on no branch that has a name, or where there is none, home's."""
        self._forget_branches()
        self._found[_ELSEWHERE] = values
        self._label = _ELSEWHERE
        try:
            drive = self._chosen()
        except ParakinError:
            self._forget_branches()
            drive = self._chosen()
            drive.home()
            return drive
        self._branch.options, self._branch.value = [HOME, _ELSEWHERE], _ELSEWHERE
        return drive

    def go_home(self) -> None:
        """Drive, from home."""
        if self._choices:
            self._label = self._branch.value = HOME
            self._enter(None)

    def take_over(self) -> None:
        """Drive, from where the mechanism stands."""
        if self._choices:
            self._enter(self._values())

    def leave(self) -> None:
        """Drive no longer."""
        if self.drive is not None:
            self.drive = None
            self._label = self._branch.value = HOME
            self._drop_handle()

    def _sync(self, drive: Drive, but: str = "") -> None:
        """Sliders to where the mechanism stands."""
        for name, value in zip(drive.solver.driven, drive.y.tolist(), strict=True):
            if name != but:
                slider = self._sliders[name]
                slider.value = _on_slider(slider, unit_of(drive.solver.graph, name)[1] * value)

    def _slid(self, name: str) -> None:
        if self.drive is None:
            self._enter(self._values(), but=name)
        drive = self.drive
        assert drive is not None
        goal = drive.y.copy()  # a slider has its own steps: what nobody moved stays
        scale = unit_of(drive.solver.graph, name)[1]
        goal[drive.solver.driven.index(name)] = self._sliders[name].value / scale
        self.to(goal)

    def to(self, goal: Sequence[float] | FloatArray) -> None:
        """Drive towards values (k,) [m or rad]; where it stops, sliders come back to that."""
        assert self.drive is not None
        stop = self.drive.to(goal)
        if stop is not None:
            self._sync(self.drive)
        self._stand(stop)

    def _stand(self, stop: Stop | None) -> None:
        """Show the driven pose, and why it goes no further."""
        drive = self.drive
        assert drive is not None
        graph, beyond = drive.solver.graph, drive.beyond
        standing = Standing(
            f"driven by hand, {self._set}",
            float(drive.tick.conditioning),
            float(drive.tick.residual),
            stop,
            {graph.joints[number].name: number for number in beyond.values()},
            self._label,
        )
        with self._page.client.atomic():
            self._page.stand(drive.solver.poses(drive.y, drive.tick), standing)
            self._place_handle()
        self._page.client.flush()  # a hand is waiting

    # The handle

    async def _hold(self, event: Any) -> None:
        """Whether a hand is on the handle. Awaited, and so in order, which threads are not."""
        self._led = event.phase != "end"

    def _lead(self) -> None:
        """Follow the handle; once it is let go it returns to where the mechanism stands."""
        if self.drive is None or self._handle is None:
            return
        stop = self.drive.to(self.drive.led(self._handle.position, self._handle.wxyz))
        self._sync(self.drive)
        self._stand(stop)

    def _place_handle(self) -> None:
        """The handle where the platform is, unless the hand is on it."""
        if self._led:
            return
        pose = None if self.drive is None else self.drive.platform()
        if pose is None or not self._handled.value:
            self._drop_handle()
            return
        if self._handle is None:
            assert self._shown is not None
            size = 0.16 * self._shown.drawing.layout.size
            handle = self._page.client.scene.add_transform_controls(
                "/handle", size, depth_test=False, position=pose[0], wxyz=pose[1]
            )
            handle.on_update(self._hold)
            self._page.on(handle.on_update, self._lead)
            self._handle = handle
        self._handle.position, self._handle.wxyz = pose

    def _drop_handle(self) -> None:
        if self._handle is not None:
            self._handle.remove()
            self._handle = None
        self._led = False


def _on_slider(slider: Any, value: float) -> float:
    """Where a slider shows a value: at its nearest step."""
    low, high, step = float(slider.min), float(slider.max), float(slider.step)
    digits = max(0, -math.floor(math.log10(step)))
    at = round(low + step * round((value - low) / step), digits)
    return min(max(at, low), high)
