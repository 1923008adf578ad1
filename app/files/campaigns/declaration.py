"""``campaign.toml``: the declaration of a recorded campaign."""

import hashlib
import re
import tomllib
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from analysis.experiment import Experiment
from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaigns.channels import KEYS, RecorderLayout, actuators, driven_by
from app.files.campaigns.kind import DECLARATION
from app.files.settings_toml import checked, read_table

FORMAT = "recorded-campaign/1"
RUN = "run"
"""Table of the options of `flexura run`: it says nothing about what was measured."""
HEADER = re.compile(r"\s*\[+\s*([\w\"'-]+)")


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
    rest = {key: value for key, value in table.items() if key not in (*KEYS, RUN)}
    for key in sorted(set(rest) - set(Experiment.model_fields)):
        meant = get_close_matches(key, KEYS, 1)
        if meant:
            problem = Problem(DECLARATION, key, "unknown key", f"[{meant[0]}]", f"did you mean {meant[0]}?")
            raise CampaignFileError(folder, [problem])
    experiment = checked(path, driven_by(path, rest, actuator), Experiment)
    idle = set(actuators(rest)) - {one.id for one in experiment.inputs}
    channels = {name: one for name, one in recorder.channels.items() if one.role != "drive" or one.at not in idle}
    return experiment, recorder.model_copy(update={"channels": channels})


def declaration_digest(path: Path) -> str:
    """SHA-256 of a declaration without its table [run]: other options of a run leave results of others valid."""
    read = path.read_bytes()
    try:
        text = read.decode("utf-8")
        declared = tomllib.loads(text)
        if RUN not in declared:
            return hashlib.sha256(read).hexdigest()
        kept = _without_run(text)
        same = tomllib.loads(kept) == {key: value for key, value in declared.items() if key != RUN}
    except (UnicodeDecodeError, tomllib.TOMLDecodeError):  # the reader says what is wrong
        return hashlib.sha256(read).hexdigest()
    return hashlib.sha256(kept.encode() if same else read).hexdigest()


def _without_run(text: str) -> str:
    """Return the text of a declaration as it was before its table [run] was appended or put in between."""
    kept: list[str] = []
    inside = False
    for line in text.splitlines(keepends=True):
        header = HEADER.match(line)
        if header:
            inside = header[1].strip("\"'") == RUN
        if not inside:
            kept.append(line)
    return "".join(kept).rstrip() + "\n"


def run_table(path: Path) -> dict[str, Any] | None:
    """Return the table [run] of a TOML file, unchecked; None where it has none."""
    return read_table(path).get(RUN)
