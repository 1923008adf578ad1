"""A twin as exact as its campaign needs: the usual mesh where it is sufficient, a finer one where it is not."""

from pathlib import Path

import numpy as np
import pytest

from analysis.declaration.plate_material import material_box
from analysis.experiment import Experiment
from analysis.material import Material, MaterialSigma
from analysis.updated import Updated
from app.files.campaigns.loading import load_campaign
from app.files.effect_cache import operators_key
from app.twins import campaign_twin
from app.twins.campaign_twin import required_error
from simulation.reduction.plate_basis import PlateBasis
from simulation.reduction.sufficient_fineness import RequiredError
from simulation.shell.fineness import Fineness

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "pp-plate"
FINER = Fineness(tolerance=1e-9)


@pytest.fixture(scope="module")
def experiment() -> Experiment:
    return load_campaign(EXAMPLE).experiment


def silent(stage: str, share: float) -> None:
    """Take no notice of progress."""


@pytest.mark.parametrize(("dropped", "expected"), [(1e-5, None), (3e-5, FINER)])
def test_only_a_twin_that_is_not_exact_enough_is_refined(
    experiment: Experiment, monkeypatch: pytest.MonkeyPatch, dropped: float, expected: Fineness | None
) -> None:
    nothing = np.zeros((0, 0))
    known = PlateBasis(nothing.astype(bool), dropped, nothing, error=1e-4)
    monkeypatch.setattr(campaign_twin, "plate_basis", lambda experiment, report: known)
    monkeypatch.setattr(campaign_twin, "sufficient_fineness", lambda **asked: FINER)
    assert campaign_twin.finer(experiment, RequiredError(1e-3, 0.03), silent) is expected


def test_a_refined_twin_has_its_own_place_in_the_cache(experiment: Experiment) -> None:
    box = material_box(experiment.plate.material)
    usual = operators_key(experiment, box)
    assert usual == operators_key(experiment, box, Fineness()) != operators_key(experiment, box, FINER)


def test_noise_and_least_damping_of_a_campaign_say_what_is_required() -> None:
    none, two = np.zeros(2), np.ones(2)
    found = Updated(
        temperature=np.array([20.0, 30.0]),
        material=Material(70e9 * two, 0.33 * two, np.array([0.003, 0.002])),
        sigma=MaterialSigma(none, none, none),
        correlation=np.zeros((2, 4, 4)),
        gain=1.0,
        sigma_gain=0.0,
        misfit_start=none,
        misfit=none,
        noise_floor=np.array([0.01, 0.02]),
        chi2_per_dof=two,
        settled=np.ones(2, bool),
    )
    required = required_error(found)
    assert (required.allowed, required.loss_factor) == (pytest.approx(0.3 * 0.015), 0.002)
