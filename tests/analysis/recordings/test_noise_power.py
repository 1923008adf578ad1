"""Noise power along frequency."""

import numpy as np
import pytest

from analysis.recordings.noise_power import SMOOTHING_LINES, noise_parts, noise_power


@pytest.mark.parametrize("lines", [8, 30, 41, 500])
def test_a_constant_power_is_its_own_average(lines: int) -> None:
    nothing = np.zeros(lines, dtype=bool)
    flat = noise_power(np.full(lines, 3.0), np.ones(lines, dtype=complex), nothing)
    np.testing.assert_allclose(flat, 3.0, rtol=1e-12)


def test_a_power_that_falls_by_thirty_decades_keeps_its_digits() -> None:
    """As of a drive with a low-pass filter; sums of `SMOOTHING_LINES` terms, one by one, are the comparison."""
    rng = np.random.default_rng(0)
    power = 10.0 ** np.linspace(15.0, -15.0, 600) * rng.exponential(1.0, 600)
    nothing = np.zeros(600, dtype=bool)
    found = noise_power(power, np.ones(600, dtype=complex), nothing)
    half = SMOOTHING_LINES // 2
    padded = np.pad(power, half, mode="edge")
    exact = np.array([padded[line : line + SMOOTHING_LINES].mean() for line in range(600)])
    np.testing.assert_allclose(found, exact, rtol=1e-12)


@pytest.mark.parametrize("beta", [0.0, 0.3, 30.0])
def test_noise_of_the_drive_is_told_from_that_of_the_response(beta: float) -> None:
    """A resonance ten lines wide: beta |H|^2 of the power is the drive's, the rest the response's own."""
    rng, lines = np.random.default_rng(2), np.arange(2000)
    h = 1.0 / (1.0 + 1j * (lines - 1000.0) / 5.0)
    wanted = 1.0 + beta * np.abs(h) ** 2
    smooth, shape = noise_parts(2.0 * wanted * rng.exponential(1.0, 2000), h, np.zeros(2000, dtype=bool))
    np.testing.assert_allclose(shape[:500], 1.0, atol=0.01)
    assert np.median(smooth) == pytest.approx(2.0, rel=0.1)
    at_peak = slice(995, 1006)
    if beta > 1.0:  # ratios of 1.8 are tried
        np.testing.assert_allclose(np.log(shape[at_peak] / wanted[at_peak]), 0.0, atol=np.log(1.8))
    np.testing.assert_allclose(np.mean((smooth * shape / wanted)[at_peak]), 2.0, rtol=0.4)
