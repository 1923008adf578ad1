"""Bringing a rig to rest after any outcome: the oven first, then the drive.

A `Session` calls it on every exit: at its end, after an exception of any class or a signal, or if it could not be
opened. ``flexura safe`` calls it alone.
"""

import math
from collections.abc import Callable

from drivers.clock import Clock
from drivers.ni.cards import Cards
from drivers.ovens.oven import Oven
from drivers.rig.rig import Rig
from drivers.watchdog.guard import Event
from drivers.watchdog.rest_watch import RestRule, RestWatch
from drivers.watchdog.supervision import AGAIN, PULL

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
