"""``campaign.toml``: the declaration of a recorded campaign."""

from pathlib import Path

from analysis.experiment import Experiment
from app.files.settings_toml import read_settings

NAME = "campaign.toml"
FORMAT = "recorded-campaign/1"


def read_experiment(folder: Path) -> Experiment:
    """Read the declaration in a recorded campaign's folder.

    Raises
    ------
    CampaignFileError
        With every missing, unknown, mistyped or implausible key.
    """
    return read_settings(folder / NAME, Experiment)
