"""The description of an unknown cause as part of ``gap.json``."""

from typing import Any

from analysis.gap.description.described import Curve, Dependence, Description, Form
from analysis.gap.description.place_map import KINDS, UNITS, PlaceMap


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
