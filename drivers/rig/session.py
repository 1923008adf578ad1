"""A rig in use: the oven opened, then the cards, and both brought to rest however that ends."""

import logging
from collections.abc import Callable, Mapping, Sequence
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from analysis.protocol.limits import Limits
from drivers.interruptions import held_back
from drivers.ni.cards import Cards, go_on
from drivers.ni.errors import DaqError
from drivers.ovens.error import OvenError
from drivers.rig.errors import RESUME, RigStopped
from drivers.rig.rest import bring_to_rest
from drivers.rig.rig import Rig
from drivers.rig.supervision import SupervisedOven
from drivers.thermometers.thermometer import Thermometer

Log = Callable[[Mapping[str, Any]], None]

NAP = 0.5
"""A request to end is heard after this long at the latest while nothing else is done, s."""

log = logging.getLogger(__name__)


def unlogged(event: Mapping[str, Any]) -> None:
    """Keep nothing of an event."""


class Session:
    """Everything that is done with a rig, from opening it to leaving it at rest; a context.

    The oven comes first on the way in, too: one that was left ramping by a power cut is told to rest even where
    the cards are no longer there.

    Parameters
    ----------
    rig : Rig
    limits : Limits
        What the oven is watched for, from the moment it is open.
    log : callable
        Keeps the event that says how the rig was left.
    asked_to_end : callable
        Raises where somebody wants the session to end; asked wherever that is safe.

    Attributes
    ----------
    rig : Rig
    oven : SupervisedOven
    cards : Cards
    thermometer : Thermometer
        Of an open session, the last only where the rig has one besides the cards.
    unsafe : tuple of str or None
        What could not be verified to be at rest when the session was left; None before: nothing was touched.
    """

    oven: SupervisedOven
    cards: Cards
    thermometer: Thermometer

    def __init__(
        self, rig: Rig, limits: Limits, log: Log = unlogged, asked_to_end: Callable[[], None] = go_on
    ) -> None:
        self.rig = rig
        self.unsafe: tuple[str, ...] | None = None
        self._limits = limits
        self._log = log
        self._asked_to_end = asked_to_end

    @property
    def now(self) -> float:
        """The rig's time, s."""
        return self.rig.clock.now()

    def __enter__(self) -> Self:
        """Open oven and cards; RigStopped, and all at rest, where one of them cannot be opened."""
        try:
            self.oven = SupervisedOven(self.rig.open_oven(), self._limits, self.rig.clock, self._asked_to_end)
            self.oven.begin()
            self.oven.temperature()  # the first reading refuses an oven in alarm, or not as declared
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
        """Raise where the session is to end: RigInterrupted as somebody wishes, RigStopped by the supervision."""
        self.oven.check()

    def restore(self, events: Sequence[Mapping[str, Any]]) -> None:
        """Let a simulated rig go back to where it was, in which hours pass that nobody needs to watch."""
        self.oven.end()
        self.rig.restore(self.oven, events)
        self.oven.begin()

    def temperatures(self) -> NDArray[np.float64]:
        """Return all readings of the plate's temperature now, degrees Celsius; none where nothing measures it."""
        source = self.cards if self.rig.open_thermometer is None else self.thermometer
        return source.temperatures()

    def reopen_cards(self) -> None:
        """Let go of lost cards and open them again.

        Raises
        ------
        DaqError
            If they are not back.
        """
        lost = self.__dict__.pop("cards", None)
        if lost is not None:
            try:
                lost.close()
            except Exception as error:  # noqa: BLE001 (a lost card may say so in any way)
                log.debug("lost cards could not be closed: %s", error)
        self.cards = self.rig.open_cards()

    def sleep_until(self, moment: float) -> None:
        """Wait for a moment of the rig's time (s), checking whether to end meanwhile."""
        self.check()
        while (left := moment - self.now) > 0.0:
            self.rig.clock.sleep(min(left, NAP))
            self.check()

    def _leave(self, error: BaseException | None) -> None:
        with held_back():
            opened = self.__dict__
            if "oven" in opened:
                self.oven.end()
            self.unsafe = bring_to_rest(self.rig, opened.get("oven"), opened.get("cards"))
            self._close_thermometer()
            if error is not None:
                for told in self.unsafe:
                    error.add_note(f"NOT AT REST: {told}")
            self._tell("the end" if error is None else f"{type(error).__name__}: {error}")

    def _close_thermometer(self) -> None:
        if "thermometer" in self.__dict__:
            try:
                self.thermometer.close()
            except Exception as error:  # noqa: BLE001 (it moves nothing, and must not hide what ended the session)
                log.debug("the thermometer could not be closed: %s", error)

    def _tell(self, why: str) -> None:
        """Log how the rig was left; a full disk is one of the reasons to be here, and must not hide the first."""
        unsafe = list(self.unsafe or ())
        try:
            date = self.rig.date().isoformat()
            left = {"event": "oven", "command": "safe", "time": self.now, "date": date}
            self._log({**left, "purpose": why, "unsafe": unsafe})
        except Exception as error:  # noqa: BLE001 (see above)
            log.warning("how the rig was left could not be logged: %s", error)
