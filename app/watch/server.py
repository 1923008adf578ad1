"""The page's server: a few addresses, all read only, none of them a file of the disk; metrics for Prometheus.

``http.server`` of the standard library is enough: no body is read, every answer is made before it is asked for or
in milliseconds, and whoever listens to events costs a thread that sleeps. What it leaves to its user is here:
limits of time and number, headers that forbid everything from elsewhere, and a log that holds no address (a token
may stand in it).
"""

import hmac
import ipaddress
import secrets
import socket
import threading
from collections.abc import Callable, Sequence
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from typing import Any, get_args
from urllib.parse import parse_qs, urlsplit

from app.files.bad_file import ResultFileError
from app.watch.status import CampaignStatus, Standing

PORT = 8750
"""Of the page where none is named; above 1023, so that no rights are needed."""
PORTS = 50
"""Ports from `PORT` on that are tried where none is named."""
CLIENT_TIMEOUT = 20.0
"""Seconds after which a client that sends or takes nothing is left."""
CONNECTIONS, LISTENERS = 250, 150
"""At a time; whoever comes then is asked to come later."""
HEARTBEAT = 10.0
"""Seconds between two signs of life to a listener: it sees that the watcher lives, and we that it does."""
COOKIE = "flexura-watch"
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self' data:; base-uri 'none'; form-action 'self'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-store",
}
FILES = {
    "/": ("page.html", "text/html; charset=utf-8"),
    "/page.css": ("page.css", "text/css; charset=utf-8"),
    "/page.js": ("page.js", "text/javascript; charset=utf-8"),
}
Charts = Callable[[int], bytes | None]


class NoPortError(ResultFileError):
    """The server cannot listen where it is asked to."""


class Published:
    """What is told to listeners: the last state, and a wait for the next.

    Attributes
    ----------
    state : bytes
        JSON.
    metrics : bytes
    """

    def __init__(self) -> None:
        self.state, self.metrics = b"{}", b""
        self._number = 0
        self._next = threading.Condition()
        self.ended = False

    def publish(self, state: bytes, metrics: bytes) -> None:
        """Replace the state, and wake all who wait."""
        with self._next:
            self.state, self.metrics = state, metrics
            self._number += 1
            self._next.notify_all()

    def end(self) -> None:
        """Let all listeners go."""
        with self._next:
            self.ended = True
            self._next.notify_all()

    def after(self, number: int, seconds: float) -> tuple[int, bytes | None]:
        """Wait for a state later than `number`; return its number and it, or None where none came."""
        with self._next:
            self._next.wait_for(lambda: self._number != number or self.ended, seconds)
            return self._number, self.state if self._number != number else None


class WatchServer(ThreadingHTTPServer):
    """Serves the page.

    Parameters
    ----------
    address : (str, int)
        Host and port.
    family : socket.AddressFamily
    published : Published
    charts : callable
        Of a campaign's number.
    token : str or None
        None: whoever reaches the port may look, under the names of this computer only.
    """

    daemon_threads = True
    block_on_close = False
    allow_reuse_address = socket.SO_REUSEADDR != 4  # on Windows it would let two programs share a port
    request_queue_size = 64

    def __init__(
        self,
        address: tuple[str, int],
        family: socket.AddressFamily,
        published: Published,
        charts: Charts,
        token: str | None,
    ) -> None:
        self.address_family = family
        self.published, self.charts, self.token = published, charts, token
        self.session = secrets.token_urlsafe(24)
        self.listeners = threading.BoundedSemaphore(LISTENERS)
        self.files = {
            path: (files("app.watch").joinpath(name).read_bytes(), kind) for path, (name, kind) in FILES.items()
        }
        self._connections = threading.BoundedSemaphore(CONNECTIONS)
        super().__init__(address, _Handler)

    def server_bind(self) -> None:
        """Bind, without asking a name server what this host is called."""
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, int(self.allow_reuse_address))
        self.socket.bind(self.server_address)
        self.server_address = self.socket.getsockname()
        self.server_name, self.server_port = str(self.server_address[0]), int(self.server_address[1])

    def process_request(self, request: Any, client_address: Any) -> None:
        """Give a connection its thread; close it at once where there are too many."""
        if not self._connections.acquire(blocking=False):
            self.shutdown_request(request)
            return
        super().process_request(request, client_address)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Answer, and give the place back."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._connections.release()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of clients that went away."""


class _Handler(BaseHTTPRequestHandler):
    server: WatchServer
    timeout = CLIENT_TIMEOUT
    server_version, sys_version = "flexura", ""
    error_message_format = "%(code)d %(message)s\n"
    error_content_type = "text/plain; charset=utf-8"

    def log_message(self, format: str, *args: Any) -> None:
        """Write no log: an address may hold a token."""

    def do_GET(self) -> None:
        """Answer."""
        address = urlsplit(self.path)
        if self.server.token is None and not self._is_ours():
            self._answer(
                b"This page is reached as localhost only.\n", "text/plain", HTTPStatus.MISDIRECTED_REQUEST
            )
        elif self.server.token is not None and (given := parse_qs(address.query).get("token")):
            self._log_in(given[0])
        elif self.server.token is not None and not self._is_known():
            self._refuse()
        elif address.path == "/events":
            self._tell_events()
        else:
            self._answer_to(address.path)

    do_HEAD = do_GET  # noqa: N815 (the names of the base class)

    def __getattr__(self, name: str) -> Callable[[], None]:
        """Answer every other method in the same way, whatever its name."""
        if name.startswith("do_"):
            return self._not_allowed
        raise AttributeError(name)

    def _not_allowed(self) -> None:
        self._answer(b"Only GET and HEAD.\n", "text/plain", HTTPStatus.METHOD_NOT_ALLOWED, {"Allow": "GET, HEAD"})

    def _answer_to(self, path: str) -> None:
        number = path.removeprefix("/campaigns/")
        if path in self.server.files:
            self._answer(*self.server.files[path])
        elif path == "/status.json":
            self._answer(self.server.published.state, "application/json")
        elif path == "/metrics":
            self._answer(self.server.published.metrics, FORM)
        elif number != path and number.isascii() and number.isdigit() and len(number) < 5:
            charts = self.server.charts(int(number))
            if charts is None:
                self._answer(b"No such campaign.\n", "text/plain", HTTPStatus.NOT_FOUND)
            else:
                self._answer(charts, "application/json")
        else:
            self._answer(b"No such page.\n", "text/plain", HTTPStatus.NOT_FOUND)

    def _answer(
        self, body: bytes, kind: str, status: HTTPStatus = HTTPStatus.OK, more: dict[str, str] | None = None
    ) -> None:
        self.send_response(status)
        headers = HEADERS | {"Content-Type": kind, "Content-Length": str(len(body))} | (more or {})
        for name, value in headers.items():
            self.send_header(name, value)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)

    def _tell_events(self) -> None:
        """Send the state whenever it changes, as Server-Sent Events, until the listener goes."""
        if not self.server.listeners.acquire(blocking=False):
            self._answer(
                b"Too many listeners.\n", "text/plain", HTTPStatus.SERVICE_UNAVAILABLE, {"Retry-After": "60"}
            )
            return
        try:
            self.send_response(HTTPStatus.OK)
            for name, value in (HEADERS | {"Content-Type": "text/event-stream"}).items():
                self.send_header(name, value)
            self.end_headers()
            number = -1
            while self.command != "HEAD" and not self.server.published.ended:
                number, state = self.server.published.after(number, HEARTBEAT)
                self.wfile.write(b": alive\n\n" if state is None else b"data: " + state + b"\n\n")
                self.wfile.flush()
        except OSError:  # it has gone, or takes nothing any more
            return
        finally:
            self.server.listeners.release()

    def _log_in(self, given: str) -> None:
        """Take a token from the address: a cookie takes its place, so that it stands in no history."""
        if not self._same(given):
            self._refuse()
            return
        cookie = f"{COOKIE}={self.server.session}; HttpOnly; SameSite=Strict; Path=/"
        path = urlsplit(self.path).path
        to = path if path in (*self.server.files, "/status.json", "/metrics") else "/"
        self._answer(b"", "text/plain", HTTPStatus.SEE_OTHER, {"Location": to, "Set-Cookie": cookie})

    def _refuse(self) -> None:
        body = (
            b"<!doctype html><html lang=en><meta charset=utf-8><title>Flexura</title>"
            b"<meta name=viewport content='width=device-width, initial-scale=1'>"
            b"<link rel=stylesheet href=/page.css><body><form action=/ method=get>"
            b"<label>token <input name=token type=password autocomplete=current-password></label> "
            b"<button>look</button></form>"
        )
        if urlsplit(self.path).path == "/page.css":  # the form's own looks hold no secret
            self._answer(*self.server.files["/page.css"])
            return
        self._answer(
            body,
            "text/html; charset=utf-8",
            HTTPStatus.UNAUTHORIZED,
            {"WWW-Authenticate": 'Bearer realm="flexura"'},
        )

    def _is_known(self) -> bool:
        kind, _, given = self.headers.get("Authorization", "").partition(" ")
        if kind.lower() == "bearer" and self._same(given.strip()):
            return True
        try:
            cookie = SimpleCookie(self.headers.get("Cookie", "")).get(COOKIE)
        except CookieError:
            return False
        mine = self.server.session.encode()
        return cookie is not None and hmac.compare_digest(cookie.value.encode(errors="replace"), mine)

    def _same(self, given: str) -> bool:
        token = (self.server.token or "").encode()
        return hmac.compare_digest(given.encode(errors="replace"), token)

    def _is_ours(self) -> bool:
        """Whether the request names this computer: a page from elsewhere may have its own name point here."""
        try:
            name = urlsplit(f"//{self.headers.get('Host', '')}").hostname
        except ValueError:
            return False
        return name is not None and (name == "localhost" or is_loopback(name))


def is_loopback(host: str) -> bool:
    """Whether only this computer reaches a host's address."""
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def open_server(
    host: str, port: int | None, published: Published, charts: Charts, token: str | None
) -> WatchServer:
    """Open the server where it is asked to listen.

    Parameters
    ----------
    host : str
        A name or address of this computer.
    port : int or None
        None: the first free one from `PORT` on.

    Returns
    -------
    WatchServer
        Bound; `serve_forever` serves.

    Raises
    ------
    NoPortError
        Where nothing is free, or the host is not this computer's.
    """
    try:
        family, _, _, _, where = socket.getaddrinfo(host, port or PORT, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError) as error:
        raise NoPortError(f"--host {host}: no address of this computer ({error})") from error
    wrong: OSError | None = None
    for one in [port] if port is not None else range(PORT, PORT + PORTS):
        try:
            return WatchServer((str(where[0]), one), family, published, charts, token)
        except OSError as error:
            wrong = error
    ports = f"{port}" if port is not None else f"{PORT} to {PORT + PORTS - 1}"
    reason = wrong.strerror if wrong is not None else ""
    raise NoPortError(f"--host {host}, port {ports}: cannot be used ({reason}); name a free one with --port")


FORM = "text/plain; version=0.0.4; charset=utf-8"
Value = Callable[[CampaignStatus], float | None]
GAUGES: tuple[tuple[str, str, Value], ...] = (
    ("air_celsius", "Temperature of the air in the oven.", lambda one: one.air),
    ("plate_celsius", "Temperature of the plate.", lambda one: one.plate),
    ("set_point_celsius", "Set-point that follows from the commands sent.", lambda one: one.set_point),
    ("limit_coldest_celsius", "Temperature below which the campaign stops.", lambda one: one.coldest),
    ("limit_hottest_celsius", "Temperature above which the campaign stops.", lambda one: one.hottest),
    ("sweeps_finished", "Sweeps that were kept.", lambda one: one.finished),
    ("sweeps_given_up", "Sweeps that were given up.", lambda one: one.missing),
    ("sweeps_asked", "Sweeps of the whole campaign.", lambda one: one.total),
    ("sweeps_doubted", "Finished sweeps whose temperature is in doubt.", lambda one: one.doubted),
    ("left_seconds", "Estimate of the time to the end.", lambda one: one.seconds_left),
    ("silent_seconds", "Time since anything was written.", lambda one: one.silent_for),
    ("patience_seconds", "Time without a sign that is no reason to worry.", lambda one: one.patience),
    ("channels_clipping", "Channels of the last repeat that clipped.", lambda one: len(one.clipping)),
    ("not_at_rest", "1: something could not be verified to be at rest.", lambda one: float(bool(one.unsafe))),
)


def metrics(statuses: Sequence[CampaignStatus], delivered: int, failed: int) -> str:
    """Return the page that Prometheus reads.

    Parameters
    ----------
    delivered, failed : int
        Messages told, and those that could not be.

    Returns
    -------
    str
        What is not known has no line.
    """
    lines = []
    for name, text, value in GAUGES:
        lines += _head(f"flexura_{name}", text, "gauge")
        for one in statuses:
            found = value(one)
            if found is not None:
                lines.append(f'flexura_{name}{{campaign="{_label(one.name)}"}} {float(found)!r}')
    lines += _head("flexura_state", "1 for the state that the campaign is in.", "gauge")
    for one in statuses:
        for state in get_args(Standing):
            labels = f'campaign="{_label(one.name)}",state="{state}"'
            lines.append(f"flexura_state{{{labels}}} {int(one.state == state)}")
    lines += _head("flexura_messages_total", "Messages, by what became of them.", "counter")
    for became, count in (("told", delivered), ("failed", failed)):
        lines.append(f'flexura_messages_total{{became="{became}"}} {count}')
    return "\n".join(lines) + "\n"


def _head(name: str, text: str, kind: str) -> list[str]:
    return [f"# HELP {name} {text}", f"# TYPE {name} {kind}"]


def _label(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
