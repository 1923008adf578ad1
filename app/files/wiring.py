"""What of a declared rig is only how its instruments are reached: it may change while a campaign is interrupted.

A cable in another socket, a port that the system has renamed, another time-out: what is measured stays the same. A
terminal of a card may get another name as long as no name that stays gets another role: two sensors exchanged are
another experiment.
"""

from collections.abc import Iterator, Mapping
from typing import Any

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

    Returns
    -------
    dict
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

    Parameters
    ----------
    there, asked : mapping

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
