"""Messages between the campaign's process and the watchdog's: one JSON object each, nothing else.

What the watchdog's process is told when it starts is declared here, too.
"""

import json
import threading
from collections.abc import Mapping
from typing import Annotated, Any, BinaryIO

from pydantic import Field

from analysis.declaration.strict import Declared
from analysis.protocol.limits import Limits
from drivers.ovens.error import Fault, OvenError
from drivers.rig.end_requests import RigStopped
from drivers.watchdog.guard import RestRule

BEAT = 1.0
"""Interval at which each process tells the other that it is alive, s."""
LONGEST = 65_536
"""Bytes of a line; a longer one is nonsense."""


class Messages:
    """Writes lines, from several threads, to a pipe whose other end may be gone.

    Parameters
    ----------
    pipe : file
        Unbuffered.
    """

    def __init__(self, pipe: BinaryIO) -> None:
        self._pipe = pipe
        self._turn = threading.Lock()

    def send(self, **line: Any) -> bool:
        """Write a line; return whether the other end took it."""
        data = json.dumps(line).encode() + b"\n"
        try:
            with self._turn:
                self._pipe.write(data)
                self._pipe.flush()
        except (OSError, ValueError):  # ValueError: closed on this side
            return False
        return True

    def close(self) -> None:
        """Close the pipe."""
        try:
            self._pipe.close()
        except (OSError, ValueError):
            return


def received(pipe: BinaryIO) -> dict[str, Any] | None:
    """Return the next line; None where the other end is gone."""
    try:
        line = pipe.readline(LONGEST)
        found = json.loads(line) if line.endswith(b"\n") else None
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) else None


def packed(error: BaseException) -> dict[str, Any]:
    """Return an error as it travels."""
    if isinstance(error, OvenError):
        return {"oven": [str(error.fault), error.what, error.advice, error.code]}
    if isinstance(error, RigStopped):
        return {"stopped": [error.what, error.next_step]}
    if isinstance(error, ValueError):
        return {"value": f"{error}"}
    return {"stopped": [f"the watchdog: {type(error).__name__}: {error}", "Report this"]}


def unpacked(packed_error: Mapping[str, Any]) -> Exception:
    """Return the error that travelled."""
    if "oven" in packed_error:
        fault, what, advice, code = packed_error["oven"]
        return OvenError(Fault(fault), what, advice, code)
    if "stopped" in packed_error:
        return RigStopped(*packed_error["stopped"])
    return ValueError(packed_error["value"])


class WatchdogSettings(Declared):
    """First line on the standard input of the watchdog."""

    oven: Annotated[Mapping[str, Any], Field(description="the [oven] of the experiment, as its kind declares it")]
    limits: Limits
    cards: Annotated[
        Mapping[str, Any] | None, Field(description="the [cards], to bring the drive to 0 V; None: not its task")
    ] = None
    rest: Annotated[RestRule, Field(description="when the oven, switched off, counts as at rest")]
    parent: Annotated[int, Field(ge=0, description="number of the campaign's process")] = 0
    signals: Annotated[
        int | None, Field(ge=0, description="descriptor on which the campaign's signals arrive")
    ] = None
    ending: Annotated[
        tuple[int, ...], Field(description="numbers of the signals that ask the campaign to end")
    ] = ()
    locks: Annotated[
        tuple[int, ...], Field(description="descriptors of the rig's locks, held as long as it lives")
    ] = ()
    log: Annotated[str | None, Field(description="file in which it says what nobody may be there to read")] = None
    linger: Annotated[
        float, Field(gt=0.0, description="s, longest time for which an oven that is not at rest is looked after")
    ] = 3600.0
