"""Which campaigns are meant: each one named, all in a folder, or those of a list."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from app.files.bad_file import ResultFileError
from app.files.campaigns.kind import is_campaign_folder, is_recorded_campaign
from app.files.declarations.plate import declares_plate
from app.files.parsed_text import read_text

LISTS = (".txt", ".list")
LARGEST_LIST_FILE = 10_000_000
"""Bytes of a list: `MOST_CAMPAIGNS` paths of a thousand characters."""
MOST_CAMPAIGNS = 9999
"""Campaigns of a fleet: the page shows each."""


@dataclass(frozen=True)
class FleetMember:
    """One piece: the name of its campaign's folder, and the campaign."""

    name: str
    campaign: Path


def is_campaign(path: Path) -> bool:
    """Whether a folder claims to be a campaign of any form."""
    return is_campaign_folder(path) or is_recorded_campaign(path) or declares_plate(path)


def is_fleet(named: Sequence[Path]) -> bool:
    """Whether the paths typed ask for a fleet, not for a single campaign."""
    (first, *others) = named
    return bool(others) or _is_list(first) or (not is_campaign(first) and bool(_inside(first)))


def fleet_members(named: Sequence[Path]) -> tuple[FleetMember, ...]:
    """Return the campaigns of the paths typed, in their order, those of a folder by name.

    Raises
    ------
    ResultFileError
        For a path that holds no campaign, a list that cannot be read, two campaigns of one name.
    """
    found: list[FleetMember] = []
    for path in named:
        found += [FleetMember(one.resolve().name, one) for one in _campaigns_of(path)]
    places: dict[str, Path] = {}
    for one in found:
        before = places.setdefault(one.name, one.campaign)
        if before is not one.campaign:
            raise ResultFileError(
                f"{before} and {one.campaign} have one name, and results are called by it: rename one of them"
            )
    if len(found) > MOST_CAMPAIGNS:
        raise ResultFileError(f"{len(found)} campaigns are named; allowed: up to {MOST_CAMPAIGNS}")
    return tuple(found)


def _is_list(path: Path) -> bool:
    return path.suffix.lower() in LISTS and path.is_file()


def _campaigns_of(path: Path) -> list[Path]:
    if _is_list(path):
        return _listed(path)
    if is_campaign(path):
        return [path]
    inside = _inside(path)
    if not inside:
        raise ResultFileError(
            f"{path}: no campaign, nor a folder of campaigns; allowed: folders with campaign.toml (recorded), "
            "protocol.json (imported) or plate.toml (FRFs), folders of such, and lists of them (*.txt)"
        )
    return inside


def _inside(folder: Path) -> list[Path]:
    """Return the campaigns in a folder, by name; none where it is none, or cannot be listed."""
    with suppress(OSError):
        return sorted(one for one in folder.iterdir() if one.is_dir() and is_campaign(one))
    return []


def _is_there(folder: Path) -> bool:
    """Whether a folder that a list names is a campaign; not where its name is none that a disk takes."""
    try:
        return is_campaign(folder)
    except (OSError, ValueError):
        return False


def _listed(path: Path) -> list[Path]:
    try:
        lines = read_text(path, LARGEST_LIST_FILE).splitlines()
    except (OSError, ValueError) as error:
        raise ResultFileError(
            f"{path}: the list cannot be read ({error}); allowed: text, one folder a line"
        ) from error
    found = []
    for number, line in enumerate(lines, start=1):
        named = line.partition("#")[0].strip()
        if not named:
            continue
        one = path.parent / named
        if not _is_there(one):
            raise ResultFileError(
                f"{path}: line {number}: {named[:80]} is no campaign; allowed: folders with campaign.toml, "
                "protocol.json or plate.toml, relative to the list"
            )
        found.append(one)
    if not found:
        raise ResultFileError(f"{path}: the list is empty; allowed: one folder a line, # before remarks")
    return found
