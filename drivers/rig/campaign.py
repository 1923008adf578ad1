"""A campaign from its first leg to its end, started or resumed; each set-point swept, checked, repeated."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from analysis.plate_temperature.resonances import FrfThermometer, log_spectrum
from analysis.protocol.acceptance import faults
from analysis.protocol.protocol import AcquisitionProtocol, Leg, SweepSetPoint
from analysis.protocol.sweep import drive_signal
from analysis.recordings.campaign import Sweep
from analysis.recordings.h1 import h1
from drivers.ni.cards import DaqError
from drivers.ovens.error import OvenError
from drivers.rig.end_requests import RESUME, RigStopped
from drivers.rig.readings import Reading
from drivers.rig.session import Session
from drivers.rig.station import Approach, Station, Watcher
from drivers.rig.store import Progress, Store


@dataclass(frozen=True)
class Attempt:
    """Result of one attempt.

    Attributes
    ----------
    sweep : Sweep or None
        None if there is no complete record.
    faults : tuple of str
        Why it is rejected; empty for a good sweep.
    may_repeat : bool
        Whether another attempt may succeed.
    """

    sweep: Sweep | None
    faults: tuple[str, ...]
    may_repeat: bool = True


class Sweeping:
    """Makes the sweeps of a campaign.

    Parameters
    ----------
    station : Station
    protocol : AcquisitionProtocol
    store : Store
    attempts : dict of int to int
        Attempts made so far, by step, including those before an interruption.
    doubted : set of int
        Steps of finished sweeps whose temperature is in doubt.
    """

    def __init__(
        self,
        station: Station,
        protocol: AcquisitionProtocol,
        store: Store,
        attempts: dict[int, int],
        doubted: Collection[int] = (),
    ) -> None:
        self._station = station
        self._protocol = protocol
        self._store = store
        self._attempts = attempts
        self._thermometer = FrfThermometer()
        for sweep in store.sweeps():
            station.check()
            self._by_resonances(sweep, doubted=sweep.step in doubted)

    def attempt(self, set_point: SweepSetPoint) -> Attempt:
        """Make one attempt; store a good sweep, put a faulty one aside.

        Raises
        ------
        DaqError
            If the cards are lost, or refuse in a way that repeating does not cure.
        RigStopped
            If the oven or a temperature requires a stop.
        OSError
            If the sweep cannot be written.
        """
        number = self._attempts.get(set_point.step, 0) + 1
        self._attempts[set_point.step] = number
        self._station.note("sweep begun", step=set_point.step, place=str(set_point), attempt=number)
        try:
            made = self._make(set_point)
        except DaqError as error:
            if error.action.retries == 0:
                raise
            made = Attempt(None, (str(error),), may_repeat=number <= error.action.retries)
        what = {"step": set_point.step, "place": str(set_point), "attempt": number}
        if made.sweep is not None and not made.faults:
            self._store.keep(made.sweep, set_point, number)
            self._station.mark(set_point.step)
            doubt = {"doubt": made.sweep.doubt} if made.sweep.doubt else {}
            self._station.note("finished", **what, temperature=round(made.sweep.temperature, 4), **doubt)
            return made
        if made.sweep is not None:
            self._store.put_aside(made.sweep, set_point, number, made.faults)
        self._station.note("rejected", **what, faults=list(made.faults))
        return made

    def _make(self, set_point: SweepSetPoint) -> Attempt:
        station, sweep = self._station, self._protocol.sweep
        rate = station.sample_rate
        drive = drive_signal(sweep, set_point.level, rate)
        before, began = station.reading(), station.date()
        if before is None:
            return Attempt(None, ("no temperature before the sweep",))
        drives, responses, overloaded = [], [], np.zeros(0, dtype=bool)
        readings = [before]
        for repeat in range(sweep.repeats):
            if repeat:  # the oven is read at least once per repeat
                between = station.reading()
                if between is None:
                    return Attempt(None, (f"no temperature before repeat {repeat + 1}",))
                readings.append(between)
            record = station.play(drive)
            self._store.show(record, set_point, repeat)
            if record.drive.shape != drive.shape:
                fault = f"repeat {repeat + 1}: {record.drive.size} samples came, {drive.size} were played"
                return Attempt(None, (fault,))
            drives.append(record.drive.astype(np.float32))
            responses.append(record.responses.astype(np.float32))
            overloaded = record.overloaded if not repeat else overloaded | record.overloaded
        after = station.reading()
        if after is None:
            return Attempt(None, ("no temperature after the sweep",))
        made = _sweep(set_point, [*readings, after], began, drives, responses)
        wrong = faults(made, drive, overloaded, rate, set_point, self._protocol)
        if not wrong:
            contradicted = self._by_resonances(made, doubted=bool(made.doubt))
            made = replace(made, doubt="; ".join(filter(None, (made.doubt, contradicted))))
        return Attempt(made, wrong)

    def _by_resonances(self, sweep: Sweep, *, doubted: bool) -> str:
        """Return what the resonances of a good sweep say against the reading of the plate's sensor."""
        if sweep.plate_temperature_start is None:
            return ""
        frequency = np.fft.rfftfreq(sweep.drive.shape[1], 1.0 / self._station.sample_rate).astype(np.float64)
        low, high = self._protocol.sweep.band
        inside = (frequency >= low) & (frequency <= high)
        if inside.sum() < 2:
            return ""
        h = np.array([h1(sweep.drive, response)[0][inside] for response in sweep.responses])
        spectrum = log_spectrum(frequency[inside], h)
        return self._thermometer.judge(
            sweep.level, sweep.temperature, spectrum, doubted=doubted or bool(sweep.doubt)
        )


LAST_SOAK = "last soak"


@dataclass(frozen=True)
class Moment:
    """State of a running campaign.

    Attributes
    ----------
    stage : str
        Present activity.
    temperature : float
        Temperature that triggers sweeps, degrees Celsius.
    done, total : int
        Number of sweeps finished or given up, and of all sweeps.
    seconds_left : float
        Estimate.
    date : str
        ISO 8601.
    reading : Reading
        Both temperatures.
    given_up : int
        Of those done.
    """

    stage: str
    temperature: float
    done: int
    total: int
    seconds_left: float
    date: str
    reading: Reading
    given_up: int = 0


class Observer(Protocol):
    """Callable that receives the progress of a campaign."""

    def __call__(self, moment: Moment) -> None:
        """Receive the state; called at every reading."""
        ...


@dataclass(frozen=True)
class Outcome:
    """Result of a campaign.

    Attributes
    ----------
    finished, missing : int
        Sweeps kept and sweeps given up, over the whole campaign.
    made_now : int
        Sweeps finished by this run.
    doubted : int
        Finished sweeps whose temperature is in doubt.
    """

    finished: int
    missing: int
    made_now: int
    doubted: int = 0


def unobserved(moment: Moment) -> None:
    """Show nothing of a campaign's progress."""


def never() -> bool:
    """Return False: no pause is requested."""
    return False


def run_campaign(
    session: Session,
    protocol: AcquisitionProtocol,
    store: Store,
    observer: Observer = unobserved,
    *,
    paused: Callable[[], bool] = never,
    again: bool = False,
) -> Outcome:
    """Run the remaining part of a campaign.

    In every case the session brings the rig to rest on exit. Only if the process is killed, and no watchdog takes
    over, does the oven continue its ramp: set-points that it passes before the campaign is resumed are missed. A
    campaign with nothing left to do ends at once; its session still brings the rig to rest.

    Parameters
    ----------
    session : Session
        Open.
    observer : callable
        May raise `RigStopped` to end the campaign for now.
    paused : callable
        Returns whether a pause is requested; called at every reading. The oven holds its temperature meanwhile;
        afterwards the ramp is started again before the next set-point.
    again : bool
        Whether to repeat missed and failed set-points: their legs are run from the start.

    Returns
    -------
    Outcome
        How many sweeps are finished, how many given up, and how many this run added.

    Raises
    ------
    RigStopped
        If the rig cannot continue now. The same call resumes the campaign.
    OSError
        If the store cannot write a sweep or an event, usually because the disk is full.
    """
    events = store.events()
    progress = Progress.of(store.finished(), events, again=again)
    if session.rig.supervise is not None:
        # The watchdog of a process that was killed brings the oven to rest, and cannot log it: a ramp that the log
        # says is under way would be waited for until it counts as stalled.
        progress = replace(progress, ramping=None)
    left = [leg for leg in protocol.legs if _todo(leg, progress)]
    station = Station(session, protocol, store)
    try:
        if events:
            station.restore(events)
        if not left:
            return Outcome(len(progress.finished), len(progress.given_up), 0, len(progress.doubted))
        begun = any(event.get("event") == "begun" for event in events)  # a start that failed has events, too
        if not begun:
            station.require_celsius()
            station.require_reachable(end for leg in protocol.legs for end in (leg.start, leg.end))
        station.note("resumed" if begun else "begun", finished=len(progress.finished))
        try:
            _run_legs(left, progress, station, protocol, store, observer, paused)
        finally:
            station.tell_mislabelled()
    except (DaqError, OvenError) as error:
        raise RigStopped(str(error), RESUME) from error
    ended = Progress.of(store.finished(), store.events())
    made_now = len(ended.finished) - len(progress.finished)
    return Outcome(len(ended.finished), len(ended.given_up), made_now, len(ended.doubted))


def _todo(leg: Leg, progress: Progress) -> list[SweepSetPoint]:
    done = progress.finished | progress.given_up
    return [point for point in leg.set_points if point.step not in done]


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
    given_up : int
        Set-points given up so far.
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
        self.given_up = 0
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
        self.given_up += 1
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


def _run_legs(
    left: list[Leg],
    progress: Progress,
    station: Station,
    protocol: AcquisitionProtocol,
    store: Store,
    observer: Observer,
    paused: Callable[[], bool],
) -> None:
    sweeping = Sweeping(station, protocol, store, dict(progress.attempts), progress.doubted)
    total, given_up = protocol.count, len(progress.given_up)
    for leg in left:
        station.leg = leg.number
        todo = _todo(leg, progress)
        later = sum(len(_todo(other, progress)) for other in left if other.number > leg.number)
        run = LegRun(leg, todo, station, sweeping, protocol)

        def watch(
            stage: str,
            reading: Reading,
            ramping: bool,
            run: LegRun = run,
            later: int = later,
            before: int = given_up,
        ) -> bool:
            temperature = station.watched(reading)
            leg_under_way = run.leg.number + (stage == LAST_SOAK)  # then the leg itself is finished
            start = run.start if leg_under_way == run.leg.number else None
            seconds = protocol.seconds(temperature, leg_under_way, ramping=ramping, start=start)
            done = total - later - len(run.todo)
            lost = before + run.given_up
            observer(Moment(stage, temperature, done, total, seconds, station.date(), reading, lost))
            return paused()

        run.run(watch, under_way=progress.ramping == leg.number, begun=leg.number in progress.begun)
        given_up += run.given_up
        if leg is left[-1] and protocol.programme.soak_after:
            run.settle(watch, leg.end, protocol.programme.ramp_rate, protocol.programme.soak_after, LAST_SOAK)


def _sweep(
    set_point: SweepSetPoint,
    readings: list[Reading],
    began: str,
    drives: list[NDArray[np.float32]],
    responses: list[NDArray[np.float32]],
) -> Sweep:
    before, after = readings[0], readings[-1]
    doubts = dict.fromkeys(why for reading in readings for why in reading.doubts)
    return Sweep(
        step=set_point.step,
        direction=set_point.direction,
        level=set_point.level,
        oven_temperature_start=before.air,
        oven_temperature_end=after.air,
        start_time=began,
        drive=np.stack(drives),
        responses=np.stack(responses, axis=1),
        plate_temperature_start=before.plate,
        plate_temperature_end=after.plate,
        doubt="; ".join(doubts),
    )
