"""``control.json``: what a window wishes of a running acquisition: go on, pause, or stop safely.

The runner asks at every reading of the temperature, and wherever the file is missing or cannot be read it goes on:
nothing that happens to a window can disturb a campaign.
"""

from pathlib import Path
from typing import Literal

from app.files.atomic import write_json
from app.files.parsed_text import parse_json, read_text

NAME = "control.json"
Wish = Literal["go on", "pause", "stop"]


def wish(folder: Path, wished: Wish) -> None:
    """Let the runner of a campaign know."""
    if wished == "go on":
        (folder / NAME).unlink(missing_ok=True)
    else:
        write_json(folder / NAME, {"wish": wished})


def wished(folder: Path) -> Wish:
    """Return what is wished of the runner."""
    try:
        found = parse_json(read_text(folder / NAME))["wish"]
    except (OSError, ValueError, KeyError, TypeError):
        return "go on"
    return "pause" if found == "pause" else "stop" if found == "stop" else "go on"
