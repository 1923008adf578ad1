"""Curves without a formula: nothing at zero, exact derivatives, straight lines over log f between their knots."""

import numpy as np
import pytest

from app.files.declarations.experiment import read_acquired_experiment
from simulation.effects.effect import Effect
from simulation.effects.free_curves import FORMS, GAIN, LOAD, MODULUS, free_effects, hats, knots
from simulation.effects.library import LIBRARY, verify


@pytest.fixture(scope="module")
def experiment():
    from pathlib import Path

    acquired = read_acquired_experiment(Path(__file__).parents[3] / "examples" / "hidden-effect.toml")
    return acquired.recorded(acquired.sample_rate)


@pytest.mark.parametrize("name", [LOAD, MODULUS, GAIN, *FORMS])
def test_every_one_passes_the_checks_of_effects(name, experiment):
    effect = free_effects(experiment)[name]
    assert isinstance(effect, Effect)
    assert effect.card(experiment).name == name
    verify(effect, experiment)


def test_none_of_them_is_a_candidate():
    assert not {LOAD, MODULUS, GAIN, *FORMS} & set(LIBRARY)


def test_hats_add_to_one_and_are_straight_over_the_logarithm():
    band = (100.0, 1600.0)
    at = knots(band, 5)
    np.testing.assert_allclose(at, [100.0, 200.0, 400.0, 800.0, 1600.0])
    np.testing.assert_allclose(hats(at, band, 5), np.eye(5), atol=1e-12)
    between = hats(np.array([np.sqrt(2.0) * 200.0, 90.0, 2000.0]), band, 5)
    np.testing.assert_allclose(between.sum(axis=0), 1.0)
    np.testing.assert_allclose(between[:, 0], [0.0, 0.5, 0.5, 0.0, 0.0])
    np.testing.assert_allclose(between[:, 1:], np.eye(5)[:, [0, -1]])
