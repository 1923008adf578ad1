import numpy as np

from analysis.radiation.measures import driven_variance, power_error, pressure_sigma
from analysis.radiation.radiator import Radiator


def test_stated_errors_are_those_of_many_noisy_scans(rng):
    """Pressure and power of 4000 scans of one field, each with its own noise, against what is stated of them."""
    x, y = np.meshgrid(np.linspace(0.01, 0.23, 12), np.linspace(0.01, 0.17, 9), indexing="ij")
    points = np.stack([x, y], axis=-1).reshape(-1, 2)
    plate = Radiator(points, np.full(len(points), 4e-4))
    frequency = np.array([150.0, 400.0])
    truth = np.stack([np.sin(12.0 * points[:, 0]), np.exp(9j * points[:, 1])])
    variance = np.stack([0.02 + points[:, 0], 0.1 + 0 * points[:, 0]])
    kernel, sources = plate.pressure(np.array([[0.1, 0.1, 1.0]]), frequency), plate.sources(400.0)
    count = 4000
    noise = rng.normal(size=(count, *truth.shape)) + 1j * rng.normal(size=(count, *truth.shape))
    scans = truth + noise * np.sqrt(0.5 * variance)

    heard = np.einsum("lfk,sfk->slf", kernel, scans)
    exact = np.einsum("lfk,fk->lf", kernel, truth)
    spread = np.sqrt(np.mean(np.abs(heard - exact) ** 2, axis=0))
    np.testing.assert_allclose(pressure_sigma(kernel, variance), spread, rtol=0.05)

    power = sources.power(scans.transpose(1, 2, 0)[:, :, :1], frequency)  # the form's own power, of one scan
    assert power.shape == (2, 1, 1)
    watts = []
    for line, here in enumerate(frequency):
        lumped = sources.lumped @ scans[:, line].T
        watts.append(np.einsum("ms,mn,ns->s", lumped.conj(), sources.resistance(here), lumped).real)
    clean = np.array([sources.power(truth[:, :, None], frequency)[line, 0, 0].real for line in range(2)])
    bias, sigma = power_error(sources, truth, variance, frequency)
    np.testing.assert_allclose(np.mean(watts, axis=1) - clean, bias, atol=4.0 * np.max(sigma) / np.sqrt(count))
    np.testing.assert_allclose(np.std(watts, axis=1), sigma, rtol=0.06)


def test_variance_of_a_driven_field_is_the_sum_over_its_actuators():
    variance = np.arange(1.0, 13.0).reshape(2, 3, 2)
    filters = np.array([[1.0, 2.0j], [3.0, 0.0], [0.0, 1.0]])
    expected = np.array([[1 + 4 * 7, 2 + 4 * 8], [9 * 3, 9 * 4], [11, 12]])
    np.testing.assert_allclose(driven_variance(variance, filters), expected)
