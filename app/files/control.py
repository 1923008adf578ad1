"""``control.json``: what a window requests of a running acquisition: to go on, to pause, or to stop safely.

The runner asks at every reading of the temperature, and wherever the file is missing or cannot be read it goes on:
nothing that happens to a window can disturb a campaign.
"""

from pathlib import Path
from typing import Literal

from app.files.atomic import write_json
from app.files.parsed_text import parse_json, read_text

NAME = "control.json"
ControlRequest = Literal["go on", "pause", "stop"]


def request(folder: Path, action: ControlRequest) -> None:
    """Write a request; the runner of the campaign reads it."""
    if action == "go on":
        (folder / NAME).unlink(missing_ok=True)
    else:
        write_json(folder / NAME, {"wish": action})


def requested(folder: Path) -> ControlRequest:
    """Return what is requested of the runner."""
    try:
        found = parse_json(read_text(folder / NAME))["wish"]
    except (OSError, ValueError, KeyError, TypeError):
        return "go on"
    return "pause" if found == "pause" else "stop" if found == "stop" else "go on"
