"""The plan of the next experiment as part of ``gap.json``."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from analysis.gap.plan.decision import Decision
from analysis.gap.plan.measurement import OVEN_FIXED, Measurement
from analysis.gap.plan.ranking import Expected, Plan
from analysis.gap.plan.separation import ENOUGH, Question
from app.files.bad_file import ResultFileError, quoted
from app.files.campaign_error import CampaignFileError
from app.files.parsed_text import parse_json, read_text

TURNED = "turned_plate"
LARGEST_GAP_FILE = 50_000_000
"""Bytes of a gap.json that is read."""


def plan_record(plan: Plan, file: str = "", to_complete: str = "") -> dict[str, Any]:
    """Return what gap.json holds of a plan.

    Parameters
    ----------
    file : str
        Name of the experiment's file that was written for the first of its measurements; empty where none was.
    to_complete : str
        What has to be filled in there.

    Returns
    -------
    dict
        Of values that JSON holds.
    """
    chosen = plan.winner
    return {
        "enough_sigma": ENOUGH,
        "questions": [_question(one, k, plan) for k, one in enumerate(plan.questions)],
        "measurements": [_expected(one) for one in plan.ranked if one.gain > 0.0],
        "next": None if chosen is None else _next(chosen.measurement, file, to_complete),
        "notes": list(plan.notes),
    }


def answer_record(decision: Decision) -> dict[str, Any]:
    """Return what gap.json holds of the answer to an earlier plan's questions."""
    best = max(decision.nats.values())
    return {
        "settled": decision.settled,
        "relative_nats": {name: nats - best for name, nats in decision.nats.items()},
    }


def _question(one: Question, place: int, plan: Plan) -> dict[str, Any]:
    before = plan.ranked[0].before[place] if plan.ranked else None
    return {"kind": one.kind, "effect": one.effect, "rival": one.rival, "separation_sigma": before}


def _expected(one: Expected) -> dict[str, Any]:
    return {
        "key": one.measurement.key,
        "words": one.measurement.words,
        "hours": one.measurement.hours,
        "gain_sigma": one.gain,
        "gain_per_hour": one.per_hour,
        "settles": list(one.settles),
        "separation_sigma": list(one.after),
    }


def _next(one: Measurement, file: str, to_complete: str) -> dict[str, Any]:
    place = None if one.place is None else list(one.place)
    return {
        "key": one.key,
        "words": one.words,
        "hours": one.hours,
        "place_m": place,
        "mass_kg": one.mass or None,
        "experiment": file or None,
        "to_complete": to_complete,
    }


def open_before(run: Path) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Read from a run what its plan left open.

    Parameters
    ----------
    run : Path
        Run folder with a gap.json of ``flexura gap --plan``.

    Returns
    -------
    effects : tuple of str
        All that its questions are about.
    turned : tuple of str
        Those whose amplitudes change sign, where the plan was to turn the plate.

    Raises
    ------
    ResultFileError
        Where there is none, or nothing was open.
    """
    file = run / "gap.json"
    try:
        record: Mapping[str, Any] = parse_json(read_text(file, LARGEST_GAP_FILE))
        plan = record["plan"]
        names = [name for one in plan["questions"] for name in (one["effect"], one["rival"]) if name]
        chosen = plan["next"] or {}
    except (OSError, CampaignFileError, ValueError, KeyError, TypeError) as error:
        wanted = f"make it with: flexura gap CAMPAIGN --plan --out {quoted(run)}"
        raise ResultFileError(f"{file}: holds no plan; {wanted}") from error
    if not names:
        raise ResultFileError(f"{file}: its plan has no questions; nothing was open that could be decided")
    turned = OVEN_FIXED if chosen.get("key") == TURNED else ()
    return tuple(dict.fromkeys(str(name) for name in names)), turned
