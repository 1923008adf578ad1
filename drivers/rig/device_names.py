r"""Names of a device that are the same however it is written: for locks.

One oven is at ``/dev/ttyUSB0`` and at ``/dev/serial/by-id/…``, at ``COM3`` and at ``\\.\COM3``; one gateway at
``localhost``, ``127.0.0.1`` and ``::1``, or at its name and its address.
"""

import ipaddress
import os
import re
import socket
import stat
from pathlib import Path
from urllib.parse import urlsplit

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
