"""Hammer stage of `acquire`: hits recorded into a folder that other verbs read, started or taken up again."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from app.files.acquisition.events import read_events
from app.files.acquisition.hammer_folder import open_hammer_folder
from app.files.campaigns.folder import Source
from app.files.declarations.hammer_experiment import HammerExperiment
from app.files.folder_lock import folder_lock
from app.stages.acquire import claimed
from drivers.hammer.campaign import HammerCampaign, HammerObserver, HeldPlate, Key, no_key, run_set_points
from drivers.hammer.hammer_rig import HammerInputs, HammerRig, HitTrigger
from drivers.hammer.judged_hit import HammerProgress, HitJudge, HitTemperature, declared, in_a_room
from drivers.ni.cards import DaqError, go_on
from drivers.rig.end_requests import RESUME, RigStopped
from drivers.rig.occupancy import occupied
from drivers.rig.readings import Reading
from drivers.rig.session import Session


@dataclass(frozen=True)
class HammerOutcome:
    """Result of a hammer test.

    Attributes
    ----------
    accepted, missing, rejected : int
        Hits that count, hits that are wanted and not there, hits that were rejected, over the whole campaign.
    skipped : int
        Points left out by whoever held the hammer.
    made_now : int
        Hits that count and were made by this run.
    stopped : bool
        Whether it was stopped by a key.
    doubted : int
        Hits that count and whose temperature is in doubt.
    """

    accepted: int
    missing: int
    rejected: int
    skipped: int
    made_now: int
    stopped: bool
    doubted: int = 0


def interrupted_at(folder: Path) -> float:
    """Return the time of a campaign's last event on the rig's clock, s; 0 of one that was not begun."""
    times = (event.get("time") for event in read_events(folder))
    return max((float(time) for time in times if isinstance(time, int | float)), default=0.0)


def acquire_hammer(
    rig: HammerRig,
    session: Session | None,
    experiment: HammerExperiment,
    folder: Path,
    source: Source,
    acquired: Mapping[str, Any],
    observer: HammerObserver,
    *,
    key: Callable[[], Key | None] = no_key,
    check: Callable[[], None] = go_on,
    again: bool = False,
    places: Sequence[str] = (),
) -> HammerOutcome:
    """Record the hits that are still missing.

    Only the process that holds the lock of the folder and those of the rig may use the rig.

    Parameters
    ----------
    session : Session, optional
        Of the rig's oven, opened and closed here; afterwards its `unsafe` names what could not be brought to rest.
        None for a rig without an oven.
    folder : Path
        Of the campaign.
    source : Source
        File that the experiment was read from.
    acquired : mapping
        Description of the rig, stored in the campaign's folder.
    key : callable
        Returns what was typed since it was called last.
    check : callable
        Raises if the campaign is to end.
    again : bool
        Whether to ask again for points that were skipped.
    places : sequence of str
        Names of the parts of the rig that only one process can use.

    Raises
    ------
    CampaignFileError
        If another process runs the campaign, or the folder holds another one.
    RigStopped
        If the cards cannot be opened, or are lost, or the oven does not hold a set-point.
    OSError
        If a hit cannot be written.
    """

    def begun(inputs: HammerInputs) -> HammerCampaign:
        return _begun(rig, inputs, experiment, folder, source, acquired, observer, key, check, again=again)

    if session is not None:
        with claimed(session, folder, places), session:
            return _in_the_oven(session, experiment, begun(cast(HammerInputs, session.cards)), observer)
    with occupied(places, f"flexura acquire, hammer test {folder}"), folder_lock(folder):
        try:
            inputs = rig.open_inputs()
        except DaqError as error:
            raise RigStopped(f"the cards cannot be opened: {error}", RESUME) from error
        try:
            campaign = begun(inputs)
            before = len(campaign.progress.valid)
            stopped = campaign.progress.next_point(0) is not None and campaign.run() == "stopped"
        finally:
            inputs.close()
    return _outcome(campaign, 1, before, stopped=stopped)


def _begun(
    rig: HammerRig,
    inputs: HammerInputs,
    experiment: HammerExperiment,
    folder: Path,
    source: Source,
    acquired: Mapping[str, Any],
    observer: HammerObserver,
    key: Callable[[], Key | None],
    check: Callable[[], None],
    *,
    again: bool,
) -> HammerCampaign:
    """Open the folder, and return the campaign as far as it has got."""
    section = experiment.hammer
    judge = HitJudge(section.test(), experiment.volts, experiment.channels, section.overload * inputs.full_scale)
    store = open_hammer_folder(folder, experiment, acquired, source, judge)
    points = len(experiment.mallet.places)
    progress = HammerProgress.of(points, section.hits, store.kept(), store.events(), again=again)
    store.declare(progress)  # a kill may have come between a hit and the declarations that name it
    return HammerCampaign(
        rig,
        inputs,
        HitTrigger(section.triggering(experiment.mallet.sensitivity), inputs.sample_rate),
        judge,
        store,
        progress,
        section.band,
        observer,
        _thermometer(experiment, inputs),
        key,
        check,
    )


def _in_the_oven(
    session: Session, experiment: HammerExperiment, campaign: HammerCampaign, observer: HammerObserver
) -> HammerOutcome:
    """Measure at every set-point."""
    set_points, limits = experiment.set_points, experiment.limits
    if set_points is None or limits is None:
        raise AssertionError("refused when the experiment was read")
    progress, store = campaign.progress, campaign.store
    before, events = len(progress.valid), store.events()
    told: list[str] = []

    def tell(stage: str, reading: Reading) -> None:
        if told[-1:] != [stage]:
            told.append(stage)
            plate = "" if reading.plate is None else f", plate {reading.plate:.1f} °C"
            observer.said(f"{stage}: air {reading.air:.1f} °C{plate}")

    held = HeldPlate(session, set_points.protocol(limits, experiment.hammer), store, tell)
    whole = all(progress.next_point(number) is None for number in range(len(set_points.temperatures)))
    stopped = not whole and not run_set_points(set_points.temperatures, held, campaign, events)
    return _outcome(campaign, len(set_points.temperatures), before, stopped=stopped)


def _outcome(campaign: HammerCampaign, set_points: int, before: int, *, stopped: bool) -> HammerOutcome:
    progress = campaign.progress
    return HammerOutcome(
        accepted=len(progress.valid),
        missing=sum(progress.missing(number) for number in range(set_points)),
        rejected=progress.rejected,
        skipped=len(progress.skipped),
        made_now=len(progress.valid) - before,
        stopped=stopped,
        doubted=len(progress.doubted(campaign.store.events())),
    )


def _thermometer(experiment: HammerExperiment, inputs: HammerInputs) -> Callable[[], HitTemperature]:
    """Return what gives the plate's temperature: as declared, or the thermocouples' mean."""
    if experiment.temperature is not None:
        return declared(experiment.temperature)
    return in_a_room(inputs.temperatures, experiment.cards.thermocouples)
