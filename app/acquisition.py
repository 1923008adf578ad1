"""An experiment run on a rig, into a campaign folder that windows may watch: begun, or taken up again."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from app.files.acquired_campaign import open_campaign
from app.files.campaign_folder import frozen_protocol, write_index
from app.files.experiment_toml import AcquiredExperiment
from app.files.folder_lock import folder_lock
from app.files.sweep_file import Source
from app.watched_campaign import WatchedCampaign
from drivers.rig.campaign import Moment, Observer, Outcome, run_campaign
from drivers.rig.session import Session


def acquire_campaign(
    session: Session,
    experiment: AcquiredExperiment,
    folder: Path,
    source: Source,
    acquired: Mapping[str, Any],
    observer: Observer,
    *,
    again: bool = False,
) -> Outcome:
    """Run what is still to be done of a campaign.

    The rig is touched only by whoever holds the folder's lock, and is at rest before the lock is given up.

    Parameters
    ----------
    session : Session
        Opened and left here; what it could not bring to rest it says afterwards.
    experiment : AcquiredExperiment
    folder : Path
        Of the campaign.
    source : Source
        What the experiment was read from.
    acquired : mapping
        What the campaign's folder is to know of the rig.
    observer : callable
        Called at every reading.
    again : bool
        Try once more what was missed or failed.

    Raises
    ------
    CampaignFileError
        If another process runs the campaign, or the folder holds another one.
    RigStopped, OSError
        As `drivers.rig.campaign.run_campaign`.
    """
    with folder_lock(folder):
        with session:
            recorded = experiment.recorded(session.cards.sample_rate)
            protocol = frozen_protocol(folder.name, recorded, {source.file: source.sha256}, dict(acquired))
            store = open_campaign(folder, protocol, recorded, source, session.check, experiment.sensitivities)
            watched = WatchedCampaign(folder)

            def look(moment: Moment) -> None:
                observer(moment)
                watched.observe(moment)

            outcome = run_campaign(session, experiment.protocol, store, look, paused=watched.paused, again=again)
        write_index(folder)
    return outcome
