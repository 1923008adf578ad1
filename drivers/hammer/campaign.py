"""A hammer test, point by point, at one or several temperatures: armed, judged at once, kept, taken up again."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Protocol, cast

import numpy as np

from analysis.estimation.estimators import estimate
from analysis.estimation.spectra import Spectra, pooled
from analysis.protocol.protocol import AcquisitionProtocol
from drivers.hammer.hammer_rig import HammerInputs, HammerRig, HammerStore, HitTrigger
from drivers.hammer.judged_hit import (
    ACCEPTED,
    REJECTED,
    SKIPPED,
    UNDONE,
    HammerProgress,
    HitJudge,
    HitTemperature,
    JudgedHit,
    KeptHit,
)
from drivers.ni.cards import Action, DaqError, go_on
from drivers.ovens.error import OvenError
from drivers.rig.end_requests import RESUME, RigStopped
from drivers.rig.readings import Reading
from drivers.rig.session import Session
from drivers.rig.station import LONGEST_PAUSE, Approach, Station
from drivers.rig.store import Store

READ_TIME = 0.1
"""s read at once: a hit is told this long after its block at most, and keys are looked at as often."""
Key = Literal["undo", "skip", "repeat", "stop"]
Ended = Literal["done", "stopped", "drifted"]


@dataclass(frozen=True)
class AskedHit:
    """The hit that is to be made now.

    Attributes
    ----------
    set_point, point : int
        From 0.
    points : int
    number, wanted : int
        Of the hits at this point; the number from 1.
    """

    set_point: int
    point: int
    points: int
    number: int
    wanted: int


@dataclass(frozen=True)
class ToldHit:
    """What is said of a hit at once.

    Attributes
    ----------
    asked : AskedHit
    step : int
        Its number in the campaign, from 0.
    peak : float
        N.
    rejected : str
        Why it does not count; empty where it does.
    coherence : float or None
        Mean over the band, of all hits at this point; None of a single one.
    doubt : str
        Why the temperature may be wrong; empty where nothing says so.
    """

    asked: AskedHit
    step: int
    peak: float
    rejected: str
    coherence: float | None
    doubt: str = ""


class HammerObserver(Protocol):
    """Shows a hammer test to whoever holds the hammer."""

    def asked(self, hit: AskedHit) -> None:
        """Show which hit is to be made."""
        ...

    def told(self, hit: ToldHit) -> None:
        """Say, to be heard and seen, what came of a hit."""
        ...

    def said(self, line: str) -> None:
        """Say what a key has done."""
        ...


def unmarked(number: int) -> None:
    """Do nothing about a hit that was kept."""


def no_key() -> Key | None:
    """Return None: nobody is at the keyboard."""
    return None


@dataclass
class HammerCampaign:
    """A campaign under way.

    Attributes
    ----------
    rig : HammerRig
    inputs : HammerInputs
        Open.
    trigger : HitTrigger
    judge : HitJudge
    store : HammerStore
    progress : HammerProgress
    band : (float, float)
        Over which coherence is told, Hz.
    observer : HammerObserver
    temperature : callable
        Returns that of the plate now.
    key : callable
        Returns what was typed since it was called last.
    check : callable
        Raises if the campaign is to end.
    held : (float, float)
        Temperatures between which a hit counts, degrees Celsius; infinite where nothing holds the plate.
    mark : callable
        Called with the number of every hit that was kept.
    patience : float
        Longest wait for a hit, s: an oven that nobody is at must not be held for ever.
    """

    rig: HammerRig
    inputs: HammerInputs
    trigger: HitTrigger
    judge: HitJudge
    store: HammerStore
    progress: HammerProgress
    band: tuple[float, float]
    observer: HammerObserver
    temperature: Callable[[], HitTemperature]
    key: Callable[[], Key | None] = no_key
    check: Callable[[], None] = go_on
    held: tuple[float, float] = (-math.inf, math.inf)
    mark: Callable[[int], None] = unmarked
    patience: float = math.inf
    _averaged: dict[int, Spectra] = field(default_factory=dict, repr=False)

    def run(self, set_point: int = 0) -> Ended:
        """Measure the hits that are missing.

        Parameters
        ----------
        set_point : int
            Temperature at which the plate is, from 0.

        Returns
        -------
        str
            ``done``; ``stopped`` by a key; ``drifted`` where the plate has left the temperatures of `held`.

        Raises
        ------
        RigStopped
            If the cards are lost, or nobody hits. The same call goes on with the next missing hit.
        OSError
            If a hit cannot be written.
        """
        try:
            self._begin()
            while (point := self.progress.next_point(set_point)) is not None:
                number = len(self.progress.at(set_point, point)) + 1
                asked = AskedHit(set_point, point, self.progress.points, number, self.progress.wanted)
                self.observer.asked(asked)
                self.rig.ask(point, self.progress.recorded)
                self.trigger.arm()
                found = self._wait()
                if found is None:
                    continue
                if isinstance(found, JudgedHit):
                    if not self._took(found, asked):
                        return "drifted"
                elif not self._typed(found, asked):
                    return "stopped"
            return "done"
        except DaqError as error:
            raise RigStopped(str(error), RESUME) from error

    def _begin(self) -> None:
        """Start to record, of which nothing follows on what was recorded before."""
        self.inputs.begin(self.check)
        self.trigger.reset()

    def _wait(self) -> JudgedHit | Key | None:
        """Return the next hit, or what was typed before it; None where samples were lost, perhaps with a hit."""
        samples = max(round(READ_TIME * self.inputs.sample_rate), 1)
        began = self.rig.clock.now()
        while True:
            self.check()
            if self.rig.clock.now() - began > self.patience:
                raise RigStopped(f"nobody has hit the plate for {self.patience / 60.0:.0f} min", RESUME)
            try:
                record = self.trigger.feed(self.inputs.read(samples))
            except DaqError as error:
                if error.action is not Action.RETRY_DISCARD:
                    raise
                self.observer.said(f"samples were lost ({error}): hit again")
                self._begin()
                return None
            if record is not None:
                return self.judge.judge(record, self.inputs.sample_rate)
            if not self.trigger.under_way and (typed := self.key()) is not None:
                return typed

    def _took(self, hit: JudgedHit, asked: AskedHit) -> bool:
        """Write a hit, then say what came of it: what is told is on the disk. Return whether the plate is held."""
        kept = KeptHit(self.progress.recorded, asked.set_point, asked.point)
        temperature, date = self.temperature(), self.rig.date().isoformat()
        here = temperature.value
        steady = self.held[0] <= here <= self.held[1]
        if not steady and not hit.rejected:
            seen = f"the plate is at {here:.2f} °C" if math.isfinite(here) else "no temperature of the plate"
            wanted = f"{self.held[0]:g} to {self.held[1]:g} °C wanted" if self._holds else temperature.doubt
            hit = replace(hit, rejected=f"{seen}; {wanted}", spectra=None)
        what: dict[str, Any] = {"set_point": kept.set_point, "point": kept.point, "peak": round(hit.peak, 4)}
        coherence: float | None = None
        if hit.rejected:
            self.store.put_aside(hit, kept, temperature, date)
            self._log(REJECTED, date, step=kept.number, **what, why=hit.rejected)
            self.progress.rejected += 1
        else:
            self.store.keep(hit, kept, temperature, date)
            self.progress.valid.append(kept)
            if hit.spectra is not None:
                self._averaged[kept.number] = hit.spectra
            coherence = self._coherence(asked)
            what |= {} if coherence is None else {"coherence": round(coherence, 4)}
            what |= {"doubt": temperature.doubt} if temperature.doubt else {}
            self._log(ACCEPTED, date, step=kept.number, **what, temperature=round(here, 4))
            self.store.declare(self.progress)
            self.mark(kept.number)
        self.progress.recorded += 1
        self.observer.told(ToldHit(asked, kept.number, hit.peak, hit.rejected, coherence, temperature.doubt))
        return steady or not self._holds

    @property
    def _holds(self) -> bool:
        """Whether an oven holds the plate."""
        return self.held[0] > -math.inf

    def _coherence(self, asked: AskedHit) -> float | None:
        """Coherence of the hits at a point, those before an interruption read again."""
        here = self.progress.at(asked.set_point, asked.point)
        self._averaged = {hit.number: self._averaged[hit.number] for hit in here if hit.number in self._averaged}
        for hit in here:
            if hit.number not in self._averaged and (found := self.store.measured(hit).spectra) is not None:
                self._averaged[hit.number] = found
        return _coherence_so_far(list(self._averaged.values()), self.band)

    def _typed(self, key: Key, asked: AskedHit) -> bool:
        """Do what was typed; return whether to go on."""
        here = [hit for hit in self.progress.valid if hit.set_point == asked.set_point]
        match key:
            case "undo" if here:
                self._undo(here[-1])
                self.observer.said(f"hit {here[-1].number} of point {here[-1].point + 1} undone: its file stays")
            case "undo":
                self.observer.said("nothing to undo")
            case "skip":
                self.progress.skipped.add((asked.set_point, asked.point))
                self._log(SKIPPED, self.rig.date().isoformat(), set_point=asked.set_point, point=asked.point)
                self.observer.said(f"point {asked.point + 1} skipped; --again asks for it once more")
            case "repeat":
                undone = self.progress.at(asked.set_point, asked.point)
                for hit in undone:
                    self._undo(hit)
                self.observer.said(f"point {asked.point + 1} from its first hit: {len(undone)} undone")
            case "stop":
                return False
        self.store.declare(self.progress)
        return True

    def _undo(self, hit: KeptHit) -> None:
        self._log(UNDONE, self.rig.date().isoformat(), step=hit.number, set_point=hit.set_point, point=hit.point)
        self.progress.valid.remove(hit)
        self.progress.skipped.discard((hit.set_point, hit.point))

    def _log(self, event: str, date: str, **what: Any) -> None:
        entry: Mapping[str, Any] = {"event": event, "time": self.rig.clock.now(), "date": date, **what}
        self.store.log(entry)


def _coherence_so_far(hits: list[Spectra], band: tuple[float, float]) -> float | None:
    """Return the mean coherence over a band, of the response where it is least; None of fewer than two hits.

    Parameters
    ----------
    band : (float, float)
        Hz.
    """
    if len(hits) < 2:
        return None
    found = estimate(pooled(hits))
    inside = (found.frequency >= band[0]) & (found.frequency <= band[1])
    return float(np.min(found.coherence[:, inside].mean(axis=1)))


MOST_RESETTLINGS = 20
"""Times that a set-point is settled again because the plate left it: an oven that cannot hold it is told."""


@dataclass
class HeldPlate:
    """The plate in an oven that holds a set-point.

    Attributes
    ----------
    session : Session
        Open.
    protocol : AcquisitionProtocol
        Its programme says how the oven moves, and when a temperature is reached.
    store : HammerStore
        For the log.
    told : callable
        Called with the activity and a reading.
    """

    session: Session
    protocol: AcquisitionProtocol
    store: HammerStore
    told: Callable[[str, Reading], None]

    def __post_init__(self) -> None:
        # of a store the station writes the log only
        self._station = Station(self.session, self.protocol, cast(Store, self.store))
        self._approach = Approach(self._station, self.protocol)
        self._next = -math.inf

    def restore(self, events: Sequence[Mapping[str, Any]], temperatures: Sequence[float]) -> None:
        """Set a simulated rig to its last state; on a new one, check what can be before anything moves."""
        if events:
            self._station.restore(events)
        else:
            self._station.require_celsius()
            self._station.require_reachable(temperatures)
        self._station.note("resumed" if events else "begun")

    def temperature(self) -> HitTemperature:
        """Return the temperature that counts, and what is in doubt about it."""
        reading = self._station.reading()
        if reading is None:
            return HitTemperature(math.nan)
        return HitTemperature(self._station.watched(reading), "; ".join(reading.doubts))

    def mark(self, number: int) -> None:
        """Note that a hit was kept at the last reading, to be judged again by what is learnt later."""
        self._station.mark(number)

    def tell_mislabelled(self) -> None:
        """Log the hits whose temperature is in doubt by what was learnt since; see `Station.tell_mislabelled`."""
        self._station.tell_mislabelled()

    def check(self) -> None:
        """Raise if the session is to end, or a reading says so: one is made at every interval."""
        self.session.check()
        now = self._station.now
        if now >= self._next:
            self._next = now + self.protocol.programme.poll_interval
            reading = self._station.reading()
            if reading is not None:
                self.told("held", reading)

    def settle(self, target: float) -> None:
        """Bring the plate to a temperature, and wait until it has stayed there, see `Approach.settle`."""
        programme = self.protocol.programme

        def watch(stage: str, reading: Reading, _: bool) -> bool:
            self.told(stage, reading)
            return False

        stage = f"way to {target:g} °C"
        self._approach.settle(watch, target, programme.ramp_rate, programme.soak_before, stage)


def run_set_points(
    temperatures: Sequence[float], held: HeldPlate, campaign: HammerCampaign, events: Sequence[Mapping[str, Any]]
) -> bool:
    """Measure the hits that are missing, set-point after set-point; the session brings the oven to rest.

    Parameters
    ----------
    temperatures : sequence of float
        Degrees Celsius.
    campaign : HammerCampaign
        Its temperature and its checks are replaced by those of the held plate.
    events : sequence of mapping
        The log, as it was before this run.

    Returns
    -------
    bool
        False where it was stopped by a key.

    Raises
    ------
    RigStopped
        If a set-point is not reached or not held, or the rig cannot continue now. The same call resumes.
    """
    within = held.protocol.programme.settling.within
    try:
        held.restore(events, temperatures)
        for number, target in enumerate(temperatures):
            drifted = 0
            while campaign.progress.next_point(number) is not None:
                held.settle(target)
                here = replace(
                    campaign,
                    inputs=cast(HammerInputs, held.session.cards),  # perhaps lost and opened again on the way
                    temperature=held.temperature,
                    check=held.check,
                    held=(target - within, target + within),
                    mark=held.mark,
                    patience=LONGEST_PAUSE,
                )
                ended = here.run(number)
                if ended == "stopped":
                    return False
                drifted += ended == "drifted"
                if drifted > MOST_RESETTLINGS:
                    raise RigStopped(
                        f"the plate left {target:g} °C by more than {within:g} K {drifted} times",
                        "Can the oven hold it? Look at the oven, or enlarge set_points.within",
                    )
    except (DaqError, OvenError) as error:
        raise RigStopped(str(error), RESUME) from error
    finally:
        held.tell_mislabelled()
    return True
