"""One line to one controller: lock, pauses between commands, time-outs, repeated attempts.

The echo of a line is left out: an adapter that receives its own transmission returns every request before the
answer. Two-wire RS-485 adapters do so unless their receiver is switched off while they send. The echo is
recognised by its bytes, which are those of the request.
"""

import logging
import math
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Protocol, TypeVar

from drivers.clock import Clock
from drivers.ovens.error import Fault, OvenError

log = logging.getLogger(__name__)

T = TypeVar("T")

End = Callable[[bytes], int | None]
"""Given the bytes so far: the length of the finished answer, or None while more is due."""

PASSING = frozenset({Fault.SILENT, Fault.GARBLED, Fault.BUSY, Fault.PORT})


LONGEST = 65_536
"""Bytes: a longer answer is refused as damaged."""


class Transport(Protocol):
    """Bytes out and in, without regard to their meaning. Raises `OvenError` of kind port."""

    def write(self, data: bytes) -> None:
        """Send all of `data`."""
        ...

    def read(self, wait: float) -> bytes:
        """Return what comes within `wait` s, as soon as it comes; empty after silence."""
        ...

    def drain(self) -> None:
        """Throw away what has come unread."""
        ...

    def close(self) -> None:
        """Let go of the port; may be called twice."""
        ...


def up_to(terminator: bytes) -> End:
    """Answers that end with `terminator`, which counts as part of them."""

    def end(received: bytes) -> int | None:
        at = received.find(terminator)
        return None if at < 0 else at + len(terminator)

    return end


@dataclass(frozen=True)
class Timing:
    """How patient the line is, all in seconds but the count.

    Attributes
    ----------
    timeout : float
        For one whole answer.
    retries : int
        Further attempts after a failed one.
    gap_after_read, gap_after_write : float
        Silence kept before the next command: some chambers lose what comes sooner.
    lost_after : float
        Contact counts as lost when every attempt over this long has failed.
    """

    timeout: float = 1.0
    retries: int = 2
    gap_after_read: float = 0.0
    gap_after_write: float = 0.0
    lost_after: float = 60.0

    def __post_init__(self) -> None:
        if not self.timeout > 0.0 or self.retries < 0 or self.lost_after < self.timeout:
            raise ValueError(f"{self}: needs timeout > 0 s, retries >= 0, lost_after at least the timeout")
        if min(self.gap_after_read, self.gap_after_write) < 0.0:
            raise ValueError(f"{self}: gaps must not be negative")


class Echo:
    """What one line is known to return of its requests.

    Attributes
    ----------
    present : bool or None
        Whether it returns them; None as long as no exchange has shown it.
    """

    def __init__(self) -> None:
        self.present: bool | None = None

    def answer(self, request: bytes, received: bytes, *, repeats: bool) -> bytes | None:
        """Return what was received without the echo before it; None while that cannot be told.

        On a line of which nothing is known yet, an answer that may be equal to its request, as that to a Modbus
        command of one register is, is told from an echo only by a second copy.

        Parameters
        ----------
        repeats : bool
            Whether a sound answer may be equal to the request.
        """
        if len(received) < len(request) and request.startswith(received):
            return None
        if not received.startswith(request):
            return received
        after = received[len(request) :]
        if not repeats:
            self.present = True
        elif self.present is None:
            if len(after) < len(request) and request.startswith(after):
                return None
            self.present = True if after.startswith(request) else None
        elif not self.present:
            return received
        return after

    def learn(self, request: bytes, received: bytes) -> None:
        """Note of a whole answer to `request` whether an echo came before it."""
        self.present = received.startswith(request)

    def at_the_end(self, request: bytes, received: bytes, *, repeats: bool) -> bytes:
        """Return the answer as `answer` does, when the time is over and nothing more is to come.

        Parameters
        ----------
        repeats : bool
            Whether a sound answer may be equal to the request.

        Returns
        -------
        bytes
            A single copy of a request that may be its own answer is taken for it: what it has done is read back.
        """
        answer = self.answer(request, received, repeats=repeats)
        return received if answer is None else answer


class Line:
    """A transport shared by threads, one exchange at a time.

    Parameters
    ----------
    transport : Transport
        Owned from now on: closed with the line.
    clock : Clock
    timing : Timing
    """

    def __init__(self, transport: Transport, clock: Clock, timing: Timing) -> None:
        self._transport = transport
        self._clock = clock
        self._timing = timing
        self._lock = threading.RLock()
        self._free_at = clock.now()
        self._failing_since = math.inf
        self._unsettled = False
        self._retries = timing.retries
        self._echo = Echo()

    @property
    def now(self) -> float:
        """The clock's seconds."""
        return self._clock.now()

    @contextmanager
    def reserved(self) -> Iterator[None]:
        """Keep other threads off the line for a read, modify, write, read back."""
        with self._lock:
            yield

    def attempt(self, action: Callable[[], T], *, writes: bool = False, checksum: bool = True) -> T:
        """Return what `action` returns, trying again within bounds while its trouble may pass.

        Parameters
        ----------
        action : callable
            One exchange.
        writes : bool
            Whether it is a command.
        checksum : bool
            Whether requests carry one. Without it a controller refuses what noise has changed on its way, so that
            a refusal may pass, too.

        Raises
        ------
        OvenError
            At once where repeating cannot help; of kind lost where attempts have failed for too long;
            otherwise that of the last attempt.
        """
        with self._lock:
            if self._unsettled:
                self._settle()
            # After a keyboard interrupt, for example, an answer that is not expected any more may still arrive.
            self._unsettled = True
            try:
                gap = self._timing.gap_after_write if writes else self._timing.gap_after_read
                result = self._tried(action, gap, passing=PASSING if checksum else PASSING | {Fault.REFUSED})
            except OvenError:
                self._unsettled = False
                raise
            self._unsettled = False
            return result

    def blind(self, *commands: Callable[[], object]) -> None:
        """Send every command once, whatever becomes of the answers.

        This is for commands that have to reach the oven even if all answers are lost, or come too late. What they
        have done is to be read back afterwards.

        Parameters
        ----------
        *commands : callable
            Each makes its attempts on this line; repeats are left to the caller.
        """
        with self._lock:
            for command in commands:
                self._retries = 0
                try:
                    command()
                except OvenError as error:
                    log.debug("a command was not acknowledged: %s", error)
                finally:
                    self._retries = self._timing.retries

    def _tried(self, action: Callable[[], T], gap: float, passing: frozenset[Fault]) -> T:
        for left in range(self._retries, -1, -1):
            self._clock.sleep(self._free_at - self._clock.now())
            begun = self._clock.now()
            try:
                result = action()
            except OvenError as error:
                if error.fault not in PASSING:
                    self._failing_since = math.inf
                    if error.fault in passing and left > 0:
                        continue
                    raise
                self._failing_since = min(self._failing_since, begun)
                failure = self._explained(error)
                if left == 0:
                    raise self._given_up(failure) from error
            else:
                self._failing_since = math.inf
                return result
            finally:
                self._free_at = self._clock.now() + gap
        raise AssertionError("the last attempt returns or raises")

    def send(self, request: bytes) -> None:
        """Send `request`, to which there is no answer."""
        if self._echo.present:  # wait for its echo, or the next answer would begin with it
            self.exchange(request, lambda _: 0)
            return
        self._transport.drain()
        self._transport.write(request)

    def exchange(self, request: bytes, end: End, quiet: float | None = None, *, repeats: bool = False) -> bytes:
        """Send `request` and return the answer, or what there is of it when the time-out is over.

        Parameters
        ----------
        end : callable
            Says where the answer ends.
        quiet : float, optional
            Take a silence of this many seconds after the first byte for the end as well.
        repeats : bool
            Whether a sound answer may be equal to the request.

        Returns
        -------
        bytes
            Without an echo of the request; empty after silence.
        """
        self._transport.drain()
        self._transport.write(request)
        deadline = self._clock.now() + self._timing.timeout
        received = b""
        answer: bytes | None = None
        while True:
            wait = deadline - self._clock.now()
            came = self._transport.read(max(min(wait, quiet) if quiet is not None and answer else wait, 0.0))
            received += came
            answer = self._echo.answer(request, received, repeats=repeats)
            length = None if answer is None else end(answer)
            if answer is not None and length is not None:
                if not repeats:
                    self._echo.learn(request, received)
                return answer[:length]
            if not came or self._clock.now() >= deadline or len(received) > LONGEST:
                break
        answer = self._echo.at_the_end(request, received, repeats=repeats)
        return answer[: end(answer)]

    def pause(self, seconds: float) -> None:
        """Let time pass before the next question."""
        self._clock.sleep(seconds)

    def close(self) -> None:
        """Close the transport."""
        with self._lock:
            self._transport.close()

    def _explained(self, error: OvenError) -> OvenError:
        # An answer that comes after its time-out would be taken for the answer to the next question:
        # wait until the line has been silent for a whole time-out before asking again.
        if error.fault is Fault.PORT:
            return error
        late = self._settle()
        if error.fault is Fault.SILENT and late:
            return OvenError(
                Fault.SILENT,
                f"the answer came later than the time-out of {self._timing.timeout:g} s",
                "Raise timeout, or let other programs query this controller less often.",
            )
        return error

    def _settle(self) -> bool:
        came = False
        deadline = self._clock.now() + 10.0 * self._timing.timeout
        try:
            while self._clock.now() < deadline and self._transport.read(self._timing.timeout):
                came = True
        except OvenError:
            return came  # the port has gone: the next attempt says so
        return came

    def _given_up(self, error: OvenError) -> OvenError:
        since = self._clock.now() - self._failing_since
        if since >= self._timing.lost_after:
            return OvenError(
                Fault.LOST,
                f"no usable answer for {since:.0f} s (limit {self._timing.lost_after:g} s); last: {error.what}",
                f"Stop the campaign; look at the instrument itself. {error.advice}",
                error.code,
            )
        return OvenError(error.fault, f"{error.what}, {self._retries + 1} attempts", error.advice, error.code)
