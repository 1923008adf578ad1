r"""Locks so that one process at a time uses a rig: one for the oven's line and one for each chassis.

Locks need names of a device that are the same however it is written. One oven is at ``/dev/ttyUSB0`` and at
``/dev/serial/by-id/…``, at ``COM3`` and at ``\\.\COM3``; one gateway at ``localhost``, ``127.0.0.1`` and ``::1``,
or at its name and its address.
"""

import hashlib
import ipaddress
import logging
import os
import re
import socket
import stat
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from datetime import datetime
from pathlib import Path
from typing import BinaryIO
from urllib.parse import urlsplit

from drivers.exclusive import NameTakenError, is_still_there, take, take_name
from drivers.ni.cards import CardsSettings
from drivers.ovens.settings import OvenSettings
from drivers.rig.end_requests import RigStopped
from drivers.thermometers.thermometer import ThermometerSettings

log = logging.getLogger(__name__)


class RigInUse(RigStopped):
    """Another process of this computer uses the oven or the cards."""


class Occupation:
    """The locks of a rig that this process holds.

    Parameters
    ----------
    locks : sequence of file or socket
    """

    def __init__(self, locks: "Sequence[BinaryIO | socket.socket]") -> None:
        self._locks = tuple(locks)

    def filenos(self) -> tuple[int, ...]:
        """Return descriptors that hold the rig in every process that inherits them, as by ``pass_fds`` of Popen.

        The rig is free when the last of these processes has ended. Empty on Windows, where a lock is that of one
        process and cannot be inherited.
        """
        return () if sys.platform == "win32" else tuple(lock.fileno() for lock in self._locks)


HERE = "this computer"
"""Instead of every address of the computer itself: a gateway's program listens to all of them."""

_WINDOWS_PORT = re.compile(r"(?:[\\/]{2}[.?][\\/])?(COM[1-9][0-9]{0,3}):?", re.IGNORECASE)
_HOST_AND_PORT = re.compile(r"(\[[0-9A-Fa-f:.%]+\]|[^\s:/\\]+):([0-9]{1,5})")


def device_names(place: str) -> frozenset[str]:
    """Return all names under which others may know a place; the same device has at least one of them in common.

    Parameters
    ----------
    place : str
        ``oven at socket://lab:502``, ``cards cDAQ1 at lab:31763``, ``cards Dev1``.
    """
    what, at, where = place.partition(" at ")
    if not at:
        return frozenset({place.casefold()})
    return frozenset(f"{what.casefold()} at {name}" for name in _names(where.strip()))


def _names(where: str) -> set[str]:
    if port := _WINDOWS_PORT.fullmatch(where):
        return {port[1].upper()}
    if "://" in where:
        return _names_of_address(where)
    if "/" in where or "\\" in where or Path(where).exists():
        return _names_of_file(where)
    if found := _HOST_AND_PORT.fullmatch(where):
        return {f"{host}:{int(found[2])}" for host in _hosts(found[1].strip("[]"), int(found[2]))}
    return {where.casefold()}


def _names_of_address(where: str) -> set[str]:
    try:
        parts = urlsplit(where)
        host, port = parts.hostname, parts.port
    except ValueError:
        return {where.casefold()}
    if host is None:
        return {where.casefold()}
    rest = f"{parts.path}?{parts.query}".rstrip("?").rstrip("/")
    return {f"{parts.scheme}://{one}:{port}{rest}" for one in _hosts(host, port)}


def _names_of_file(where: str) -> set[str]:
    """Return the path behind all links, and the device's number, which another node of the same device shares."""
    path = os.path.normcase(os.path.realpath(where))
    # macOS has two nodes for each port, to call out and to be called
    names = {re.sub(r"^/dev/tty\.", "/dev/cu.", path)}
    try:
        found = Path(path).stat()
    except (OSError, ValueError):
        return names
    if stat.S_ISCHR(found.st_mode):
        names.add(f"character device {os.major(found.st_rdev)}:{os.minor(found.st_rdev)}")
    return names


def _hosts(host: str, port: int | None) -> set[str]:
    """Return a host's name and all its addresses, or `HERE`."""
    name = host.casefold().rstrip(".")
    if name == "localhost":  # also where no table of hosts says so
        return {HERE}
    try:
        found = socket.getaddrinfo(name, port or 0, type=socket.SOCK_STREAM)
    except (OSError, UnicodeError, OverflowError):
        return {name}
    return {name, *(_address(str(address[0])) for *_, address in found)}


def _address(text: str) -> str:
    address = ipaddress.ip_address(text.partition("%")[0])
    if isinstance(address, ipaddress.IPv6Address) and address.ipv4_mapped is not None:
        address = address.ipv4_mapped
    if address.is_loopback or address.is_unspecified or _is_own(address):
        return HERE
    return str(address)


def _is_own(address: ipaddress.IPv4Address | ipaddress.IPv6Address) -> bool:
    """Whether the address is one of this computer's: only to these a socket can be bound."""
    family = socket.AF_INET if address.version == 4 else socket.AF_INET6
    try:
        with socket.socket(family, socket.SOCK_DGRAM) as probe:
            probe.bind((str(address), 0))
    except OSError:
        return False
    return True


@contextmanager
def occupied(places: Sequence[str], does: str) -> Iterator[Occupation]:
    """Context manager that locks a rig for this process.

    Parameters
    ----------
    places : sequence of str
        Names of what only one process can use: ``oven at COM3``. They are compared as devices, whatever their
        spelling.
    does : str
        Purpose, shown to other processes that want the rig meanwhile.

    Raises
    ------
    RigInUse
        If another process uses one of them; the rig was not touched.
    """
    with ExitStack() as held:
        locks: list[BinaryIO | socket.socket] = []
        taken: set[str] = set()
        for place in places:
            for name in sorted(device_names(place) - taken):
                locks += _locks(place, name, does, held)
                taken.add(name)
        yield Occupation(locks)


def _locks(place: str, name: str, does: str, held: ExitStack) -> "list[BinaryIO | socket.socket]":
    """Take a device's name, then its file, which says who holds it and locks it where there are no such names."""
    path = _path(name)
    try:
        claimed = take_name(f"{path.stem}-{_digest(str(path.parent))}")
    except NameTakenError as error:
        raise RigInUse(f"the {place} is in use by {_holder(path)}", HOW_TO_STOP) from error
    locks: list[BinaryIO | socket.socket] = [] if claimed is None else [held.enter_context(claimed)]
    try:
        file = held.enter_context(_open(path))
        for _ in range(ATTEMPTS):
            try:
                take(file)
            except OSError as error:
                raise RigInUse(f"the {place} is in use by {_holder(path)}", HOW_TO_STOP) from error
            if is_still_there(file, path):
                break
            file = held.enter_context(_open(path))
    except OSError as error:
        if claimed is None:
            log.warning("%s cannot be locked, another process may use it as well: %s", place, error)
        return locks
    _sign(file, does)
    return [*locks, file]


ATTEMPTS = 5
"""A file that is removed between opening and locking is opened again so often."""

HOW_TO_STOP = (
    "Stop that one (Ctrl-C there, or flexura view on its campaign), which brings the rig to rest; where it "
    "does not answer, kill it and run flexura safe"
)


def in_use(places: Sequence[str]) -> str | None:
    """Describe the process that uses the rig; None if there is none."""
    try:
        with occupied(places, "flexura doctor"):
            return None
    except RigInUse as error:
        return error.what


def instrument_places(
    oven: OvenSettings | None, thermometer: ThermometerSettings | None, cards: CardsSettings | None
) -> tuple[str, ...]:
    """Return names of the instruments that only one process can use, for `occupied`.

    Returns
    -------
    tuple of str
        "oven at …", "thermometer at …", "cards …"; an instrument without a place is left out.
    """
    lines = [("oven", oven.place)] if oven is not None else []
    lines += [("thermometer", thermometer.place)] if thermometer is not None else []
    named = [f"{what} at {place}" for what, place in lines if place]
    return (*named, *(f"cards {place}" for place in (cards.places if cards is not None else ())))


def lock_folder() -> Path:
    """Return the folder of the locks, the same for all users of this computer, whatever their environment says."""
    if sys.platform == "win32":
        from platformdirs import site_data_path

        return site_data_path("flexura", appauthor=False)
    return Path("/var/tmp")  # noqa: S108 (not TMPDIR, which each user may set; links are not followed)


def _path(name: str) -> Path:
    return lock_folder() / f"flexura-rig-{_digest(name)}.lock"


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _open(path: Path) -> BinaryIO:
    """Open the file for reading, and for writing unless it belongs to another user: either can be locked."""
    if sys.platform == "win32":  # its folder is Flexura's own
        path.parent.mkdir(parents=True, exist_ok=True)
    flags = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    try:
        number = os.open(path, os.O_RDWR | os.O_CREAT | flags, 0o666)
    except PermissionError:
        return os.fdopen(os.open(path, os.O_RDONLY | flags), "rb")
    return os.fdopen(number, "r+b")


def _sign(file: BinaryIO, does: str) -> None:
    """Write into the file which process holds it; information only, the lock is the system's."""
    if file.writable():
        since = datetime.now().astimezone().isoformat(sep=" ", timespec="minutes")
        file.seek(0)
        file.write(f"process {os.getpid()} ({does}, since {since})".encode())
        file.truncate()
        file.flush()


def _holder(path: Path) -> str:
    try:
        signed = path.read_bytes()[:1000].decode()
    except (OSError, UnicodeDecodeError):
        return "another process"
    return signed if signed.startswith("process ") and signed.isprintable() else "another process"
