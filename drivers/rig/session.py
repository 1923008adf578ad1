"""A rig in use: opens the oven, then the cards, and brings both to rest on every exit.

Bringing a rig to rest after any outcome: the oven first, then the drive.

A `Session` calls `bring_to_rest` on every exit: at its end, after an exception of any class or a signal, or if it
could not be opened. ``flexura safe`` calls it alone.
"""

import logging
import math
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from analysis.protocol.limits import Limits
from drivers.clock import Clock
from drivers.interruptions import held_back
from drivers.ni.cards import Cards, DaqError, go_on
from drivers.ovens.error import OvenError
from drivers.ovens.oven import Oven
from drivers.rig.end_requests import RESUME, RigStopped
from drivers.rig.rig import Aftercare, Rig
from drivers.thermometers.thermometer import Thermometer
from drivers.watchdog.guard import Event, RestRule, RestWatch
from drivers.watchdog.remote_oven import RemoteOven
from drivers.watchdog.supervision import AGAIN, PULL, SupervisedOven

Log = Callable[[Mapping[str, Any]], None]

WRITTEN_WITHIN = 30.0
"""A line of the log, or a campaign's index, that takes longer, s, is on a disk that hangs."""
STANDS_STILL = "the campaign has stood still since it left the rig. Is its folder out of reach, a network share?"
NAP = 0.5
"""Longest wait between two checks for a request to end, s."""

log = logging.getLogger(__name__)


def unlogged(event: Mapping[str, Any]) -> None:
    """Do not log an event."""


class Session:
    """Context manager for a rig: opens it, and brings it to rest on exit.

    The oven is opened first: if it was left ramping by a power cut, it is brought to rest even if the cards are
    missing.

    Parameters
    ----------
    rig : Rig
    limits : Limits
        Limits for the supervision of the oven, from its opening on.
    log : callable
        Logs the event with the rig's final state.
    asked_to_end : callable
        Raises if the user wants the session to end; called wherever that is safe.

    Attributes
    ----------
    rig : Rig
    oven : SupervisedOven or RemoteOven
    cards : Cards
    thermometer : Thermometer
        Of an open session; the thermometer only if the rig has one besides the cards.
    aftercare : Aftercare
        For a watchdog that outlives this process; set before the session is opened.
    unsafe : tuple of str or None
        What could not be verified to be at rest on exit; None before.
    """

    oven: SupervisedOven | RemoteOven
    cards: Cards
    thermometer: Thermometer

    def __init__(
        self, rig: Rig, limits: Limits, log: Log = unlogged, asked_to_end: Callable[[], None] = go_on
    ) -> None:
        self.rig = rig
        self.aftercare = Aftercare()
        self.unsafe: tuple[str, ...] | None = None
        self._limits = limits
        self._log = log
        self._asked_to_end = asked_to_end

    @property
    def now(self) -> float:
        """The rig's time, s."""
        return self.rig.clock.now()

    def __enter__(self) -> Self:
        """Open oven and cards; if one cannot be opened, bring all to rest and raise RigStopped."""
        try:
            self.oven = self.rig.open_supervised(self._limits, self._asked_to_end, self.aftercare)
            self.oven.temperature()  # the first reading raises for an oven in alarm, or not as declared
            self.cards = self.rig.open_cards()
            if self.rig.open_thermometer is not None:
                self.thermometer = self.rig.open_thermometer()
        except (DaqError, OvenError) as error:
            stopped = RigStopped(f"the rig cannot be opened: {error}", RESUME)
            self._leave(stopped)
            raise stopped from error
        except BaseException as error:
            self._leave(error)
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Bring everything to rest."""
        self._leave(error)

    def check(self) -> None:
        """Raise if the session is to end: RigInterrupted by the user, RigStopped by the supervision."""
        self.oven.check()

    def restore(self, events: Sequence[Mapping[str, Any]]) -> None:
        """Set a simulated rig to its last state; hours of simulated time may pass, without supervision."""
        self.oven.restored(lambda oven: self.rig.restore(oven, events))

    def temperatures(self) -> NDArray[np.float64]:
        """Return all readings of the plate's temperature now, degrees Celsius; empty if nothing measures it."""
        source = self.cards if self.rig.open_thermometer is None else self.thermometer
        return source.temperatures()

    def reopen_cards(self) -> None:
        """Close lost cards and open them again.

        Raises
        ------
        DaqError
            If they are still missing.
        """
        lost = self.__dict__.pop("cards", None)
        if lost is not None:
            try:
                lost.close()
            except Exception as error:  # noqa: BLE001 (a lost card may say so in any way)
                log.debug("lost cards could not be closed: %s", error)
        self.cards = self.rig.open_cards()

    def sleep_until(self, moment: float) -> None:
        """Wait until a moment of the rig's time (s); `check` is called meanwhile."""
        self.check()
        while (left := moment - self.now) > 0.0:
            self.rig.clock.sleep(min(left, NAP))
            self.check()

    def _leave(self, error: BaseException | None) -> None:
        with held_back():
            opened = self.__dict__
            since = self._moment()
            if "oven" in opened:
                self.oven.end()
            self.unsafe = bring_to_rest(self.rig, opened.get("oven"), opened.get("cards"))
            self._close_thermometer()
            if error is not None:
                for message in self.unsafe:
                    error.add_note(f"NOT AT REST: {message}")
            self._tell("the end" if error is None else f"{type(error).__name__}: {error}", since)

    def _close_thermometer(self) -> None:
        if "thermometer" in self.__dict__:
            try:
                self.thermometer.close()
            except Exception as error:  # noqa: BLE001 (harmless, and must not hide what ended the session)
                log.debug("the thermometer could not be closed: %s", error)

    def _moment(self) -> tuple[float, str] | None:
        """Return the rig's time and date, under which the command that ends the session is logged."""
        try:
            return self.now, self.rig.date().isoformat()
        except BaseException as error:  # noqa: BLE001 (nothing must keep the rig from its rest)
            log.warning("the rig's clock: %s", error)
            return None

    def _tell(self, why: str, since: tuple[float, str] | None) -> None:
        """Log the rig's final state; an error here, such as a full disk, must not hide the session's own error."""
        try:
            with self.told_if_it_hangs():
                time, date = since or (self.now, self.rig.date().isoformat())
                left = {"event": "oven", "command": "safe", "time": time, "date": date}
                self._log({**left, "purpose": why, "unsafe": list(self.unsafe or ())})
        except Exception as error:  # noqa: BLE001 (see above)
            log.warning("how the rig was left could not be logged: %s", error)

    @contextmanager
    def told_if_it_hangs(self) -> Iterator[None]:
        """Context manager for what is written after the rig was left, which no watchdog looks after.

        Where a disk hangs, another thread says so, and how the rig was left.
        """
        unsafe = "; ".join(self.unsafe or ())
        rest = f"NOT AT REST: {unsafe}" if unsafe else "it is at rest"
        still = threading.Timer(WRITTEN_WITHIN, log.warning, ("%s; the rig: %s", STANDS_STILL, rest))
        still.daemon = True
        still.start()
        try:
            yield
        finally:
            still.cancel()


ATTEMPTS = 5
"""Attempts on a disturbed line, one second apart; before the last one the oven is opened again."""
READ_EVERY = 3.0
"""Interval at which an oven that was switched off is read, s."""
FIRST_WORD = 6.0
"""People are told that the program waits after so long, s."""


def bring_to_rest(rig: Rig, oven: Oven | None = None, cards: Cards | None = None) -> tuple[str, ...]:
    """Bring the oven to rest and the drive to 0 V, and close both.

    Each is attempted even if the other fails, whatever the class of its exception. The oven's state is read back,
    and its air is watched until it goes to the room's temperature, because a heater whose relay is welded on reads
    back as off; the drive has played zeros to their end. What is not open, or no longer answers, is opened again.

    Parameters
    ----------
    oven : Oven, optional
        If it is open.
    cards : Cards, optional
        If they are open.

    Returns
    -------
    tuple of str
        What could not be verified to be at rest, with what to do; empty if both are.
    """
    resting = _RestingOven(rig.open_oven, rig.clock, oven)
    failed = resting.switched_off()
    failures = (failed, rest_drive(rig.open_cards, cards))  # the drive does not wait until the oven has cooled
    if failed is None and rig.rest_rule is not None:
        failures = (resting.seen_cooling(rig.rest_rule, rig.tell), failures[1])
    resting.close()
    return tuple(what for what in failures if what is not None)


def rest_oven(open_oven: Callable[[], Oven], clock: Clock) -> str | None:
    """Switch an oven off, read back, and close it; return what could not be verified, None if it is off."""
    resting = _RestingOven(open_oven, clock, None)
    failed = resting.switched_off()
    resting.close()
    return failed


class _RestingOven:
    """An oven on its way to rest.

    Parameters
    ----------
    open_oven : callable
        Returns the oven, open.
    clock : Clock
        For the waits between attempts and readings.
    oven : Oven or None
        If it is open.
    """

    def __init__(self, open_oven: Callable[[], Oven], clock: Clock, oven: Oven | None) -> None:
        self._open_oven = open_oven
        self._clock = clock
        self._oven = oven

    def switched_off(self) -> str | None:
        """Switch it off; return what could not be verified."""
        failure = _attempted(self._switch_off)
        for left in reversed(range(ATTEMPTS - 1)):
            if failure is None:
                break
            _attempted(lambda: self._clock.sleep(1.0))
            if left == 0:  # a port that was lost and is back has to be opened again
                self.close()
            failure = _attempted(self._switch_off)
        return failure and f"the oven could not be brought to rest and may continue its ramp: {failure}"

    def seen_cooling(self, rule: RestRule, tell: Callable[[str], None]) -> str | None:
        """Wait until it is seen to cool; return what was seen if it does not."""
        began = self._clock.now()
        watch, event, next_word = RestWatch(rule, began), None, began + FIRST_WORD
        while event is None:
            air = self._air()
            now = self._clock.now()
            event = watch.see(now, air)
            if event is None:
                if now >= next_word:
                    tell(f"the oven is off, and watched until it is seen to cool: {watch.words(now, air)}")
                    next_word = now + AGAIN
                _attempted(lambda: self._clock.sleep(READ_EVERY))
        if event is Event.TOWARDS_ROOM:
            return None
        return f"the oven reads back as switched off, but {watch.words(now, air)}. {PULL}"

    def close(self) -> None:
        """Close its port."""
        if self._oven is not None:
            _attempted(self._oven.close)
            self._oven = None

    def _switch_off(self) -> None:
        self._oven = self._oven if self._oven is not None else self._open_oven()
        self._oven.safe()

    def _air(self) -> float | None:
        found: list[float] = []
        if self._oven is None or _attempted(lambda: found.append(self._oven.temperature())) is not None:  # type: ignore[union-attr]
            return None
        return found[0] if math.isfinite(found[0]) else None


def rest_drive(open_cards: Callable[[], Cards], cards: Cards | None = None) -> str | None:
    """Bring a drive to 0 V and close the cards; return what could not be verified, None if it is at 0 V."""

    def open_and_close() -> None:
        open_cards().close()  # both bring the output to 0 V

    failure = _attempted(cards.close if cards is not None else open_and_close)
    if failure is not None:
        failure = _attempted(open_and_close)
    return failure and f"the drive could not be brought to 0 V, turn the amplifier off: {failure}"


def _attempted(action: Callable[[], object]) -> str | None:
    """Return the error as text, or None."""
    try:
        action()
    except BaseException as error:  # noqa: BLE001 (the following actions have to be done after any exception)
        return f"{error}" if f"{error}" else type(error).__name__
    return None
