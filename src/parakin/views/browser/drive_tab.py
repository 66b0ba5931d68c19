"""The Drive tab of a page: sliders and a handle on the platform, to drive a mechanism by hand."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, Protocol

from parakin.arrays import FloatArray
from parakin.errors import ParakinError
from parakin.solving.forces import Forces
from parakin.solving.modes import modes
from parakin.views.browser.content import LoadedMechanism
from parakin.views.browser.controls import nearest_step, tell
from parakin.views.browser.drive import Drive, Stop, choices, driven_by
from parakin.views.browser.messages import (
    HOME,
    PoseState,
    branch_label,
    efforts_message,
    escaped,
    range_message,
)
from parakin.views.browser.workspace_controls import WorkspaceControls
from parakin.views.units import Unit, unit_of

_BELOW = 1e9  # the order of what stands below the sliders, which come and go
_UNNUMBERED = "unnumbered"  # a branch that no search has found yet


class Page(Protocol):
    """What the tab needs of its page."""

    client: Any

    @property
    def loads(self) -> Mapping[str, float]:
        """Masses of payloads [kg]."""

    @property
    def reactions(self) -> bool:
        """Whether forces in the joints are shown."""

    def on(self, event: Callable[[Any], Any], act: Callable[[], None]) -> None:
        """Call `act` when the user operates a control; event: such as the control's `on_update`."""

    def locked(self, act: Callable[[], None]) -> None:
        """Call `act` when nothing else is done to the page, unless it has been closed."""

    def pause(self) -> Mapping[str, float] | None:
        """Pause the motion. Returns all coordinates of the pose shown, if a motion is loaded."""

    def show_progress(self, text: str) -> None:
        """Show what is going on while it takes time."""

    def show_pose(
        self, poses: tuple[FloatArray, FloatArray], state: PoseState, forces: Forces | None
    ) -> None:
        """Show a pose: positions and orientations of all bodies but the base, and what holds it."""


class DriveTab:
    """The controls, and the `drive` that they operate; None while a motion plays."""

    def __init__(self, page: Page, tab: Any) -> None:
        self._page, self._tab = page, tab
        self.drive: Drive | None = None
        self._loaded: LoadedMechanism | None = None
        self._sliders: dict[str, Any] = {}
        self._spans: dict[str, tuple[float, float]] = {}  # of the sliders [m or rad]
        self._choices: dict[str, tuple[str, ...]] = {}
        self._kinematics = ""  # which of the choices
        self._branch_name = HOME
        self._drives: dict[tuple[str, str], Drive] = {}
        self._found: dict[str, Mapping[str, float]] = {}
        self._handle: Any = None
        self._dragging = False
        gui = page.client.gui
        with tab:
            self._kinematics_list = gui.add_dropdown("Kinematics", ["inverse", "forward"])
            self._branch_list = gui.add_dropdown("Branch", [HOME])
            self._search_button = gui.add_button("Search for branches here")
            self._result = gui.add_markdown("", visible=False)
            self._left = gui.add_markdown("", visible=False, order=_BELOW)
            self._efforts = gui.add_markdown("", visible=False)
            self._here_button = gui.add_button("Drive from here")
            self._home_button = gui.add_button("Home")
            self._handle_box = gui.add_checkbox("Handle in the scene", initial_value=True)
        self._space = WorkspaceControls(page, tab, _BELOW + 1.0, self._driving_outputs)
        page.on(self._kinematics_list.on_update, self._switch)
        page.on(self._branch_list.on_update, self._choose_branch)
        page.on(self._search_button.on_click, self._search_branches)
        page.on(self._here_button.on_click, self.drive_from_here)
        page.on(self._home_button.on_click, self.drive_from_home)
        page.on(self._handle_box.on_update, self._place_handle)

    # Kinematics: inverse or forward

    def show(self, loaded: LoadedMechanism) -> None:
        """Offer the controls of a mechanism; none if it cannot be driven."""
        self.leave()
        self._loaded, self._choices = loaded, {}
        self._drives.clear()
        if loaded.solver is not None:
            solver = loaded.solver
            self._choices = choices(solver)
            self._kinematics = next(name for name, c in self._choices.items() if c == solver.driven)
            self._drives[self._kinematics, HOME] = Drive(solver)  # others are compiled on demand
            self._kinematics_list.options = list(self._choices)
            self._kinematics_list.value = self._kinematics
        self._forget_branches()
        for control in (
            *(self._kinematics_list, self._branch_list, self._search_button),
            *(self._here_button, self._home_button, self._handle_box),
        ):
            control.visible = bool(self._choices)
        self._space.offer(self._choices.get("inverse", ()))
        self._fit_sliders(self._chosen() if self._choices else None)

    def _chosen(self) -> Drive:
        """The drive for the chosen kinematics and branch, compiled when first needed."""
        assert self._loaded is not None
        key = self._kinematics, self._branch_name
        if key not in self._drives:
            self._page.show_progress("compiling …")
            near = self._found.get(self._branch_name)
            self._drives[key] = driven_by(
                self._loaded.mechanism, self._choices[self._kinematics], near
            )
        return self._drives[key]

    def _fit_sliders(self, drive: Drive | None) -> None:
        """Make the sliders span the useful range and the current pose."""
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
                unit = self._unit(name)
                scale = unit.per_si
                step = 10.0 ** math.floor(math.log10(scale * (span[1] - span[0]) / 1000))
                low = step * math.floor(scale * span[0] / step)
                high = step * math.ceil(scale * span[1] / step)
                with self._tab:
                    slider = self._page.client.gui.add_slider(
                        f"{name} [{unit.name}]", low, high, step, low
                    )
                self._page.on(slider.on_update, partial(self._slider_moved, name))
                self._sliders[name] = slider
        self._sync_sliders(drive)

    def _unit(self, name: str) -> Unit:
        assert self._loaded is not None
        graph = self._loaded.graph
        return unit_of(graph.coordinates[graph.index(name, "driven")].angle)

    def _switch(self) -> None:
        """Change to the chosen kinematics, at the current pose."""
        values, before = self._values(), (self._kinematics, self._branch_name)
        self._kinematics, self._branch_name = self._kinematics_list.value, HOME
        try:
            self._chosen()
        except ParakinError:
            self._kinematics, self._branch_name = before
            self._kinematics_list.value = self._kinematics
            raise
        self._forget_branches()
        self._start(values)

    def _driving_outputs(self) -> Drive:
        """The drive of the platform, or other output, at the pose shown."""
        if self._kinematics != "inverse":
            self._kinematics_list.value = "inverse"
            self._switch()
        elif self.drive is None:
            self._start(self._values())
        assert self.drive is not None
        return self.drive

    # Branches

    def _forget_branches(self) -> None:
        """Keep only the branch of home: others depend on the kinematics and the driven values."""
        self._branch_name = HOME
        self._found.clear()
        for key in [key for key in self._drives if key[1] != HOME]:
            del self._drives[key]
        self._branch_list.options, self._branch_list.value = [HOME], HOME
        self._result.visible = False

    def _search_branches(self) -> None:
        """Offer the other branches for the current driven values."""
        if self.drive is None:
            self._start(self._values())
        drive = self.drive
        assert drive is not None
        self._page.show_progress("searching …")
        values = dict(zip(drive.solver.driven, drive.y.tolist(), strict=True))
        from_home = self._drives[self._kinematics, HOME]
        search = modes(from_home.solver, values)  # numbered from the mechanism's home
        poses = [branch.coordinates for branch in search.modes]
        labels = [branch_label(k, search) for k in range(len(poses))]
        here = home = drive.nearest(poses, search.distinguished_by)
        if self._branch_name != HOME:  # each search numbers them anew
            self._branch_name = _UNNUMBERED if here is None else labels[here]
            from_home.home()
            home = (
                from_home.nearest(poses, search.distinguished_by)
                if from_home.to(drive.y) is None
                else None
            )
        self._drives = {key: kept for key, kept in self._drives.items() if key[1] == HOME}
        self._drives[self._kinematics, self._branch_name] = drive
        self._found = dict(zip(labels, poses, strict=True))
        if home is not None:
            del self._found[labels[home]]
        if self._branch_name != HOME:
            self._found[self._branch_name] = drive.values
        self._branch_list.options = [HOME, *self._found]
        self._branch_list.value = self._branch_name
        self._result.content = escaped(search.summary)
        self._result.visible = True
        self._show_pose(None)

    def _choose_branch(self) -> None:
        """Change to the chosen branch, at the same driven values."""
        before, goal = self._branch_name, None if self.drive is None else self.drive.y
        self._branch_name = self._branch_list.value
        try:
            drive = self._chosen()
        except ParakinError:
            self._branch_name = self._branch_list.value = before
            raise
        drive.home()
        self._page.pause()
        self.drive = drive
        stop = None if goal is None else drive.to(goal)
        self._fit_sliders(drive)
        self._show_pose(stop)

    # The pose

    def _values(self) -> Mapping[str, float] | None:
        """All coordinates of the pose shown, if they are known."""
        return self.drive.values if self.drive is not None else self._page.pause()

    def _start(self, values: Mapping[str, float] | None, *, except_for: str = "") -> None:
        """Start driving from a pose, or from home. All sliders follow, `except_for` one."""
        self._page.pause()
        drive = self._chosen()
        if values is None:
            drive.home()
        elif not drive.start_from(values):
            drive = self._unnumbered_branch(values)
        self.drive = drive
        if except_for:
            self._sync_sliders(drive, except_for)
        else:
            self._fit_sliders(drive)
        self._show_pose(None)

    def _unnumbered_branch(self, values: Mapping[str, float]) -> Drive:
        """The drive for a pose on a branch not found yet; at home if it cannot be assembled."""
        self._forget_branches()
        self._found[_UNNUMBERED] = values
        self._branch_name = _UNNUMBERED
        try:
            drive = self._chosen()
        except ParakinError:
            self._forget_branches()
            drive = self._chosen()
            drive.home()
            return drive
        self._branch_list.options, self._branch_list.value = [HOME, _UNNUMBERED], _UNNUMBERED
        return drive

    def drive_from_home(self) -> None:
        """Start driving from home."""
        if self._choices:
            self._branch_name = self._branch_list.value = HOME
            self._start(None)

    def drive_from_here(self) -> None:
        """Start driving from the pose shown."""
        if self._choices:
            self._start(self._values())

    def leave(self) -> None:
        """Stop driving."""
        if self.drive is not None:
            self.drive = None
            for control in (self._left, self._efforts):
                tell(control, "")
            self._branch_name = self._branch_list.value = HOME
            self._drop_handle()

    def _sync_sliders(self, drive: Drive, except_for: str = "") -> None:
        """Set the sliders to the current pose."""
        for name, value in zip(drive.solver.driven, drive.y.tolist(), strict=True):
            if name != except_for:
                slider = self._sliders[name]
                slider.value = nearest_step(slider, self._unit(name).per_si * value)

    def _slider_moved(self, name: str) -> None:
        if self.drive is None:
            self._start(self._values(), except_for=name)
        drive = self.drive
        assert drive is not None
        goal = drive.y.copy()  # other sliders are rounded to their steps
        value = self._sliders[name].value / self._unit(name).per_si
        goal[drive.solver.driven.index(name)] = value
        self.to(goal)

    def to(self, goal: Sequence[float] | FloatArray) -> None:
        """Drive towards values (k,) [m or rad]; if it stops, the sliders return to where."""
        assert self.drive is not None
        stop = self.drive.to(goal)
        if stop is not None:
            self._sync_sliders(self.drive)
        self._show_pose(stop)

    def _show_pose(self, stop: Stop | None) -> None:
        """Show the current pose and, if it stopped, why."""
        drive = self.drive
        assert drive is not None
        state = PoseState(
            f"driven by hand, {self._kinematics}",
            float(drive.tick.conditioning),
            float(drive.tick.residual),
            stop,
            drive.beyond_limits,
            self._branch_name,
            len(drive.solver.graph.limited),
            drive.tick.why(),
        )
        forces = drive.forces(self._page.loads, reactions=self._page.reactions)
        with self._page.client.atomic():
            self._page.show_pose(drive.solver.poses(drive.y, drive.tick), state, forces)
            tell(self._left, range_message(drive.left()))
            tell(self._efforts, efforts_message(forces))
            self._place_handle()
        self._page.client.flush()  # at once: the user is waiting for it

    def load(self) -> None:
        """Show the pose again, as payloads have changed."""
        if self.drive is not None:
            self._show_pose(None)

    # The handle

    async def _note_dragging(self, event: Any) -> None:
        """Note whether the handle is being dragged. A coroutine, because these run in order."""
        self._dragging = event.phase != "end"

    def _follow_handle(self) -> None:
        """Drive the platform towards the handle."""
        if self.drive is None or self._handle is None:
            return
        stop = self.drive.to(self.drive.values_for_pose(self._handle.position, self._handle.wxyz))
        self._sync_sliders(self.drive)
        self._show_pose(stop)

    def _place_handle(self) -> None:
        """Put the handle at the platform, unless it is being dragged."""
        if self._dragging:
            return
        pose = None if self.drive is None else self.drive.platform()
        if pose is None or not self._handle_box.value:
            self._drop_handle()
            return
        if self._handle is None:
            assert self._loaded is not None
            size = 0.16 * self._loaded.drawing.arrangement.size
            handle = self._page.client.scene.add_transform_controls(
                "/handle", size, depth_test=False, position=pose[0], wxyz=pose[1]
            )
            handle.on_update(self._note_dragging)
            self._page.on(handle.on_update, self._follow_handle)
            self._handle = handle
        self._handle.position, self._handle.wxyz = pose

    def _drop_handle(self) -> None:
        if self._handle is not None:
            self._handle.remove()
            self._handle = None
        self._dragging = False
