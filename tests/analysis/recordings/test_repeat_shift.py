"""How far resonances move over the repeats of a sweep."""

import numpy as np
import pytest

from analysis.identification.pole_residue import NONE, synthesis
from analysis.recordings.h1 import repeat_shift

FREQUENCY = np.arange(100.0, 900.0, 0.5)
POLES = 2j * np.pi * np.array([170.0, 240.0, 310.0, 455.0, 560.0, 700.0]) * np.sqrt(1.0 + 0.03j)
RESIDUES = 1j * np.array([[100.0, -120, 150, 130, -160, 200], [80.0, 90, -150, 130, 100, -90]])


@pytest.mark.parametrize("step", [3e-4, -1e-3])
def test_shift_of_all_frequencies_is_found_in_spite_of_noise(step: float) -> None:
    none = np.zeros((2, 0), complex)
    h = np.array([synthesis(FREQUENCY, POLES * (1.0 + n * step), RESIDUES, NONE, none) for n in (-1, 0, 1)])
    draw = np.random.default_rng(0).normal(size=(2, *h.shape))
    h = h + 1e-3 * np.sqrt(np.mean(np.abs(h) ** 2)) * (draw[0] + 1j * draw[1])
    assert repeat_shift(h.swapaxes(0, 1), 200) == pytest.approx(abs(step) * np.sqrt(2.0 / 3.0), rel=0.05)


def test_noise_alone_shifts_little_and_one_repeat_not_at_all() -> None:
    h = synthesis(FREQUENCY, POLES, RESIDUES, NONE, np.zeros((2, 0), complex))[:, None].repeat(3, axis=1)
    draw = np.random.default_rng(0).normal(size=(2, *h.shape))
    noisy = h + 1e-3 * np.sqrt(np.mean(np.abs(h) ** 2)) * (draw[0] + 1j * draw[1])
    assert repeat_shift(noisy, 200) < 1e-5
    assert repeat_shift(h[:, :1], 200) == 0.0
