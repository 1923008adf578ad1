"""What the status of a pole says about its peak."""

import numpy as np
import pytest

from analysis.identification.automatic import identify
from analysis.identification.measured import Measured
from analysis.identification.pole_residue import NONE, synthesis

FREQUENCY = np.arange(100.0, 400.0, 0.1)


@pytest.mark.parametrize(("apart", "said"), [(0.0, False), (0.05, True)])
def test_a_peak_that_one_pole_does_not_describe_is_remarked(apart: float, said: bool) -> None:
    """Two modes a twentieth of a half width apart: one that moved looks the same, and noise is low."""
    frequencies = np.array([150.0, 250.0 - 1.25 * apart, 250.0 + 1.25 * apart, 330.0])
    poles = 2j * np.pi * frequencies * np.sqrt(1.0 + 0.02j)
    residues = 1j * np.array([[100.0, 80.0, 80.0, -120.0]])
    clean = synthesis(FREQUENCY, poles, residues, NONE, np.zeros((1, 0), complex))
    deviation = 2e-5 * np.abs(clean).max()
    draw = np.random.default_rng(0).normal(size=(2, *clean.shape))
    h = clean + deviation / np.sqrt(2.0) * (draw[0] + 1j * draw[1])
    modes = identify(Measured(FREQUENCY, h, np.full(h.shape, deviation**2)))
    real = np.flatnonzero(modes.real)
    assert modes.poles[real].imag / (2.0 * np.pi) == pytest.approx([150.0, 250.0, 330.0], abs=0.05)
    assert ["perhaps not one mode" in modes.reason[j] for j in real] == [False, said, False]
