"""A panel in closed form, and music nobody has to listen to."""

from dataclasses import dataclass

import numpy as np
import pytest

RATE, BAND = 1_000.0, (40.0, 380.0)


@dataclass(frozen=True)
class ModalPanel:
    """Six modes whose pitch falls by 0.8 % a kelvin: three patches drive, one listens."""

    softness: float = 1.0
    loss_factor: float = 0.06
    loss_slope: float = 0.0005

    def transfer(self, temperature, frequency):
        pitch = np.array([70.0, 115.0, 160.0, 205.0, 270.0, 330.0]) * np.sqrt(self.softness)
        squares = (2 * np.pi * pitch * np.exp(-0.008 * (temperature - 20.0))) ** 2
        loss = self.loss_factor + self.loss_slope * temperature
        modal = 1.0 / (squares[:, None] * (1.0 + 1j * loss) - (2 * np.pi * frequency) ** 2)
        shapes = np.cos(np.outer([1.0, 2.3, 3.1], np.arange(1, 7)) + 0.4)
        return 1e5 * (shapes * np.cos(np.arange(1, 7) * 0.7)) @ modal


@pytest.fixture(scope="session")
def panel():
    return ModalPanel


def notes(seconds, seed):
    """Strike notes of random pitch and length that die away, over faint hiss: (n,)."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(seconds * RATE)) / RATE
    sound = 0.01 * rng.standard_normal(len(time))
    for begin in np.arange(0.0, seconds, 0.125):
        pitch = 50.0 * 2.0 ** (rng.integers(0, 36) / 12.0)
        since = np.maximum(time - begin, 0.0)
        struck = (time >= begin) * np.exp(-since / rng.uniform(0.1, 0.6))
        for harmonic in (1, 2, 3):
            if harmonic * pitch < 0.45 * RATE:
                sound += struck * rng.uniform(0.2, 1.0) / harmonic * np.sin(2 * np.pi * harmonic * pitch * since)
    return sound


@pytest.fixture(scope="session")
def drives():
    """Make three drives (3, n): one music through three filters."""

    def make(seconds, seed=0):
        sound = notes(seconds, seed)
        rng = np.random.default_rng(7)
        filters = rng.standard_normal((3, 24)) * np.exp(-np.arange(24) / 8.0)
        return np.array([np.convolve(sound, taps)[: len(sound)] for taps in filters])

    return make
