"""A hammer test, point by point: armed, judged at once, kept, and taken up again where it was interrupted."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, Protocol

import numpy as np

from analysis.estimation.estimators import estimate
from analysis.estimation.spectra import Spectra, pooled
from drivers.hammer.hammer_rig import HammerInputs, HammerRig
from drivers.hammer.judged_hit import HitJudge, HitTemperature, JudgedHit
from drivers.hammer.progress import ACCEPTED, REJECTED, SKIPPED, UNDONE, HammerProgress, KeptHit
from drivers.hammer.store import HammerStore
from drivers.hammer.trigger import HitTrigger
from drivers.ni.cards import go_on
from drivers.ni.errors import Action, DaqError
from drivers.rig.errors import RESUME, RigStopped

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
