"""Hammer stage of `acquire`: hits recorded into a folder that other verbs read, started or taken up again."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app.files.events import read_events
from app.files.folder_lock import folder_lock
from app.files.hammer_experiment import HammerExperiment
from app.files.hammer_folder import open_hammer_folder
from app.files.sweep_file import Source
from drivers.hammer.campaign import HammerCampaign, HammerObserver, Key, no_key
from drivers.hammer.hammer_rig import HammerInputs, HammerRig
from drivers.hammer.judged_hit import HitJudge
from drivers.hammer.progress import HammerProgress
from drivers.hammer.trigger import HitTrigger
from drivers.ni.cards import go_on
from drivers.ni.errors import DaqError
from drivers.rig.errors import RESUME, RigStopped
from drivers.rig.occupancy import occupied


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
    """

    accepted: int
    missing: int
    rejected: int
    skipped: int
    made_now: int
    stopped: bool


def interrupted_at(folder: Path) -> float:
    """Return the time of a campaign's last event on the rig's clock, s; 0 of one that was not begun."""
    return max((float(event.get("time", 0.0)) for event in read_events(folder)), default=0.0)


def acquire_hammer(
    opened: Callable[[], AbstractContextManager[HammerRig]],
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

    Parameters
    ----------
    opened : callable
        Opens the rig, once the folder and the cards are this process's own.
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
        If the cards cannot be opened, or are lost.
    OSError
        If a hit cannot be written.
    """
    with occupied(places, f"flexura acquire, hammer test {folder}"), folder_lock(folder), opened() as rig:
        try:
            inputs = rig.open_inputs()
        except DaqError as error:
            raise RigStopped(f"the cards cannot be opened: {error}", RESUME) from error
        try:
            section = experiment.hammer
            judge = HitJudge(
                section.test(), experiment.volts, experiment.channels, section.overload * inputs.full_scale
            )
            store = open_hammer_folder(folder, experiment, acquired, source, judge)
            points = len(experiment.mallet.places)
            progress = HammerProgress.of(points, section.hits, store.kept(), store.events(), again=again)
            before = len(progress.valid)
            store.declare(progress)  # a kill may have come between a hit and the declarations that name it
            campaign = HammerCampaign(
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
            whole = progress.next_point(0) is None or campaign.run()
        finally:
            inputs.close()
    return HammerOutcome(
        accepted=len(progress.valid),
        missing=progress.missing(0),
        rejected=progress.rejected,
        skipped=len(progress.skipped),
        made_now=len(progress.valid) - before,
        stopped=not whole,
    )


def _thermometer(experiment: HammerExperiment, inputs: HammerInputs) -> Callable[[], float]:
    """Return what gives the plate's temperature, degrees Celsius: as declared, or the thermocouples' mean."""
    if experiment.temperature is not None:
        declared = experiment.temperature
        return lambda: declared
    return lambda: float(np.mean(inputs.temperatures()))
