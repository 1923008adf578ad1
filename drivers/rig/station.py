"""Cards and oven together, as a campaign uses them, with logging."""

import logging
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.protocol.protocol import AcquisitionProtocol
from drivers.ni.cards import Record
from drivers.ni.errors import Action, DaqError
from drivers.ovens.error import OvenError
from drivers.ovens.line import PASSING
from drivers.rig.errors import RESUME, RigStopped
from drivers.rig.plausibility import CheckedSensor, StuckSensorCheck, require_celsius
from drivers.rig.progress import Purpose
from drivers.rig.readings import RESOLUTION, Patience, Reading
from drivers.rig.session import Session
from drivers.rig.store import Store

log = logging.getLogger(__name__)


class Station:
    """The open rig of one campaign.

    Parameters
    ----------
    session : Session
        Open.
    protocol : AcquisitionProtocol
    store : Store
        For the log.

    Attributes
    ----------
    leg : int
        Leg under way; written into every event.
    """

    def __init__(self, session: Session, protocol: AcquisitionProtocol, store: Store) -> None:
        self._session = session
        self._oven = session.oven
        self._protocol = protocol
        self._store = store
        self._patience = Patience(protocol.limits.lost_after)
        self._stuck_check = StuckSensorCheck()
        max_rate = session.oven.limits.max_rate
        self._air = CheckedSensor(self._ask_air, lambda: self.now, max_rate)
        self._plate = CheckedSensor(self._ask_plate, lambda: self.now, max_rate)
        self.leg = -1

    @property
    def now(self) -> float:
        """The rig's time, s."""
        return self._session.now

    def date(self) -> str:
        """Date and time of day, ISO 8601."""
        return self._session.rig.date().isoformat()

    @property
    def sample_rate(self) -> float:
        """Rate of output and inputs as read back, Hz."""
        return self._session.cards.sample_rate

    def play(self, drive: NDArray[np.float64]) -> Record:
        """Play a drive (M,), V, and return the record; aborted if the session is to end."""
        return self._session.cards.sweep(drive, self._session.check)

    def restore(self, events: Sequence[Mapping[str, Any]]) -> None:
        """Set a simulated rig to its last state."""
        self._session.restore(events)

    def note(self, event: str, **what: Any) -> None:
        """Log an event with its time."""
        self._store.log({"event": event, "time": self.now, "date": self.date(), "leg": self.leg, **what})

    def next_reading(self) -> Reading | None:
        """Wait for the next point of the time grid, and read; None if there is no usable reading now.

        Readings are made at whole multiples of the interval, so that their times do not depend on the work in
        between.

        Raises
        ------
        RigStopped
            If readings have been missing for too long, are beyond the limits, or the oven is in alarm.
        DaqError
            If the cards are lost, or refuse in a way that repeating does not cure.
        """
        interval = self._protocol.programme.poll_interval
        self._session.sleep_until((math.floor(self.now / interval + 1e-6) + 1) * interval)
        return self.reading()

    def reading(self) -> Reading | None:
        """Read both temperatures now; see `next_reading`."""
        advice = "Check the oven's line, its sensor and the thermocouple; then run the same command again"
        try:
            found = Reading(self._air.read(), self._plate.read())
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
        self._stuck_check.require_moving(found)
        return found

    def watched(self, reading: Reading) -> float:
        """Return the temperature that triggers sweeps, degrees Celsius."""
        if self._protocol.programme.watch == "air":
            return reading.air
        if reading.plate is None:
            raise RigStopped(
                "programme.watch is the plate, but no thermocouple is wired",
                "Wire one and name it in cards.thermocouples, declare a [thermometer], or watch the air",
            )
        return reading.plate

    def require_celsius(self) -> None:
        """Raise RigStopped if the controller clearly shows another unit; to be called before anything moves."""
        try:
            require_celsius(Reading(self._air.read(), self._plate.read()))
        except (OvenError, DaqError) as error:
            if not _passes(error):
                raise

    def require_reachable(self) -> None:
        """Raise RigStopped if the programme exceeds the controller's own limits, where these can be read."""
        low, high = self._oven.bounds()
        ends = sorted({end for leg in self._protocol.legs for end in (leg.start, leg.end)})
        beyond = [end for end in ends if not low <= end <= high]
        if beyond:
            raise RigStopped(
                f"the controller's own set-points end at {low:g} and {high:g} °C; the programme, with its lead, "
                f"goes to {' and '.join(f'{end:g}' for end in beyond)} °C",
                "Correct programme.lowest, highest and lead, or the controller's limits",
            )

    def _ask_air(self) -> float:
        return round(float(self._oven.temperature()), RESOLUTION)

    def _ask_plate(self) -> float | None:
        readings = self._session.temperatures()
        return round(float(np.mean(readings)), RESOLUTION) if readings.size else None

    def ramp(self, target: float, rate: float, purpose: Purpose) -> None:
        """Start a ramp of the oven, and log the command with its time.

        Parameters
        ----------
        target : float
            Degrees Celsius.
        rate : float
            K/min.
        purpose : str
            ``approach`` to a leg's start, or the ``leg`` itself.

        Raises
        ------
        RigStopped
            If the oven does not take the command.
        """
        self._command("ramp", lambda: self._oven.ramp_to(target, rate), target=target, rate=rate, purpose=purpose)

    def hold(self, why: str) -> None:
        """Hold the oven at its present temperature."""
        self._command("hold", self._oven.hold, purpose=why)

    def _command(self, kind: str, command: Callable[[], Any], **what: Any) -> None:
        before = self.now
        try:
            command()
        except OvenError as error:
            raise RigStopped(f"the oven would not {kind}: {error}", RESUME) from error
        self._store.log(
            {"event": "oven", "command": kind, "time": before, "date": self.date(), "leg": self.leg, **what}
        )

    def regain_cards(self) -> None:
        """Hold the oven and try to open the cards until they are back; RigStopped if that takes too long."""
        self.note("trouble", what="the cards are lost")
        self.hold("cards lost")
        patience = Patience(self._protocol.limits.lost_after)
        while True:
            try:
                self._session.reopen_cards()
            except DaqError as error:
                patience.bad(self.now, f"the cards are lost: {error}", RESUME)
            else:
                self.note("recovered", what="the cards are back")
                return
            self._session.sleep_until(self.now + 5.0)


def _passes(error: OvenError | DaqError) -> bool:
    """Whether the error may be transient, so that the next reading may succeed."""
    if isinstance(error, OvenError):
        return error.fault in PASSING
    return error.action in (Action.RETRY_DISCARD, Action.RETRY_ONCE)
