"""Locks so that one process at a time uses a rig: one for the oven's line and one for each chassis."""

import hashlib
import logging
import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from datetime import datetime
from pathlib import Path
from typing import BinaryIO

from drivers.exclusive import take
from drivers.ni.cards import CardsSettings
from drivers.ovens.settings import OvenSettings
from drivers.rig.errors import RigStopped
from drivers.thermometers.settings import ThermometerSettings

log = logging.getLogger(__name__)


class RigInUse(RigStopped):
    """Another process of this computer uses the oven or the cards."""


@contextmanager
def occupied(places: Sequence[str], does: str) -> Iterator[None]:
    """Context manager that locks a rig for this process.

    Parameters
    ----------
    places : sequence of str
        Names of what only one process can use, equal in all processes: ``oven at COM3``.
    does : str
        Purpose, shown to other processes that want the rig meanwhile.

    Raises
    ------
    RigInUse
        If another process uses one of them; the rig was not touched.
    """
    with ExitStack() as held:
        for place in places:
            path = _path(place)
            try:
                file = held.enter_context(_open(path))
            except OSError as error:
                log.warning("%s cannot be locked, another process may use it as well: %s", place, error)
                continue
            try:
                take(file)
            except OSError as error:
                raise RigInUse(f"the {place} is in use by {_holder(path)}", HOW_TO_STOP) from error
            _sign(file, does)
        yield


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
    """Return names of the instruments that only one process can use, equal in all processes.

    Parameters
    ----------
    oven : OvenSettings or None
    thermometer : ThermometerSettings or None
    cards : CardsSettings or None

    Returns
    -------
    tuple of str
        "oven at …", "thermometer at …", "cards …"; an instrument without a place is left out.
    """
    lines = [("oven", oven.place)] if oven is not None else []
    lines += [("thermometer", thermometer.place)] if thermometer is not None else []
    named = [f"{what} at {_line(place)}" for what, place in lines if place]
    return (*named, *(f"cards {place}" for place in (cards.places if cards is not None else ())))


def _line(place: str) -> str:
    """Return one name for a port that has several."""
    if "://" in place:
        return place.lower()
    return str(Path(place).resolve()) if Path(place).is_absolute() else place


def lock_folder() -> Path:
    """Return the folder of the locks: one for all users of this computer, if the system has one."""
    return Path(tempfile.gettempdir())


def _path(place: str) -> Path:
    return lock_folder() / f"flexura-rig-{hashlib.sha256(place.encode()).hexdigest()[:16]}.lock"


def _open(path: Path) -> BinaryIO:
    """Open the file for reading, and for writing unless it belongs to another user: either can be locked."""
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
