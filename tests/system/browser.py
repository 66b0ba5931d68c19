"""A page in a real Chromium: what a user sees and does there."""

from __future__ import annotations

import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from parakin.arrays import FloatArray
from parakin.views.browser.content import Content
from parakin.views.browser.session import Session
from parakin.views.browser.viewer import Viewer, serving

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
_FLAGS = (
    "--headless --no-sandbox --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --use-angle=swiftshader --enable-unsafe-swiftshader"
)
ELSEWHERE = "elsewhere.example"  # another site, whose name leads to this computer
_KNOWN = ("THREE.Clock", "GL Driver Message")  # warnings of viser's own page
_LOOKS = 60_000  # a hundredth of a second apart or more, before a thing is given up
_PATIENCE = 60_000  # [ms]; pictures are drawn without a graphics card

needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")


@contextmanager
def chromium() -> Iterator[Any]:
    """A browser with a profile of its own."""
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile, sync_playwright() as p:
        browser = p.chromium.launch_persistent_context(
            profile,
            executable_path=CHROMIUM,
            headless=True,
            args=[*_FLAGS.split(), f"--host-resolver-rules=MAP {ELSEWHERE} 127.0.0.1"],
            viewport={"width": 1280, "height": 800},
        )
        browser.set_default_timeout(_PATIENCE)
        yield browser
        browser.close()


class Page:
    """One page of the viewer, and what its console and network said."""

    def __init__(self, browser: Any, viewer: Viewer) -> None:
        known = set(viewer.sessions)
        self.viewer = viewer
        self.said: list[str] = []
        self.asked: list[str] = []
        self.page = browser.new_page()
        self.page.on("console", self._console)
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(viewer.url)
        until(lambda: set(viewer.sessions) - known)
        (self.id,) = set(viewer.sessions) - known
        self.drawn()

    def drawn(self) -> None:
        """Wait until what is shown has come to the page."""
        names = [f"/mechanism/{name}" for name in self.session.loaded.graph.bodies]
        self.page.wait_for_function(
            "names => names.every(n => window.__viserMutable?.nodeRefFromName[n])", arg=names
        )

    @property
    def session(self) -> Session:
        return self.viewer.sessions[self.id]

    def _console(self, message: Any) -> None:
        told = message.type in ("error", "warning")
        if told and not any(known in message.text for known in _KNOWN):
            self.said.append(message.text)

    def poses(self) -> tuple[FloatArray, FloatArray]:
        """Positions (bodies, 3) and quaternions wxyz (bodies, 4) of all bodies but the base, as
        the page's own scene graph has them.
        """
        names = [f"/mechanism/{name}" for name in self.session.loaded.graph.bodies[1:]]
        found = self.page.evaluate(
            """names => names.map(n => {
                const node = window.__viserMutable.nodeRefFromName[n];
                return [...node.position.toArray(), ...node.quaternion.toArray()];
            })""",
            names,
        )
        rows = np.array(found)
        return rows[:, :3], rows[:, [6, 3, 4, 5]]

    def colours(self, node: str) -> set[tuple[int, ...]]:
        """Colours of the meshes whose names begin so."""
        found = self.page.evaluate(
            """start => Object.entries(window.__viserSceneTree.getState())
                .filter(([name, node]) => name.startsWith(start) && node?.message?.props?.color)
                .map(([name, node]) => [...node.message.props.color])""",
            node,
        )
        return {tuple(colour) for colour in found}

    def press(self, button: str) -> None:
        self.page.get_by_role("button", name=button, exact=True).click()

    def tab(self, name: str) -> None:
        self.page.get_by_role("tab", name=name).click()

    def choose(self, label: str, option: str) -> None:
        self.page.get_by_role("combobox", name=label).click()
        self.page.get_by_role("option", name=option, exact=True).click()

    def enter(self, slider: str, value: str) -> None:
        """Type a value beside a slider."""
        self._box(slider).fill(value)
        self._box(slider).press("Enter")

    def value(self, slider: str) -> str:
        """What stands beside a slider."""
        return str(self._box(slider).input_value())

    def _box(self, slider: str) -> Any:
        label = self.page.get_by_text(slider, exact=True)
        return label.locator("xpath=following::input[not(@type='hidden')][1]")

    def pixels(self) -> FloatArray:
        """The scene as it is seen, (height, width, 3)."""
        import io

        from PIL import Image

        picture = self.page.locator("canvas").first.screenshot()
        return np.asarray(Image.open(io.BytesIO(picture)).convert("RGB"), dtype=float)

    def close(self) -> None:
        self.page.close()


@contextmanager
def viewed(browser: Any, mechanism: str | Path, **options: Any) -> Iterator[Page]:
    """A mechanism's page, served at a free port."""
    with serving(Content(str(mechanism), **options), port=0) as viewer:
        page = Page(browser, viewer)
        yield page
        page.close()
        until(lambda: not viewer.sessions)


def agree(page: Page, position: FloatArray, wxyz: FloatArray) -> None:
    """The page's scene comes to these poses, within what single precision tells."""
    until(lambda: shows(page, position, wxyz))


def shows(page: Page, position: FloatArray, wxyz: FloatArray) -> bool:
    """Whether the page's scene stands at these poses, within what single precision tells."""
    seen, turned = page.poses()
    across = np.abs((turned * wxyz).sum(axis=1))
    return bool(np.abs(seen - position).max() < 1e-6 and (across > 1 - 1e-6).all())


def until(condition: Callable[[], Any]) -> None:
    """Wait for something to come true."""
    for _ in range(_LOOKS):
        if condition():
            return
        time.sleep(0.01)
    raise AssertionError(f"did not come true in {_LOOKS} looks")
