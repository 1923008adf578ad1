"""How a campaign or a hammer test stands: what `flexura watch` and `flexura status` say, with its exit status."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import datetime, timedelta
from typing import Any, Literal

import numpy as np

from app.files.acquisition.events import seconds
from app.files.bad_file import quoted
from app.files.folder_lock import is_being_written
from app.summaries.numbers import duration
from app.watch.watched import Watched, set_point_line
from app.watch.watched_hits import WatchedHits
from app.watch.words import ended_by, in_words, plain
from drivers.hammer.judged_hit import ACCEPTED, REJECTED

Standing = Literal["not begun", "running", "pausing", "paused", "silent", "stopped", "complete", "gone"]
UNDER_WAY = ("not begun", "running", "pausing", "paused")
COMPLETE, NOT_WHOLE, NOT_AT_REST, SILENT, GOING_ON = 0, 1, 3, 4, 5
"""Exit statuses; 2 is bad input."""
AT_REST_AGAIN = ("the oven is at rest", "the oven cools after all")
"""Of what the watchdog says."""


@dataclass(frozen=True)
class CampaignStatus:
    """What is known of a campaign at one moment.

    Attributes
    ----------
    name, folder : str
    state : str
        ``silent``: nothing was written for longer than `patience`, or its process is gone. ``gone``: the folder
        cannot be read.
    problem : str
        What cannot be read; empty where all can.
    simulated : bool
        Whether the rig is simulated; `read`, `ends` and `seconds_left` are then of its own, virtual time.
    stage : str
        Present activity.
    air, plate, set_point : float or None
        Degrees Celsius, last known; `set_point` as the commands sent to the oven make it, None at rest.
    coldest, hottest : float or None
        Limits, degrees Celsius.
    lowest, highest : float or None
        Between which the programme takes the oven, its way from the first reading included, degrees Celsius.
    finished, missing, lost, total : int
        Sweeps kept, given up, kept of which the files are not there any more, and asked for.
    given_up : str
        Which was given up last, and why.
    doubted : int
        Finished sweeps whose temperature is in doubt.
    seconds_left : float or None
        Estimate, from the last reading on.
    read, ends : str or None
        Date of the last reading and expected end, ISO 8601.
    silent_for, patience : float
        Seconds since the runner's last sign, and how many of them are no reason to worry.
    rest : str
        ``at rest``, ``not at rest``, ``follows the programme``, or ``unknown``.
    unsafe : tuple of str
        What could not be verified to be at rest.
    clipping : tuple of str
        Channels of the last repeat that came near the range of their input.
    trouble : str
        What the rig is trying to overcome; empty where nothing is wrong.
    ending : str
        Why it was stopped; empty while it runs.
    kind : str
        What `finished`, `missing` and `total` count: ``sweeps``, or the ``hits`` of a hammer test.
    rejected : int
        Hits that were rejected.
    abandoned : bool
        Whether it is silent because its process is gone.
    next_step : str
        What to do; empty where it is not known.
    """

    name: str
    folder: str
    state: Standing
    problem: str = ""
    simulated: bool = False
    stage: str = ""
    air: float | None = None
    plate: float | None = None
    set_point: float | None = None
    coldest: float | None = None
    hottest: float | None = None
    lowest: float | None = None
    highest: float | None = None
    finished: int = 0
    missing: int = 0
    lost: int = 0
    given_up: str = ""
    total: int = 0
    doubted: int = 0
    seconds_left: float | None = None
    read: str | None = None
    ends: str | None = None
    silent_for: float = 0.0
    patience: float = 0.0
    rest: str = "unknown"
    unsafe: tuple[str, ...] = ()
    clipping: tuple[str, ...] = ()
    trouble: str = ""
    ending: str = ""
    kind: Literal["sweeps", "hits"] = "sweeps"
    rejected: int = 0
    abandoned: bool = False
    next_step: str = ""

    @property
    def exit_status(self) -> int:
        """Exit status of ``flexura status``; NOT AT REST comes before everything else."""
        if self.unsafe:
            return NOT_AT_REST
        if self.state in ("silent", "gone"):
            return SILENT
        if self.state == "complete":
            return NOT_WHOLE if self.missing or self.lost else COMPLETE
        return NOT_WHOLE if self.state == "stopped" else GOING_ON

    @property
    def line(self) -> str:
        """All of it that matters, in one line."""
        return "; ".join(part for part in self._parts() if part)

    def record(self) -> dict[str, Any]:
        """Return the fields and the line, for JSON."""
        return asdict(self) | {"line": self.line, "exit_status": self.exit_status}

    def _parts(self) -> list[str]:
        if self.state == "gone":
            return [f"the folder cannot be read: {self.problem}"]
        state: str = self.state
        if state == "silent":
            gone = "its process is gone without a word" if self.abandoned else "nothing was written"
            state = f"silent: {gone} for {duration(self.silent_for)}"
        elif state == "complete" and (self.missing or self.lost):
            state = f"complete with {self.kind} missing"
        elif state == "stopped" and self.ending:
            state = f"stopped: {self.ending}"
        sweeps = f"{self.finished} of {self.total} {self.kind}"
        sweeps += f", {self.missing} given up" if self.missing else ""
        sweeps += f", {self.rejected} rejected" if self.rejected else ""
        sweeps += f", the temperature of {self.doubted} in doubt" if self.doubted else ""
        here = ", ".join(
            f"{what} {value:.2f} °C"
            for what, value in (("plate", self.plate), ("air", self.air))
            if value is not None
        )
        going = self.state in UNDER_WAY
        left = self.seconds_left if going else None
        clock = " of simulated time" if self.simulated else ""
        return [
            *(f"NOT AT REST: {what}" for what in self.unsafe),
            state,
            sweeps,
            f"{self.stage}: {here}" if going and here else here,
            f"{duration(left)} left{clock}" if left is not None else "",
            f"trouble: {self.trouble}" if self.trouble else "",
            f"clipping: {', '.join(self.clipping)}" if self.clipping else "",
            self.problem,
            self.next_step,
        ]


def status_of(watched: Watched, name: str, now: float) -> CampaignStatus:
    """Return how a campaign stands.

    Parameters
    ----------
    watched : Watched
        Brought up to date by its `look`.
    name : str
        What it is called.
    now : float
        Time of day, s since 1970.
    """
    _, total, left = watched.progress
    recorded, state = watched.finished, watched.state(now)
    lost = recorded - watched.there if state in ("complete", "stopped") else set()
    finished = recorded - lost
    missing = {event.get("step") for event in watched.events_of("missing")} - recorded
    problems = [f"{file}: {what}" for file, what in watched.problems.items()]
    if lost:
        problems.append(f"sweeps/: {len(lost)} of {len(recorded)} that were recorded are not there any more")
    last = watched.readings[-1] if watched.readings else None
    seconds_left = left if last is not None and math.isfinite(left) and state in UNDER_WAY else None
    rest, unsafe = at_rest(watched.events_of("oven"), [] if watched.simulated else watched.said)
    programme = watched.protocol.programme if watched.protocol is not None else None
    ends = sorted(end for leg in programme.legs for end in programme.ends(leg)) if programme is not None else []
    if ends and last is not None:
        ends = sorted((*ends, watched.readings[0].air_c))
    abandoned = state == "silent" and watched.abandoned
    ended = next((str(e.get("purpose", "")) for e in reversed(watched.events_of("oven"))), "")
    return CampaignStatus(
        name=name,
        folder=plain(watched.folder),
        state=state,
        problem=plain("; ".join(problems)),
        simulated=watched.simulated,
        stage=plain(last.stage) if last is not None else "",
        air=_finite(last.air_c) if last is not None else None,
        plate=_finite(last.plate_c) if last is not None else None,
        set_point=_set_point(watched),
        coldest=watched.protocol.limits.coldest if watched.protocol is not None else None,
        hottest=watched.protocol.limits.hottest if watched.protocol is not None else None,
        lowest=ends[0] if ends else None,
        highest=ends[-1] if ends else None,
        finished=len(finished),
        missing=len(missing),
        lost=len(lost),
        given_up=next((in_words(one) for one in reversed(watched.events_of("missing"))), ""),
        total=total,
        doubted=len(_doubted(watched) & finished),
        seconds_left=seconds_left,
        read=last.date if last is not None else None,
        ends=_later(last.date, seconds_left) if last is not None and seconds_left is not None else None,
        silent_for=max(now - watched.last_sign, 0.0),
        patience=watched.patience,
        rest=rest,
        unsafe=unsafe,
        clipping=_clipping(watched) if state in UNDER_WAY else (),
        trouble=plain(watched.trouble or "") if state in (*UNDER_WAY, "silent") else "",
        ending=plain(ended_by(ended)) if state == "stopped" else "",
        abandoned=abandoned,
        next_step=_after_a_kill(rest, simulated=watched.simulated) if abandoned else "",
    )


def _after_a_kill(rest: str, *, simulated: bool) -> str:
    """Say what to do where the process is gone; a simulated oven has gone with it."""
    if simulated or rest == "at rest":
        return "the same flexura acquire continues it"
    return (
        "look at the oven: nothing says that it is at rest; the same flexura acquire continues it, flexura safe "
        "brings the oven to rest"
    )


def gone(name: str, folder: str, why: str) -> CampaignStatus:
    """Return the status of a campaign whose folder cannot be read now.

    Parameters
    ----------
    why : str
        One sentence.
    """
    return CampaignStatus(name=name, folder=plain(folder), state="gone", problem=plain(why))


def at_rest(commands: Sequence[Mapping[str, Any]], said: Sequence[tuple[str, str]]) -> tuple[str, tuple[str, ...]]:
    """Return whether the rig is at rest, by the last command logged and by what the watchdog said since.

    Parameters
    ----------
    commands : sequence of mapping
        Events of the oven, oldest first.
    said : sequence of (str, str)
        What the watchdog said: date, ISO 8601, and sentence.

    Returns
    -------
    rest : str
    unsafe : tuple of str
        As `CampaignStatus` has them.
    """
    last = commands[-1] if commands else None
    rest, since = "unknown", -math.inf
    unsafe: tuple[str, ...] = ()
    if last is not None:
        since = seconds(last["date"])
        unsafe = tuple(plain(what) for what in last.get("unsafe") or ())
        safe = "not at rest" if unsafe else "at rest"
        rest = safe if last["command"] == "safe" else "follows the programme"
    for date, sentence in said:
        if seconds(date) < since - 1.0:  # its dates are whole seconds
            continue
        if sentence.startswith("NOT AT REST"):
            told = plain(sentence.removeprefix("NOT AT REST: "))
            rest, unsafe = "not at rest", (*(one for one in unsafe if not one.startswith("the oven")), told)[-4:]
        elif sentence.startswith(AT_REST_AGAIN):
            unsafe = tuple(one for one in unsafe if not one.startswith("the oven"))
            rest = "not at rest" if unsafe else "at rest"
    return rest, unsafe


def _set_point(watched: Watched) -> float | None:
    commands = watched.events_of("oven")[-1:]
    if not commands or not watched.readings:
        return None
    at = np.array([seconds(reading.date) for reading in watched.readings])
    air = np.array([reading.air_c for reading in watched.readings])
    _, value = set_point_line(commands, [seconds(commands[0]["date"])], at, air, float(at[-1]))
    return _finite(float(value[-1])) if value.size else None


def _doubted(watched: Watched) -> set[Any]:
    kept = {event.get("step") for event in watched.events_of("finished") if event.get("doubt")}
    return kept | {event.get("step") for event in watched.events_of("temperature in doubt") if "step" in event}


def _clipping(watched: Watched) -> tuple[str, ...]:
    latest = watched.latest
    if latest is None:
        return ()
    return tuple(
        plain(name) for name, over in zip(latest.channels, latest.overloaded.tolist(), strict=False) if over
    )


def _later(date: str, wait: float) -> str:
    try:
        return (datetime.fromisoformat(date) + timedelta(seconds=wait)).isoformat(timespec="seconds")
    except OverflowError:
        return date


def _finite(value: float) -> float | None:
    return round(value, 3) if math.isfinite(value) else None


def status_of_hits(watched: WatchedHits, name: str, now: float) -> CampaignStatus:
    """Return how a hammer test stands.

    Somebody has to hit the plate, and may rest: no silence is too long as long as its process is there.

    Parameters
    ----------
    watched : WatchedHits
        Brought up to date by its `look`.
    name : str
        What it is called.
    now : float
        Time of day, s since 1970.
    """
    progress, temperatures = watched.progress, watched.experiment.temperatures
    total = progress.points * progress.wanted * len(temperatures)
    missing = sum(progress.missing(number) for number in range(len(temperatures)))
    skipped = len(progress.skipped)
    oven = [event for event in watched.events if event.get("event") == "oven"]
    rest, unsafe = at_rest(oven, [] if watched.simulated else watched.said)
    if watched.experiment.oven is None:
        rest = "at rest"  # nothing is heated or driven
    state, ending = _standing(watched, missing, rest, oven[-1].get("purpose", "") if oven else "")
    hits = [event for event in watched.events if event.get("event") in (ACCEPTED, REJECTED)]
    last: dict[str, Any] = next((event for event in reversed(hits) if event.get("event") == ACCEPTED), {})
    limits = watched.experiment.limits
    return CampaignStatus(
        name=name,
        folder=plain(watched.folder),
        state=state,
        kind="hits",
        problem=plain(watched.trouble),
        simulated=watched.simulated,
        stage=_stage(watched) if state == "running" else "",
        plate=last.get("temperature") if isinstance(last.get("temperature"), int | float) else None,
        set_point=temperatures[watched.set_point] if watched.experiment.oven is not None and oven else None,
        coldest=limits.coldest if limits is not None else None,
        hottest=limits.hottest if limits is not None else None,
        finished=total - missing,
        missing=_given_up(watched) if state != "complete" else missing,
        total=total,
        doubted=len(progress.doubted(watched.events)),
        rejected=progress.rejected,
        silent_for=max(now - watched.last_sign, 0.0),
        rest=rest,
        unsafe=unsafe,
        ending=plain(ending),
        abandoned=state == "silent",
        next_step=_next_step(watched, state, missing, skipped),
    )


def _standing(watched: WatchedHits, missing: int, rest: str, purpose: str) -> tuple[Standing, str]:
    """Return the state, and why it was stopped."""
    if is_being_written(watched.folder):
        return "running", ""
    if not watched.events:
        return "not begun", ""
    if rest == "follows the programme":
        return "silent", ""  # its process is gone without a word, and nobody has said that the oven is at rest
    if missing == _given_up(watched):
        return "complete", ""
    return "stopped", "" if purpose == "the end" else ended_by(purpose)


def _given_up(watched: WatchedHits) -> int:
    """Hits that are missing at points that were skipped."""
    progress = watched.progress
    return sum(max(progress.wanted - len(progress.at(*place)), 0) for place in progress.skipped)


def _stage(watched: WatchedHits) -> str:
    """Say which hit is waited for."""
    number = watched.set_point
    point = watched.progress.next_point(number)
    if point is None:
        return "nothing is left"
    done = len(watched.progress.at(number, point))
    at = watched.experiment.temperatures[number]
    where = "" if at is None else f" at {at:g} °C"
    hit = f"hit {done + 1} of {watched.progress.wanted}"
    return f"{hit} at point {point + 1} of {watched.progress.points}{where}"


def _next_step(watched: WatchedHits, state: Standing, missing: int, skipped: int) -> str:
    """Say what to do."""
    if state == "running":
        return f"hit the plate: {_stage(watched)}"
    if state == "silent":
        return "look at the oven: its process is gone, and nothing says that it is at rest; then flexura safe"
    if state == "complete" and skipped and missing:
        return f"flexura acquire with --again asks for the {skipped} skipped points"
    if state == "complete":
        return f"flexura identify {quoted(watched.folder)}"
    return "the same flexura acquire goes on"
