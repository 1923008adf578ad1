"""Bringing the plate to a temperature, and reading it meanwhile, whatever happens to cards and oven."""

from collections import deque
from collections.abc import Callable
from typing import TypeVar

from analysis.protocol.protocol import AcquisitionProtocol
from drivers.ni.errors import Action, DaqError
from drivers.rig.errors import RESUME, RigStopped
from drivers.rig.readings import Patience, Reading, require_agreement
from drivers.rig.station import Station
from drivers.rig.store import Purpose

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
