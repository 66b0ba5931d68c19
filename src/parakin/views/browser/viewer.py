"""The viewer: pages served to browsers, each a session of its own.

Closing a page ends its session. A page can show what a `Content` offers, and nothing else.
"""

from __future__ import annotations

import asyncio
import contextlib
import io
import socket
import threading
import warnings
from collections.abc import Iterator
from typing import Any

from parakin.errors import InputError, ParakinError, not_installed, reason
from parakin.views.browser.content import Content, LoadedMechanism
from parakin.views.browser.guard import guarded, is_loopback
from parakin.views.browser.session import Session

_LOOK_EVERY = 0.5  # [s], at the files


def exposure(host: str) -> str:
    """A warning about what serving at an address exposes; "" at the loopback address."""
    if is_loopback(host):
        return ""
    return (
        f"served at {host}: anyone who can reach this address can open the page without a "
        "password, see the catalogue and the files named on the command line, and use this "
        "computer's processor; the connection is not encrypted"
    )


@contextlib.contextmanager
def serving(content: Content, host: str = "127.0.0.1", port: int = 8080) -> Iterator[Viewer]:
    """Serve the pages in the background. Raises InputError if the mechanism is bad, viser is not
    installed, or the address is not available.
    """
    try:
        import viser
    except ImportError:
        raise not_installed("view", "viser", "view") from None
    first = content.load(content.first)
    if not 0 <= port <= 65535:
        raise InputError("--port", str(port), "0 to 65535")
    _check_address(host)
    # A page may close while a pose is on its way to it, before viser calls `_disconnected`.
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
    with guarded(host), contextlib.redirect_stdout(io.StringIO()):  # viser's banner
        server = viser.ViserServer(host=host, port=port, label="parakin", verbose=False)
    viewer = Viewer(server, content, first)
    try:
        yield viewer
    finally:
        viewer.close()
        with contextlib.redirect_stdout(io.StringIO()):
            server.get_event_loop().call_soon_threadsafe(_hang_up)
            server.stop()


def _hang_up() -> None:
    """Drop the connections that a browser opened in advance and never used: the server closes the
    others itself, but would wait ten seconds for these. Runs in the server's loop.
    """
    from websockets.protocol import State

    for task in asyncio.all_tasks():
        handler: Any = task.get_coro()
        if getattr(handler, "__name__", "") != "conn_handler":  # of websockets' server
            continue
        if handler.cr_frame.f_locals["connection"].protocol.state is State.CONNECTING:
            task.cancel()


def _check_address(host: str) -> None:
    """Raises InputError unless the address is this computer's; viser would wait forever."""
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, 0, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        with socket.socket(family, kind, protocol) as probe:
            probe.bind(address)
    except (OSError, UnicodeError) as error:
        raise InputError(f"--host {host}", reason(error), "an address of this computer") from None


class Viewer:
    """The server, and its `sessions` by page."""

    def __init__(self, server: Any, content: Content, first: LoadedMechanism) -> None:
        self.server, self.content = server, content
        self.sessions: dict[int, Session] = {}
        self.first = first
        self._closing = threading.Event()
        # A page can ask viser to publish it through a tunnel: never.
        server.request_share_url = lambda *_, **__: None
        server.gui.configure_theme(show_share_button=False, show_logo=False, control_width="large")
        server.scene.configure_default_lights(enabled=True, cast_shadow=False)
        server.on_client_connect(self._connected)
        server.on_client_disconnect(self._disconnected)
        self._watch = threading.Thread(target=self._watch_files, name="parakin files", daemon=True)
        self._watch.start()

    @property
    def url(self) -> str:
        """The address of the page."""
        host = self.server.get_host()
        name = "localhost" if host in ("0.0.0.0", "::") else host
        return f"http://{f'[{name}]' if ':' in name else name}:{self.server.get_port()}"

    def _connected(self, client: Any) -> None:
        if client.client_id not in self.server.get_clients():  # closed in the meantime
            return
        self.sessions[client.client_id] = Session(client, self.content, self.first)
        if client.client_id not in self.server.get_clients():  # closed in the meantime
            self._disconnected(client)

    def _disconnected(self, client: Any) -> None:
        session = self.sessions.pop(client.client_id, None)
        if session is not None:
            session.close()

    def _watch_files(self) -> None:
        """Reload the mechanism when its files change, and show errors in them."""
        stamp = self.content.stamp()
        while not self._closing.wait(_LOOK_EVERY):
            now = self.content.stamp()
            if now == stamp:
                continue
            stamp = now
            try:
                self.first = self.content.load(self.content.first)
            except ParakinError as error:
                for session in list(self.sessions.values()):
                    if session.loaded.name == self.content.first:
                        session.show_error(str(error))
                continue
            for session in list(self.sessions.values()):
                session.reloaded(self.first)

    def close(self) -> None:
        """End all sessions."""
        self._closing.set()
        self._watch.join()
        for session in list(self.sessions.values()):
            session.close()
        self.sessions.clear()
