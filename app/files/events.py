"""``events.jsonl``: what happened to a campaign, one JSON object a line, each on the disk before the next."""

import json
import os
from pathlib import Path
from typing import Any

from app.files.campaign_error import CampaignFileError, Problem
from app.files.parsed_text import parse_json, read_bytes

NAME = "events.jsonl"
LARGEST = 50_000_000
"""Bytes: some hundred thousand events."""


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
        If a line before the last is no JSON object: that is no kill, that is damage. And if the file is no log.
    """
    path = folder / NAME
    if not path.exists():
        return []
    try:
        lines = read_bytes(path, LARGEST).split(b"\n")[:-1]
    except ValueError as error:
        raise CampaignFileError(folder, [Problem(NAME, "", str(error), "")]) from error
    events = []
    for number, line in enumerate(lines, 1):
        try:
            event = parse_json(line)
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
