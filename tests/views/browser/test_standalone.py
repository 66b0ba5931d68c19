"""A standalone page plays without a server, with the bodies where the solver puts them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from browser import chromium, needs_chromium

import parakin
from parakin.views.browser.content import Content
from parakin.views.browser.standalone import standalone_page

_POSITION = "() => window.__viserMutable.nodeRefFromName['/mechanism/coupler'].position.toArray()"


@needs_chromium
def test_a_recording_plays_from_a_file_alone(tmp_path: Path) -> None:
    content = Content("four-bar")
    loaded = content.load("four-bar")
    path = tmp_path / "four-bar.html"
    path.write_text(standalone_page(loaded, content.playback(loaded, "turn")), "utf-8")
    ds = parakin.compile("four-bar").solve("turn", bodies=["coupler"])
    with chromium() as browser:
        page = browser.new_page()
        asked: list[str] = []
        page.on("request", lambda request: asked.append(request.url))
        page.goto(path.as_uri())
        page.wait_for_function("window.__viserMutable?.nodeRefFromName['/mechanism/coupler']")
        seen = []
        for _ in range(300):  # looks, however long a busy machine takes for each
            seen.append(page.evaluate(_POSITION))
            if len(seen) >= 8 and np.ptp(seen, axis=0).max() > 0.01:
                break
            page.wait_for_timeout(130)
    assert all(url.startswith(("file:", "blob:", "data:")) for url in asked)
    points = ds["body_position"].values[:, 0]
    for at in seen:
        assert np.abs(points - at).max(axis=1).min() < 1e-6
    assert np.ptp(seen, axis=0).max() > 0.01


@pytest.mark.parametrize("name", ["flight-simulator-upu", "rssr"])
def test_what_has_rods_or_cannot_move_is_recorded_too(name: str) -> None:
    content = Content(name)
    loaded = content.load(name)
    playback = content.playback(loaded, loaded.motions[0]) if loaded.motions else None
    assert "__VISER_EMBED_DATA__" in standalone_page(loaded, playback)
