"""One ramp through its set-points."""

from collections import deque
from collections.abc import Callable, Sequence
from typing import TypeVar

from analysis.protocol.protocol import AcquisitionProtocol
from analysis.protocol.set_points import Leg, SweepSetPoint
from drivers.ni.errors import Action, DaqError
from drivers.rig.errors import RESUME, RigStopped
from drivers.rig.plausibility import require_agreement
from drivers.rig.progress import Purpose
from drivers.rig.readings import Patience, Reading
from drivers.rig.station import Station
from drivers.rig.sweeping import Sweeping

Result = TypeVar("Result")

LONGEST_PAUSE = 7200.0
"""A longer pause ends the session, with the rig at rest, s."""

STALLED = 1800.0
"""The ramp counts as stalled if in this time, s, the temperature moves less than a quarter of the ramp."""

Watcher = Callable[[str, Reading, bool], bool]
"""Called with the activity, the temperatures, and whether the leg's ramp has begun; returns whether to pause."""


class LegRun:
    """Runs one leg.

    Parameters
    ----------
    leg : Leg
    todo : sequence of SweepSetPoint
        Remaining set-points.
    station : Station
    sweeping : Sweeping
    protocol : AcquisitionProtocol

    Attributes
    ----------
    leg : Leg
    todo : list of SweepSetPoint
        What is left.
    """

    def __init__(
        self,
        leg: Leg,
        todo: Sequence[SweepSetPoint],
        station: Station,
        sweeping: Sweeping,
        protocol: AcquisitionProtocol,
    ) -> None:
        self.leg = leg
        self.todo = list(todo)
        self._station = station
        self._sweeping = sweeping
        self._protocol = protocol
        self._failures: dict[int, int] = {}
        self._losing = Patience(protocol.limits.lost_after)
        self._mark: tuple[float, float] | None = None
        self._begun_anew = False
        self._held = False
        self._ramp: tuple[float, float, Purpose] = (leg.end, protocol.programme.ramp_rate, "leg")

    def run(self, watch: Watcher, *, under_way: bool, begun: bool) -> None:
        """Measure the remaining set-points.

        Parameters
        ----------
        under_way : bool
            Whether the oven is in this leg's ramp already: set-points that it has passed are missed.
        begun : bool
            Whether the ramp was begun before and interrupted: it starts again just before the next set-point, not
            at the leg's start.
        """
        if not under_way:
            self._begin(watch, self._before_next() if begun else self.leg.start)
        self._measure(watch)

    def _begin(self, watch: Watcher, start: float) -> None:
        """Bring the plate to `start` and start the ramp there."""
        programme = self._protocol.programme
        self.settle(watch, start, programme.to_start, programme.soak_before, f"way to {start:g} °C")
        self._ramp = (self.leg.end, programme.ramp_rate, "leg")
        self._station.ramp(*self._ramp)

    def _before_next(self) -> float:
        """Return where to restart the ramp, °C: one lead before the next set-point, within the leg."""
        along = self.leg.sign * self.todo[0].temperature - self._protocol.programme.lead
        return self.leg.sign * max(along, self.leg.sign * self.leg.start)

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

    def _measure(self, watch: Watcher) -> None:
        sign, travel = self.leg.sign, self._protocol.sweep_travel
        tolerance = self._protocol.programme.tolerance
        while self.todo:
            reading = self._read()
            if self._was_held():  # the plate has drifted while held: go back, then ramp steadily through the rest
                self._begin(watch, self._before_next())
                continue
            if reading is None:
                continue
            here = self._station.watched(reading)
            if watch(f"{self.leg.direction} to {self.todo[0].temperature:g} °C", reading, True):
                self._pause(watch)
                continue
            # Temperature at the middle of a sweep started now, positive in the ramp's direction.
            middle = sign * here + 0.5 * travel
            while self.todo and middle > sign * self.todo[0].temperature + tolerance:
                self._give_up(self.todo[0], f"passed: {here:.2f} °C when a sweep could have begun")
            if self.todo and middle >= sign * self.todo[0].temperature + self.todo[0].offset * travel:
                self._sweep(self.todo[0])
            elif self.todo:
                self._require_progress(sign * here)

    def _sweep(self, set_point: SweepSetPoint) -> None:
        self._mark = None
        made = self._with_cards(lambda: self._sweeping.attempt(set_point))
        if made is not None and not made.faults:
            self.todo.remove(set_point)
            return
        failed = self._failures.get(set_point.step, 0) + 1
        self._failures[set_point.step] = failed
        if failed > self._protocol.limits.retries or (made is not None and not made.may_repeat):
            last = "the cards were lost" if made is None else "; ".join(made.faults)
            self._give_up(set_point, f"{failed} attempts failed; the last: {last}")

    def _give_up(self, set_point: SweepSetPoint, why: str) -> None:
        self.todo.remove(set_point)
        self._station.note("missing", step=set_point.step, place=str(set_point), why=why)

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

    def _require_progress(self, along: float) -> None:
        """Restart a stalled ramp once; raise RigStopped if that does not help.

        A key may have been pressed on the oven, or a killed program may have brought it to rest without logging
        it.
        """
        now, least = self._station.now, 0.25 * self._protocol.programme.ramp_rate * STALLED / 60.0
        if self._mark is None or along - self._mark[1] >= least:
            self._mark = (now, along)
        if now - self._mark[0] < STALLED:
            return
        here = self.leg.sign * along
        if self._begun_anew:
            raise RigStopped(
                f"the temperature stays at {here:.1f} °C: the oven does not ramp",
                "Look at the oven: is it in remote control, and is its heating or cooling on?",
            )
        self._begun_anew, self._mark = True, None
        self._station.note("trouble", what=f"the ramp has halted at {here:.1f} °C; it is started again")
        self._station.ramp(*self._ramp)
