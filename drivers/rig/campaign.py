"""A campaign from its first leg to its end, begun or taken up again."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from analysis.protocol.protocol import AcquisitionProtocol
from analysis.protocol.set_points import Leg, SetPoint
from drivers.ni.errors import DaqError
from drivers.ovens.error import OvenError
from drivers.rig.errors import RigInterrupted, RigStopped
from drivers.rig.leg import LegRun
from drivers.rig.progress import Progress
from drivers.rig.readings import Reading
from drivers.rig.rig import Rig
from drivers.rig.station import Station
from drivers.rig.store import Store
from drivers.rig.sweeping import Sweeping

LAST_SOAK = "last soak"
RESUME = "Then run the same command again: what is finished stays"


@dataclass(frozen=True)
class Moment:
    """Where a running campaign is.

    Attributes
    ----------
    stage : str
        What is being done.
    temperature : float
        Of what is watched, degrees Celsius.
    done, total : int
        Sweeps finished or given up, and all of them.
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
    """Is shown how a campaign gets on."""

    def __call__(self, moment: Moment) -> None:
        """Look at a moment; called at every reading."""
        ...


@dataclass(frozen=True)
class Outcome:
    """What a campaign came to.

    Attributes
    ----------
    finished, missing : int
        Sweeps kept and sweeps given up, over the whole campaign.
    made_now : int
        Sweeps finished by this run.
    unsafe : tuple of str
        What could not be brought to rest at the end.
    """

    finished: int
    missing: int
    made_now: int
    unsafe: tuple[str, ...]


def unobserved(moment: Moment) -> None:
    """Look away."""


def never() -> bool:
    """Wish for no pause."""
    return False


def run_campaign(
    rig: Rig,
    protocol: AcquisitionProtocol,
    store: Store,
    observer: Observer = unobserved,
    *,
    paused: Callable[[], bool] = never,
    again: bool = False,
) -> Outcome:
    """Run what is still to be done of a campaign.

    However this ends, by itself, by an error, by Ctrl-C or by SIGTERM, the drive is brought to 0 V
    and the oven to rest first. After a kill, which nobody can act on, the hardware ends the sweep
    with zeros, and the oven goes on with its ramp: the set-points it passes before the campaign is
    taken up again are given up as missed.

    Parameters
    ----------
    rig : Rig
    protocol : AcquisitionProtocol
    store : Store
    observer : callable
        May raise `RigStopped` to end the campaign for now.
    paused : callable
        Whether somebody wishes the campaign to wait; asked at every reading. The oven holds its temperature
        meanwhile, and the ramp is begun again before the next set-point afterwards.
    again : bool
        Try once more what was missed or failed: legs with such set-points are run from their start.

    Raises
    ------
    RigStopped
        If the rig cannot go on now. Taken up again by the same call.
    OSError
        If the store cannot keep a sweep or an event: a full disk, as a rule.
    """
    progress = Progress.of(store.finished(), store.events(), again=again)
    left = [leg for leg in protocol.legs if _todo(leg, progress)]
    if not left:
        return Outcome(len(progress.finished), len(progress.given_up), 0, ())
    station = _opened(rig, protocol, store)
    why = "the end"
    try:
        events = store.events()
        if events:
            station.restore(events)
        station.note("resumed" if events else "begun", finished=len(progress.finished))
        _run_legs(left, progress, station, protocol, store, observer, paused)
    except BaseException as error:
        why = f"{type(error).__name__}: {error}"
        unsafe = station.make_safe(why)
        if isinstance(error, DaqError | OvenError):
            stopped = RigStopped(str(error), RESUME)
            stopped.unsafe = unsafe
            raise stopped from error
        if isinstance(error, RigStopped | RigInterrupted):
            error.unsafe = unsafe
        for told in unsafe:
            error.add_note(told)
        raise
    unsafe = station.make_safe(why)
    ended = Progress.of(store.finished(), store.events())
    return Outcome(len(ended.finished), len(ended.given_up), len(ended.finished) - len(progress.finished), unsafe)


def _opened(rig: Rig, protocol: AcquisitionProtocol, store: Store) -> Station:
    try:
        station = Station(rig, protocol, store)
    except (DaqError, OvenError) as error:
        raise RigStopped(f"the rig cannot be opened: {error}", RESUME) from error
    longest = max(protocol.sweep.record, protocol.programme.poll_interval)
    if longest >= station.poll_within:
        unsafe = station.make_safe("never begun")
        stopped = RigStopped(
            f"this oven stops when it is left alone for {station.poll_within:g} s, and one repeat with its tail, "
            f"or programme.poll_interval, takes {longest:g} s",
            "Make the sweeps shorter and the readings closer",
        )
        stopped.unsafe = unsafe
        raise stopped
    return station


def _todo(leg: Leg, progress: Progress) -> list[SetPoint]:
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
    sweeping = Sweeping(station, protocol, store, dict(progress.attempts))
    total = protocol.count
    for leg in left:
        station.leg = leg.number
        todo = _todo(leg, progress)
        later = sum(len(_todo(other, progress)) for other in left if other.number > leg.number)
        run = LegRun(leg, todo, station, sweeping, protocol)

        def watch(stage: str, reading: Reading, ramping: bool, run: LegRun = run, later: int = later) -> bool:
            temperature = station.watched(reading)
            leg_under_way = run.leg.number + (stage == LAST_SOAK)  # the leg itself is over then
            seconds = protocol.seconds(temperature, leg_under_way, ramping=ramping)
            done = total - later - len(run.todo)
            observer(Moment(stage, temperature, done, total, seconds, station.date(), reading))
            return paused()

        run.run(watch, under_way=progress.ramping == leg.number, begun=leg.number in progress.begun)
        if leg is left[-1] and protocol.programme.soak_after:
            run.settle(watch, leg.end, protocol.programme.ramp_rate, protocol.programme.soak_after, LAST_SOAK)
