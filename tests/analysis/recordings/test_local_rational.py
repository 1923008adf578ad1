"""Noise of an FRF without repeats: against noise of known power, at peaks from two lines to hundreds wide."""

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.identification.automatic import identify
from analysis.identification.measured import Measured
from analysis.identification.settings import Settings
from analysis.recordings.noise_power import noise_power, rough_power, single_repeat_power

FREQUENCY = np.arange(100.0, 1500.0, 0.25)
F = np.array([131.0, 188.0, 265.0, 371.0, 494.0, 660.0, 873.0, 1120.0, 1342.0])
SIGNS = np.array([1.0, -0.7, 1.3, 0.9, -1.6, -0.8, 1.1, -1.2, 0.6])


def plate(eta: float) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Poles, and the FRF of nine modes that are about equally high."""
    poles = 2.0 * np.pi * F * (-eta / 2.0 + 1j * np.sqrt(1.0 - eta**2 / 4.0))
    residues = SIGNS * poles.real / 1j
    s = 2j * np.pi * FREQUENCY[:, None]
    return poles, np.asarray((residues / (s - poles) + residues.conj() / (s - poles.conj())).sum(1))


def noise(rng: np.random.Generator, size: float) -> NDArray[np.complex128]:
    real, imaginary = rng.standard_normal((2, len(FREQUENCY)))
    return np.asarray(size * (real + 1j * imaginary) / np.sqrt(2.0))


@pytest.mark.parametrize("eta", [0.001, 0.002, 0.005, 0.03])
@pytest.mark.parametrize("size", [1e-3, 1e-2])
def test_noise_is_seen_beside_narrow_peaks_as_between_them(eta: float, size: float) -> None:
    """Sheet metal and polymers; a quartic left up to thousands of times the noise at peaks of a few lines."""
    h = plate(eta)[1] + noise(np.random.default_rng(0), size)
    everywhere = np.zeros(len(h), dtype=bool)
    found = noise_power(rough_power(h), h, everywhere) / size**2
    near = np.abs(FREQUENCY[:, None] - F).min(1) < 2.0
    assert np.median(found) == pytest.approx(1.0, abs=0.1)
    assert np.median(found[near]) == pytest.approx(1.0, abs=0.35)


@pytest.mark.parametrize("lines", [7, 10, 11, 12])
def test_few_lines_are_enough(lines: int) -> None:
    h = noise(np.random.default_rng(1), 1.0)[:lines]
    power = rough_power(h)
    assert power.shape == (lines,)
    assert (power <= single_repeat_power(h)).all()


def test_noise_alone_is_not_taken_for_resonances() -> None:
    h = 1.0 + noise(np.random.default_rng(2), 0.1)
    assert rough_power(h).mean() == pytest.approx(0.01, rel=0.04)


@pytest.mark.parametrize("eta", [0.001, 0.005, 0.03])
def test_modes_of_one_repeat_are_as_exact_as_its_noise_allows(eta: float) -> None:
    """Against weights from the true noise; their deviations are those of the errors."""
    poles, true = plate(eta)
    errors, ideal, scaled = [], [], []
    for seed in range(4):
        h = true + noise(np.random.default_rng(seed), 3e-3)
        stated = noise_power(rough_power(h), h, np.zeros(len(h), dtype=bool))
        for variance, kept in ((stated, errors), (np.full(len(h), 9e-6), ideal)):
            modes = identify(Measured(FREQUENCY, h[None], variance[None]), Settings(mains=None))
            off = np.log(np.abs(modes.poles[modes.real]) / np.abs(poles))
            kept.append(off)
            if variance is stated:
                scaled.append(off / np.sqrt(modes.covariance[modes.real, 0, 0]))
    assert np.sqrt(np.mean(np.square(errors))) < 1.2 * np.sqrt(np.mean(np.square(ideal)))
    assert 0.7 < np.sqrt(np.mean(np.square(scaled))) < 1.4
