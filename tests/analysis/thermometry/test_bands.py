"""Decimation in blocks, the same for all channels."""

import numpy as np
import pytest

from analysis.thermometry import Decimator


def test_blocks_do_not_matter():
    signal = np.random.default_rng(0).standard_normal((2, 5_003))
    whole = Decimator(2, 44_100.0, 900.0)
    parts = Decimator(2, 44_100.0, 900.0)
    found = np.hstack([parts.take(signal[:, a : a + 700]) for a in range(0, 5_003, 700)])
    np.testing.assert_allclose(found, whole.take(signal), atol=1e-12)
    assert found.shape[1] == -(-5_003 // 19)
    assert whole.rate == pytest.approx(44_100 / 19)


@pytest.mark.parametrize("pitch", [20.0, 300.0, 900.0])
def test_a_tone_of_the_band_passes_whole(pitch):
    down = Decimator(1, 44_100.0, 900.0)
    tone = np.sin(2 * np.pi * pitch / 44_100.0 * np.arange(88_200))
    kept = down.take(tone[None])[0, 1_000:]
    assert np.sqrt(2.0 * np.mean(kept**2)) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("pitch", [1_500.0, 2_000.0, 3_221.0, 9_000.0])
def test_what_would_be_folded_into_the_band_is_gone(pitch):
    down = Decimator(1, 44_100.0, 900.0)
    kept = down.take(np.sin(2 * np.pi * pitch / 44_100.0 * np.arange(88_200))[None])[0, 1_000:]
    assert np.abs(kept).max() < 2e-4


def test_a_rate_that_is_low_already_is_left_alone():
    down = Decimator(1, 2_000.0, 900.0)
    signal = np.arange(20.0)[None]
    np.testing.assert_array_equal(down.take(signal), signal)
