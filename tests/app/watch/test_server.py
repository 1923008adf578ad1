"""The page's server: read only, for this computer, or for those who have the token."""

import http.client
import json
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from app.watch import server as serving
from app.watch.server import NoPortError, Published, WatchServer, is_loopback, metrics, open_server
from app.watch.watcher import Watcher

TOKEN = "a-token-of-23-characters"  # noqa: S105
PATHS = ("/", "/page.css", "/page.js", "/status.json", "/metrics", "/campaigns/0", "/events")
Answer = tuple[int, dict[str, str], bytes]


@contextmanager
def served(folders: list[Path], token: str | None = None) -> Iterator[WatchServer]:
    watcher, published = Watcher(folders, lambda _: None), Published()
    statuses = watcher.look()
    published.publish(json.dumps(watcher.record(), allow_nan=False).encode(), metrics(statuses, 0, 0).encode())
    server = open_server("127.0.0.1", None, published, watcher.charts, token)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield server
    finally:
        published.end()
        server.shutdown()
        server.server_close()
        thread.join(10.0)


def ask(server: WatchServer, path: str, method: str = "GET", body: bytes | None = None, **headers: str) -> Answer:
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=30.0)
    try:
        connection.putrequest(method, path, skip_host="Host" in headers)
        for name, value in headers.items():
            connection.putheader(name, value)
        if body is not None:
            connection.putheader("Content-Length", str(len(body)))
        connection.endheaders(body)
        answer = connection.getresponse()
        events = path.startswith("/events") and answer.status == 200 and method == "GET"
        found = answer.readline() if events else answer.read()
        return answer.status, {name.lower(): value for name, value in answer.getheaders()}, found
    finally:
        connection.close()


@pytest.fixture
def server(finished: Path) -> Iterator[WatchServer]:
    with served([finished]) as found:
        yield found


@pytest.mark.parametrize("path", PATHS)
def test_every_address_forbids_all_that_is_not_its_own(server: WatchServer, path: str) -> None:
    status, headers, body = ask(server, path)
    assert status == 200
    assert "default-src 'none'" in headers["content-security-policy"]
    assert "unsafe" not in headers["content-security-policy"]
    assert (headers["x-content-type-options"], headers["referrer-policy"]) == ("nosniff", "no-referrer")
    assert body
    assert ask(server, path, "HEAD")[::2] == (200, b"")


def test_what_pages_load_is_here(server: WatchServer) -> None:
    for path in ("/", "/page.css", "/page.js"):
        text = ask(server, path)[2].decode()
        assert "https:" not in text
        assert [word for word in text.split() if "http:" in word and "www.w3.org/2000/svg" not in word] == []


def test_state_charts_and_metrics_hold_the_campaign(server: WatchServer, finished: Path) -> None:
    (state,) = json.loads(ask(server, "/status.json")[2])["campaigns"]
    assert (state["name"], state["state"], state["finished"]) == (finished.name, "complete", 6)
    charts = json.loads(ask(server, "/campaigns/0")[2])
    assert [mark["kind"] for mark in charts["marks"]] == ["finished"] * 6
    (sensor,) = charts["frfs"]["sensors"]
    peak = sensor["last"]["frequency"][sensor["last"]["level"].index(max(sensor["last"]["level"]))]
    assert peak == pytest.approx(600.0 * (1.0 - 0.01 * 14.0), rel=0.02)  # the resonance of the plate at 34 °C
    assert float(charts["frfs"]["last"].split()[0]) == pytest.approx(34.0, abs=0.4)  # as the programme allows
    assert [one["name"] for one in charts["levels"]["channels"]] == ["drive", "S1"]
    assert charts["log"][0]["words"].startswith(("oven at rest", "finished"))
    lines = ask(server, "/metrics")[2].decode().splitlines()
    assert f'flexura_sweeps_finished{{campaign="{finished.name}"}} 6.0' in lines
    assert f'flexura_state{{campaign="{finished.name}",state="complete"}} 1' in lines


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "BREW"])
def test_nothing_but_looking_is_allowed(server: WatchServer, method: str) -> None:
    status, headers, _ = ask(server, "/", method, b"x=1")
    assert (status, headers["allow"]) == (405, "GET, HEAD")


@pytest.mark.parametrize(
    "path",
    [
        "/../../etc/passwd",
        "/page.css/../page.py",
        "/%2e%2e/%2e%2e/etc/passwd",
        "//etc/passwd",
        "/campaigns/../0",
        "/campaigns/-1",
        "/campaigns/1",
        "/campaigns/99999",
        "/campaigns/0/protocol.json",
        "/campaigns/%30",
        "/campaigns/%C2%B2",
        "/watcher.py",
        "/page.js%00",
        "/C:\\windows",
    ],
)
def test_no_other_address_leads_anywhere(server: WatchServer, path: str) -> None:
    status, headers, body = ask(server, path)
    assert status == 404
    assert body == (b"No such campaign.\n" if body.startswith(b"No such c") else b"No such page.\n")
    assert headers["content-type"] == "text/plain"


def test_a_page_from_elsewhere_cannot_name_this_computer_its_own(server: WatchServer) -> None:
    port = server.server_port
    for host in ("evil.example", f"evil.example:{port}", "127.0.0.1.evil.example", "", "[::1", "192.168.0.2"):
        assert ask(server, "/status.json", Host=host)[0] == 421
    for host in ("localhost", f"localhost:{port}", "127.0.0.1", f"[::1]:{port}", "127.0.0.2"):
        assert ask(server, "/status.json", Host=host)[0] == 200


def test_with_a_token_nothing_is_told_without_it(finished: Path, capfd: pytest.CaptureFixture[str]) -> None:
    with served([finished], TOKEN) as server:
        for path in PATHS:
            if path != "/page.css":
                status, headers, body = ask(server, path)
                assert status == 401
                assert headers["www-authenticate"].startswith("Bearer")
                assert finished.name.encode() not in body
        for given in ("wrong", TOKEN[:-1], TOKEN + "x", "%00", "é"):
            assert ask(server, f"/?token={given.encode().hex() if given == 'é' else given}")[0] == 401
            assert ask(server, "/status.json", Authorization=f"Bearer {given}")[0] == 401
            assert ask(server, "/status.json", Cookie=f"flexura-watch={given}")[0] == 401
        assert ask(server, "/status.json", Authorization=f"Bearer {TOKEN}")[0] == 200
        assert (
            ask(server, "/status.json", Cookie=f"flexura-watch={TOKEN}")[0] == 401
        )  # the cookie is not the token
        status, headers, _ = ask(server, f"/?token={TOKEN}")
        assert (status, headers["location"]) == (303, "/")
        cookie = headers["set-cookie"]
        assert TOKEN not in cookie
        assert "HttpOnly" in cookie
        assert "SameSite=Strict" in cookie
        assert ask(server, "/status.json", Cookie=cookie.split(";")[0])[0] == 200
        assert ask(server, f"//evil.example/?token={TOKEN}")[1]["location"] == "/"
        assert ask(server, "/", Host="any.example", Authorization=f"Bearer {TOKEN}")[0] == 200
    assert TOKEN not in "".join(capfd.readouterr())


def test_tokens_are_compared_in_constant_time(finished: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compared = []
    constant = serving.hmac.compare_digest
    monkeypatch.setattr(serving.hmac, "compare_digest", lambda a, b: compared.append((a, b)) or constant(a, b))
    with served([finished], TOKEN) as server:
        ask(server, "/", Authorization="Bearer x")
        ask(server, "/?token=y")
    assert [a for a, _ in compared] == [b"x", b"y"]


def test_listeners_hear_every_change_until_the_end(finished: Path) -> None:
    with served([finished]) as server:
        connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=30.0)
        connection.request("GET", "/events")
        answer = connection.getresponse()
        assert answer.getheader("Content-Type") == "text/event-stream"
        assert answer.readline().startswith(b"data: {")
        assert answer.readline() == b"\n"
        server.published.publish(b'{"next": 1}', b"")
        assert answer.readline() == b'data: {"next": 1}\n'
        server.published.end()
        answer.read()
        connection.close()


def test_too_many_are_asked_to_come_later(finished: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serving, "LISTENERS", 3)
    monkeypatch.setattr(serving, "CONNECTIONS", 6)
    with served([finished]) as server, ExitStack() as held:

        def connected() -> socket.socket:
            return held.enter_context(socket.create_connection(("127.0.0.1", server.server_port), timeout=30.0))

        for _ in range(3):
            one = connected()
            one.sendall(b"GET /events HTTP/1.0\r\nHost: localhost\r\n\r\n")
            assert one.recv(15).endswith(b"200 OK"[:6])
        assert ask(server, "/events")[0] == 503
        for _ in range(3):
            connected()

        def ask_until_refused() -> None:
            until = time.monotonic() + 30.0
            while time.monotonic() < until:  # the server has not seen yet all that say nothing
                ask(server, "/")

        with pytest.raises((http.client.HTTPException, OSError)):
            ask_until_refused()
        held.close()
        server.published.publish(b"{}", b"")
        until = time.monotonic() + 30.0
        while True:
            try:
                assert ask(server, "/")[0] == 200
                break
            except (http.client.HTTPException, OSError):
                assert time.monotonic() < until
                time.sleep(0.1)


def test_a_port_that_is_taken_is_named() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(NoPortError, match=rf"port {port}: cannot be used .*name a free one with --port"):
            open_server("127.0.0.1", port, Published(), lambda _: None, None)
    with pytest.raises(NoPortError, match="no address of this computer"):
        open_server("no such host", None, Published(), lambda _: None, None)


def test_loopback_is_told_from_the_rest() -> None:
    assert [is_loopback(host) for host in ("localhost", "127.0.0.1", "::1", "127.9.9.9")] == [True] * 4
    assert [is_loopback(host) for host in ("0.0.0.0", "::", "10.0.0.1", "example.org", "")] == [False] * 5  # noqa: S104
