"""The plan of the next experiment as part of ``gap.json``."""

from typing import Any

from analysis.gap.plan.decision import Decision
from analysis.gap.plan.measurement import Measurement
from analysis.gap.plan.question import Question
from analysis.gap.plan.ranking import Expected, Plan
from analysis.gap.plan.separation import ENOUGH


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
