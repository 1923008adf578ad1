"""Events and states of a campaign in words, with times of day as they are read where the reader is."""

import math
import re
from collections.abc import Callable, Mapping
from datetime import datetime
from typing import Any

CONTROL = dict.fromkeys((*range(32), *range(127, 160), 8232, 8233), " ") | dict.fromkeys(
    (*range(0x202A, 0x202F), *range(0x2066, 0x206A), 0x200E, 0x200F), ""
)
"""Characters that would move a terminal's cursor, break a line of a message, or turn its direction."""
LONGEST_SENTENCE = 600
"""Characters of a sentence that came from a file."""
DOES = {"approach": "to settle there", "leg": "the leg's ramp", "paused": "for a pause"}
SIGNALS = {
    "SIGINT": "Ctrl-C",
    "SIGTERM": "kill",
    "SIGHUP": "its terminal was closed",
    "SIGBREAK": "Ctrl-Break",
}
"""What people did, by the signal that the program got."""


def plain(text: object) -> str:
    """Return a text of any origin as one line without control characters, cut if it is very long."""
    line = str(text).translate(CONTROL).strip()
    return line if len(line) <= LONGEST_SENTENCE else line[: LONGEST_SENTENCE - 1] + "…"


def local(date: str) -> str:
    """Return an ISO 8601 date in this computer's local time, with its offset: ``2026-03-01 14:05:09 +0100``."""
    return datetime.fromisoformat(date).astimezone().strftime("%Y-%m-%d %H:%M:%S %z")


def said_at(date: str, *, simulated: bool) -> str:
    """Return a date as `local` has it; of a simulated rig the time of day of its own clock, with that word."""
    return f"{date[11:19]} simulated" if simulated else local(date)


def ended_by(purpose: str) -> str:
    """Say why a campaign ended.

    Parameters
    ----------
    purpose : str
        Of the log's last event of the oven: ``the end``, or class and text of the exception.
    """
    if purpose == "the end":
        return "the campaign has ended"
    kind, _, what = purpose.partition(": ")
    if kind == "RigInterrupted":
        return f"{SIGNALS.get(what, what)}; the same command continues it"
    if kind == "RigStopped" or (kind.endswith("Error") and " " in what):  # a sentence, not a key that was missing
        return re.sub(r"^\[Errno -?\d+\] ", "", what)
    return purpose


def in_words(event: Mapping[str, Any]) -> str:
    """Say an event of a campaign's log in a sentence.

    Parameters
    ----------
    event : mapping
        As `app.files.acquisition.events.parse_event` returns it.

    Returns
    -------
    str
        One line. An event of a kind that is not known here: its kind and its fields.
    """
    kind, place = str(event["event"]), event.get("place")
    known: dict[str, Callable[[], str]] = {
        "begun": lambda: "the campaign began",
        "resumed": lambda: f"the campaign was continued, with {event.get('finished', 0)} sweeps finished before",
        "sweep begun": lambda: f"sweep at {place}" + _attempt(event),
        "finished": lambda: f"finished: {place}{_at(event)}" + _doubt(event),
        "rejected": lambda: f"rejected: {place}{_attempt(event)}: {_joined(event.get('faults'))}",
        "hit": lambda: f"hit {event.get('step')} of {_point(event)} accepted, {_peak(event)}",
        "hit rejected": lambda: f"hit of {_point(event)} rejected, {_peak(event)}: {event.get('why')}",
        "hit undone": lambda: f"hit {event.get('step')} of {_point(event)} undone",
        "point skipped": lambda: f"{_point(event)} skipped",
        "missing": lambda: f"given up: {place}: {event.get('why', 'no reason in the log')}",
        "trouble": lambda: f"trouble: {event.get('what')}",
        "recovered": lambda: f"over: {event.get('what', 'temperatures are read again')}",
        "paused": lambda: "paused",
        "continued": lambda: "continued after a pause",
        "oven": lambda: _oven(event),
        "sensor left out": lambda: f"a sensor is left out: {event.get('what')}",
        "temperature in doubt": lambda: f"temperature in doubt: {_joined(event.get('what'))}",
        "temperature believed": lambda: "the temperature is believed again",
        "wiring changed": lambda: "continued with instruments that are reached in another way",
    }
    if kind in known:
        return plain(known[kind]())
    rest = ", ".join(
        f"{key} {value}" for key, value in event.items() if key not in ("event", "time", "date", "leg")
    )
    return plain(f"{kind}: {rest}" if rest else kind)


def _oven(event: Mapping[str, Any]) -> str:
    purpose = str(event.get("purpose", ""))
    if event["command"] == "ramp":
        rate = f" at {event['rate']:g} K/min" if "rate" in event else ""
        return f"oven: ramp to {event['target']:g} °C{rate}, {DOES.get(purpose, purpose)}".rstrip(", ")
    if event["command"] == "hold":
        return f"oven: held, {DOES.get(purpose, purpose)}".rstrip(", ")
    why = ended_by(purpose)
    unsafe = event.get("unsafe") or ()
    if unsafe:
        return f"NOT AT REST: {_joined(unsafe)}; {why}".rstrip("; ")
    return f"oven at rest, drive at 0 V: {why}".rstrip(": ")


def _at(event: Mapping[str, Any]) -> str:
    here = event.get("temperature")
    return "" if here is None or not math.isfinite(here) else f", measured at {here:.2f} °C"


def _attempt(event: Mapping[str, Any]) -> str:
    number = event.get("attempt")
    return f", attempt {number}" if number is not None and number > 1 else ""


def _doubt(event: Mapping[str, Any]) -> str:
    return f"; its temperature is in doubt: {event['doubt']}" if event.get("doubt") else ""


def _joined(parts: object) -> str:
    return "; ".join(map(str, parts)) if isinstance(parts, list | tuple) else str(parts or "")


def _point(event: Mapping[str, Any]) -> str:
    point = event.get("point")
    return f"point {point + 1}" if isinstance(point, int) else "a point"


def _peak(event: Mapping[str, Any]) -> str:
    peak = event.get("peak")
    return f"{peak:.1f} N" if isinstance(peak, int | float) else "force unknown"
