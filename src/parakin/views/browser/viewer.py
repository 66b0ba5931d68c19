"""The viewer: pages served to browsers, each a session of its own.

Closing a page ends its session. Whatever the user may ask for comes from a `Repertoire`.
"""

from __future__ import annotations

import asyncio
import contextlib
import io
import ipaddress
import socket
import threading
import warnings
from collections.abc import Iterator
from typing import Any
from urllib.parse import urlsplit

from parakin.errors import InputError, ParakinError, not_installed, reason
from parakin.views.browser.captions import plain
from parakin.views.browser.repertoire import Repertoire, Shown
from parakin.views.browser.session import Session

_LOOK = 0.5  # seconds between looks at the files


def is_loopback(host: str) -> bool:
    """Whether an address is only reached from this computer."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def is_foreign(origin: str | None) -> bool:
    """Whether a page is of another site: one that is open in the same browser reaches the loopback
    address too. Browsers say in every request whose page it is; other programs need not.
    """
    return origin is not None and not is_loopback(urlsplit(origin).hostname or "")


def exposure(host: str) -> str:
    """What serving at an address exposes, in words; "" at the loopback address."""
    if is_loopback(host):
        return ""
    return (
        f"served at {host}: whoever can reach this computer there can open the page without a "
        "password, see the mechanisms of the catalogue and the files named on the command line, "
        "and use this computer's processor; nothing is encrypted"
    )


@contextlib.contextmanager
def serving(repertoire: Repertoire, host: str = "127.0.0.1", port: int = 8080) -> Iterator[Viewer]:
    """The pages, served in the background. Raises InputError where the mechanism named is bad,
    viser is not installed, or the address is not to be had.
    """
    try:
        import viser
    except ImportError:
        raise not_installed("view", "viser", "view") from None
    first = repertoire.load(repertoire.named)
    if not 0 <= port <= 65535:
        raise InputError("--port", str(port), "0 to 65535")
    _check_address(host)
    # A page may close while a pose is on its way to it, and viser calls us only afterwards.
    warnings.filterwarnings("ignore", "Queued a .* on a closed connection", UserWarning)
    with contextlib.redirect_stdout(io.StringIO()):  # its banner
        server = viser.ViserServer(host=host, port=port, label="parakin", verbose=False)
    viewer = Viewer(server, repertoire, first)
    try:
        yield viewer
    finally:
        viewer.close()
        with contextlib.redirect_stdout(io.StringIO()):
            server.get_event_loop().call_soon_threadsafe(_hang_up)
            server.stop()


def _hang_up() -> None:
    """Drop the connections that a browser opened in advance and never used, for which the server
    would wait ten seconds; it closes the others itself. Called in its loop.
    """
    from websockets.protocol import State

    for task in asyncio.all_tasks():
        handler: Any = task.get_coro()
        if getattr(handler, "__name__", "") != "conn_handler":  # of websockets' server
            continue
        if handler.cr_frame.f_locals["connection"].protocol.state is State.CONNECTING:
            task.cancel()


def _check_address(host: str) -> None:
    """Raises InputError on an address that is not this computer's; viser would wait for ever."""
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, 0, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        with socket.socket(family, kind, protocol) as probe:
            probe.bind(address)
    except (OSError, UnicodeError) as error:
        raise InputError(f"--host {host}", reason(error), "an address of this computer") from None


class Viewer:
    """The server and the sessions it holds; `sessions` by page."""

    def __init__(self, server: Any, repertoire: Repertoire, first: Shown) -> None:
        self.server, self.repertoire = server, repertoire
        self.sessions: dict[int, Session] = {}
        self._first = first
        self._closing = threading.Event()
        # A page may ask viser for a tunnel through which all the world can see it. Never.
        server.request_share_url = lambda *_, **__: None
        server.gui.configure_theme(show_share_button=False, show_logo=False, control_width="large")
        server.scene.configure_default_lights(enabled=True, cast_shadow=False)
        server.on_client_connect(self._opened)
        server.on_client_disconnect(self._left)
        self._watch = threading.Thread(target=self._look, name="parakin files", daemon=True)
        self._watch.start()

    @property
    def url(self) -> str:
        """Where the page is."""
        host = self.server.get_host()
        shown = "localhost" if host in ("0.0.0.0", "::") else host
        return f"http://{f'[{shown}]' if ':' in shown else shown}:{self.server.get_port()}"

    def _opened(self, client: Any) -> None:
        connection = self.server._websock_server._live_connections.get(client.client_id)
        if connection is None:  # gone meanwhile
            return
        origin = connection.request.headers.get("Origin")
        if is_loopback(self.server.get_host()) and is_foreign(origin):
            client.gui.add_markdown(
                f"Refused: a page of {plain(origin)}, not of this computer; see --host."
            )
            return
        self.sessions[client.client_id] = Session(client, self.repertoire, self._first)
        if client.client_id not in self.server.get_clients():  # gone meanwhile
            self._left(client)

    def _left(self, client: Any) -> None:
        session = self.sessions.pop(client.client_id, None)
        if session is not None:
            session.close()

    def _look(self) -> None:
        """Reload what is shown when its files change; tell what is wrong with them."""
        stamp = self.repertoire.stamp()
        while not self._closing.wait(_LOOK):
            now = self.repertoire.stamp()
            if now == stamp:
                continue
            stamp = now
            try:
                self._first = self.repertoire.load(self.repertoire.named)
            except ParakinError as error:
                for session in list(self.sessions.values()):
                    if session.shown.name == self.repertoire.named:
                        session.tell(str(error))
                continue
            for session in list(self.sessions.values()):
                session.reloaded(self._first)

    def close(self) -> None:
        """End all sessions."""
        self._closing.set()
        self._watch.join()
        for session in list(self.sessions.values()):
            session.close()
        self.sessions.clear()
