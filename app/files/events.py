"""``events.jsonl``: what happened to a campaign, one JSON object a line, each on the disk before the next."""

import json
import os
from pathlib import Path
from typing import Any

from app.files.campaign_error import CampaignFileError, Problem

NAME = "events.jsonl"


def append_event(folder: Path, event: dict[str, Any]) -> None:
    """Add one event; returns when it is on the disk. A torn line left by a kill is closed off first."""
    line = json.dumps(event, ensure_ascii=False, allow_nan=False).encode() + b"\n"
    with (folder / NAME).open("ab+") as file:
        whole = _whole(file)
        file.truncate(whole)
        file.write(line)
        file.flush()
        os.fsync(file.fileno())


def read_events(folder: Path) -> list[dict[str, Any]]:
    """Read every whole event, oldest first; a torn last line is ignored.

    Raises
    ------
    CampaignFileError
        If a line before the last is no JSON object: that is no kill, that is damage.
    """
    path = folder / NAME
    if not path.exists():
        return []
    events = []
    for number, line in enumerate(path.read_bytes().split(b"\n")[:-1], 1):
        try:
            event = json.loads(line)
        except ValueError as error:
            raise CampaignFileError(folder, [_damaged(number, line)]) from error
        if not isinstance(event, dict):
            raise CampaignFileError(folder, [_damaged(number, line)])
        events.append(event)
    return events


def _whole(file: Any) -> int:
    """Bytes up to the end of the last whole line."""
    file.seek(0)
    return int(file.read().rfind(b"\n")) + 1


def _damaged(number: int, line: bytes) -> Problem:
    return Problem(NAME, f"line {number}", repr(line[:60]), "a JSON object", "import the campaign again")
