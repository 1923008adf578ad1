"""Cards and oven together, as a campaign uses them, with logging.

Bringing the plate to a temperature, and reading it meanwhile, whatever happens to cards and oven.
"""

import logging
import math
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from analysis.plate_temperature.plate_sensors import PlateReading, PlateSensors
from analysis.protocol.protocol import AcquisitionProtocol
from drivers.ni.cards import Action, DaqError, Record
from drivers.ovens.error import OvenError
from drivers.ovens.line import PASSING
from drivers.rig.end_requests import RESUME, RigStopped
from drivers.rig.readings import RESOLUTION, CheckedSensor, Patience, Reading, require_agreement, require_celsius
from drivers.rig.session import Session
from drivers.rig.store import Purpose, Store

LINES = "Check the oven's line, its sensor and the thermocouple; then run the same command again"
SENSORS = f"Look at the sensors on the plate, their wires and their module, and at the oven's own sensor. {RESUME}"

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
        self._air = CheckedSensor(self._ask_air, lambda: self.now, session.oven.limits.max_rate)
        self._sensors: PlateSensors | None = None
        self._doubted: tuple[str, ...] = ()
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

    def check(self) -> None:
        """Raise if the session is to end."""
        self._session.check()

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
        try:
            found, wrong = self._read()
        except (OvenError, DaqError) as error:
            if not _passes(error):
                raise
            self._failed(f"no temperature: {error}", str(error), LINES)
            return None
        if wrong:
            if found.believable:  # beyond the limits it stops at once, believed or not
                self._require_within(found)
            self._failed(wrong, wrong, SENSORS)
            return None
        if not found.believable:
            absurd = f"air {found.air} °C, plate {found.plate} °C"
            self._failed(absurd.replace("air ", "air reads ", 1), f"absurd reading: {absurd}", LINES)
            return None
        if self._patience.failing:
            self.note("recovered", air=found.air, plate=found.plate)
        self._patience.good()
        self._require_within(found)
        return found

    def _require_within(self, reading: Reading) -> None:
        reading.require_within(self._protocol.limits.coldest, self._protocol.limits.hottest)

    def _read(self) -> tuple[Reading, str]:
        """Return the temperatures, and what is wrong where those of the plate are not believed."""
        air = self._air.read()
        values = self._ask_plate()
        if not values.size or not Reading(air, None).believable:
            return Reading(air, _mean(values)), ""
        if self._sensors is None:
            self._sensors = PlateSensors(self._protocol.plate_sensors(values.size))
        if not self._sensors.fit(self.now, air, values.tolist()):
            values = self._ask_plate()  # a glitch on the line is unlikely to happen twice
        judged = self._sensors.judge(self.now, air, values.tolist())
        self._tell(judged)
        if judged.temperature is None:
            return Reading(air, _mean(values)), judged.why
        return Reading(air, round(judged.temperature, RESOLUTION), judged.doubts), ""

    def _failed(self, what: str, logged: str, next_step: str) -> None:
        """Log that there is no reading; RigStopped if that has lasted too long."""
        if not self._patience.failing:
            self.note("trouble", what=logged)
        self._patience.bad(self.now, what, next_step)

    def _tell(self, judged: PlateReading) -> None:
        """Log sensors that are left out, and doubts when they begin and end."""
        for what in judged.left_out:
            self.note("sensor left out", what=what)
        if bool(judged.doubts) != bool(self._doubted):
            self.note(
                "temperature in doubt" if judged.doubts else "temperature believed", what=list(judged.doubts)
            )
        self._doubted = judged.doubts

    def mark(self, step: int) -> None:
        """Note that a sweep was kept at the last reading, to be judged again by what is learnt later."""
        if self._sensors is not None:
            self._sensors.mark(step)

    def tell_mislabelled(self) -> None:
        """Log sweeps that were kept, and whose temperature is in doubt by what was learnt since.

        Called at every end: a disk that cannot be written must not hide what ended the campaign.
        """
        found = {} if self._sensors is None else self._sensors.mislabelled()
        for step, why in found.items():
            try:
                self.note("temperature in doubt", step=step, what=[why])
            except OSError as error:
                log.warning("step %d: %s; this could not be logged: %s", step, why, error)

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
            require_celsius(Reading(self._air.read(), _mean(self._ask_plate())))
        except (OvenError, DaqError) as error:
            if not _passes(error):
                raise

    def require_reachable(self, ends: Iterable[float]) -> None:
        """Raise RigStopped if the programme exceeds the controller's own limits, where these can be read.

        Parameters
        ----------
        ends : iterable of float
            Temperatures to which the oven is brought, degrees Celsius.
        """
        low, high = self._oven.bounds()
        beyond = [end for end in sorted(set(ends)) if not low <= end <= high]
        if beyond:
            raise RigStopped(
                f"the controller's own set-points end at {low:g} and {high:g} °C; the programme, with its lead, "
                f"goes to {' and '.join(f'{end:g}' for end in beyond)} °C",
                "Correct programme.lowest, highest and lead, or the controller's limits",
            )

    def _ask_air(self) -> float:
        return round(float(self._oven.temperature()), RESOLUTION)

    def _ask_plate(self) -> NDArray[np.float64]:
        return np.round(self._session.temperatures(), RESOLUTION)

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


def _mean(values: NDArray[np.float64]) -> float | None:
    return round(float(np.mean(values)), RESOLUTION) if values.size else None


def _passes(error: OvenError | DaqError) -> bool:
    """Whether the error may be transient, so that the next reading may succeed."""
    if isinstance(error, OvenError):
        return error.fault in PASSING
    return error.action in (Action.RETRY_DISCARD, Action.RETRY_ONCE)


Result = TypeVar("Result")

LONGEST_PAUSE = 7200.0
"""A longer pause ends the session, with the rig at rest, s."""

Watcher = Callable[[str, Reading, bool], bool]
"""Called with the activity, the temperatures, and whether the leg's ramp has begun; returns whether to pause."""


class Approach:
    """Moves the oven and waits for the plate.

    Parameters
    ----------
    station : Station
    protocol : AcquisitionProtocol
    """

    def __init__(self, station: Station, protocol: AcquisitionProtocol) -> None:
        self._station = station
        self._protocol = protocol
        self._losing = Patience(protocol.limits.lost_after)
        self._mark: tuple[float, float] | None = None
        self._held = False
        self._ramp: tuple[float, float, Purpose] = (0.0, protocol.programme.to_start, "approach")

    def settle(self, watch: Watcher, target: float, rate: float, soak: float, stage: str) -> None:
        """Bring the plate to `target` and soak it there.

        Parameters
        ----------
        target : float
            Degrees Celsius.
        rate : float
            K/min.
        soak : float
            Duration of the soak, s; at least `lasting` of the programme's settling.
        stage : str
            Activity passed to `watch`.

        Raises
        ------
        RigStopped
            If it does not reach `target` in the time allowed by ramp and settling, or air and plate disagree
            there.
        """
        settling = self._protocol.programme.settling
        self._ramp = (target, rate, "approach")
        self._station.ramp(*self._ramp)
        deadline: float | None = None
        inside_since: float | None = None
        plate: deque[tuple[float, float | None]] = deque()
        while True:
            reading = self._read()
            now = self._station.now
            if self._was_held():
                self._station.ramp(*self._ramp)
            if reading is None:
                continue
            here = self._station.watched(reading)
            plate.append((now, reading.plate))
            while len(plate) > 1 and plate[1][0] <= now - 60.0:
                plate.popleft()
            if deadline is None:
                deadline = now + 60.0 * abs(target - here) / rate + settling.timeout
            if watch(stage, reading, False):
                deadline += self._pause(watch)
                continue
            if abs(here - target) > settling.within:
                inside_since = None
            elif inside_since is None:
                inside_since = now
            if inside_since is not None and now - inside_since >= max(settling.lasting, soak):
                require_agreement(reading, plate[0][1] if plate[0][0] <= now - 60.0 else None)
                return
            if inside_since is None and now > deadline:
                late = f"{here:.1f} °C after {settling.timeout:g} s more than the ramp to {target:g} °C takes"
                raise RigStopped(
                    "; ".join([late, *reading.doubts]),
                    "Can the oven reach it? Check the oven, or correct programme and oven limits",
                )

    def _read(self) -> Reading | None:
        reading = self._with_cards(self._station.next_reading)
        if reading is not None:
            self._losing.good()
        return reading

    def _with_cards(self, action: Callable[[], Result]) -> Result | None:
        """Return the result of `action`; None if the cards were lost during it and are back."""
        try:
            return action()
        except DaqError as error:
            if error.action is not Action.LOST_DEVICE:
                raise
            self._losing.bad(self._station.now, f"the cards are lost again and again: {error}", RESUME)
        self._station.regain_cards()
        self._held, self._mark = True, None
        return None

    def _pause(self, watch: Watcher) -> float:
        """Hold the oven and continue reading until the pause ends; return its duration, s."""
        since = self._station.now
        self._station.note("paused")
        self._station.hold("paused")
        while True:
            reading = self._read()
            if reading is not None and not watch("paused", reading, False):
                break
            if self._station.now - since > LONGEST_PAUSE:
                raise RigStopped(f"paused for {LONGEST_PAUSE / 3600:g} h: no oven is held hot for longer", RESUME)
        self._station.note("continued")
        self._held, self._mark = True, None
        return self._station.now - since

    def _was_held(self) -> bool:
        """Whether the oven was held since the last call, for lost cards or a pause."""
        held, self._held = self._held, False
        return held
