"""One campaign of a trial judged: by what the verbs do, from its folder alone."""

import time
from collections.abc import Collection
from pathlib import Path

from app.blind_trial.expected_frf import MAINS
from app.files.atomic import write_json
from app.files.bad_file import ResultFileError
from app.files.campaign import load_campaign
from app.files.campaign_error import CampaignFileError
from app.stages import gap

REFUSED = "refused.json"


def judge_campaign(folder: Path, run: Path, without: Collection[str]) -> None:
    """Compare a campaign as ``flexura gap`` does; gap.json, or why it cannot be judged, goes into `run`.

    Parameters
    ----------
    folder : Path
        The campaign's.
    run : Path
        Made if it is not there.
    without : collection of str
        Effects that the library lacks today.
    """
    run.mkdir(parents=True, exist_ok=True)
    begun = time.perf_counter()
    try:
        campaign = load_campaign(folder)
        found = gap.compute(campaign, MAINS, lambda stage, share: None, without=without)
    except (CampaignFileError, ResultFileError) as error:
        write_json(run / REFUSED, {"why": str(error)})
        return
    gap.save(run, campaign, found, MAINS, time.perf_counter() - begun)


def is_judged(run: Path) -> bool:
    """Whether a run holds a verdict; it is the last thing written."""
    return (run / gap.GAP).is_file() or (run / REFUSED).is_file()
