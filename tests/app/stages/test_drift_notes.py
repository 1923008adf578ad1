"""Notes on drift that updating cannot take into account: one temperature only, repeats too far apart."""

import numpy as np

from analysis.experiment import Protocol
from analysis.material import Material
from analysis.updated import Updated
from analysis.updating.laws import fit_laws
from app.stages.comparison.temperature_notes import drift_notes

TEMPERATURE = np.array([15.0, 25.0, 35.0, 45.0])
MATERIAL = Material(2.5e9 * np.exp(-0.019 * (TEMPERATURE - 15.0)), np.full(4, 0.37), np.full(4, 0.07))
SIGMA = Material(np.full(4, 1e5), np.full(4, 1e-4), np.full(4, 1e-5))


def protocol(**changes: object) -> Protocol:
    table = {
        "sweep": "logarithmic",
        "band": [100.0, 600.0],
        "sweep_duration": 10.0,
        "tail": 0.4,
        "taper": 0.1,
        "repeats": 3,
        "ramp_rate": 1.5,
        "temperatures": [25.0],
        "directions": ["up"],
        "levels": [1.0],
    }
    return Protocol.model_validate(table | changes)


def updated() -> Updated:
    ones = np.ones(4)
    return Updated(
        temperature=TEMPERATURE,
        material=MATERIAL,
        sigma=SIGMA,
        correlation=np.tile(np.eye(4), (4, 1, 1)),
        gain=1.0,
        sigma_gain=1e-3,
        misfit=0.01 * ones,
        misfit_start=0.01 * ones,
        noise_floor=0.01 * ones,
        chi2_per_dof=ones,
        settled=ones.astype(bool),
    )


def test_without_laws_the_drift_within_a_sweep_is_left_and_a_note_says_so() -> None:
    (said,) = drift_notes(protocol(), updated(), None)
    assert "spreads over 0.25 K" in said
    assert said.endswith("from three temperatures on, update takes the drift into account")
    assert drift_notes(protocol(ramp_rate=0.0), updated(), None) == ()
    assert drift_notes(protocol(taper=None), updated(), None) == ()  # gap has a note of its own then


def test_with_laws_only_repeats_that_differ_are_named() -> None:
    laws = fit_laws(TEMPERATURE, MATERIAL, SIGMA, temperature_range=(15.0, 45.0))
    assert drift_notes(protocol(), updated(), laws) == ()
    (said,) = drift_notes(protocol(sweep_duration=30.0, ramp_rate=3.0), updated(), laws)
    assert "the 3 repeats of a sweep spread over 3 K" in said
