"""Updating returns the material and the gain that were put in, with honest standard deviations."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.recordings.frf import Frf
from analysis.updated import Updated
from analysis.updating.normal_equations import SweepData, normal_equations
from analysis.updating.update import update

GAIN = 14.3
TEMPERATURE = np.linspace(0.0, 60.0, 11)
E_TRUE = 1.0e9 + 2.25e9 / (1 + np.exp((TEMPERATURE - 22.0) / 12.0))
NU_TRUE = 0.34 + 0.13 * TEMPERATURE / 60.0
ETA_TRUE = 0.035 + 0.05 * np.exp(-(((TEMPERATURE - 15.0) / 15.0) ** 2))


def measured(twin, rng: np.random.Generator, noise: float = 0.01) -> Frf:
    return twin.measured(TEMPERATURE, zip(E_TRUE, NU_TRUE, ETA_TRUE, strict=True), GAIN, rng, noise)


def errors_in_sigma(result: Updated) -> NDArray[np.float64]:
    return np.array(
        [
            (result.material.youngs_modulus - E_TRUE) / result.sigma.youngs_modulus,
            (result.material.poisson_ratio - NU_TRUE) / result.sigma.poisson_ratio,
            (result.material.loss_factor - ETA_TRUE) / result.sigma.loss_factor,
        ]
    )


def test_returns_the_material_put_in(twin) -> None:
    result = update(measured(twin, np.random.default_rng(1)), twin)
    assert result.settled.all()
    np.testing.assert_allclose(result.material.youngs_modulus, E_TRUE, rtol=2e-3)
    np.testing.assert_allclose(result.material.poisson_ratio, NU_TRUE, atol=3e-3)
    np.testing.assert_allclose(result.material.loss_factor, ETA_TRUE, rtol=2e-2)
    assert result.gain == pytest.approx(GAIN, abs=4 * result.sigma_gain)
    np.testing.assert_allclose(result.misfit, result.noise_floor, rtol=0.1)
    np.testing.assert_allclose(result.chi2_per_dof, 1.0, atol=0.12)


def test_standard_deviations_are_those_of_repeated_measurements(twin) -> None:
    scores = np.array(
        [errors_in_sigma(update(measured(twin, np.random.default_rng(seed)), twin)) for seed in range(12)]
    )
    spread = np.sqrt((scores**2).mean((0, 2)))
    np.testing.assert_allclose(spread, 1.0, atol=0.25)


def test_no_temperature_lands_in_a_neighbouring_minimum_when_temperatures_are_far_apart(twin) -> None:
    frf = measured(twin, np.random.default_rng(3))
    ends = [0, 10]  # E falls to a third in one stride: the neighbour's material is a hopeless start
    two = replace(
        frf, temperature=TEMPERATURE[ends], direction=("up",) * 2, level=np.ones(2), h=frf.h[ends],
        variance=frf.variance[ends], coherence=frf.coherence[ends],
    )  # fmt: skip
    result = update(two, twin)
    np.testing.assert_allclose(result.material.youngs_modulus, E_TRUE[ends], rtol=2e-3)


def test_excluded_lines_take_no_part(twin) -> None:
    frf = measured(twin, np.random.default_rng(4))
    lines = np.arange(0, len(frf.frequency), 50)
    hum = frf.h.copy()
    hum[:, :, lines] += 20.0 * np.abs(frf.h).max()
    excluded = frf.excluded.copy()
    excluded[lines] = True
    result = update(replace(frf, h=hum, excluded=excluded), twin)
    np.testing.assert_allclose(result.misfit, result.noise_floor, rtol=0.1)


def test_a_material_outside_the_box_is_said_not_to_have_settled(twin) -> None:
    frf = measured(twin, np.random.default_rng(5))
    hot = replace(frf, frequency=frf.frequency * 0.55)  # as if E were 0.3 times what it is
    result = update(hot, twin)
    assert not result.settled[-1]


def test_refuses_frfs_without_variance(twin) -> None:
    frf = measured(twin, np.random.default_rng(6))
    with pytest.raises(ValueError, match="without variance"):
        update(replace(frf, variance=np.zeros_like(frf.variance)), twin)


def test_gradient_and_curvature_are_those_of_chi2(twin) -> None:
    data = SweepData.of(measured(twin, np.random.default_rng(8)), 4)
    material, gain = np.array([E_TRUE[4] * 1.001, NU_TRUE[4], ETA_TRUE[4]]), 14.0
    point = normal_equations(twin, data, material, gain)
    step = 1e-6
    for k, moved in enumerate(np.eye(4) * step):
        ahead, behind = (
            normal_equations(
                twin,
                data,
                material * np.exp(sign * moved[:3] * [1, 0, 1]) + sign * moved[:3] * [0, 1, 0],
                gain * np.exp(sign * moved[3]),
            ).chi2
            for sign in (1, -1)
        )
        assert (ahead - behind) / (2 * step) == pytest.approx(-2 * point.gradient[k], rel=1e-4)


def test_the_estimates_are_the_optimum_over_all_lines(twin) -> None:
    """Normal equations of all sweeps over every line, with one gain: their solution is next to no step."""
    frf = measured(twin, np.random.default_rng(9), noise=0.002)
    result = update(frf, twin)
    m, count = result.material, len(TEMPERATURE)
    dense, right = np.zeros((3 * count + 1,) * 2), np.zeros(3 * count + 1)
    for t in range(count):
        material = np.array([m.youngs_modulus[t], m.poisson_ratio[t], m.loss_factor[t]])
        point = normal_equations(twin, SweepData.of(frf, t), material, result.gain)
        place = [3 * t, 3 * t + 1, 3 * t + 2, 3 * count]
        dense[np.ix_(place, place)] += point.matrix
        right[place] += point.gradient
    covariance = np.linalg.inv(dense)
    sigma = np.sqrt(np.diag(covariance))
    assert np.abs(covariance @ right / sigma).max() < 0.1
    stated = [result.sigma.youngs_modulus / m.youngs_modulus, result.sigma.poisson_ratio]
    stated += [result.sigma.loss_factor / m.loss_factor]
    inflated = sigma[:-1].reshape(-1, 3).T * np.sqrt(np.maximum(result.chi2_per_dof, 1.0))
    np.testing.assert_allclose(np.array(stated), inflated, rtol=1e-3)
    assert result.sigma_gain / result.gain == pytest.approx(sigma[-1], rel=0.05)


def test_two_inputs_share_a_material_and_have_gains_of_their_own(twin) -> None:
    rng = np.random.default_rng(5)
    few = slice(None, None, 2)
    rows = list(zip(E_TRUE[few], NU_TRUE[few], ETA_TRUE[few], strict=True))
    first, second = (
        twin.measured(TEMPERATURE[few], rows, gain, rng, source=source)
        for source, gain in enumerate((GAIN, 0.5 * GAIN))
    )
    count = len(rows)
    both = replace(
        first,
        temperature=np.tile(TEMPERATURE[few], 2), direction=("up",) * 2 * count, level=np.ones(2 * count),
        **{name: np.concatenate([getattr(first, name), getattr(second, name)])
           for name in ("h", "variance", "coherence")},
        source=np.repeat([0, 1], count), sources=("A1", "A2"),
    )  # fmt: skip
    result = update(both, twin)
    assert result.settled.all()
    np.testing.assert_allclose(result.material.youngs_modulus, np.tile(E_TRUE[few], 2), rtol=2e-3)
    np.testing.assert_allclose(result.gains, [GAIN, 0.5 * GAIN], atol=4 * result.sigma_gains.max())
    np.testing.assert_allclose(result.chi2_per_dof, 1.0, atol=0.12)
    alone = update(both.of_source(0), twin)
    np.testing.assert_allclose(alone.gain, result.gain, rtol=1e-6)  # a sweep has a material of its own
