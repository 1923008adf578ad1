"""Filters whose pitch follows the temperature."""

import numpy as np
import pytest

from analysis.focusing.fir import FirBank


@pytest.fixture(scope="session")
def filters():
    """Make decaying tones (T, 3, M) at some temperatures, 8 kHz."""

    def make(knots, taps=48):
        t = np.arange(taps) / 8_000.0
        pitch = 300.0 * np.exp(-0.008 * np.asarray(knots, dtype=float))[:, None, None]
        n = np.arange(3)[:, None]
        rung = np.sin(2 * np.pi * (1 + 0.4 * n) * pitch * t + n) * np.exp(-200 * t)
        return FirBank(rung, np.asarray(knots, dtype=float), 8e3, 12)

    return make
