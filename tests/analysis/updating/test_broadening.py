"""Data broadened are those of a plate damped more."""

import numpy as np
import pytest

from analysis.updating.normal_equations import SweepData
from analysis.updating.start import broadened


@pytest.mark.parametrize("more", [0.004, 0.012])
def test_a_resonance_is_widened_by_what_is_asked(more: float) -> None:
    lines = np.arange(200.0, 1000.0, 0.1)

    def resonance(frequency, loss):
        return 1.0 / ((1.0 + 1j * loss) * 600.0**2 - frequency**2)[None]

    data = broadened(SweepData(lines, resonance(lines, 0.003), np.ones((1, lines.size))), more)
    near = np.abs(data.frequency - 600.0) < 30.0
    expected = resonance(data.frequency, 0.003 + more)
    assert np.abs(data.h - expected)[:, near].max() < 0.03 * np.abs(expected).max()


def test_noise_averages_out() -> None:
    rng = np.random.default_rng(1)
    lines = np.arange(200.0, 1000.0, 0.1)
    noise = (rng.standard_normal((1, lines.size)) + 1j * rng.standard_normal((1, lines.size))) / np.sqrt(2.0)
    data = broadened(SweepData(lines, noise, np.ones((1, lines.size))), 0.02)
    assert data.frequency.size < lines.size
    assert np.mean(np.abs(data.h) ** 2 * data.weight) == pytest.approx(1.0, abs=0.25)
