"""Effects of a comparison for people: their names, and what was found, in units that people use."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import PEOPLES
from app.summaries.numbers import roughly

Record = Mapping[str, Any]
USUAL = {"kg": "g", "m": "mm"}
"""Units for people of parameters whose card names none."""


def title(name: str, titles: Mapping[str, str]) -> str:
    """Return the name of an effect for people."""
    return titles.get(name) or name.replace("_", " ")


def titles_of(record: Record) -> dict[str, str]:
    """Return the names for people of all effects in the record of a comparison."""
    found = dict(record.get("titles", {}))
    for effect in record["effects"]:
        if effect.get("title"):
            found[effect["name"]] = effect["title"]
    return found


def in_words(effect: Record) -> str:
    """Return what was found of an effect, with values: "an added mass of 0.800 ± 0.002 g at the cable"."""
    shown = effect.get("shown_units", {})
    values = {name: _value(one, shown.get(name, "")) for name, one in effect["parameters"].items()}
    phrase = str(effect.get("phrase", ""))
    if phrase:
        for name, value in values.items():  # not str.format: the file may be anybody's
            phrase = phrase.replace(f"{{{name}}}", value)
        return phrase.replace("{{", "{").replace("}}", "}")
    listed = ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in values.items())
    return f"{effect.get('title') or effect['name'].replace('_', ' ')}: {listed}"


def found_words(effect: Record, titles: Mapping[str, str]) -> str:
    """Return `in_words`, and the effects that could not be told from it."""
    others = " or ".join(title(name, titles) for name in effect["equivalent"])
    return in_words(effect) + (f" (or, not to be told from it: {others})" if others else "")


def _value(one: Record, shown: str) -> str:
    """Return a value with its standard deviation in the unit for people."""
    shown = shown or USUAL.get(one["unit"], "")
    factor = PEOPLES.get((one["unit"], shown), 1.0)
    unit = shown if (one["unit"], shown) in PEOPLES else one["unit"]
    return roughly(factor * one["value"], factor * one["sigma"], unit)
