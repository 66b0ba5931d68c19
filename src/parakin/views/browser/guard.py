"""Who may connect: the page that is served, and programs of this computer.

Any page that is open in the same browser can reach the loopback address, and a name of another
site can be made to lead there. Both are told by the headers that browsers send, and refused before
a WebSocket is opened.
"""

from __future__ import annotations

import asyncio
import contextlib
import ipaddress
import logging
import socket
import threading
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

if TYPE_CHECKING:
    from websockets import Headers

_CLOSING = 1.0  # [s] that the other side has to close what is closed here
_PATCHING = threading.Lock()


def is_loopback(host: str) -> bool:
    """Whether an address can be reached from this computer only."""
    if host.casefold() == "localhost":
        return True
    address = _address(host)
    return address is not None and address.is_loopback


def refusal(headers: Headers, host: str, port: int) -> str:
    """Why a request to the server at an address is refused; "" if it is not.

    Its Host must be the server's: at the loopback address with the very port, elsewhere any number,
    or a name of this computer. Its Origin, which browsers send, must be exactly that host and port.
    """
    hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
    if len(hosts) != 1 or len(origins) > 1:
        return "one Host and at most one Origin are expected"
    name, at = _parts(f"//{hosts[0]}")
    if not _is_own(name, at, host, port):
        return "this host is not the one that the page is served at"
    if origins and not any(
        _parts(origins[0], scheme) == (name, at) for scheme in ("http", "https")
    ):
        return "pages of other sites are not served"
    return ""


def _is_own(name: str, at: int | None, host: str, port: int) -> bool:
    if is_loopback(host):
        known = {"localhost", "127.0.0.1", "::1", host.casefold()}
        return name in known and (80 if at is None else at) == port
    known = {host.casefold(), "localhost", socket.gethostname().casefold()}
    return name in known or name.removesuffix(".local") in known or _address(name) is not None


def _parts(url: str, scheme: str = "") -> tuple[str, int | None]:
    """Name and port of an origin of a scheme, or of a Host after slashes; no name if it is none."""
    try:
        split = urlsplit(url)
        if split.scheme != scheme or split.netloc.count("@") or split.path.strip("/"):
            return "", None
        if split.query or split.fragment:
            return "", None
        return split.hostname or "", split.port
    except ValueError:
        return "", None


def _address(host: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    try:
        return ipaddress.ip_address(host)
    except ValueError:
        return None


@contextlib.contextmanager
def guarded(host: str) -> Iterator[None]:
    """Servers of viser started within answer a 403, and no WebSocket, to what `refusal` refuses.

    They close what sends nonsense, and print nothing about either. viser has no option for it: it
    is done where viser calls websockets, so that no connection comes before it.
    """
    import websockets.asyncio.server as sockets

    with _PATCHING:
        serve = sockets.serve

        def guarding(handler: Any, *arguments: Any, process_request: Any, **options: Any) -> Any:
            def asked(connection: Any, request: Any) -> Any:
                why = refusal(request.headers, host, connection.local_address[1])
                if why:
                    return connection.respond(403, f"Refused: {why}.\n")
                return process_request(connection, request)

            async def handled(connection: Any) -> None:
                # Messages of the right form with nonsense in them fail in tasks of their own.
                asyncio.get_running_loop().set_exception_handler(lambda *_: None)
                try:
                    await handler(connection)
                except Exception:  # whatever nonsense makes viser raise
                    await connection.close(1002)

            silent = logging.getLogger("parakin.view")
            silent.disabled = True
            options |= {"logger": silent, "close_timeout": _CLOSING}
            return serve(handled, *arguments, process_request=asked, **options)

        sockets.serve = guarding  # type: ignore[assignment,misc]
        try:
            yield
        finally:
            sockets.serve = serve  # type: ignore[misc]
