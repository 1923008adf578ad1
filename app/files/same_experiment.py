"""Whether a folder holds the campaign of this very experiment, so that it can be taken up again.

An experiment may be changed as long as nothing was measured, as after a test shot that was too loud. How its
instruments are reached may change at any time (`app.files.wiring`).
"""

from collections.abc import Mapping
from itertools import count
from pathlib import Path
from typing import Any

from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaign_folder import ENDING, SWEEPS, read_protocol
from app.files.campaign_kind import PROTOCOL, is_campaign_folder
from app.files.events import NAME as EVENTS
from app.files.events import read_events
from app.files.latest_repeat import NAME as LATEST
from app.files.readings import NAME as READINGS
from app.files.wiring import changed_wiring, without_wiring

REJECTED = "rejected"
"""Folder of the sweeps that were recorded, and found faulty."""

REWIRED = "wiring changed"
"""Event of a campaign that is continued with other wiring than that of its protocol."""

LATER = {
    ".acquired.oven.rest_after": 1800.0,
    ".acquired.simulation.modules.4": "NI-9215",
    ".acquired.simulation.modules.5": "NI-9263",
}
"""Keys that came after the first campaigns, with their defaults: a campaign begun before is still the same one."""


def require_ours(folder: Path, protocol: Mapping[str, Any]) -> None:
    """Raise CampaignFileError if a folder holds something else than the campaign of this protocol."""
    ours = {PROTOCOL, f"{PROTOCOL}.part", SWEEPS, ENDING}
    if is_campaign_folder(folder):
        different = changed_keys(folder, protocol)
        if different and not may_change(folder):
            seen = f"holds a campaign begun with another experiment; different: {', '.join(different[:6])}"
            allowed = "a new folder, or this same experiment"
            raise CampaignFileError(folder, [Problem("", "", seen, allowed, "undo the change, or use --out")])
    elif folder.exists() and (not folder.is_dir() or {child.name for child in folder.iterdir()} - ours):
        allowed = "a new folder, or one this same experiment began"
        raise CampaignFileError(folder, [Problem("", "", "exists and is no campaign", allowed, "use --out")])


def changed_keys(folder: Path, protocol: Mapping[str, Any]) -> list[str]:
    """Return what differs between a protocol and that of a campaign folder, as the experiment's file names it."""
    there, _ = read_protocol(folder)
    before, now = {part: there.get(part) for part in protocol}, dict(protocol)
    begun, asked = before.get("acquired"), now.get("acquired")
    if isinstance(begun, dict) and isinstance(asked, dict):
        before["acquired"], now["acquired"] = without_wiring(begun, asked), without_wiring(asked, begun)
    return _differences(before, now)


def rewired(folder: Path, protocol: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return the wiring of a protocol that is not that of a campaign folder, by the names of its keys.

    None if it is what the log of the folder says already.
    """
    there, asked = read_protocol(folder)[0].get("acquired"), protocol.get("acquired")
    if not isinstance(there, dict) or not isinstance(asked, dict):
        return None
    wiring = changed_wiring(there, asked)
    logged = [event.get("wiring") for event in read_events(folder) if event["event"] == REWIRED]
    return wiring if wiring != (logged or [{}])[-1] else None


def may_change(folder: Path) -> bool:
    """Whether a campaign that a rig began holds no sweep, kept or rejected, and left its oven at rest."""
    if "acquired" not in read_protocol(folder)[0]:
        return False
    measured = any(child.suffix == ".h5" for part in (SWEEPS, REJECTED) for child in (folder / part).glob("*"))
    commands = [event["command"] for event in read_events(folder) if event.get("command")]
    return not measured and commands[-1:] in ([], ["safe"])


def put_log_aside(folder: Path) -> None:
    """Rename the log and the readings of an experiment that was changed: ``events-1.jsonl``, ``readings-1.csv``.

    A new log makes the campaign begin with its test shot. The last repeat recorded, which is only shown, goes.
    """
    (folder / LATEST).unlink(missing_ok=True)
    for name in (EVENTS, READINGS):
        stem, _, ending = name.partition(".")
        kept = (folder / f"{stem}-{number}.{ending}" for number in count(1))
        if (folder / name).exists():
            (folder / name).rename(next(path for path in kept if not path.exists()))


def _differences(there: dict[str, Any], asked: dict[str, Any]) -> list[str]:
    """Keys in which two protocols differ; the text of the file, such as comments, is not compared.

    Those of the experiment's file as they stand there; what is derived from them, the declaration of the
    campaign, is named only where they are the same (other cards run at another rate).
    """
    one, other = LATER | _flat(there), LATER | _flat(asked)
    keys = sorted(key[1:] for key in set(one) | set(other) if one.get(key) != other.get(key))
    of_file = [key for key in keys if key.startswith("acquired.")]
    derived = ("source", "sha256", "acquired.", *(["experiment."] if of_file else []))
    rest = [key for key in keys if not key.startswith(tuple(derived))]
    return [_as_written(key.removeprefix("acquired.")) for key in of_file] + rest


def _as_written(key: str) -> str:
    table, _, name = key.rpartition(".")
    return f"[{table}] {name}" if table else name


def _flat(tree: Any, prefix: str = "") -> dict[str, Any]:
    if not isinstance(tree, dict):
        return {prefix: tree}
    return {key: value for name, part in tree.items() for key, value in _flat(part, f"{prefix}.{name}").items()}
