"""Whether a twin file belongs to a campaign's plate, and whether the library has its effects."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from analysis.declared import Declared
from analysis.effect_card import EffectCard
from analysis.experiment import Experiment
from app.files.campaign_error import CampaignFileError, Problem
from app.files.twin_file import TwinFile

RECORDER = ("acquisition.module", "acquisition.sample_rate")
"""May differ between campaigns on one plate: they change nothing a twin answers."""
DRIVEN_OR_HELD = {repr("actuator"), repr("shorted")}
"""Roles of one patch in campaigns that several actuators drove one after the other; short-circuited in either."""


def require_same_plate(path: Path, twin: TwinFile, experiment: Experiment) -> None:
    """Raise unless a twin's plate is that of the campaign.

    Parameters
    ----------
    path : Path
        File of the twin.
    experiment : Experiment
        Of the campaign.

    Raises
    ------
    CampaignFileError
        With all that is declared otherwise, but for `RECORDER` and which of several patches drove the plate.
    """
    remedy = "as the campaign declares; a twin belongs to one plate with its patches"
    problems = [
        Problem(path.name, place, seen, wanted, remedy)
        for key in ("plate", "patch", "drive", "sensor", "string", "cable", "acquisition", "oven")
        for place, seen, wanted in _differences(key, getattr(twin, key), getattr(experiment, key))
        if place not in RECORDER and not (place.endswith(".role") and {seen, wanted} == DRIVEN_OR_HELD)
    ]
    if problems:
        raise CampaignFileError(path.parent, problems)


def require_known_effects(path: Path, twin: TwinFile, cards: Mapping[str, EffectCard]) -> None:
    """Raise unless the library has a twin's effects, their parameters and units, and allows the values.

    Parameters
    ----------
    path : Path
        File of the twin.
    cards : mapping of str to EffectCard
        The library's, by effect.

    Raises
    ------
    CampaignFileError
        With all that it does not know or allow.
    """
    problems: list[Problem] = []
    for number, effect in enumerate(twin.effect):
        place = f"effect[{number}]"
        if effect.name not in cards:
            remedy = "a user's own needs --effects FOLDER"
            problems.append(Problem(path.name, f"{place}.name", repr(effect.name), ", ".join(cards), remedy))
            continue
        known = {p.name: p for p in cards[effect.name].parameters}
        if set(effect.parameter) != set(known):
            seen = ", ".join(effect.parameter)
            problems.append(Problem(path.name, f"{place}.parameter", seen, "exactly " + ", ".join(known)))
            continue
        for name, given in effect.parameter.items():
            wanted, key = known[name], f"{place}.parameter.{name}"
            if given.unit != wanted.unit:
                problems.append(Problem(path.name, f"{key}.unit", repr(given.unit), repr(wanted.unit)))
            if not wanted.low <= given.value <= wanted.high:
                allowed = f"{wanted.low:g} to {wanted.high:g} {wanted.unit}"
                problems.append(Problem(path.name, f"{key}.value", f"{given.value:g}", allowed))
    if problems:
        raise CampaignFileError(path.parent, problems)


def _differences(place: str, ours: Any, theirs: Any) -> list[tuple[str, str, str]]:
    """Places at which two declarations differ, with both values."""
    if isinstance(ours, Declared) and type(ours) is type(theirs):
        names = type(ours).model_fields
        return [d for n in names for d in _differences(f"{place}.{n}", getattr(ours, n), getattr(theirs, n))]
    if _tables(ours) and _tables(theirs):
        if len(ours) != len(theirs):
            return [(place, f"{len(ours)} tables", f"{len(theirs)} tables")]
        pairs = zip(ours, theirs, strict=True)
        return [d for n, (a, b) in enumerate(pairs) for d in _differences(f"{place}[{n}]", a, b)]
    return [] if ours == theirs else [(place, _said(ours), _said(theirs))]


def _tables(value: Any) -> bool:
    return isinstance(value, tuple) and all(isinstance(item, Declared) for item in value)


def _said(value: Any) -> str:
    return "nothing" if value is None else repr(value)
