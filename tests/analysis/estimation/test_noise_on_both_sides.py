"""H1, H2 and Hv of a structure with seven modes, with noise on its force and on its response, and its modes."""

from typing import get_args

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.estimation.estimators import Estimator, FrfEstimate, estimate
from analysis.estimation.spectra import SampledSignals, welch
from analysis.identification.automatic import identify
from analysis.identification.measured import Measured
from analysis.identification.settings import Settings

RATE, SECONDS, BEFORE = 2048.0, 60.0, 8.0
F = np.array([95.0, 178.0, 291.0, 377.0, 492.0, 583.0, 668.0])
ZETA = np.array([0.011, 0.006, 0.008, 0.01, 0.005, 0.009, 0.007])
POLES = 2.0 * np.pi * F * (-ZETA + 1j * np.sqrt(1.0 - ZETA**2))
WEIGHT = np.array([0.6, 1.9, 0.8, 2.4, 0.5, 1.2, 2.1])


def receptance(frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
    """At the driving point: an antiresonance between any two modes."""
    s = 2j * np.pi * frequency[:, None]
    residue = WEIGHT / (2j * POLES.imag)
    return np.asarray((residue / (s - POLES) + residue.conj() / (s - POLES.conj())).sum(1))


def found(seed: int, estimator: Estimator, at_force: float, at_response: float) -> FrfEstimate:
    rng = np.random.default_rng(seed)
    count = round((SECONDS + BEFORE) * RATE)
    force = rng.standard_normal(count)
    grid = np.fft.rfftfreq(2 * count, 1.0 / RATE)
    motion = np.fft.irfft(np.fft.rfft(force, 2 * count) * receptance(grid), 2 * count)[:count]
    recorded = np.stack([force, motion])[:, round(BEFORE * RATE) :]
    noise = np.array([[at_force], [at_response]]) * recorded.std(axis=1, keepdims=True)
    u, y = recorded + noise * rng.standard_normal(recorded.shape)
    return estimate(welch(SampledSignals(RATE, u[None], y[None]), 2.0), estimator)


@pytest.mark.parametrize("estimator", get_args(Estimator))
@pytest.mark.parametrize(("at_force", "at_response"), [(0.1, 0.1), (0.003, 0.2), (0.1, 0.003)])
def test_no_estimator_invents_or_loses_modes(estimator: Estimator, at_force: float, at_response: float) -> None:
    """H2 gave two to seven poles too many per FRF, and it and Hv lost modes whose peaks are low."""
    for seed in range(2):
        frf = found(seed, estimator, at_force, at_response)
        band = (frf.frequency > 40.0) & (frf.frequency < 800.0)
        assert frf.variance is not None
        lines = Measured(frf.frequency[band], frf.h[:, 0, band], frf.variance[:, 0, band])
        modes = identify(lines, Settings(mains=None))
        np.testing.assert_allclose(modes.reading("viscous").frequency_hz[modes.real], F, rtol=3e-3)


@pytest.mark.parametrize("estimator", get_args(Estimator))
def test_noise_of_the_response_biases_no_estimator(estimator: Estimator) -> None:
    """Mean deviation at lines of equal coherence; that of H2 was 1 / coherence - 1."""
    frfs = [found(seed, estimator, 0.0, 0.2) for seed in range(4)]
    band = (frfs[0].frequency > 40.0) & (frfs[0].frequency < 800.0)
    true = receptance(frfs[0].frequency)
    ratio = np.mean([frf.h[0, 0] / true for frf in frfs], axis=0).real
    coherence = np.mean([frf.coherence[0] for frf in frfs], axis=0)
    for low, high in ((0.2, 0.4), (0.4, 0.7), (0.7, 0.95)):
        lines = band & (coherence > low) & (coherence < high)
        assert lines.sum() > 40
        assert ratio[lines].mean() == pytest.approx(1.0, abs=0.12 * (1.0 / low - 1.0))
