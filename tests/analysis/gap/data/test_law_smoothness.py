"""How laws run on from the temperatures at which they are known."""

import numpy as np
import pytest

from analysis.gap.data.groups import LawSmoothness


def smooth(t, value):
    """Three equal laws."""
    values = np.stack([value] * 3, axis=1)
    smoothness = LawSmoothness.of(t, values)
    slope, curvature = smoothness.derivatives(values)
    sigma = np.sqrt((smoothness.root[0] ** 2).sum(1))
    return smoothness, slope[:, 0], curvature[:, 0], sigma[: len(t)], sigma[len(t) :]


def softening(t, centre, width):
    """Return a law that falls by a step about a temperature, its slope and its curvature."""
    x = (t - centre) / width
    slope = -0.008 - 0.1 / width / np.cosh(x) ** 2
    return -0.008 * t - 0.1 * np.tanh(x), slope, 0.2 / width**2 * np.tanh(x) / np.cosh(x) ** 2


@pytest.mark.parametrize(("step", "within"), [(2.0, 0.02), (4.0, 0.02)])
def test_slopes_and_curvatures_of_a_transition(step, within):
    t = np.arange(0.0, 61.0, step)
    value, slope, curvature = softening(t, 8.0, 10.0)
    _, found, bent, _, _ = smooth(t, value)
    assert np.sqrt(np.mean((found / slope - 1.0) ** 2)) < within
    assert np.sqrt(np.mean((bent - curvature) ** 2)) < 0.15 * np.abs(curvature).max()


def test_straight_laws_have_their_slope_from_two_temperatures_on():
    for t in (np.array([10.0, 40.0]), np.array([10.0, 20.0, 50.0])):
        values = np.outer(t, [-0.01, 0.001, 0.02])
        slope, curvature = LawSmoothness.of(t, values).derivatives(values)
        assert slope == pytest.approx(np.tile([-0.01, 0.001, 0.02], (len(t), 1)), abs=1e-9)
        assert curvature == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("sweeps", [1, 3])
def test_one_temperature_says_nothing_of_a_slope(sweeps):
    values = np.arange(3.0 * sweeps).reshape(sweeps, 3)
    smoothness = LawSmoothness.of(np.full(sweeps, 20.0), values)
    assert not np.any(smoothness.derivatives(values))
    assert smoothness.unknowns == 0
    assert smoothness.errors(values, values).size == 0
    assert not np.any(smoothness.deviations(np.zeros(0)))


@pytest.mark.parametrize("step", [2.0, 5.0, 10.0, 15.0, 20.0])
@pytest.mark.parametrize("width", [8.0, 15.0, 25.0])
def test_derivatives_are_as_uncertain_as_they_are_wrong(step, width):
    t = np.arange(0.0, 61.0, step)
    pulls = []
    for centre in np.arange(0.0, 61.0, 5.0):
        value, slope, curvature = softening(t, centre, width)
        _, found, bent, sigma, sigma_bent = smooth(t, value)
        pulls.append(np.concatenate([(found - slope) / sigma, (bent - curvature) / sigma_bent]))
    pulls = np.array(pulls)
    assert 0.1 < np.sqrt(np.mean(pulls**2)) < 1.2
    ends = pulls[:, [0, len(t) - 1, len(t), -1]]  # where neighbours are on one side only
    assert np.sqrt(np.mean(ends**2)) < 1.3


def test_slopes_are_the_less_known_the_further_apart_the_temperatures():
    spread = []
    for step in (2.0, 4.0, 20.0):
        t = np.arange(0.0, 61.0, step)
        spread.append(np.median(smooth(t, softening(t, 10.0, 15.0)[0])[3]))
    assert 0.0 < spread[0] < spread[1] < spread[2]


def test_neighbours_share_the_errors_of_their_derivatives():
    t = np.arange(0.0, 61.0, 5.0)
    smoothness = smooth(t, softening(t, 25.0, 15.0)[0])[0]
    root = smoothness.root[0]
    covariance = root @ root.T
    scale = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(scale, scale)
    assert np.abs(np.diag(correlation[: len(t), : len(t)], 1)).min() > 0.2


def test_errors_of_derivatives_are_read_back():
    t = np.arange(0.0, 61.0, 10.0)
    value = softening(t, 25.0, 15.0)[0]
    values = np.stack([value, 0.3 + 0.1 * value, -value], axis=1)
    smoothness = LawSmoothness.of(t, values)
    wanted = np.random.default_rng(1).standard_normal(smoothness.unknowns)
    assert smoothness.errors(*smoothness.deviations(wanted)) == pytest.approx(wanted, abs=1e-6)


def test_what_a_sweep_sees_of_the_laws():
    t = np.arange(0.0, 61.0, 10.0)
    value = softening(t, 25.0, 15.0)[0]
    values = np.stack([value, 0.3 + 0.1 * value, -value], axis=1)
    smoothness = LawSmoothness.of(t, values)
    errors = np.random.default_rng(1).standard_normal(smoothness.unknowns)
    away = 0.7
    for group, (laws, tilt, bend) in enumerate(
        zip(smoothness.laws(values), *smoothness.deviations(errors), strict=True)
    ):
        there = t[group] + away
        near = laws.tilted(tilt, bend, there)
        seen = [np.log(near.youngs_modulus(there)), near.poisson_ratio(there), np.log(near.loss_factor(there))]
        found = smoothness.seen(group, away) @ np.concatenate([values.ravel(), errors])
        assert found[:3] == pytest.approx(np.array(seen, dtype=float))
        assert found[3:6] == pytest.approx(near.rates(there))
        assert found[6:] == pytest.approx(near.curvature)
