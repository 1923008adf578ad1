"""Whether a twin file, or a later recording, belongs to a plate, and whether the library has a twin's effects."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from analysis.declaration.strict import Declared
from analysis.effect_card import EffectCard
from analysis.experiment import Experiment
from app.files.allowed_values import nearest
from app.files.campaign_error import CampaignFileError, Problem
from app.files.twin_file import TwinFile

RECORDER = ("acquisition.module", "acquisition.sample_rate")
"""May differ between campaigns on one plate: they change nothing a twin answers."""
PLATE = ("plate", "patch", "drive", "sensor", "string", "cable", "acquisition")
"""Tables of a declaration that describe the plate and what is on it."""
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
        for place, seen, wanted in _of_the_plate(twin, experiment, (*PLATE, "oven"))
        if not (place.endswith(".role") and {seen, wanted} == DRIVEN_OR_HELD)
    ]
    if problems:
        raise CampaignFileError(path.parent, problems)


def require_same_panel(folder: Path, name: str, later: Experiment, baseline: Experiment) -> None:
    """Raise unless a later recording is of the panel of a baseline, with its patches in the same roles.

    Parameters
    ----------
    folder : Path
        Of the later recording.
    name : str
        Of the file there that declares it.
    later, baseline : Experiment

    Raises
    ------
    CampaignFileError
        With all that is declared otherwise, but for `RECORDER`.
    """
    remedy = "as the baseline declares; a panel is compared with itself: name its own baseline"
    found = _of_the_plate(later, baseline, PLATE)
    if found:
        raise CampaignFileError(
            folder, [Problem(name, place, seen, wanted, remedy) for place, seen, wanted in found]
        )


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
            own = "a user's own needs --effects FOLDER"
            remedy = "; ".join(filter(None, (nearest(effect.name, cards), own)))
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


def _of_the_plate(
    ours: TwinFile | Experiment, theirs: Experiment, tables: tuple[str, ...]
) -> list[tuple[str, str, str]]:
    """Places in some tables at which two plates differ, with both values; not in what only records."""
    found = [one for key in tables for one in _differences(key, getattr(ours, key), getattr(theirs, key))]
    return [one for one in found if one[0] not in RECORDER]


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
