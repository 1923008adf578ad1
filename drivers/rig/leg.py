"""One ramp through its set-points."""

from collections.abc import Sequence

from analysis.protocol.protocol import AcquisitionProtocol
from analysis.protocol.set_points import Leg, SweepSetPoint
from drivers.rig.approach import Approach, Watcher
from drivers.rig.errors import RigStopped
from drivers.rig.station import Station
from drivers.rig.sweeping import Sweeping

STALLED = 1800.0
"""The ramp counts as stalled if in this time, s, the temperature moves less than a quarter of the ramp."""
CLOSING_READINGS = 3
"""After the last sweep: a thermocouple that came loose during it, by less than a jump, shows in them."""


class LegRun(Approach):
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
    start : float
        Where the ramp begins, or is begun again, degrees Celsius.
    """

    def __init__(
        self,
        leg: Leg,
        todo: Sequence[SweepSetPoint],
        station: Station,
        sweeping: Sweeping,
        protocol: AcquisitionProtocol,
    ) -> None:
        super().__init__(station, protocol)
        self.leg = leg
        self.todo = list(todo)
        self.start = leg.start
        self._sweeping = sweeping
        self._failures: dict[int, int] = {}
        self._begun_anew = False
        self._ramp = (leg.end, protocol.programme.ramp_rate, "leg")

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
        self.start = start
        self.settle(watch, start, programme.to_start, programme.soak_before, f"way to {start:g} °C")
        self._ramp = (self.leg.end, programme.ramp_rate, "leg")
        self._station.ramp(*self._ramp)

    def _before_next(self) -> float:
        """Return where to restart the ramp, °C: one lead before the next set-point, within the leg."""
        along = self.leg.sign * self.todo[0].temperature - self._protocol.programme.lead
        return self.leg.sign * max(along, self.leg.sign * self.leg.start)

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
        for _ in range(CLOSING_READINGS):
            self._read()

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
