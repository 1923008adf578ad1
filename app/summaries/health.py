"""What is said of a panel's health: a record, a table of dates, sentences."""

import math
from typing import Any

from analysis.effect_card import PEOPLES
from analysis.health.candidates import WORDS
from analysis.health.refined import RefinedChange
from analysis.health.watch import HealthDate, HealthReport, NamedChange
from app.summaries.gap import USUAL
from app.summaries.numbers import roughly
from app.summaries.table import Table

SCHEMA = "flexura-health/1"


def health_record(report: HealthReport) -> dict[str, Any]:
    """Return what health.json holds, without notes and provenance.

    Parameters
    ----------
    report : HealthReport

    Returns
    -------
    dict
        Of values that JSON holds.
    """
    first = report.first_alarm
    return {
        "schema": SCHEMA,
        "verdict": "healthy" if report.found is None else "changed",
        "false_alarms_per_date": report.rate,
        "limit_sigma": report.limit,
        "misfit_limit": report.misfit_limit,
        "baseline": {"misfit": report.baseline_misfit, "order": report.order},
        "first_alarm": None if first is None else first.date,
        "change": None if report.found is None else _change_record(report.found),
        "dates": [_date_record(one) for one in report.dates],
    }


def _date_record(one: HealthDate) -> dict[str, Any]:
    if one.skipped:
        return {"date": one.date, "recorded_c": one.label, "skipped": one.skipped}
    return {
        "date": one.date,
        "recorded_c": one.label,
        "temperature_c": one.temperature,
        "sigma_k": one.sigma,
        "misfit": one.misfit,
        "strongest": one.strongest,
        "z": one.z,
        "dates_added": one.span,
        "alarm": one.alarm,
    }


def _change_record(found: NamedChange) -> dict[str, Any]:
    change = found.change
    record: dict[str, Any] = {
        "family": found.family,
        "said": change_words(found),
        "probability": found.probability,
        "probabilities": dict(found.probabilities),
        "since": found.since,
        "dates_added": found.span,
        "effect": None,
        "parameters": {},
        "trend": [{"amplitude": a, "sigma": s if math.isfinite(s) else None} for a, s in found.trend],
    }
    if change is not None:
        candidate = change.candidate
        units = {"x": "m", "y": "m", candidate.parameter.name: candidate.parameter.unit}
        record["effect"] = candidate.effect
        record["patch"] = candidate.patch or None
        record["parameters"] = {
            name: {"value": change.values[name], "sigma": sigma, "unit": units[name]}
            for name, sigma in change.sigma.items()
        }
        record["misfit"] = change.misfit
        record["also"] = [
            {
                key: {"value": one.values[key], "sigma": sigma, "unit": units[key]}
                for key, sigma in one.sigma.items()
            }
            for one in found.also
        ]
    return record


def change_words(found: NamedChange) -> str:
    """Return what has changed, with values: "added mass 2.01 ± 0.03 g at x 60 ± 1 mm, y 110 ± 1 mm"."""
    if found.family == "unknown" or found.change is None:
        return WORDS["unknown"]
    others = [f", or at {_place(one)}" for one in found.also]
    return _in_words(found.change) + "".join(others)


def _in_words(change: RefinedChange) -> str:
    candidate = change.candidate
    one = candidate.parameter
    amplitude = _value(change.values[one.name], change.sigma[one.name], one.unit, one.shown)
    said = f"{candidate.title} {amplitude}"
    if not candidate.placed:
        return said
    return f"{said} at {_place(change)}"


def _place(change: RefinedChange) -> str:
    return ", ".join(f"{axis} {_value(change.values[axis], change.sigma[axis], 'm', 'mm')}" for axis in ("x", "y"))


def _value(value: float, sigma: float, unit: str, shown: str) -> str:
    shown = shown or USUAL.get(unit, "")
    factor = PEOPLES.get((unit, shown), 1.0)
    return roughly(factor * value, factor * sigma, shown if (unit, shown) in PEOPLES else unit)


def headline(report: HealthReport) -> str:
    """Return the result in one line."""
    judged, found, first = report.judged, report.found, report.first_alarm
    if not judged:
        return f"none of {len(report.dates)} dates could be judged"
    if found is None:
        largest = max(one.z for one in judged)
        said = f"no change on the last of {len(judged)} dates (largest {largest:.1f} of {report.limit:.1f} σ)"
        return said if first is None else f"{said}; alarm on {first.date} only earlier"
    since = f"first alarm on {first.date}" if first is not None else ""
    probability = "" if found.family == "unknown" else f", probability {min(found.probability, 0.999):.3f}"
    return f"changed: {change_words(found)}{probability}; {since}"


def tables(report: HealthReport) -> list[Table]:
    """Return the dates, and how likely each kind of change is where something has changed."""
    headings = ("date", "recorded [°C]", "own [°C]", "misfit", "strongest", "σ", "dates", "")
    rows = tuple(_row(one) for one in report.dates)
    caption = (
        f"alarm above {report.limit:.2f} σ, or a misfit above {report.misfit_limit:.3g}: at most {report.rate:g} "
        "false alarms per date"
    )
    found = [Table("", headings, rows, caption, frozenset({0, 4, 7}))]
    if report.found is not None:
        shares = tuple((WORDS[name], f"{share:.3f}") for name, share in report.found.probabilities)
        found.append(Table("", ("kind of change", "probability"), shares, words=frozenset({0})))
    return found


def _row(one: HealthDate) -> tuple[str, ...]:
    label = "" if one.label is None else f"{one.label:.1f}"
    if one.skipped:
        return (one.date, label, "", "", one.skipped, "", "", "skipped")
    return (
        one.date,
        label,
        roughly(one.temperature, one.sigma),
        f"{one.misfit:.3g}",
        one.strongest,
        f"{one.z:.1f}",
        str(one.span),
        "alarm" if one.alarm else "",
    )
