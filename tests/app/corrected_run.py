"""A run folder after a comparison that named an effect, written without a twin: plain and corrected laws, gap."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from analysis.estimates import DeclaredQuantity, FittedLaws
from analysis.material import Material, MaterialLaws
from analysis.updated import Updated
from analysis.updating.laws import fit_laws
from app.files.provenance import provenance
from app.files.results.gap_file import GapFigures, GapMap, save_gap
from app.files.results.laws_file import TwinFrf, save_laws
from app.files.results.modes_file import save_frf
from tests.app.view.conftest import FREQUENCY, TEMPERATURE, experiment, frf, updated

HASHES = {"protocol.json": "00ff", "a.h5": "0a0a"}
FACTOR = 1.05
"""Corrected over plain E."""
BEFORE = 1.02
"""E of the comparison's own twin without the effect, over that of update."""
PHRASE = "an added mass of {mass} at the cable"
DECLARED = (
    DeclaredQuantity("plate_thickness", "share", "1", "thickness of the plate", 0.005, 0.002, 0.001),
    DeclaredQuantity("plate_mass", "share", "1", "mass of the plate", 0.001, -0.0005, 0.0009),
    DeclaredQuantity("patch_place S1", "dx", "m", "place of patch S1", 3e-4, 1e-4, 1e-5),
)


def effect() -> dict[str, Any]:
    return {
        "name": "point_mass",
        "equivalent": [],
        "probability": 0.95,
        "against": {},
        "log_evidence_gain": 500.0,
        "parameters": {"mass": {"value": 7.997e-4, "sigma": 2.2e-6, "unit": "kg"}},
        "title": "added mass at the cable",
        "summary": "the cable adds its mass where it is fixed",
        "phrase": PHRASE,
        "shown_units": {"mass": "g"},
        "separated_by": "weigh cable and glue",
    }


def region(share: float = 0.6) -> dict[str, Any]:
    span = {"frequency_hz": [900.0, 1100.0], "temperature_c": [30.0, 30.0]}
    return {"channel": "S1", **span, "share": share, "largest_sigma": 31.0}


def record(verdict: str = "explained", **changes: Any) -> dict[str, Any]:
    """Record of a comparison as in gap.json."""
    before, after = (
        {"chi2_per_dof": 283.0, "relative_misfit": 0.066},
        {"chi2_per_dof": 1.01, "relative_misfit": 0.004},
    )
    held = {"what": "every second temperature", "baseline": before, "final": after}
    found: dict[str, Any] = {
        "schema": "flexura-gap/1",
        "verdict": verdict,
        "effects": [] if verdict == "none" else [effect()],
        "pairing": None,
        "not_observable": ["thermal_lag"],
        "gap": {
            "baseline": before,
            "final": after,
            "held_out": {**held, "closure": 0.9999, "closure_sigma": 2e-5},
            "held_out_also": [],
        },
        "unexplained": {"share": {"none": None, "explained": 1e-4}.get(verdict, 0.07), "where": [region()]},
        "seconds": 1.0,
        "where": {"regions": [region()], "shares": {}},
        "titles": {"point_mass": "added mass at the cable", "thermal_lag": "plate that lags behind the oven"},
        "starting_effects": {},
        "observability": [
            {"name": "thermal_lag", "observable": False, "kept": 0.0, "size_sigma": 0.0, "needs": "two ramps"}
        ],
        "candidates": [],
        "declared": [],
        "laws": {},
        "noise": {},
        "notes": [],
        "provenance": provenance(HASHES, {"mains": 50.0, "campaign": "plate"}),
    }
    return {**found, **changes}


def corrected() -> Updated:
    """Estimates under the effect; the misfits at their start are those of the plain twin."""
    plain = updated()
    material = plain.material
    return replace(
        plain,
        material=Material(
            FACTOR * material.youngs_modulus, material.poisson_ratio + 0.01, 1.1 * material.loss_factor
        ),
        misfit_start=plain.misfit,
        misfit=plain.noise_floor,
        declared=DECLARED,
    )


def baseline() -> Updated:
    """Estimates of the comparison's own twin without the effect."""
    plain = updated()
    material = replace(plain.material, youngs_modulus=BEFORE * plain.material.youngs_modulus)
    return replace(plain, material=material)


def laws_of(found: Updated) -> MaterialLaws:
    return fit_laws(TEMPERATURE, found.material, found.sigma, temperature_range=(0.0, 40.0))


def write_run(folder: Path, told: Mapping[str, Any] | None = None) -> Path:
    """Write frf.h5, laws.h5, laws-corrected.h5, gap.h5 and gap.json."""
    folder.mkdir(parents=True, exist_ok=True)
    told = record() if told is None else told
    measured, made = frf(), provenance(HASHES, {"mains": 50.0, "campaign": "plate"})
    save_frf(folder / "frf.h5", experiment(), measured, made)
    twin = TwinFrf(FREQUENCY, 1.01 * measured.h, 1e-4, 950.0)
    for name, found in (("laws.h5", updated()), ("laws-corrected.h5", corrected())):
        save_laws(folder / name, found, laws_of(found), twin, made)
    save_gap(folder / "gap.h5", figures(), (), told, made)
    (folder / "gap.json").write_text(json.dumps(told), encoding="utf-8")
    return folder


def figures() -> GapFigures:
    quiet = GapMap(
        edges=np.linspace(100.0, 900.0, 5),
        temperature=TEMPERATURE,
        level=np.ones(5),
        direction=("up",) * 5,
        channels=("S1", "S2"),
        sigma=np.full((5, 2, 4), 1.0),
        excess=np.zeros((5, 2, 4)),
    )
    loud = replace(quiet, sigma=np.full((5, 2, 4), 9.0), excess=np.full((5, 2, 4), 80.0))
    before, after = (_nodes(one) for one in (baseline(), corrected()))
    return GapFigures(loud, quiet, before, after)


def _nodes(found: Updated) -> FittedLaws:
    m, s = found.material, found.sigma
    value = np.stack([np.log(m.youngs_modulus), m.poisson_ratio, np.log(m.loss_factor)], axis=1)
    relative = (s.youngs_modulus / m.youngs_modulus, s.poisson_ratio, s.loss_factor / m.loss_factor)
    return FittedLaws(TEMPERATURE, value, np.stack(relative, axis=1))
