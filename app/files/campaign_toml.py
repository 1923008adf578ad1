"""``campaign.toml``: the declaration of a recorded campaign."""

from pathlib import Path

from analysis.experiment import Experiment
from app.files.one_actuator import driven_by
from app.files.settings_toml import checked, read_table

NAME = "campaign.toml"
FORMAT = "recorded-campaign/1"


def read_experiment(folder: Path, actuator: str | None = None) -> Experiment:
    """Read the declaration in a recorded campaign's folder; of several actuators, the one named drives.

    Raises
    ------
    CampaignFileError
        With every missing, unknown, mistyped or implausible key.
    """
    path = folder / NAME
    return checked(path, driven_by(path, read_table(path), actuator), Experiment)
