"""An experiment run on a rig, into a campaign folder that windows may watch: begun, or taken up again."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from app.files.acquired_campaign import open_campaign
from app.files.campaign_folder import frozen_protocol
from app.files.experiment_toml import AcquiredExperiment
from app.files.sweep_file import Source
from app.rig import declared_by
from app.watched_campaign import WatchedCampaign
from drivers.rig.campaign import Moment, Observer, Outcome, run_campaign
from drivers.rig.rig import Rig


def acquire_campaign(
    rig: Rig,
    experiment: AcquiredExperiment,
    folder: Path,
    source: Source,
    acquired: Mapping[str, Any],
    observer: Observer,
    *,
    again: bool = False,
) -> Outcome:
    """Run what is still to be done of a campaign.

    Parameters
    ----------
    rig : Rig
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
        If the folder holds another campaign.
    RigStopped, DaqError, OSError
        As `drivers.rig.campaign.run_campaign`.
    """
    recorded = declared_by(experiment, rig)
    protocol = frozen_protocol(folder.name, recorded, {source.file: source.sha256}, dict(acquired))
    with open_campaign(folder, protocol, recorded, source, experiment.sensitivities) as store:
        watched = WatchedCampaign(folder)

        def look(moment: Moment) -> None:
            observer(moment)
            watched.observe(moment)

        return run_campaign(rig, experiment.protocol, store, look, paused=watched.paused, again=again)
