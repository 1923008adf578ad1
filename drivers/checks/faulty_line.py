"""A line between a driver and its instrument, simulated or real, that fails as asked."""

import math
import random
from enum import StrEnum

from drivers.clock import Clock
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import Transport
from drivers.ovens.modbus import crc16


class LineFault(StrEnum):
    """What becomes of an answer."""

    SILENCE = "silence"
    """It never comes."""
    GARBAGE = "garbage"
    """Other bytes come, as many."""
    LATE = "late answers"
    """It comes after the time-out."""
    STALE = "stale answers"
    """It comes a second time, before the next question is asked."""
    ERROR = "error answers"
    """The instrument says no: a Modbus exception, or a line of text that is none it should say."""
    GONE = "disconnected"
    """The port is gone."""
    ECHO = "echo"
    """What was asked comes back before it, as from an adapter that receives its own transmission."""
    INTERRUPTED = "interrupted"
    """Ctrl-C comes while it is waited for."""


class FaultyLine:
    """Passes everything on until `fail` is called.

    Parameters
    ----------
    inner : Transport
    clock : Clock
    timeout : float
        Of the driver, s: an answer is late after more than that.
    seed : int
        Of the garbage.

    Attributes
    ----------
    questions : int
        Queries so far: none if the driver does not use the line that it was given.
    """

    def __init__(self, inner: Transport, clock: Clock, timeout: float, seed: int = 0) -> None:
        self._inner = inner
        self._clock = clock
        self._timeout = timeout
        self._random = random.Random(seed)  # noqa: S311 (noise)
        self._fault: LineFault | None = None
        self._left = math.inf
        self._request = b""
        self._coming: list[tuple[float, bytes]] = []
        self._last = b""
        self._closed = False
        self.questions = 0

    def fail(self, fault: LineFault, questions: float = math.inf) -> None:
        """Fail so for so many questions from now on."""
        self._fault, self._left = fault, questions

    def mend(self) -> None:
        """Fail no more; what is late still comes."""
        self._fault = None

    def write(self, data: bytes) -> None:
        """Pass a question on."""
        if self._left <= 0:
            self._fault = None
        self._check()
        self._left -= 1
        self.questions += 1
        self._request = data
        if self._fault is LineFault.ECHO:
            self._coming.append((self._clock.now(), data))
        self._inner.write(data)

    def read(self, wait: float) -> bytes:
        """Return what comes, or what the fault makes of it."""
        self._check()
        if self._coming and self._coming[0][0] <= self._clock.now() + wait:
            due, data = self._coming.pop(0)
            self._clock.sleep(due - self._clock.now())
            return data
        begun = self._clock.now()
        data = self._inner.read(wait)
        if not data or self._fault is None:
            return data
        return self._made_of(data, begun, wait)

    def drain(self) -> None:
        """Throw away what has come."""
        self._check()
        now = self._clock.now()
        self._coming = [(due, data) for due, data in self._coming if due > now]
        self._inner.drain()

    def close(self) -> None:
        """Close the line."""
        self._closed = True
        self._inner.close()

    def _made_of(self, data: bytes, begun: float, wait: float) -> bytes:
        now = self._clock.now()
        match self._fault:
            case LineFault.GARBAGE:
                return bytes(self._random.randrange(256) for _ in data)
            case LineFault.STALE:
                self._coming.append((now, data))
                return data
            case LineFault.ERROR:
                return _refusal(self._request, data)
            case LineFault.ECHO:
                return data
            case LineFault.INTERRUPTED:
                self._fault = None
                self._coming.append((now, data))
                raise KeyboardInterrupt
            case LineFault.LATE:
                self._coming.append((now + 1.2 * self._timeout, data))
        self._clock.sleep(begun + wait - now)
        return b""

    def _check(self) -> None:
        if self._closed:
            raise OvenError(Fault.PORT, "the line was closed", "Open the instrument again.")
        if self._fault is LineFault.GONE:
            raise OvenError(Fault.PORT, "the line is unplugged", "Plug it in again.")


def _refusal(request: bytes, answer: bytes) -> bytes:
    """Return what an instrument says that refuses: Modbus where the question is a frame of it."""
    device_failure = 4
    if len(request) > 4 and crc16(request[:-2]) == request[-2:]:
        body = bytes([request[0], request[1] | 0x80, device_failure])
        return body + crc16(body)
    if len(request) > 8 and request[2:4] == b"\0\0" and int.from_bytes(request[4:6], "big") == len(request) - 6:
        return request[:4] + bytes([0, 3, request[6], request[7] | 0x80, device_failure])
    ending = answer[len(answer.rstrip(b"\r\n")) :] or b"\r\n"
    return b"ERR 113" + ending
