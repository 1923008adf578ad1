"""What a scatter of resonances makes of the data's weight, against closed forms and drawn scatter."""

import numpy as np
import pytest

from analysis.gap.data.sweeps import LineWeights
from analysis.gap.fitting.normal_equations import whiten_all
from analysis.gap.imperfect.discrepancy import SMALLEST, Discrepancy, DiscrepancyShape


def shape_at(context, fit):
    return DiscrepancyShape.of(context.sweeps, fit.predicted, context.loss_factors(fit.state))


def test_weights_are_undone_exactly():
    rng = np.random.default_rng(0)
    shape = (3, 2, 50)
    residual = rng.standard_normal(shape) + 1j * rng.standard_normal(shape)
    weights = LineWeights(
        np.exp(1j * rng.uniform(0, 6, shape)), rng.uniform(0.1, 1, shape), rng.uniform(0.1, 1, shape)
    )
    weighted = np.array([weights.weigh(one, sweep) for sweep, one in enumerate(residual)])
    assert np.abs(weighted) == pytest.approx(np.abs(residual), rel=0.95)
    assert weights.undone(weighted) == pytest.approx(residual, rel=1e-12)
    assert LineWeights.equal(shape).undone(residual) == pytest.approx(residual)


def test_modes_that_scatter_tell_the_modulus_as_a_mean_of_so_many_frequencies(scattered, toy):
    """Frequencies off by s each: log E = 2 log f is known to 2 s / sqrt(modes), however small the noise."""
    context, fit = scattered(1, 0.003)
    scatter = 0.003
    weights = shape_at(context, fit).weights(Discrepancy(scatter, SMALLEST, SMALLEST))
    white = whiten_all(context.model, context.sweeps, fit.state, (), context.executor)
    tangent = np.array([weights.weigh(one.white[0], sweep) for sweep, one in enumerate(white)])
    modes = toy.Plate(2).modes()[0].size
    assert 1.0 / np.sqrt((np.abs(tangent) ** 2).sum()) == pytest.approx(2.0 * scatter / np.sqrt(modes), rel=0.1)


def test_without_scatter_the_data_keep_their_weight(scattered):
    context, fit = scattered(1, 0.0)
    shape = shape_at(context, fit)
    found = shape.scatter(context.sweeps, fit.residual, fit.determined)
    assert found.frequency < 1e-5
    assert found.amplitude < 1e-5


def test_the_scatter_drawn_is_found(scattered):
    found = []
    for seed in range(1, 7):
        context, fit = scattered(seed, 0.003, 0.03)
        shape = shape_at(context, fit)
        found.append(shape.scatter(context.sweeps, fit.residual, fit.determined))
    assert np.sqrt(np.mean([one.frequency**2 for one in found])) == pytest.approx(0.003, rel=0.3)
    assert max(one.damping for one in found) < 0.0015
