"""Cards and oven together: opened, watched, and brought to rest on every way out."""

import logging
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from analysis.protocol.protocol import AcquisitionProtocol
from drivers.ni.cards import Cards
from drivers.ni.errors import Action, DaqError
from drivers.ni.interruptions import held_back
from drivers.ovens.error import OvenError
from drivers.ovens.line import PASSING
from drivers.rig.errors import RigStopped
from drivers.rig.progress import Purpose
from drivers.rig.readings import RESOLUTION, Patience, Reading
from drivers.rig.rig import Rig
from drivers.rig.store import Store

SAFE_ATTEMPTS = 5
"""A disturbed line is tried so often, a second apart, before the oven counts as out of reach."""

log = logging.getLogger(__name__)


class Station:
    """The open rig of one campaign.

    Parameters
    ----------
    rig : Rig
    protocol : AcquisitionProtocol
    store : Store
        For the log.

    Attributes
    ----------
    leg : int
        Leg under way; written into every event.
    """

    def __init__(self, rig: Rig, protocol: AcquisitionProtocol, store: Store) -> None:
        self._rig = rig
        self._protocol = protocol
        self._store = store
        self._patience = Patience(protocol.limits.lost_after)
        self.leg = -1
        self.cards: Cards = rig.open_cards()
        try:
            self._oven = rig.open_oven()
        except BaseException:
            self.cards.close()
            raise

    @property
    def now(self) -> float:
        """The rig's time, s."""
        return self._rig.clock.now()

    def date(self) -> str:
        """Date and time of day, ISO 8601."""
        return self._rig.date().isoformat()

    @property
    def poll_within(self) -> float:
        """Longest time the oven may be left alone, s."""
        return self._oven.poll_within

    def restore(self, events: Sequence[Mapping[str, Any]]) -> None:
        """Let a simulated rig go back to where it was."""
        self._rig.restore(self._oven, events)

    def note(self, event: str, **what: Any) -> None:
        """Log an event with its time."""
        self._store.log({"event": event, "time": self.now, "date": self.date(), "leg": self.leg, **what})

    def next_reading(self) -> Reading | None:
        """Wait for the next point of the time grid, and read; None if there is no usable reading now.

        Readings come at whole multiples of the interval, so that their times do not depend on what
        was done in between.

        Raises
        ------
        RigStopped
            If readings have been missing for too long, are beyond the limits, or the oven is in alarm.
        DaqError
            If the cards are lost, or refuse what repeating cannot mend.
        """
        interval = self._protocol.programme.poll_interval
        self._rig.clock.sleep((math.floor(self.now / interval + 1e-6) + 1) * interval - self.now)
        return self.reading()

    def reading(self) -> Reading | None:
        """Read both temperatures now; see `next_reading`."""
        advice = "Check the oven's line, its sensor and the thermocouple; then run the same command again"
        try:
            found = Reading(self._air(), self._plate())
        except (OvenError, DaqError) as error:
            if not _passes(error):
                raise
            if not self._patience.failing:
                self.note("trouble", what=str(error))
            self._patience.bad(self.now, f"no temperature: {error}", advice)
            return None
        if not found.believable:
            if not self._patience.failing:
                self.note("trouble", what=f"absurd reading: air {found.air} °C, plate {found.plate} °C")
            self._patience.bad(self.now, f"air reads {found.air} °C, plate {found.plate} °C", advice)
            return None
        if self._patience.failing:
            self.note("recovered", air=found.air, plate=found.plate)
        self._patience.good()
        found.require_within(self._protocol.limits.coldest, self._protocol.limits.hottest)
        return found

    def watched(self, reading: Reading) -> float:
        """Return the temperature that triggers sweeps, degrees Celsius."""
        if self._protocol.programme.watch == "air":
            return reading.air
        if reading.plate is None:
            raise RigStopped(
                "programme.watch is the plate, but no thermocouple is wired",
                "Wire one and name it in cards.thermocouples, or watch the air",
            )
        return reading.plate

    def _air(self) -> float:
        return round(float(self._oven.temperature()), RESOLUTION)

    def _plate(self) -> float | None:
        readings = self.cards.temperatures()
        return round(float(np.mean(readings)), RESOLUTION) if readings.size else None

    def ramp(self, target: float, rate: float, purpose: Purpose) -> None:
        """Let the oven ramp, and log it with the time it was told to; RigStopped if it will not."""
        self._command("ramp", lambda: self._oven.ramp_to(target, rate), target=target, rate=rate, purpose=purpose)

    def hold(self, why: str) -> None:
        """Let the oven stay where it is."""
        self._command("hold", self._oven.hold, purpose=why)

    def _command(self, kind: str, command: Callable[[], Any], **what: Any) -> None:
        before = self.now
        try:
            command()
        except OvenError as error:
            raise RigStopped(f"the oven would not {kind}: {error}", "Then run the same command again") from error
        self._store.log(
            {"event": "oven", "command": kind, "time": before, "date": self.date(), "leg": self.leg, **what}
        )

    def regain_cards(self) -> None:
        """Hold the oven and look for the cards until they are back; RigStopped if that takes too long."""
        self.note("trouble", what="the cards are lost")
        self.hold("cards lost")
        patience = Patience(self._protocol.limits.lost_after)
        while True:
            try:
                self.cards.close()
            except DaqError as error:
                log.debug("lost cards could not be closed: %s", error)
            try:
                self.cards = self._rig.open_cards()
            except DaqError as error:
                patience.bad(self.now, f"the cards are lost: {error}", "Then run the same command again")
            else:
                self.note("recovered", what="the cards are back")
                return
            try:
                self._oven.temperature()  # some ovens stop when nobody asks
            except OvenError as error:
                log.debug("oven while the cards are lost: %s", error)
            self._rig.clock.sleep(min(5.0, 0.3 * self._oven.poll_within))

    def make_safe(self, why: str) -> tuple[str, ...]:
        """Bring the drive to 0 V and the oven to rest; return what could not be brought there.

        Nothing interrupts this, and no failure of one part keeps it from the other.
        """
        unsafe = []
        with held_back():
            try:
                self.cards.close()
            except DaqError as error:
                unsafe.append(str(error))
            told = self._rest_oven()
            if told:
                unsafe.append(told)
            try:
                self._store.log(
                    {
                        "event": "oven",
                        "command": "safe",
                        "time": self.now,
                        "date": self.date(),
                        "leg": self.leg,
                        "purpose": why,
                        "unsafe": unsafe,
                    }
                )
            except OSError as error:  # a full disk is one of the reasons to be here
                log.warning("the stop could not be logged: %s", error)
            self._oven.close()
        return tuple(unsafe)

    def _rest_oven(self) -> str | None:
        failure: OvenError | None = None
        for _ in range(SAFE_ATTEMPTS):
            try:
                self._oven.safe()
            except OvenError as error:
                failure = error
                self._rig.clock.sleep(1.0)
            else:
                return None
        return f"the oven could not be told to rest and may go on with its ramp: {failure}"


def _passes(error: OvenError | DaqError) -> bool:
    """Whether the next reading may be a good one."""
    if isinstance(error, OvenError):
        return error.fault in PASSING
    return error.action in (Action.RETRY_DISCARD, Action.RETRY_ONCE)
