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
from functools import partial
from typing import Any

import numpy as np

from parakin.captions import plain, unit_of, words
from parakin.charts import Charts
from parakin.drive import Drive, Stop, choices, driven_by
from parakin.errors import ParakinError
from parakin.repertoire import Repertoire, Shown, Take
from parakin.scene import Scene

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
    drive: Drive | None = field(init=False, default=None)
    time: float = field(init=False, default=0.0)
    playing: bool = field(init=False, default=False)
    poses: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        self._lock = threading.RLock()
        self._wake = threading.Condition(self._lock)
        self._closed = False
        self._slow = 0.0  # when the page's words were last updated
        self._sliders: dict[str, Any] = {}
        self._choices: dict[str, tuple[str, ...]] = {}
        self._drives: dict[str, Drive] = {}
        self._set = ""  # which of the choices is driven
        self._handle: Any = None
        self._led = False
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
        self._drive_tab = tabs.add_tab("Drive")
        with self._drive_tab:
            self._which = gui.add_dropdown("Kinematics", ["inverse", "forward"])
            self._here = gui.add_button("Drive from here")
            self._home = gui.add_button("Home")
            self._handled = gui.add_checkbox("Handle in the scene", initial_value=True)
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
        self._on(self._mechanism, lambda: self._choose(self._mechanism.value))
        self._on(self._motion, lambda: self._choose_motion(self._motion.value))
        self._on(self._slider, lambda: self.seek(self._slider.value))
        self._on(self._traced, self._trace)
        self._on(self._which, self._switch)
        self._on(self._handled, self._place_handle)
        self._on(self._frames, lambda: self.scene.show_frames(self._frames.value))
        self._on(self._names, lambda: self.scene.show_names(self._names.value))
        self._button.on_click(lambda _: self.toggle())
        self._here.on_click(lambda _: self._locked(self.drive_here))
        self._home.on_click(lambda _: self._locked(self.drive_home))

    def _on(self, control: Any, act: Callable[[], None]) -> None:
        """Act when the user moves a control, and not when this session does."""

        def moved(event: Any) -> None:
            if event.client is not None:
                self._locked(act)

        control.on_update(moved)

    def _locked(self, act: Callable[[], None]) -> None:
        with self._lock:
            if not self._closed:
                self._guarded(act)

    def _guarded(self, act: Callable[[], None]) -> None:
        try:
            act()
        except ParakinError as error:
            self.tell(str(error))

    def tell(self, message: str) -> None:
        """Show what is wrong; "" clears it."""
        self._message.content = f"**Error:** {plain(message)}" if message else ""
        self._message.visible = bool(message)

    # What is shown

    def _choose(self, name: str) -> None:
        self._state.content = "loading …"
        try:
            shown = self.repertoire.load(name)
        except ParakinError:
            self._mechanism.value = self.shown.name
            self._state.content = ""
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
                self._drop_handle()
                self.scene.remove()
            self.shown = shown
            self.scene = Scene(self.client.scene, shown.drawing, shown.meshes)
            self.scene.show_frames(self._frames.value)
            self.scene.show_names(self._names.value)
            if not keep:
                self._look_at()
            source = f"  \n{plain(shown.mechanism.source)}" if shown.mechanism.source else ""
            self._title.content = f"**{plain(shown.mechanism.title or shown.name)}**{source}"
            self.take, self.drive = None, None
            self._fill_drive()
            self._motion.options = list(shown.motions) or [_STANDS]
            self._motion.value = self._motion.options[0]
            self._charts.clear()
            if shown.problem:
                self.tell(shown.problem)
        if shown.motions:
            self._guarded(lambda: self._choose_motion(motion or shown.motions[0], at))
        elif shown.solver is not None:
            self.drive_home()
        else:
            self._state.content = "stands at home"

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
        self._state.content = "solving …"
        try:
            take = self.repertoire.play(self.shown, name)
        except ParakinError:
            self._state.content = "stands as it was"
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
            self._leave_drive()
            self._wake.notify_all()

    def seek(self, at: float) -> None:
        """Show the motion at a time [s]."""
        with self._lock:
            if self.take is not None:
                self._leave_drive()
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
        if at >= end:
            if self._loop.value and end > start:
                at = start + (at - end) % (end - start)
            else:
                at = end
                self._set_playing(False)
        self.time = at
        now = time.perf_counter()
        slow = now - self._slow > 1 / _SLOW or not self.playing
        self._slow = now if slow else self._slow
        self._frame(at, slow=slow)

    def _frame(self, at: float, *, slow: bool) -> None:
        take = self.take
        assert take is not None
        k = take.index(at)
        beyond = {number for number, when in take.beyond.items() if when[k]}
        ended = take.stop if k == len(take.time) - 1 else None
        self.poses += 1
        with self.client.atomic():
            self.scene.place(take.position[k], take.wxyz[k])
            self.scene.light(beyond | (ended.joints if ended else frozenset()))
            if slow:
                self._slider.value = at
                self._charts.cursor(at)
                self._state.content = words(
                    f"{take.name}, t = {at:.2f} s{take.said}",
                    float(take.conditioning[k]),
                    float(take.residual[k]),
                    ended,
                    [self.shown.graph.joints[number].name for number in sorted(beyond)],
                )

    # Driving

    def _fill_drive(self) -> None:
        """What can be driven, and its sliders; none where nothing can."""
        self._drives, self._choices = {}, {}
        if self.shown.solver is not None:
            solver = self.shown.solver
            self._choices = choices(solver)
            self._set = next(name for name, c in self._choices.items() if c == solver.driven)
            self._drives[self._set] = Drive(solver)  # others are compiled when asked for
            self._which.options = list(self._choices)
            self._which.value = self._set
        for control in (self._which, self._here, self._home, self._handled):
            control.visible = bool(self._choices)
        self._add_sliders()

    def _chosen(self) -> Drive:
        """The drive of the set that is chosen; compiled when first asked for."""
        if self._set not in self._drives:
            self._state.content = "compiling …"
            self._drives[self._set] = driven_by(self.shown.mechanism, self._choices[self._set])
        return self._drives[self._set]

    def _add_sliders(self) -> None:
        for slider in self._sliders.values():
            slider.remove()
        self._sliders.clear()
        if not self._choices:
            return
        drive = self._chosen()
        with self._drive_tab:
            for name, value in zip(drive.solver.driven, drive.y.tolist(), strict=True):
                unit, scale = unit_of(self.shown.graph, name)
                low, high = (scale * end for end in drive.span(name))
                step = 10.0 ** math.floor(math.log10((high - low) / 1000))
                low, high = step * math.floor(low / step), step * math.ceil(high / step)
                at = min(max(scale * value, low), high)
                slider = self.client.gui.add_slider(f"{name} [{unit}]", low, high, step, at)
                self._on(slider, partial(self._slid, name))
                self._sliders[name] = slider

    def _switch(self) -> None:
        """Drive the other set, from where the mechanism stands."""
        values, before = self._values(), self._set
        self._set = self._which.value
        try:
            self._chosen()
        except ParakinError:
            self._set = self._which.value = before
            raise
        self._add_sliders()
        self._enter(values)

    def _values(self) -> dict[str, float] | None:
        """All coordinates as shown, if they are known."""
        if self.drive is not None:
            return self.drive.values
        return None if self.take is None else self.take.values(self.time)

    def _enter(self, values: dict[str, float] | None, *, but: str = "") -> None:
        """Start driving from a pose, or home; sliders go there, `but` one."""
        self._set_playing(False)
        drive = self._chosen()
        if values is None or not drive.from_pose(values):
            drive.home()
        self.drive = drive
        self._sync(but)
        self._stand(None)

    def drive_home(self) -> None:
        """Drive, from home."""
        with self._lock:
            if self._choices:
                self._enter(None)

    def drive_here(self) -> None:
        """Drive, from where the mechanism stands."""
        with self._lock:
            if self._choices:
                self._enter(self._values())

    def _leave_drive(self) -> None:
        if self.drive is not None:
            self.drive = None
            self._drop_handle()

    def _sync(self, but: str = "") -> None:
        """Sliders to where the mechanism stands."""
        assert self.drive is not None
        for name, value in zip(self.drive.solver.driven, self.drive.y.tolist(), strict=True):
            if name != but:
                slider = self._sliders[name]
                scaled = unit_of(self.shown.graph, name)[1] * value
                slider.value = min(max(scaled, slider.min), slider.max)

    def _slid(self, name: str) -> None:
        if self.drive is None:
            self._enter(self._values(), but=name)
        drive = self.drive
        assert drive is not None
        graph = self.shown.graph
        goal = [self._sliders[n].value / unit_of(graph, n)[1] for n in drive.solver.driven]
        rest = np.abs(goal - drive.y) < 0.5 * np.array(
            [self._sliders[n].step / unit_of(graph, n)[1] for n in drive.solver.driven]
        )  # a slider has its own steps: what nobody moved stays
        self._stand(drive.to(np.where(rest, drive.y, goal)))

    async def _hold(self, event: Any) -> None:
        """Whether a hand is on the handle. Awaited, and so in order, which threads are not."""
        self._led = event.phase != "end"

    def _lead(self) -> None:
        """Follow the handle; once it is let go it returns to where the mechanism stands."""
        if self.drive is None or self._handle is None:
            return
        stop = self.drive.to(self.drive.led(self._handle.position, self._handle.wxyz))
        self._sync()
        self._stand(stop)

    def _stand(self, stop: Stop | None) -> None:
        """Show the driven pose, and why it goes no further."""
        drive = self.drive
        assert drive is not None
        position, wxyz = drive.solver.poses(drive.y, drive.tick)
        lit = stop.joints if stop is not None else frozenset()
        with self.client.atomic():
            self.scene.place(position, wxyz)
            self.scene.light(lit)
            self._place_handle()
            self._state.content = words(
                f"driven by hand, {self._set}",
                float(drive.tick.conditioning),
                float(drive.tick.residual),
                stop,
                [self.shown.graph.joints[k].name for k in sorted(lit)],
            )
        self.client.flush()  # a hand is waiting

    def _place_handle(self) -> None:
        """The handle where the platform is, unless the hand is on it."""
        if self._led:
            return
        pose = None if self.drive is None else self.drive.platform()
        if pose is None or not self._handled.value:
            self._drop_handle()
            return
        if self._handle is None:
            size = 0.16 * self.shown.drawing.size
            handle = self.client.scene.add_transform_controls(
                "/handle", size, depth_test=False, position=pose[0], wxyz=pose[1]
            )
            handle.on_update(self._hold)
            handle.on_update(lambda _: self._locked(self._lead))
            self._handle = handle
        self._handle.position, self._handle.wxyz = pose

    def _drop_handle(self) -> None:
        if self._handle is not None:
            self._handle.remove()
            self._handle = None
        self._led = False

    def close(self) -> None:
        """End the session; its page is gone."""
        with self._lock:
            self._closed, self.playing = True, False
            self._wake.notify_all()
        self._player.join()
