"""One page of the viewer: its controls, its time, and what it shows.

It plays what is solved and takes sliders, and knows no mechanics: poses come from a `Take` or a
`Drive`, and go to a `Scene`.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from parakin.arrays import FloatArray
from parakin.errors import ParakinError
from parakin.views.browser.captions import Standing, plain, words
from parakin.views.browser.drive_tab import Steering
from parakin.views.browser.live_plots import Charts
from parakin.views.browser.repertoire import Repertoire, Shown, Take
from parakin.views.browser.scene import Scene

_RATE = 60.0  # poses a second
_SLOW = 8.0  # other updates a second
_SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "4")
_STANDS = "None: it stands at home"


@dataclass
class Session:
    """One page: what it shows, and its controls; `poses` counts those sent."""

    client: Any
    repertoire: Repertoire
    shown: Shown
    scene: Scene = field(init=False)
    take: Take | None = field(init=False, default=None)
    steering: Steering = field(init=False)
    time: float = field(init=False, default=0.0)
    playing: bool = field(init=False, default=False)
    poses: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        self._lock = threading.RLock()
        self._wake = threading.Condition(self._lock)
        self._closed = False
        self._told = self._words = ""
        self._slow = 0.0  # when the page's words were last updated
        with self._lock:
            self._add_controls()
            self._show(self.shown)
        self._player = threading.Thread(target=self._play, name="parakin player", daemon=True)
        self._player.start()

    # Controls

    def _add_controls(self) -> None:
        gui = self.client.gui
        names = self.repertoire.names
        self._mechanism = gui.add_dropdown("Mechanism", names, initial_value=self.shown.name)
        self._title = gui.add_markdown("")
        self._message = gui.add_markdown("", visible=False)
        self._state = gui.add_markdown("")
        tabs = gui.add_tab_group()
        with tabs.add_tab("Play"):
            self._motion = gui.add_dropdown("Motion", [_STANDS])
            self._button = gui.add_button("Play")
            self._slider = gui.add_slider("Time [s]", 0.0, 1.0, 0.001, 0.0)
            self._speed = gui.add_dropdown("Speed", _SPEEDS, initial_value="1")
            self._loop = gui.add_checkbox("Loop", initial_value=True)
            self._traced = gui.add_checkbox("Trace of the platform's point", initial_value=True)
        self.steering = Steering(self, tabs.add_tab("Drive"))
        with tabs.add_tab("Show"):
            self._frames = gui.add_checkbox("Frames of bodies", initial_value=False)
            self._names = gui.add_checkbox("Names", initial_value=False)
        panel = gui.add_panel()
        with panel.add_tab("Actuators"):
            self._charts = Charts(gui)
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
        self.on(self._button.on_click, self.toggle)

    def on(self, event: Callable[[Any], Any], act: Callable[[], None]) -> None:
        """Act on a control's event when the user makes it, and not when this session does."""

        def moved(made: Any) -> None:
            if made.client is not None:
                self._locked(act)

        event(moved)

    def _locked(self, act: Callable[[], None]) -> None:
        with self._lock:
            if not self._closed:
                self._guarded(act)

    def _guarded(self, act: Callable[[], None]) -> None:
        try:
            act()
        except ParakinError as error:
            self._state.content = self._words  # and no longer what it was about to do
            self.tell(str(error))

    def tell(self, message: str) -> None:
        """Show what is wrong; "" clears it."""
        if message != self._told:
            self._told = message
            self._message.content = f"**Error:** {plain(message)}" if message else ""
            self._message.visible = bool(message)

    # What is shown

    def _choose(self, name: str) -> None:
        self.say("loading …")
        try:
            shown = self.repertoire.load(name)
        except ParakinError:
            self._mechanism.value = self.shown.name
            raise
        self._show(shown)

    def reloaded(self, shown: Shown) -> None:
        """Take over a mechanism whose file has changed, if this page shows it."""
        with self._lock:
            if not self._closed and self.shown.name == shown.name:
                motion = self._motion.value if self._motion.value in shown.motions else None
                self._guarded(lambda: self._show(shown, motion, self.time, keep=True))

    def _show(
        self, shown: Shown, motion: str | None = None, at: float = 0.0, *, keep: bool = False
    ) -> None:
        """Show a mechanism at a time of a motion, its first if none is given; `keep` the view."""
        self._set_playing(False)
        self.tell("")
        with self.client.atomic():
            if hasattr(self, "scene"):
                self.steering.leave()
                self.scene.remove()
            self.shown = shown
            self.scene = Scene(self.client.scene, shown.drawing, shown.meshes)
            self.scene.show_frames(self._frames.value)
            self.scene.show_names(self._names.value)
            if not keep:
                self._look_at()
            source = f"  \n{plain(shown.mechanism.source)}" if shown.mechanism.source else ""
            self._title.content = f"**{plain(shown.mechanism.title or shown.name)}**{source}"
            self.take = None
            self._words = "stands at home"
            self.steering.show(shown)
            self._motion.options = list(shown.motions) or [_STANDS]
            self._motion.value = self._motion.options[0]
            self._charts.clear()
            if shown.problem:
                self.tell(shown.problem)
        if shown.motions:
            self._guarded(lambda: self._choose_motion(motion or shown.motions[0], at))
        elif shown.solver is not None:
            self.steering.go_home()
        else:
            self._caption("stands at home")

    def _look_at(self) -> None:
        view = self.shown.drawing.view
        camera = self.client.camera
        camera.up_direction = view.up
        camera.position = view.middle + 1.15 * view.span * view.eye
        camera.look_at = view.middle

    # Playing

    def _choose_motion(self, name: str, at: float = 0.0) -> None:
        if name == _STANDS:
            return
        self.say("solving …")
        try:
            take = self.repertoire.play(self.shown, name)
        except ParakinError:
            if self.take is not None:
                self._motion.value = self.take.name
            raise
        self.take = take
        self.tell(self.shown.problem)
        with self.client.atomic():
            self._motion.value = name
            last = max(float(take.time[-1]), 1e-3)
            self._slider.min, self._slider.max = float(take.time[0]), last
            self._slider.step = 10.0 ** math.floor(math.log10(last / 500))
            self._charts.show(take)
            self._trace()
        self.seek(min(max(at, float(take.time[0])), float(take.time[-1])))

    def _trace(self) -> None:
        seen = self.take is not None and self.take.point is not None and self._traced.value
        points = self.take.point if seen and self.take is not None else None
        if points is None:
            points = np.zeros((0, 3))
        self.scene.trace(points[:: max(1, len(points) // 400)])

    def toggle(self) -> None:
        """Play or pause."""
        with self._lock:
            if self.take is None:
                return
            if not self.playing and self.time >= self.take.time[-1]:
                self.time = float(self.take.time[0])
            self._set_playing(not self.playing)

    def _set_playing(self, playing: bool) -> None:
        self.playing = playing
        self._button.label = "Pause" if playing else "Play"
        if playing:
            self.steering.leave()
            self._wake.notify_all()

    def seek(self, at: float) -> None:
        """Show the motion at a time [s]."""
        with self._lock:
            if self.take is not None:
                self.steering.leave()
                self.time = at
                self._frame(at, slow=True)

    def _play(self) -> None:
        """The player's thread: poses as long as the motion plays."""
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
        take = self.take
        if take is None:
            self._set_playing(False)
            return
        start, end = float(take.time[0]), float(take.time[-1])
        at = self.time + float(self._speed.value) / _RATE
        over = at >= end and not (self._loop.value and end > start)
        if over:
            at = end
        elif at >= end:
            at = start + (at - end) % (end - start)
        self.time = at
        if over:  # who sees that it stopped finds it at the end
            self._set_playing(False)
        now = time.perf_counter()
        slow = now - self._slow > 1 / _SLOW or not self.playing
        self._slow = now if slow else self._slow
        self._frame(at, slow=slow)

    def _frame(self, at: float, *, slow: bool) -> None:
        take = self.take
        assert take is not None
        k = take.index(at)
        joints = self.shown.graph.joints
        standing = Standing(
            f"{take.name}, t = {at:.2f} s{take.said}",
            float(take.conditioning[k]),
            float(take.residual[k]),
            take.stop if k == len(take.time) - 1 else None,
            {joints[number].name: number for number, when in take.beyond.items() if when[k]},
        )
        self.poses += 1
        with self.client.atomic():
            self.scene.place(take.position[k], take.wxyz[k])
            self.scene.light(standing.lit)
            if slow:
                self._slider.value = at
                self._charts.cursor(at)
                self._caption(words(standing))

    # Steered

    def halt(self) -> dict[str, float] | None:
        """Stop playing; all coordinates where the motion stands, if there is one."""
        self._set_playing(False)
        return None if self.take is None else self.take.values(self.time)

    def say(self, text: str) -> None:
        """A word while something takes its time."""
        self._state.content = text

    def stand(self, poses: tuple[FloatArray, FloatArray], standing: Standing) -> None:
        """Show a pose that is driven by hand."""
        self.tell(self.shown.problem)
        self.scene.place(*poses)
        self.scene.light(standing.lit)
        self._caption(words(standing))

    def _caption(self, text: str) -> None:
        """What is always in view."""
        self._words = text
        self._state.content = text

    def close(self) -> None:
        """End the session; its page is gone."""
        with self._lock:
            self._closed, self.playing = True, False
            self._wake.notify_all()
        self._player.join()
