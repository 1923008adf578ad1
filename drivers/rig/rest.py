"""The one place where a rig comes to rest: the oven first, then the drive, whatever has happened before.

Every way out of a rig leads here. A `Session` calls it when it is left: at its end, by an exception of any class,
by a signal, or because it could not be opened. ``flexura safe`` calls it alone.
"""

from collections.abc import Callable

from drivers.clock import Clock
from drivers.ni.cards import Cards
from drivers.ovens.oven import Oven
from drivers.rig.rig import Rig

ATTEMPTS = 5
"""A disturbed line is tried so often, a second apart; the last time, the oven is opened anew."""


def bring_to_rest(rig: Rig, oven: Oven | None = None, cards: Cards | None = None) -> tuple[str, ...]:
    """Tell the oven to rest, bring the drive to 0 V, and let go of both.

    Each is attempted whatever became of the other, and whatever class of error either raises. The oven reads its
    state back; the drive has played zeros to their end. What is not open, or answers no more, is opened anew.

    Parameters
    ----------
    rig : Rig
    oven : Oven, optional
        As far as it is open.
    cards : Cards, optional
        As far as they are open.

    Returns
    -------
    tuple of str
        What could not be verified to be at rest, with what to do; empty where both are.
    """
    told = (rest_oven(rig.open_oven, rig.clock, oven), rest_drive(rig.open_cards, cards))
    return tuple(what for what in told if what is not None)


def rest_oven(open_oven: Callable[[], Oven], clock: Clock, oven: Oven | None = None) -> str | None:
    """Tell an oven to rest, and let go of it.

    Parameters
    ----------
    open_oven : callable
        Returns the oven, open.
    clock : Clock
        For the second between two attempts.
    oven : Oven, optional
        As far as it is open.

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
        if left == 0 and oven is not None:  # a port that was lost and is back has to be opened anew
            _attempted(oven.close)
            oven = None
        failure = _attempted(rest)
    if oven is not None:
        _attempted(oven.close)
    return failure and f"the oven could not be told to rest and may go on with its ramp: {failure}"


def rest_drive(open_cards: Callable[[], Cards], cards: Cards | None = None) -> str | None:
    """Bring a drive to 0 V, and let go of the cards; return what could not be verified, None where it is at 0."""

    def open_and_close() -> None:
        open_cards().close()  # both bring the output to 0 V

    failure = _attempted(cards.close if cards is not None else open_and_close)
    if failure is not None:
        failure = _attempted(open_and_close)
    return failure and f"the drive could not be brought to 0 V, turn the amplifier off: {failure}"


def _attempted(action: Callable[[], object]) -> str | None:
    """Return what went wrong, in words; None where nothing did."""
    try:
        action()
    except BaseException as error:  # noqa: BLE001 (whatever it is, what comes after it has to be done)
        return f"{error}" if f"{error}" else type(error).__name__
    return None
