"""A campaign's folder as it grows: read-only, and never stopped by what is damaged in it.

The temperature programme, and the oven's set-point, are lines over time.
"""

import math
from collections.abc import Collection, Mapping, Sequence, Sized
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from analysis.arrays import Real
from analysis.checked_fields import check_shapes
from analysis.protocol.limits import Limits
from analysis.protocol.protocol import AcquisitionProtocol, Programme
from analysis.protocol.sweep import SweepSettings
from analysis.recordings.h1 import h1
from app.files.acquisition import events
from app.files.acquisition.events import (
    LatestRepeat,
    ReadingLine,
    Tail,
    load_latest,
    parse_event,
    parse_reading,
    requested,
    seconds,
)
from app.files.acquisition.same_experiment import REWIRED
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.folder import SWEEPS, read_protocol, read_sweep_file, sweep_paths
from app.files.campaigns.kind import PROTOCOL
from app.files.folder_lock import is_abandoned


@dataclass(frozen=True)
class Course:
    """The part of a temperature programme that is still to come.

    Attributes
    ----------
    time, temperature : (C,) ndarray
        Corners, s from its beginning and degrees Celsius.
    asked_at, asked : (P,) ndarray
        When it meets each set-point, s, and its temperature, degrees Celsius.
    """

    time: Real
    temperature: Real
    asked_at: Real
    asked: Real


def course(
    protocol: AcquisitionProtocol,
    start: float,
    done: Collection[int] = (),
    begun: Collection[int] = (),
    ramping: int | None = None,
) -> Course:
    """Return the programme as `AcquisitionProtocol.seconds` reckons it and a campaign that is continued runs it.

    Parameters
    ----------
    start : float
        Temperature at its beginning, degrees Celsius.
    done : collection of int
        Steps that are finished or given up: a leg without others is left out.
    begun : collection of int
        Legs whose ramp was begun before: it begins anew one lead before the next set-point.
    ramping : int, optional
        Leg in whose ramp the oven still is.
    """
    programme = protocol.programme
    time, temperature = [0.0], [start]
    asked_at: list[float] = []
    asked: list[float] = []

    def then(duration: float, here: float) -> None:
        time.append(time[-1] + duration)
        temperature.append(here)

    for leg in protocol.legs:
        todo = [point for point in leg.set_points if point.step not in done]
        if not todo:
            continue
        if leg.number != ramping:
            along = (
                leg.sign * todo[0].temperature - programme.lead if leg.number in begun else leg.sign * leg.start
            )
            from_here = leg.sign * max(along, leg.sign * leg.start)
            then(60.0 * abs(from_here - temperature[-1]) / programme.to_start, from_here)
            then(max(programme.soak_before, programme.settling.lasting), from_here)
        asked_at += [
            time[-1] + 60.0 * max(leg.sign * (point.temperature - temperature[-1]), 0.0) / programme.ramp_rate
            for point in todo
        ]
        asked += [point.temperature for point in todo]
        then(60.0 * abs(leg.end - temperature[-1]) / programme.ramp_rate, leg.end)
    then(programme.soak_after, temperature[-1])
    return Course(*(np.array(values) for values in (time, temperature, asked_at, asked)))


def set_point_line(
    commands: Sequence[Mapping[str, Any]], when: Sequence[float], at: Real, air: Real, now: float
) -> tuple[Real, Real]:
    """Set-point that follows from the commands sent to the oven; NaN while it is at rest.

    Parameters
    ----------
    commands : sequence of mapping
        Events of the kind ``oven``.
    when : sequence of float
        Their times, s.
    at, air : (R,) ndarray
        Times, s, and temperatures read, degrees Celsius: a ramp begins where the air is.
    now : float
        Time up to which the last command counts, s.

    Returns
    -------
    time, value : (n,) ndarray
        Corners of the line, s and degrees Celsius.
    """
    time: list[float] = []
    value: list[float] = []
    for command, begun, ended in zip(commands, when, [*when[1:], now], strict=False):
        here = float(np.interp(begun, at, air)) if at.size else math.nan
        if command["command"] == "safe":
            time, value = [*time, begun], [*value, math.nan]
            continue
        target = float(command["target"]) if command["command"] == "ramp" else here
        rate = float(command.get("rate", 1.0)) / 60.0
        arrives = min(begun + abs(target - here) / rate, ended) if math.isfinite(here) else begun
        reached = here + math.copysign(rate * (arrives - begun), target - here)
        time += [begun, arrives, ended]
        value += [here, reached, reached]
    return np.array(time), np.array(value)


FRFS_SHOWN = 24
"""FRFs shown at once."""
AT_A_TIME = 4
"""Sweeps read in one look, so that the window never waits long."""
SILENT_AFTER = 60.0
"""Seconds without a sign from the runner, beyond those that it may need, after which it counts as silent."""
WATCHDOG = "watchdog.log"
"""What the watchdog said that nobody may have been there to read: a date, then a sentence."""
ENDS_TROUBLE = frozenset({"recovered", "finished", "sweep begun", "begun", "resumed"})
"""Events after which an earlier trouble is over; so it is after a ramp."""
State = Literal["not begun", "running", "pausing", "paused", "silent", "stopped", "complete"]


@dataclass(frozen=True)
class MeasuredSweep:
    """The FRFs of one finished sweep.

    Attributes
    ----------
    step : int
    direction : str
    temperature : float
        Degrees Celsius.
    frequency : (F,) ndarray
        Hz.
    h : (K, F) complex ndarray
        In the units of the transfers.
    coherence : (K, F) ndarray
    """

    step: int
    direction: str
    temperature: float
    frequency: NDArray[np.float64]
    h: NDArray[np.complex128]
    coherence: NDArray[np.float64]

    def __post_init__(self) -> None:
        check_shapes(self, frequency="F", h="K F", coherence="K F")


class Watched:
    """What is known of a campaign; `look` brings it up to date.

    Parameters
    ----------
    folder : Path
        A campaign folder.
    kept : int
        Finished sweeps of which the FRFs are kept, the last ones.

    Attributes
    ----------
    folder : Path
    experiment : Experiment
    protocol : AcquisitionProtocol or None
        None for a campaign that was imported.
    simulated : bool
        Whether its rig is simulated: dates are those of the rig's own, virtual clock.
    events : list of dict
    said : list of (str, str)
        What the watchdog said: date, ISO 8601, and sentence.
    readings : list of ReadingLine
    sweeps : dict of int to MeasuredSweep
        The last ones, by step.
    latest : LatestRepeat or None
    problems : dict of str to str
        What cannot be read, by file.

    Raises
    ------
    CampaignFileError
        If the frozen protocol cannot be read.
    """

    def __init__(self, folder: Path, kept: int = FRFS_SHOWN) -> None:
        self.folder, self._kept = folder, kept
        frozen, self.experiment = read_protocol(folder)
        self.protocol = _protocol(folder, frozen.get("acquired"))
        self.simulated = (frozen.get("acquired") or {}).get("rig") == "simulated"
        self.events: list[dict[str, Any]] = []
        self.said: list[tuple[str, str]] = []
        self.readings: list[ReadingLine] = []
        self.sweeps: dict[int, MeasuredSweep] = {}
        self.latest: LatestRepeat | None = None
        self.problems: dict[str, str] = {}
        self._tails = {name: Tail(folder / name) for name in (events.NAME, events.READINGS, WATCHDOG)}
        self._seen: set[str] = set()
        self._latest_time = 0.0

    def look(self) -> bool:
        """Read what is new; return whether anything is."""
        before = self._amounts()
        for line in self._tails[events.NAME].lines():
            self._take_event(line)
        found = (parse_reading(line) for line in self._tails[events.READINGS].lines())
        self.readings += [reading for reading in found if reading is not None]
        told = (told_by_watchdog(line) for line in self._tails[WATCHDOG].lines())
        self.said += [one for one in told if one is not None]
        if not self.events and self.there:
            self.problems[events.NAME] = "not there, or it cannot be read; sweeps are counted by their files"
        self._look_at_latest()
        self._look_at_sweeps()
        return before != self._amounts()

    def _amounts(self) -> tuple[float, ...]:
        grown: tuple[Sized, ...] = (self.events, self.readings, self.said, self._seen, self.problems)
        return (*(len(one) for one in grown), self._latest_time)

    def state(self, now: float) -> State:
        """Return where the campaign is; `now` is the time of day, s since 1970."""
        last: dict[str, Any] = next(
            (e for e in reversed(self.events) if e.get("event") in ("oven", "begun", "resumed")), {}
        )
        if last.get("command") == "safe":
            return "complete" if last.get("purpose") == "the end" else "stopped"
        if self.abandoned or now - self.last_sign > self.patience:
            return "silent"
        if not self.events:
            return "stopped" if self.there else "not begun"
        resting = next(
            (e["event"] for e in reversed(self.events) if e.get("event") in ("paused", "continued")), ""
        )
        if resting == "paused":
            return "paused"
        return "pausing" if requested(self.folder) == "pause" else "running"

    @property
    def abandoned(self) -> bool:
        """Whether its process is known to be gone; False where nobody can tell."""
        return is_abandoned(self.folder)

    @property
    def patience(self) -> float:
        """Longest time without a sign from a runner that is well, s: a sweep, an interval, and a margin.

        While the rig is in trouble, it tries for `limits.lost_after` to regain cards, oven or readings.
        """
        if self.protocol is None:
            return SILENT_AFTER
        needed = self.protocol.sweep_seconds + self.protocol.programme.poll_interval
        return SILENT_AFTER + needed + (self.protocol.limits.lost_after if self.trouble is not None else 0.0)

    @property
    def trouble(self) -> str | None:
        """What the rig is trying to overcome now; None where nothing is wrong."""
        for event in reversed(self.events):
            if event["event"] == "trouble":
                return str(event.get("what", ""))
            if event["event"] in ENDS_TROUBLE or event.get("command") in ("ramp", "safe"):
                return None
        return None

    @property
    def last_sign(self) -> float:
        """Time of the last sign of the runner, s since 1970; that of its protocol before there is another."""
        names = (events.NAME, events.READINGS, events.LATEST)
        last = max((self._changed(self.folder / name) for name in names), default=0.0)
        return last or self._changed(self.folder / PROTOCOL)

    def events_of(self, kind: str) -> list[dict[str, Any]]:
        """Return every event of a kind."""
        return [event for event in self.events if event.get("event") == kind]

    @property
    def there(self) -> set[int]:
        """Steps of the sweeps whose files are there."""
        return {int(path.name[:4]) for path in sweep_paths(self.folder) if path.name[:4].isdigit()}

    @property
    def finished(self) -> set[int]:
        """Steps of the sweeps that were finished: by the log, or, where that is away, by their files."""
        by_log = {event.get("step") for event in self.events_of("finished")}
        return {step for step in by_log if isinstance(step, int)} if self.events else self.there

    @property
    def progress(self) -> tuple[int, int, float]:
        """Sweeps done, all of them, and the seconds left."""
        done = {event.get("step") for kind in ("finished", "missing") for event in self.events_of(kind)}
        left = self.readings[-1].seconds_left if self.readings else float("nan")
        return len(done), self.protocol.count if self.protocol is not None else len(done), left

    @property
    def course(self) -> tuple[float, Course] | None:
        """When the campaign was begun or continued last, s since 1970, and its programme from then on."""
        places = [n for n, event in enumerate(self.events) if event["event"] in ("begun", "resumed")]
        if self.protocol is None or not places:
            return None
        since, before = seconds(self.events[places[-1]]["date"]), self.events[: places[-1]]
        first = next((one for one in self.readings if seconds(one.date) >= since), None)
        if first is None:
            return None
        done = {int(e["step"]) for e in before if e["event"] in ("finished", "missing") and "step" in e}
        ramps = [event for event in before if event["event"] == "oven"]
        begun = {int(event["leg"]) for event in ramps if event.get("purpose") == "leg"}
        ramping = int(ramps[-1]["leg"]) if ramps and ramps[-1].get("purpose") == "leg" else None
        here = (
            first.air_c if math.isnan(first.plate_c) or self.protocol.programme.watch == "air" else first.plate_c
        )
        return seconds(first.date), course(self.protocol, here, done, begun, ramping)

    def _take_event(self, line: str) -> None:
        try:
            event = parse_event(line)
            if event["event"] == REWIRED and self.events:  # it is written before the rig and its clock are known
                event.setdefault("date", self.events[-1]["date"])
            seconds(event["date"])
            self.events.append(event)
        except (ValueError, KeyError, TypeError):
            self.problems[events.NAME] = f"a line that is no event: {line[:60]!r}"

    @staticmethod
    def _changed(path: Path) -> float:
        try:
            return path.stat().st_mtime
        except OSError:
            return 0.0

    def _look_at_latest(self) -> None:
        changed = self._changed(self.folder / events.LATEST)
        if changed > self._latest_time:
            self._latest_time = changed
            self.latest = load_latest(self.folder) or self.latest

    def _look_at_sweeps(self) -> None:
        """Read the newest sweeps not seen yet, a few at a time; those that would not be shown are left unread."""
        new = [path for path in sweep_paths(self.folder)[-self._kept :] if path.name not in self._seen]
        for path in new[: -AT_A_TIME - 1 : -1]:
            self._seen.add(path.name)
            sweep, wrong = read_sweep_file(path, f"{SWEEPS}/{path.name}")
            if wrong is not None:
                self.problems[wrong.file] = f"{wrong.key} {wrong.seen}".strip()
            if sweep is not None:
                rate = self.experiment.acquisition.sample_rate
                frequency = np.fft.rfftfreq(sweep.drive.shape[1], 1.0 / rate).astype(np.float64)
                low, high = self.experiment.protocol.band
                band = (frequency >= low) & (frequency <= high)
                h, _, coherence = zip(*(h1(sweep.drive, response) for response in sweep.responses), strict=True)
                self.sweeps[sweep.step] = MeasuredSweep(
                    sweep.step,
                    sweep.direction,
                    sweep.temperature,
                    frequency[band],
                    np.array(h)[:, band],
                    np.array(coherence)[:, band],
                )
        for step in sorted(self.sweeps)[: -self._kept]:
            del self.sweeps[step]


def told_by_watchdog(line: str) -> tuple[str, str] | None:
    """Take a line of the watchdog's apart; None for what is none."""
    date, sentence = line[:25], line[26:].strip()
    try:
        seconds(date)
    except ValueError:
        return None
    return (date, sentence) if sentence else None


def _protocol(folder: Path, acquired: dict[str, Any] | None) -> AcquisitionProtocol | None:
    if acquired is None:
        return None
    try:
        return AcquisitionProtocol(
            SweepSettings.model_validate(acquired["sweep"]),
            Programme.model_validate(acquired["programme"]),
            Limits.model_validate(acquired["limits"]),
            settling=_settling(acquired.get("cards") or {}),
        )
    except (KeyError, TypeError, ValueError, ValidationError) as error:
        raise CampaignFileError(folder, []) from error


def _settling(cards: dict[str, Any]) -> float:
    """Silence before every repeat, s, as `drivers.ni.wiring` has it; 0 for what has no IEPE sensors."""
    return min(max(float(cards.get("iepe_settling", 5.0)), 0.0), 60.0) if cards.get("iepe") else 0.0
