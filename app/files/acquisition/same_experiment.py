"""Whether a folder holds the campaign of this very experiment, so that it can be taken up again.

An experiment may be changed as long as nothing was measured, as after a test shot that was too loud. How its
instruments are reached may change at any time (`rewired` below).

A cable in another socket, a port that the system has renamed, another time-out: what is measured stays the same. A
terminal of a card may get another name as long as no name that stays gets another role: two sensors exchanged are
another experiment.
"""

from collections.abc import Iterator, Mapping
from itertools import count
from pathlib import Path
from typing import Any

from analysis.declaration.tolerances import Tolerances
from app.files.acquisition.events import LATEST as LATEST
from app.files.acquisition.events import NAME as EVENTS
from app.files.acquisition.events import READINGS as READINGS
from app.files.acquisition.events import read_events
from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaigns.folder import ENDING, SWEEPS, read_protocol
from app.files.campaigns.kind import PROTOCOL, is_campaign_folder

LINE = (
    "port",
    "baud_rate",
    "parity",
    "stop_bits",
    "timeout",
    "retries",
    "gap_after_read",
    "gap_after_write",
    "lost_after",
    "address",
    "framing",
    "terminator",
    "acknowledge",
)
"""Of a line to an instrument."""

REACHED = {
    "oven": LINE,
    "thermometer": LINE,
    "cards": ("grpc", "device"),
    "programme": ("poll_interval",),
    "limits": ("lost_after",),
}
"""Keys by their table; how often instruments are asked, and how long they may be silent, are of the same kind."""

TERMINALS = ("output", "drive_input", "responses", "thermocouples", "iepe")
"""Keys of ``[cards]`` with names of terminals, those that give them a role first."""


def without_wiring(acquired: Mapping[str, Any], other: Mapping[str, Any]) -> dict[str, Any]:
    """Return a declaration without what is only wiring, to be compared with another one.

    Parameters
    ----------
    acquired : mapping
        An experiment's declaration.
    other : mapping
        The one it is compared with: names of terminals are left out if each can be one in the other.
    """
    kept = dict(acquired)
    for table, keys in REACHED.items():
        if isinstance(kept.get(table), dict):
            kept[table] = {key: value for key, value in kept[table].items() if key not in keys}
    if isinstance(kept.get("cards"), dict) and _only_renamed(acquired, other):
        roles = _roles(kept["cards"])
        for key in TERMINALS:
            if key in kept["cards"]:
                kept["cards"][key] = _replaced(kept["cards"][key], roles)
    return kept


def changed_wiring(there: Mapping[str, Any], asked: Mapping[str, Any]) -> dict[str, Any]:
    """Return the wiring that differs between two declarations of one experiment, as the second has it.

    Returns
    -------
    dict
        ``[oven] port`` and so on, to its value in `asked`.
    """
    changed = {}
    for table, keys in {**REACHED, "cards": REACHED["cards"] + TERMINALS}.items():
        before, after = there.get(table), asked.get(table)
        if isinstance(before, dict) and isinstance(after, dict):
            for key in keys:
                if before.get(key) != after.get(key):
                    changed[f"[{table}] {key}"] = after.get(key)
    return changed


def _only_renamed(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Whether every role has one terminal in both, and none that both name has two roles."""
    first, second = one.get("cards"), other.get("cards")
    if not isinstance(first, dict) or not isinstance(second, dict):
        return False
    before, after = _roles(first), _roles(second)
    if sorted(before.values()) != sorted(after.values()):
        return False
    if "simulated" in (one.get("rig"), other.get("rig")):  # whose slots say what modules are simulated
        places = ({role: _slot(name) for name, role in roles.items()} for roles in (before, after))
        return next(places) == next(places)
    return all(after[name] == role for name, role in before.items() if name in after)


def _roles(cards: Mapping[str, Any]) -> dict[str, str]:
    """Return the role of each terminal: that of the IEPE inputs is the one they have anyway."""
    return {
        name: f"{key} {number}" for key in TERMINALS[:-1] for number, name in enumerate(_listed(cards.get(key)), 1)
    }


def _listed(value: Any) -> Iterator[str]:
    yield from (value if isinstance(value, list) else [value] if isinstance(value, str) else [])


def _replaced(value: Any, roles: Mapping[str, str]) -> Any:
    if isinstance(value, list):
        return sorted(roles.get(name, name) for name in value)
    return roles.get(value, value) if isinstance(value, str) else value


def _slot(terminal: str) -> str:
    device, _, channel = terminal.partition("/")
    return f"{device.partition('Mod')[2]}/{channel}"


REJECTED = "rejected"
"""Folder of the sweeps that were recorded, and found faulty."""

REWIRED = "wiring changed"
"""Event of a campaign that is continued with other wiring than that of its protocol."""

LATER = {
    ".acquired.oven.rest_after": 1800.0,
    ".acquired.simulation.modules.4": "NI-9215",
    ".acquired.simulation.modules.5": "NI-9263",
    **{
        f".{part}.tolerances.{name}": value
        for part in ("acquired", "experiment")
        for name, value in Tolerances().model_dump(mode="json", exclude={"own"}).items()
    },
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
    """Return what differs between a protocol and that of a campaign folder, as the experiment's file names it.

    The campaign's name is that of its folder, which may have been renamed.
    """
    there, _ = read_protocol(folder)
    now = {part: value for part, value in protocol.items() if part != "name"}
    before = {part: there.get(part) for part in now}
    begun, asked = before.get("acquired"), now.get("acquired")
    if isinstance(begun, dict) and isinstance(asked, dict):
        before["acquired"], now["acquired"] = without_wiring(begun, asked), without_wiring(asked, begun)
    return differences(before, now)


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


def differences(there: dict[str, Any], asked: dict[str, Any]) -> list[str]:
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
