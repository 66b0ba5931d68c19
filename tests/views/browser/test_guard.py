"""Who may connect: raw sockets, and real browsers from other sites and other ports."""

from __future__ import annotations

import base64
import http.server
import os
import socket
import threading
from collections.abc import Iterator
from typing import Any

import pytest
from browser import ELSEWHERE, chromium, needs_chromium
from websockets import Headers

from parakin.views.browser.content import Content
from parakin.views.browser.guard import refusal
from parakin.views.browser.viewer import Viewer, serving


@pytest.fixture(scope="module")
def viewer() -> Iterator[Viewer]:
    with serving(Content("four-bar"), port=0) as found:
        yield found


@pytest.mark.parametrize(
    ("served", "host", "origin", "taken"),
    [
        ("127.0.0.1", "127.0.0.1:8080", None, True),
        ("127.0.0.1", "127.0.0.1:8080", "http://127.0.0.1:8080", True),
        ("127.0.0.1", "LOCALHOST:8080", "http://localhost:8080", True),
        ("localhost", "127.0.0.1:8080", "http://127.0.0.1:8080", True),
        ("::1", "[::1]:8080", "http://[::1]:8080", True),
        ("127.0.0.9", "127.0.0.9:8080", "http://127.0.0.9:8080", True),
        ("127.0.0.1", "127.0.0.1:8080", "http://localhost:8080", False),
        ("127.0.0.1", "127.0.0.1:8080", "http://127.0.0.1:8081", False),
        ("127.0.0.1", "127.0.0.1:8080", "http://127.0.0.1", False),
        ("127.0.0.1", "127.0.0.1:8080", "https://elsewhere.example", False),
        ("127.0.0.1", "127.0.0.1:8080", "http://127.0.0.1:8080.elsewhere.example", False),
        ("127.0.0.1", "127.0.0.1:8080", "http://127.0.0.1:8080@elsewhere.example", False),
        ("127.0.0.1", "127.0.0.1:8080", "file://127.0.0.1:8080", False),
        ("127.0.0.1", "127.0.0.1:8080", "null", False),
        ("127.0.0.1", "127.0.0.1:8080", "", False),
        ("127.0.0.1", "127.0.0.1:8081", None, False),
        ("127.0.0.1", "127.0.0.1", None, False),
        ("127.0.0.1", "elsewhere.example:8080", None, False),
        ("127.0.0.1", "elsewhere.example:8080", "http://elsewhere.example:8080", False),
        ("127.0.0.1", "192.168.0.1:8080", None, False),
        ("127.0.0.1", "127.0.0.1:80a", None, False),
        ("127.0.0.1", "", None, False),
        ("0.0.0.0", "192.168.0.1:8080", "http://192.168.0.1:8080", True),
        ("0.0.0.0", "192.168.0.1:9000", "https://192.168.0.1:9000", True),
        ("0.0.0.0", "localhost:8080", None, True),
        ("0.0.0.0", f"{socket.gethostname()}:8080", None, True),
        ("0.0.0.0", "192.168.0.1:8080", "http://elsewhere.example", False),
        ("0.0.0.0", "elsewhere.example:8080", "http://elsewhere.example:8080", False),
    ],
)
def test_who_is_refused(served: str, host: str, origin: str | None, taken: bool) -> None:
    headers = Headers(Host=host) if origin is None else Headers(Host=host, Origin=origin)
    assert (refusal(headers, served, 8080) == "") == taken


def test_at_the_port_of_http_browsers_name_none() -> None:
    assert not refusal(Headers(Host="localhost", Origin="http://localhost"), "127.0.0.1", 80)


@pytest.mark.parametrize("twice", ["Host", "Origin"])
def test_headers_that_contradict_one_another_are_refused(twice: str) -> None:
    headers = Headers(Host="127.0.0.1:8080", Origin="http://127.0.0.1:8080")
    headers[twice] = headers[twice]
    assert refusal(headers, "127.0.0.1", 8080)
    assert refusal(Headers(), "127.0.0.1", 8080)


def _asked(viewer: Viewer, host: str, origin: str | None = None, then: bytes = b"") -> bytes:
    """All that a WebSocket's handshake, and what follows it, is answered until the end."""
    import viser

    headers = {
        "Host": host,
        "Upgrade": "websocket",
        "Connection": "Upgrade",
        "Sec-WebSocket-Key": base64.b64encode(os.urandom(16)).decode(),
        "Sec-WebSocket-Version": "13",
        "Sec-WebSocket-Protocol": f"viser-v{viser.__version__}",
    }
    headers |= {} if origin is None else {"Origin": origin}
    lines = [f"{name}: {value}" for name, value in headers.items()]
    with socket.create_connection(("127.0.0.1", viewer.server.get_port())) as asking:
        asking.sendall("\r\n".join(["GET / HTTP/1.1", *lines, "", ""]).encode() + then)
        answer = b""
        while some := asking.recv(65536):  # until the other side closes
            answer += some
    return answer


@pytest.mark.parametrize("what", ["origin", "port", "host", "null"])
def test_others_get_a_403_and_not_a_byte_more(viewer: Viewer, what: str) -> None:
    port = viewer.server.get_port()
    host, origin = f"127.0.0.1:{port}", f"http://127.0.0.1:{port}"
    host = f"{ELSEWHERE}:{port}" if what == "host" else host
    wrong = {"origin": f"http://{ELSEWHERE}:{port}", "null": "null"}
    origin = wrong.get(what, f"http://127.0.0.1:{port + 1}" if what == "port" else origin)
    answer = _asked(viewer, host, origin)
    assert answer.startswith(b"HTTP/1.1 403 Forbidden")
    assert b"Upgrade: websocket" not in answer
    assert answer.count(b"Refused: ") == 1
    assert answer.endswith(b".\n")
    assert not viewer.server.get_clients()


@pytest.mark.parametrize(
    "nonsense",
    [
        b"\x81\x85\0\0\0\0hello",  # text
        b"\x82\x85\0\0\0\0hello",  # no message
        b"\x82\x80\0\0\0\0",
        b"\x82\x83\0\0\0\0\x81\xa4\xff",
        b"\x83\x81\0\0\0\0x",  # no frame of this kind
        b"\xff" * 50,
        b"GET / HTTP/1.1\r\n\r\n",
    ],
)
def test_who_sends_nonsense_is_closed_and_nothing_is_printed(
    nonsense: bytes, viewer: Viewer, capfd: pytest.CaptureFixture[str]
) -> None:
    _asked(viewer, f"127.0.0.1:{viewer.server.get_port()}", None, nonsense)  # until it is closed
    with socket.create_connection(("127.0.0.1", viewer.server.get_port())) as asking:
        asking.sendall(nonsense + b"\r\n\r\n")
        while asking.recv(65536):
            pass
    assert capfd.readouterr() == ("", "")


class _Quiet(http.server.SimpleHTTPRequestHandler):
    def do_GET(self) -> None:
        self.send_response(200)
        self.end_headers()
        self.wfile.write(b"<title>another page</title>")

    def log_message(self, *_: Any) -> None:
        pass


LISTEN = """([url, version]) => new Promise(done => {
    let bytes = 0;
    const socket = new WebSocket(url, [version]);
    socket.onmessage = message => { bytes += message.data.size; };
    socket.onopen = () => { bytes += 1; };
    socket.onclose = () => done(bytes);
})"""


@needs_chromium
@pytest.mark.parametrize("site", [ELSEWHERE, "127.0.0.1", "localhost"])
def test_a_page_elsewhere_gets_not_a_byte(site: str, viewer: Viewer) -> None:
    import viser

    other = http.server.ThreadingHTTPServer(("127.0.0.1", 0), _Quiet)
    threading.Thread(target=other.serve_forever, daemon=True).start()
    port = viewer.server.get_port()
    with chromium() as browser:
        page = browser.new_page()
        page.goto(f"http://{site}:{other.server_address[1]}/")
        for name in ("127.0.0.1", "localhost", ELSEWHERE):
            url = [f"ws://{name}:{port}", f"viser-v{viser.__version__}"]
            assert page.evaluate(LISTEN, url) == 0
        rebound = page.goto(f"http://{ELSEWHERE}:{port}/")
        assert rebound.status == 403
        page.close()
    other.shutdown()
    other.server_close()
    assert not viewer.sessions
