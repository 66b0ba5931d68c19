"""The server: who may see what, and how it ends."""

from __future__ import annotations

import gc
import signal
import socket
import subprocess
import sys
import time
import warnings
from pathlib import Path
from typing import Any

import pytest
from browser import Page, needs_chromium, until, viewed

import parakin
from parakin.views.browser.content import Content
from parakin.views.browser.viewer import Viewer, exposure, serving

pytestmark = needs_chromium


def test_a_page_may_close_while_it_plays(browser: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    left = Viewer._disconnected

    def late(viewer: Viewer, client: Any) -> None:
        time.sleep(0.5)
        left(viewer, client)

    monkeypatch.setattr(Viewer, "_disconnected", late)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # which ends the player's thread, and fails the test
        with viewed(browser, "four-bar") as page:
            page.press("Play")
            until(lambda: page.session.playing)
            session = page.session
            page.close()
            at = session.poses
            until(lambda: session.poses > at + 10)


def test_the_server_ends_and_closes_all_connections(browser: Any) -> None:
    with serving(Content("four-bar"), port=0) as viewer:
        page = Page(browser, viewer)
        page.press("Play")
        silent = socket.create_connection(("127.0.0.1", viewer.server.get_port()))
        until(lambda: page.session.playing)
        time.sleep(0.2)
    assert silent.recv(1) == b""
    silent.close()
    page.page.close()
    gc.collect()  # what is left open is told


def test_it_is_bound_to_the_loopback_address_alone() -> None:
    with serving(Content("four-bar"), port=0) as viewer:
        port = viewer.server.get_port()
        socket.create_connection(("127.0.0.1", port), 5).close()
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.2", port), 5)
        assert viewer.server.request_share_url() is None


def test_ctrl_c_is_how_it_ends() -> None:
    # What a shell starts in the background, these tests perhaps, is told to ignore Ctrl-C.
    heard = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    start = f"{heard}; import sys; from parakin.cli.main import main; sys.exit(main())"
    view = [sys.executable, "-c", start, "view", "four-bar", "--port", "0"]
    process = subprocess.Popen(view, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    said = process.stdout.readline()
    assert said.startswith("four-bar at http://127.0.0.1:")
    process.send_signal(signal.SIGINT)
    rest, errors = process.communicate(timeout=600)
    assert (process.returncode, rest, errors) == (0, "", "")


@pytest.mark.parametrize(
    "arguments",
    [["nothing"], ["four-bar", "--port", "70000"], ["four-bar", "--host", "300.1.1.1"]],
)
def test_what_cannot_be_served_is_reported_in_one_line(arguments: list[str]) -> None:
    view = [sys.executable, "-m", "parakin", "view", *arguments]
    done = subprocess.run(view, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 2
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1
    assert arguments[-1] in done.stderr


def test_without_viser_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    with (
        pytest.raises(parakin.InputError, match=r"pip install 'parakin\[view\]'"),
        serving(Content("four-bar")),
    ):
        pass


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "::1", "127.0.0.9"])
def test_loopback_exposes_nothing(host: str) -> None:
    assert exposure(host) == ""


def test_another_address_says_what_it_exposes() -> None:
    view = ["-m", "parakin", "view", "four-bar", "--host", "0.0.0.0", "--port", "0"]
    process = subprocess.Popen([sys.executable, *view], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    said = process.stdout.readline()
    process.kill()
    process.communicate()
    assert "0.0.0.0" in said
    assert "without a password" in said


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["no-such-motion.toml"], "no-such-motion.toml: found no such file or directory"),
        (["bad.csv"], "bad.csv: found no text"),
        (["--mesh", "no-such.stl"], "no-such.stl: found no such file or directory"),
        (["--mesh", "empty.stl"], "empty.stl: found no triangles"),
    ],
)
def test_a_motion_or_mesh_that_cannot_be_shown_is_said_where_it_was_named(
    arguments: list[str], said: str, tmp_path: Path
) -> None:
    (tmp_path / "bad.csv").write_text("")
    (tmp_path / "empty.stl").write_text("solid nothing")
    view = [sys.executable, "-m", "parakin", "view", "four-bar", *arguments, "--port", "0"]
    with subprocess.Popen(
        view, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline().startswith("four-bar at http://127.0.0.1:")
        process.terminate()
        assert said in process.stderr.read()
