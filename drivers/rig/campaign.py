"""A campaign from its first leg to its end, started or resumed."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

from analysis.protocol.protocol import AcquisitionProtocol
from analysis.protocol.set_points import Leg, SweepSetPoint
from drivers.ni.errors import DaqError
from drivers.ovens.error import OvenError
from drivers.rig.errors import RESUME, RigStopped
from drivers.rig.leg import LegRun
from drivers.rig.progress import Progress
from drivers.rig.readings import Reading
from drivers.rig.session import Session
from drivers.rig.station import Station
from drivers.rig.store import Store
from drivers.rig.sweeping import Sweeping

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
    """

    stage: str
    temperature: float
    done: int
    total: int
    seconds_left: float
    date: str
    reading: Reading


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
    total = protocol.count
    for leg in left:
        station.leg = leg.number
        todo = _todo(leg, progress)
        later = sum(len(_todo(other, progress)) for other in left if other.number > leg.number)
        run = LegRun(leg, todo, station, sweeping, protocol)

        def watch(stage: str, reading: Reading, ramping: bool, run: LegRun = run, later: int = later) -> bool:
            temperature = station.watched(reading)
            leg_under_way = run.leg.number + (stage == LAST_SOAK)  # then the leg itself is finished
            start = run.start if leg_under_way == run.leg.number else None
            seconds = protocol.seconds(temperature, leg_under_way, ramping=ramping, start=start)
            done = total - later - len(run.todo)
            observer(Moment(stage, temperature, done, total, seconds, station.date(), reading))
            return paused()

        run.run(watch, under_way=progress.ramping == leg.number, begun=leg.number in progress.begun)
        if leg is left[-1] and protocol.programme.soak_after:
            run.settle(watch, leg.end, protocol.programme.ramp_rate, protocol.programme.soak_after, LAST_SOAK)
