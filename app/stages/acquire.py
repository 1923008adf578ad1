"""Acquire stage: an experiment run on a rig into a campaign folder that a window watches; begun or resumed."""

import logging
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from app.files.acquisition.campaign_folder import open_campaign
from app.files.acquisition.events import ReadingLine, append_reading, request, requested
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.folder import Source, frozen_protocol, write_index
from app.files.declarations.experiment import AcquiredExperiment
from app.files.folder_lock import FolderInUseError, folder_lock
from app.rig.doctor import require_room
from drivers.ni.cards import DaqError
from drivers.rig.campaign import Moment, Observer, Outcome, run_campaign
from drivers.rig.end_requests import RESUME, RigStopped
from drivers.rig.occupancy import occupied
from drivers.rig.rig import Aftercare
from drivers.rig.session import Session
from drivers.rig.shot import fire

PAUSE_LOOK_INTERVAL = 0.2
"""Seconds of ours between two looks at a pause: a simulated oven's time would race on otherwise."""
log = logging.getLogger(__name__)


class WatchedCampaign:
    """Writes the readings of a campaign, and reads requests for pause and stop.

    Parameters
    ----------
    folder : Path
        The campaign's; requests to an earlier run are deleted.
    """

    def __init__(self, folder: Path) -> None:
        self._folder, self._written = folder, True
        request(folder, "go on")

    def observe(self, moment: Moment) -> None:
        """Write a reading; RigStopped where a stop is requested."""
        plate = moment.reading.plate
        line = ReadingLine(
            date=moment.date,
            air_c=moment.reading.air,
            plate_c=math.nan if plate is None else plate,
            stage=moment.stage,
            done=moment.done,
            total=moment.total,
            seconds_left=round(moment.seconds_left, 1),
        )
        try:
            append_reading(self._folder, line)
            self._written = True
        except OSError as error:  # a full disk is reported when a sweep is written; a reading is no reason to stop
            if self._written:  # once, not with every reading of an hour
                log.warning("readings cannot be written, and the campaign goes on: %s", error.strerror or error)
            self._written = False
        if requested(self._folder) == "stop":
            request(self._folder, "go on")
            raise RigStopped("stopped from flexura view", RESUME)

    def paused(self) -> bool:
        """Whether a pause is requested."""
        pause = requested(self._folder) == "pause"
        if pause:
            time.sleep(PAUSE_LOOK_INTERVAL)
        return pause


def acquire_campaign(
    session: Session,
    experiment: AcquiredExperiment,
    folder: Path,
    source: Source,
    acquired: Mapping[str, Any],
    observer: Observer,
    *,
    again: bool = False,
    places: Sequence[str] = (),
) -> Outcome:
    """Run the sweeps of a campaign that are still missing.

    Only the process that holds the lock of the folder and that of the rig may use the rig; it brings the rig to
    rest before it releases them.

    Parameters
    ----------
    session : Session
        Opened and closed here; afterwards its `unsafe` names what could not be brought to rest.
    folder : Path
        Of the campaign.
    source : Source
        File that the experiment was read from.
    acquired : mapping
        Description of the rig, stored in the campaign's folder.
    observer : callable
        Called at every reading.
    again : bool
        Whether to repeat missed and failed sweeps.
    places : sequence of str
        Names of the parts of the rig that only one process can use.

    Raises
    ------
    CampaignFileError
        If another process runs the campaign, the folder holds another one, or its disk is too small.
    RigInUse
        If another process uses the rig.
    RigStopped, OSError
        As `drivers.rig.campaign.run_campaign`.
    """
    with claimed(session, folder, places):
        with session:
            recorded = experiment.recorded(session.cards.sample_rate)
            protocol = frozen_protocol(folder.name, recorded, {source.file: source.sha256}, dict(acquired))
            store = open_campaign(folder, protocol, recorded, source, session.check, experiment.sensitivities)
            require_room(experiment, folder)
            if not any(event.get("command") in ("ramp", "hold") for event in store.events()):
                _require_wired(session, experiment)
            watched = WatchedCampaign(folder)

            def look(moment: Moment) -> None:
                observer(moment)
                watched.observe(moment)

            outcome = run_campaign(session, experiment.protocol, store, look, paused=watched.paused, again=again)
        with session.told_if_it_hangs():
            write_index(folder)
    return outcome


@contextmanager
def claimed(session: Session, folder: Path, places: Sequence[str]) -> Iterator[None]:
    """Context manager that locks the rig and the folder for this process.

    If the folder cannot be written, a rig that a killed campaign left on is brought to rest before the error is
    raised.
    """
    with occupied(places, f"flexura acquire, campaign {folder}") as locks, ExitStack() as held:
        session.aftercare = Aftercare(locks.filenos(), folder / "watchdog.log")
        try:
            held.enter_context(folder_lock(folder))
        except FolderInUseError:
            raise
        except (CampaignFileError, OSError):
            with session:
                raise
        yield


def _require_wired(session: Session, experiment: AcquiredExperiment) -> None:
    """Raise RigStopped if a short sweep, before the oven moves, shows a fault that would spoil the campaign."""
    try:
        shot = fire(session.cards, experiment.protocol, session.check)
    except DaqError as error:
        raise RigStopped(f"the shot before the campaign: {error}", RESUME) from error
    if shot.faults:
        raise RigStopped(
            f"the test shot before the campaign, before the oven moves: {'; '.join(shot.faults)}",
            f"Check cables, terminals of [cards] and levels; --test-shot repeats the check. {RESUME}",
        )
