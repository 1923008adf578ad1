"""Noise power along frequency."""

import numpy as np
import pytest

from analysis.noise_power import SMOOTHING_LINES, noise_power


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
