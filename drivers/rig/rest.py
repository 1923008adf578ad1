"""Bringing a rig to rest after any outcome: the oven first, then the drive.

A `Session` calls it on every exit: at its end, after an exception of any class or a signal, or if it could not be
opened. ``flexura safe`` calls it alone.
"""

from collections.abc import Callable

from drivers.clock import Clock
from drivers.ni.cards import Cards
from drivers.ovens.oven import Oven
from drivers.rig.rig import Rig

ATTEMPTS = 5
"""Attempts on a disturbed line, one second apart; before the last one the oven is opened again."""


def bring_to_rest(rig: Rig, oven: Oven | None = None, cards: Cards | None = None) -> tuple[str, ...]:
    """Bring the oven to rest and the drive to 0 V, and close both.

    Each is attempted even if the other fails, whatever the class of its exception. The oven's state is read back;
    the drive has played zeros to their end. What is not open, or no longer answers, is opened again.

    Parameters
    ----------
    rig : Rig
    oven : Oven, optional
        If it is open.
    cards : Cards, optional
        If they are open.

    Returns
    -------
    tuple of str
        What could not be verified to be at rest, with what to do; empty if both are.
    """
    failures = (rest_oven(rig.open_oven, rig.clock, oven), rest_drive(rig.open_cards, cards))
    return tuple(what for what in failures if what is not None)


def rest_oven(open_oven: Callable[[], Oven], clock: Clock, oven: Oven | None = None) -> str | None:
    """Bring an oven to rest and close it.

    Parameters
    ----------
    open_oven : callable
        Returns the oven, open.
    clock : Clock
        For the wait of one second between attempts.
    oven : Oven, optional
        If it is open.

    Returns
    -------
    str or None
        What could not be verified; None where the oven is at rest.
    """

    def rest() -> None:
        nonlocal oven
        oven = oven if oven is not None else open_oven()
        oven.safe()

    failure = _attempted(rest)
    for left in reversed(range(ATTEMPTS - 1)):
        if failure is None:
            break
        _attempted(lambda: clock.sleep(1.0))
        if left == 0 and oven is not None:  # a port that was lost and is back has to be opened again
            _attempted(oven.close)
            oven = None
        failure = _attempted(rest)
    if oven is not None:
        _attempted(oven.close)
    return failure and f"the oven could not be brought to rest and may continue its ramp: {failure}"


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
