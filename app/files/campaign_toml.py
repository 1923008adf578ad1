"""``campaign.toml``: the declaration of a recorded campaign."""

from difflib import get_close_matches
from pathlib import Path

from analysis.experiment import Experiment
from app.files.campaign_channels import KEYS, RecorderLayout
from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaign_kind import DECLARATION
from app.files.one_actuator import actuators, driven_by
from app.files.settings_toml import checked, read_table

FORMAT = "recorded-campaign/1"


def read_experiment(folder: Path, actuator: str | None = None) -> Experiment:
    """Read the declaration in a recorded campaign's folder; of several actuators, the one named drives.

    Raises
    ------
    CampaignFileError
        With every missing, unknown, mistyped or implausible key.
    """
    return read_declaration(folder, actuator)[0]


def read_declaration(folder: Path, actuator: str | None = None) -> tuple[Experiment, RecorderLayout]:
    """Read the same, and what it says of files that a recorder wrote in a layout of its own."""
    path = folder / DECLARATION
    table = read_table(path)
    recorder = checked(path, {key: table[key] for key in KEYS if key in table}, RecorderLayout)
    rest = {key: value for key, value in table.items() if key not in KEYS}
    for key in sorted(set(rest) - set(Experiment.model_fields)):
        meant = get_close_matches(key, KEYS, 1)
        if meant:
            problem = Problem(DECLARATION, key, "unknown key", f"[{meant[0]}]", f"did you mean {meant[0]}?")
            raise CampaignFileError(folder, [problem])
    experiment = checked(path, driven_by(path, rest, actuator), Experiment)
    idle = set(actuators(rest)) - {one.id for one in experiment.inputs}
    channels = {name: one for name, one in recorder.channels.items() if one.role != "drive" or one.at not in idle}
    return experiment, recorder.model_copy(update={"channels": channels})
