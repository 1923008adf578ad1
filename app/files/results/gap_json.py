"""``gap.json``: comparison of a campaign with its twin, for machines (flexura-gap/1), with the plan."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.estimates import Estimate, FittedLaws, SheetMaterial
from analysis.gap.description.describing import Curve, Dependence, Description, Form
from analysis.gap.description.place_map import KINDS, UNITS, PlaceMap
from analysis.gap.fitting.residual_map import Region
from analysis.gap.plan.decision import Decision, Expected, Plan
from analysis.gap.plan.measurement import Measurement
from analysis.gap.plan.separation import ENOUGH, Question
from analysis.gap.report import Agreement, CandidateRow, GapReport, NamedEffect
from analysis.gap.search.held_out import HeldOut
from analysis.gap.search.observability import Observability
from analysis.pairing.assignment import Pairing
from analysis.updating.corrected_twin import material_of
from app.files.results.pairing_json import declared_record, pairing_record

SCHEMA = "flexura-gap/1"


def gap_record(
    report: GapReport,
    given: Mapping[str, tuple[Estimate, ...]],
    made_from: Mapping[str, Any],
    seconds: float,
    pairing: Pairing | None = None,
    more: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Return what gap.json holds.

    Parameters
    ----------
    given : mapping of str to tuple of Estimate
        Effects that were on from the beginning.
    made_from : mapping
        Provenance.
    seconds : float
        Wall time from reading the FRFs to the file.
    more : mapping, optional
        Records of `plan_record`, `answer_record` and `description_record`, by ``plan``, ``answer``
        and ``description``.

    Returns
    -------
    dict
        Of values that JSON holds.
    """
    gap = report.unexplained is not None
    left = report.after.regions if gap else ()
    return {
        "schema": SCHEMA,
        "verdict": report.verdict,
        "effects": [_effect(effect) for effect in report.effects],
        "pairing": pairing_record(pairing),
        "not_observable": [o.effect for o in report.not_observable],
        "gap": {
            "baseline": _agreement(report.baseline),
            "final": _agreement(report.final),
            "held_out": _held_out(report),
            "held_out_also": [_tried(tried) for tried in report.held_out[1:]],
        },
        "scatter": _scatter(report),
        "unexplained": {"share": report.unexplained, "where": [_region(region) for region in left]},
        "seconds": seconds,
        "where": {
            "regions": [_region(region) for region in (report.before.regions if gap else ())],
            "shares": report.before.shares() if gap else {},
        },
        "titles": dict(report.titles),
        "starting_effects": {name: _parameters(values) for name, values in given.items()},
        "observability": [_observability(one) for one in report.seen],
        "candidates": [_candidate(one) for one in report.candidates],
        "declared": [{**declared_record(one), "words": one.words} for one in report.declared],
        "laws": {"baseline": _laws(report.laws_before), "final": _laws(report.laws_after)},
        "noise": {
            "variance_over_stated": dict(zip(report.before.channels, report.noise.ratio.tolist(), strict=True))
        },
        "description": None,
        "plan": None,
        "answer": None,
        **(more or {}),
        "notes": list(report.notes),
        "provenance": dict(made_from),
    }


def _scatter(report: GapReport) -> dict[str, dict[str, float]] | None:
    """Scatter of the plate's resonances about those of the twin, without and with effects."""
    if report.scatter is None:
        return None
    parts = zip(("baseline", "final"), report.scatter, strict=True)
    return {
        when: {"frequency": one.frequency, "half_loss_factor": one.damping, "amplitude": one.amplitude}
        for when, one in parts
    }


def _observability(one: Observability) -> dict[str, Any]:
    return {
        "name": one.effect,
        "observable": one.observable,
        "kept": one.kept,
        "size_sigma": one.size,
        "needs": one.needs,
    }


def _candidate(row: CandidateRow) -> dict[str, Any]:
    return {
        "name": row.effect,
        "log_evidence_screened": row.screened,
        "log_evidence_fitted": row.fitted,
        "share": row.share,
        "kept": row.kept,
        "cosine_to_first": row.cosine,
    }


def _effect(effect: NamedEffect) -> dict[str, Any]:
    return {
        "name": effect.name,
        "equivalent": list(effect.equivalent),
        "probability": effect.probability,
        "against": dict(effect.against),
        "log_evidence_gain": effect.log_evidence_gain,
        "parameters": _parameters(effect.parameters),
        "title": effect.title,
        "summary": effect.summary,
        "phrase": effect.phrase,
        "shown_units": dict(effect.shown),
        "separated_by": effect.separated_by,
    }


def _parameters(parameters: Sequence[Estimate]) -> dict[str, Any]:
    return {p.name: {"value": p.value, "sigma": p.sigma, "unit": p.unit} for p in parameters}


def _agreement(agreement: Agreement) -> dict[str, Any]:
    return {
        "chi2_per_dof": agreement.chi2_per_dof,
        "relative_misfit": agreement.relative_misfit,
        "z": agreement.z,
        "whiteness_sigma": list(agreement.whiteness),
    }


def _held_out(report: GapReport) -> dict[str, Any]:
    """Agreement on data that the effects were not fitted to; all of it where none was fitted."""
    if not report.held_out:
        same = _plain(report.baseline)
        closure = None if report.unexplained is None else 0.0
        what = "all records: no effect was fitted"
        return {"what": what, "baseline": same, "final": same, "closure": closure, "closure_sigma": None}
    return _tried(report.held_out[0])


def _tried(tried: HeldOut) -> dict[str, Any]:
    return {
        "what": tried.what,
        "baseline": {"chi2_per_dof": tried.baseline_chi2 / tried.dof, "relative_misfit": tried.baseline_misfit},
        "final": {"chi2_per_dof": tried.final_chi2 / tried.dof, "relative_misfit": tried.final_misfit},
        "closure": tried.closure,
        "closure_sigma": tried.closure_sigma,
        "gain": tried.gain,
    }


def _plain(agreement: Agreement) -> dict[str, Any]:
    return {"chi2_per_dof": agreement.chi2_per_dof, "relative_misfit": agreement.relative_misfit}


def _region(region: Region) -> dict[str, Any]:
    return {
        "channel": region.channel,
        "frequency_hz": list(region.frequency),
        "temperature_c": list(region.temperature),
        "share": region.share,
        "largest_sigma": region.sigma,
    }


def _laws(laws: FittedLaws) -> dict[str, Any]:
    if laws.sheet is not None:
        return _sheet_laws(laws.temperature, laws.sheet)
    material, sigma = material_of(laws)
    return {
        "temperature_c": laws.temperature.tolist(),
        "youngs_modulus_pa": material.youngs_modulus.tolist(),
        "poisson_ratio": material.poisson_ratio.tolist(),
        "loss_factor": material.loss_factor.tolist(),
        "sigma_youngs_modulus_pa": sigma.youngs_modulus.tolist(),
        "sigma_poisson_ratio": sigma.poisson_ratio.tolist(),
        "sigma_loss_factor": sigma.loss_factor.tolist(),
    }


def _sheet_laws(temperature: NDArray[np.float64], sheet: SheetMaterial) -> dict[str, Any]:
    """Return the constants of an orthotropic sheet by direction, and their standard deviations."""
    found: dict[str, Any] = {
        "temperature_c": temperature.tolist(),
        "delta_e": sheet.delta_e,
        "delta_g": sheet.delta_g,
    }
    for before, constants in (("", sheet.value), ("sigma_", sheet.sigma)):
        for entry in fields(constants):
            unit = "_pa" if "modulus" in entry.name else ""
            found[f"{before}{entry.name}{unit}"] = getattr(constants, entry.name).tolist()
    return found


def description_record(found: Description, file: str = "") -> dict[str, Any]:
    """Return what gap.json holds of a description.

    Parameters
    ----------
    file : str
        Of the effect that was written, relative to the run folder; empty where none was.

    Returns
    -------
    dict
        Of values that JSON holds.
    """
    return {
        "best": _form(found.best),
        "forms": [
            {
                "name": one.name,
                "log_evidence_gain": one.nats,
                "share": one.share,
                "curve": None if one.curve is None else _curve(one.curve),
            }
            for one in found.forms
        ],
        "dependence": [_dependence(one) for one in found.dependence],
        "map": _map(found.map),
        "beside": sorted(found.beside),
        "effect_file": file or None,
    }


def _form(form: Form) -> dict[str, Any]:
    return {
        "name": form.name,
        "log_evidence_gain": form.nats,
        "share": form.share,
        "parameters": {
            one.name: {"value": one.value, "sigma": one.sigma, "unit": one.unit}
            for one in form.parameters
            if form.curve is None or one.name in ("x", "y")
        },
        "or_at_m": [list(place) for place in form.also],
        "curve": None if form.curve is None else _curve(form.curve),
    }


def _curve(curve: Curve) -> dict[str, Any]:
    return {
        "frequency_hz": curve.frequency.tolist(),
        "first": curve.value[0].tolist(),
        "second": curve.value[1].tolist(),
        "sigma_first": curve.sigma[0].tolist(),
        "sigma_second": curve.sigma[1].tolist(),
    }


def _dependence(one: Dependence) -> dict[str, Any]:
    return {
        "on": one.on,
        "label": list(one.label),
        "factor": one.factor.tolist(),
        "sigma": one.sigma.tolist(),
        "constant": one.constant,
    }


def _map(found: PlaceMap) -> dict[str, Any]:
    maps = {
        kind: {
            "unit": unit,
            "value": found.value[k].tolist(),
            "sigma": found.sigma[k].tolist(),
            "resolution_m": float(found.resolution[k]),
            "log_evidence_gain": float(found.nats[k]),
        }
        for k, (kind, unit) in enumerate(zip(KINDS, UNITS, strict=True))
    }
    return {"places_m": found.places.tolist(), **maps}


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
