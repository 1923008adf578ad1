"""SHA-256 of all that a stage reads, found without reading the campaign itself."""

import hashlib
import json
import tomllib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from app.files.acquisition.events import NAME as EVENTS
from app.files.campaigns.declaration import declaration_digest
from app.files.campaigns.folder import SWEEPS, sweep_paths
from app.files.campaigns.kind import DECLARATION, PROTOCOL, is_campaign_folder
from app.files.campaigns.loading import load_campaign
from app.files.provenance import sha256

TOLD = (b'"missing"', b'"temperature in doubt"')
"""Events that decide what is made of a campaign's sweeps; a running campaign writes others all the time."""


def campaign_hashes(campaign: Path) -> dict[str, str]:
    """SHA-256 of a campaign's files as they are now, by name, sweeps named as in `Campaign.hashes`.

    Parameters
    ----------
    campaign : Path
        Recorded, imported or acquired.

    Returns
    -------
    dict
        Also of meshes and drawings that a declaration names, and of events that put temperatures in doubt.
    """
    if is_campaign_folder(campaign):
        found = {PROTOCOL: sha256(campaign / PROTOCOL)}
        found |= {f"{SWEEPS}/{path.name}": sha256(path) for path in sweep_paths(campaign)}
        return found | _told(campaign / EVENTS)
    declaration = campaign / DECLARATION
    if not declaration.exists():  # a plate with FRFs: only its reader knows which files it names
        return dict(load_campaign(campaign).hashes) | _told(campaign / EVENTS)
    found = {DECLARATION: declaration_digest(declaration)} | _named_in(declaration)
    folder = campaign / SWEEPS
    files = sorted(folder.iterdir()) if folder.is_dir() else []
    return found | {
        f"{SWEEPS}/{path.name}": sha256(path)
        for path in files
        if path.suffix.lower() == ".tdms" and not path.name.startswith(".")
    }


def is_import_of(folder: Path, recording: Path) -> bool:
    """Whether a folder is a campaign that a recording, as it is declared now, was imported into."""
    try:
        frozen = json.loads((folder / PROTOCOL).read_text(encoding="utf-8"))
        return bool(frozen["source"][DECLARATION] == declaration_digest(recording / DECLARATION))
    except (OSError, ValueError, KeyError, TypeError):  # its reader says what is wrong with it
        return False


def file_hashes(path: Path) -> dict[str, str]:
    """SHA-256 of a TOML file and of the meshes and drawings that it names; empty where it is not there."""
    return {path.name: sha256(path)} | _named_in(path) if path.is_file() else {}


def effect_hashes(folder: Path | None) -> dict[str, str]:
    """SHA-256 of a user's own effects, by file."""
    if folder is None or not folder.is_dir():
        return {}
    return {f"effect {path.name}": sha256(path) for path in sorted(folder.glob("[!_]*.py"))}


def _told(events: Path) -> dict[str, str]:
    try:
        lines = [line for line in events.read_bytes().splitlines() if any(kind in line for kind in TOLD)]
    except OSError:
        return {}
    return {EVENTS: hashlib.sha256(b"\n".join(lines)).hexdigest()} if lines else {}


def _named_in(path: Path) -> dict[str, str]:
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):  # the reader says what is wrong
        return {}
    found = {}
    for text in _texts(table):
        with suppress(OSError, ValueError):  # a title may be too long for a name, or hold what no name may
            if (path.parent / text).is_file():
                found[text] = sha256(path.parent / text)
    return found


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str) and value.strip():
        yield value
    elif isinstance(value, dict):
        for one in value.values():
            yield from _texts(one)
    elif isinstance(value, list):
        for one in value:
            yield from _texts(one)
