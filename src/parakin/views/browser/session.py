"""One page of the viewer: its controls, its time, and the mechanism it shows.

It plays and takes input, and knows no mechanics: poses come from a `Playback` or a `Drive`, and go
to a `Scene`.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from parakin.arrays import FloatArray
from parakin.errors import ParakinError
from parakin.mechanics.reactions import JointAt
from parakin.solving.forces import Forces
from parakin.views.browser.content import Content, LoadedMechanism
from parakin.views.browser.drive_tab import DriveTab
from parakin.views.browser.live_plots import LivePlots
from parakin.views.browser.messages import PoseState, escaped, pose_message
from parakin.views.browser.payloads import Payloads
from parakin.views.browser.playback import Playback, PlayedForces
from parakin.views.browser.scene import Scene

_RATE = 60.0  # poses a second
_UPDATES = 8.0  # updates a second of text, slider and plots
_SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "4")
_NO_MOTION = "none (at home)"


@dataclass
class Session:
    """One page; `poses` counts the poses sent to it."""

    client: Any
    content: Content
    loaded: LoadedMechanism
    scene: Scene = field(init=False)
    playback: Playback | None = field(init=False, default=None)
    drive_tab: DriveTab = field(init=False)
    time: float = field(init=False, default=0.0)
    playing: bool = field(init=False, default=False)
    poses: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        self._lock = threading.RLock()
        self._wake = threading.Condition(self._lock)
        self._closed, self._last_update = False, 0.0  # the latter of text, slider and plots
        self._error_text = self._state_text = ""
        with self._lock:
            self._add_controls()
            self._show(self.loaded)
        self._player = threading.Thread(target=self._play, name="parakin player", daemon=True)
        self._player.start()

    # Controls

    def _add_controls(self) -> None:
        gui = self.client.gui
        names = self.content.names
        self._mechanism = gui.add_dropdown("Mechanism", names, initial_value=self.loaded.name)
        self._title = gui.add_markdown("")
        self._message = gui.add_markdown("", visible=False)
        self._state = gui.add_markdown("")
        tabs = gui.add_tab_group()
        with tabs.add_tab("Play"):
            self._motion = gui.add_dropdown("Motion", [_NO_MOTION])
            self._button = gui.add_button("Play")
            self._slider = gui.add_slider("Time [s]", 0.0, 1.0, 0.001, 0.0)
            self._speed = gui.add_dropdown("Speed", _SPEEDS, initial_value="1")
            self._loop = gui.add_checkbox("Loop", initial_value=True)
            self._traced = gui.add_checkbox("Trace of the platform's point", initial_value=True)
        self.drive_tab = DriveTab(self, tabs.add_tab("Drive"))
        with tabs.add_tab("Show"):
            self._frames = gui.add_checkbox("Frames of bodies", initial_value=False)
            self._names = gui.add_checkbox("Names", initial_value=False)
            self._arrows = gui.add_checkbox("Efforts of the actuators", initial_value=True)
            self._reactions = gui.add_checkbox("Forces in the joints", initial_value=False)
        self._payloads = Payloads(self, self._load)
        panel = gui.add_panel()
        with panel.add_tab("Actuators"):
            self._plots = LivePlots(gui)
        panel.dock_left()
        panel.set_width(340)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(340)
        self.on(self._mechanism.on_update, lambda: self._choose(self._mechanism.value))
        self.on(self._motion.on_update, lambda: self._choose_motion(self._motion.value))
        self.on(self._slider.on_update, lambda: self.seek(self._slider.value))
        self.on(self._traced.on_update, self._trace)
        self.on(self._frames.on_update, lambda: self.scene.show_frames(self._frames.value))
        self.on(self._names.on_update, lambda: self.scene.show_names(self._names.value))
        self.on(self._arrows.on_update, self._show_again)
        self.on(self._reactions.on_update, self._load)
        self.on(self._button.on_click, self.toggle)

    def on(self, event: Callable[[Any], Any], act: Callable[[], None]) -> None:
        """Call `act` when the user operates a control, but not when this session sets it."""

        def handle(made: Any) -> None:
            if made.client is not None:
                self.locked(act)

        event(handle)

    def locked(self, act: Callable[[], None]) -> None:
        """Call `act` when nothing else is done to the page, unless it has been closed."""
        with self._lock:
            if not self._closed:
                self._guarded(act)

    def _guarded(self, act: Callable[[], None]) -> None:
        try:
            act()
        except ParakinError as error:
            self._state.content = self._state_text  # in place of the progress
            self.show_error(str(error))

    def show_error(self, message: str) -> None:
        """Show an error; "" clears it."""
        if message != self._error_text:
            self._error_text = message
            self._message.content = f"**Error:** {escaped(message)}" if message else ""
            self._message.visible = bool(message)

    # The mechanism

    def _choose(self, name: str) -> None:
        self.show_progress("loading …")
        try:
            loaded = self.content.load(name)
        except ParakinError:
            self._mechanism.value = self.loaded.name
            raise
        self._show(loaded)

    def reloaded(self, loaded: LoadedMechanism) -> None:
        """Show a mechanism again whose file has changed, if this page shows it."""
        with self._lock:
            if not self._closed and self.loaded.name == loaded.name:
                motion = self._motion.value if self._motion.value in loaded.motions else None
                self._guarded(lambda: self._show(loaded, motion, self.time, keep=True))

    def _show(
        self,
        loaded: LoadedMechanism,
        motion: str | None = None,
        at: float = 0.0,
        *,
        keep: bool = False,
    ) -> None:
        """Show a mechanism at a time of a motion, by default its first; keep: the camera's view."""
        self._set_playing(False)
        self.show_error("")
        with self.client.atomic():
            if hasattr(self, "scene"):
                self.drive_tab.leave()
                self.scene.remove()
            self.loaded = loaded
            self.scene = Scene(self.client.scene, loaded.drawing, loaded.meshes)
            self.scene.show_frames(self._frames.value)
            self.scene.show_names(self._names.value)
            if not keep:
                self._reset_camera()
            source = f"  \n{escaped(loaded.mechanism.source)}" if loaded.mechanism.source else ""
            self._title.content = f"**{escaped(loaded.mechanism.title or loaded.name)}**{source}"
            self.playback = None
            self._state_text = "at home"
            forced = loaded.solver is not None and not loaded.solver.no_forces
            self._arrows.visible = self._reactions.visible = forced
            self._payloads.show(loaded.graph if forced else None)
            self.drive_tab.show(loaded)
            self._motion.options = list(loaded.motions) or [_NO_MOTION]
            self._motion.value = self._motion.options[0]
            self._plots.clear()
            if loaded.problem:
                self.show_error(loaded.problem)
        if loaded.motions:
            self._guarded(lambda: self._choose_motion(motion or loaded.motions[0], at))
        elif loaded.solver is not None:
            self.drive_tab.drive_from_home()
        else:
            self._show_state("at home")

    def _reset_camera(self) -> None:
        view = self.loaded.drawing.view
        camera = self.client.camera
        camera.up_direction = view.up
        camera.position = view.middle + 1.15 * view.span * view.eye
        camera.look_at = view.middle

    # Playing

    def _choose_motion(self, name: str, at: float = 0.0) -> None:
        if name == _NO_MOTION:
            return
        self.show_progress("solving …")
        try:
            playback = self._solved(name)
        except ParakinError:
            if self.playback is not None:
                self._motion.value = self.playback.name
            raise
        self.playback = playback
        self._scale_arrows()
        self.show_error(self.loaded.problem)
        with self.client.atomic():
            self._motion.value = name
            last = max(float(playback.time[-1]), 1e-3)
            self._slider.min, self._slider.max = float(playback.time[0]), last
            self._slider.step = 10.0 ** math.floor(math.log10(last / 500))
            self._plots.show(playback)
            self._trace()
        self.seek(at)

    # Forces

    @property
    def loads(self) -> Mapping[str, float]:
        """Masses of payloads [kg]."""
        return self._payloads.masses

    def _solved(self, name: str) -> Playback:
        return self.content.playback(self.loaded, name, self.loads, reactions=self.reactions)

    def _load(self) -> None:
        """Find the forces again, with other payloads or in other places."""
        if self.playback is not None:
            self.playback = self._solved(self.playback.name)
            self._scale_arrows()
            with self.client.atomic():
                self._plots.show_forces(self.playback)
        self._show_again()

    def _scale_arrows(self) -> None:
        forces = None if self.playback is None else self.playback.forces
        if forces is not None:
            self.scene.efforts.scale_to(forces.effort, forces.units)
            if forces.reactions is not None:
                self.scene.reactions.scale_to(forces.reactions)

    def _show_again(self) -> None:
        """Show the pose as it is, with other forces."""
        if self.drive_tab.drive is not None:
            self.drive_tab.load()
        elif self.playback is not None:
            self._frame(self.time, full=True)

    def _show_forces(
        self,
        poses: tuple[FloatArray, FloatArray],
        forces: Forces | PlayedForces,
        now: FloatArray,
        joints: tuple[JointAt, ...],
        reactions: FloatArray | None,
    ) -> None:
        """Arrows of efforts and of forces in joints, as far as they are wanted."""
        if self._arrows.value:
            self.scene.efforts.show(*poses, forces.actuators, forces.units, now)
        else:
            self.scene.efforts.hide()
        if self.reactions and reactions is not None and joints:
            self.scene.reactions.show(*poses, joints, reactions)
        else:
            self.scene.reactions.hide()

    @property
    def reactions(self) -> bool:
        """Whether forces in the joints are shown."""
        return bool(self._reactions.value)

    def _trace(self) -> None:
        playback = self.playback
        self.scene.trace(playback.point if playback is not None and self._traced.value else None)

    def toggle(self) -> None:
        """Play or pause."""
        with self._lock:
            if self.playback is None:
                return
            if not self.playing and self.time >= self.playback.time[-1]:
                self.time = float(self.playback.time[0])
            self._set_playing(not self.playing)

    def _set_playing(self, playing: bool) -> None:
        self.playing = playing
        self._button.label = "Pause" if playing else "Play"
        if playing:
            self.drive_tab.leave()
            self._wake.notify_all()

    def seek(self, at: float) -> None:
        """Show the motion at a time [s], or the nearest that it has: any may be typed."""
        with self._lock:
            if self.playback is not None:
                self.drive_tab.leave()
                self.time = self.playback.within(at)
                self._frame(self.time, full=True)

    def _play(self) -> None:
        """The player's thread: sends poses while the motion plays."""
        due = time.perf_counter()
        while True:
            with self._lock:
                while not (self.playing or self._closed):
                    self._wake.wait()
                    due = time.perf_counter()
                if self._closed:
                    return
                self._step()
            due = max(due + 1 / _RATE, time.perf_counter() - 0.1)
            time.sleep(max(0.0, due - time.perf_counter()))

    def _step(self) -> None:
        playback = self.playback
        if playback is None:
            self._set_playing(False)
            return
        start, end = float(playback.time[0]), float(playback.time[-1])
        at = self.time + float(self._speed.value) / _RATE
        over = at >= end and not (self._loop.value and end > start)
        if over:
            at = end
        elif at >= end:
            at = start + (at - end) % (end - start)
        self.time = at
        if over:  # after the time, for who waits for the end
            self._set_playing(False)
        now = time.perf_counter()
        full = now - self._last_update > 1 / _UPDATES or not self.playing
        self._last_update = now if full else self._last_update
        self._frame(at, full=full)

    def _frame(self, at: float, *, full: bool) -> None:
        """Send the pose at a time and, if `full`, update text, slider and plots."""
        playback = self.playback
        assert playback is not None
        k = playback.index(at)
        graph = self.loaded.graph
        state = PoseState(
            f"{playback.name}, t = {at:.2f} s{playback.note}",
            float(playback.conditioning[k]),
            float(playback.residual[k]),
            playback.stop if k == len(playback.time) - 1 else None,
            {name: graph.holder(name) for name, when in playback.beyond_limits.items() if when[k]},
            limits=len(graph.limited),
            because=playback.why(k),
        )
        self.poses += 1
        with self.client.atomic():
            poses = playback.position[k], playback.wxyz[k]
            self.scene.place(*poses)
            self.scene.highlight(state.highlighted)
            if playback.forces is not None:
                forces = playback.forces
                known = None if forces.reactions is None else forces.reactions[k]
                self._show_forces(poses, forces, forces.effort[k], forces.joints, known)
            if full:
                self._slider.value = at
                self._plots.cursor(at)
                self._show_state(pose_message(state))

    # For the Drive tab

    def pause(self) -> dict[str, float] | None:
        """Pause the motion. Returns all coordinates of the pose shown, if a motion is loaded."""
        self._set_playing(False)
        return None if self.playback is None else self.playback.values(self.time)

    def show_progress(self, text: str) -> None:
        """Show what is going on while it takes time."""
        self._state.content = text

    def show_pose(
        self, poses: tuple[FloatArray, FloatArray], state: PoseState, forces: Forces | None
    ) -> None:
        """Show a pose that is driven by hand."""
        self.show_error(self.loaded.problem)
        self.scene.place(*poses)
        self.scene.highlight(state.highlighted)
        if forces is not None:
            drive = self.drive_tab.drive
            joints = drive.joints if drive is not None and self.reactions else ()
            self._show_forces(poses, forces, forces.effort, joints, forces.reaction_force)
        self._show_state(pose_message(state))

    def _show_state(self, text: str) -> None:
        """Show the lines that are always in view."""
        self._state_text = text
        self._state.content = text

    def close(self) -> None:
        """End the session, as its page is gone."""
        with self._lock:
            self._closed, self.playing = True, False
            self._wake.notify_all()
        self._player.join()
