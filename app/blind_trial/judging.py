"""Gap workflow on one campaign of a trial, from its folder alone, by the same code as the verbs."""

import time
from collections.abc import Collection
from pathlib import Path

from app.blind_trial.expected_frf import MAINS
from app.files.atomic import write_json
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.loading import load_campaign
from app.stages import gap
from app.stages.comparison_request import GapRequest

REFUSED = "refused.json"


def judge_campaign(folder: Path, run: Path, without: Collection[str]) -> None:
    """Compare a campaign as ``flexura gap`` does; write gap.json, or the reason for refusal, into `run`.

    Parameters
    ----------
    folder : Path
        Folder of the campaign.
    run : Path
        Run folder; created if missing.
    without : collection of str
        Effects removed from the library for this campaign.
    """
    run.mkdir(parents=True, exist_ok=True)
    begun = time.perf_counter()
    try:
        campaign = load_campaign(folder)
        request = GapRequest(campaign, mains=MAINS, without=frozenset(without), describing=False)
        found = gap.compute(request, lambda stage, share: None)
    except (CampaignFileError, ResultFileError) as error:
        write_json(run / REFUSED, {"why": str(error)})
        return
    gap.save(run, request, found, time.perf_counter() - begun)


def is_judged(run: Path) -> bool:
    """Whether a run holds a verdict, which is written last."""
    return (run / gap.GAP).is_file() or (run / REFUSED).is_file()
