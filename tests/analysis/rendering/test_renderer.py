"""Blocks and fades against plain convolution of the whole signal."""

import numpy as np
import pytest
from scipy.signal import butter, lfilter, sosfiltfilt

from analysis.rendering.following import FADE_TIME, TEMPERATURE_STEP, FollowingBank, raised_cosine
from analysis.rendering.renderer import Past, Renderer, partitions

KNOTS = np.arange(0.0, 61.0, 5.0)


def whole(taps, signal):
    return np.array([lfilter(row, 1.0, signal) for row in taps])


def rendered(renderer, signal):
    return np.hstack([renderer.process(part) for part in signal.reshape(-1, renderer.block)])


@pytest.mark.parametrize(("block", "taps"), [(64, 48), (48, 48), (16, 50), (7, 48), (1, 5)])
def test_partitions_convolve_like_the_whole(block, taps):
    rng = np.random.default_rng(0)
    filters, signal = rng.standard_normal((2, taps)), rng.standard_normal(12 * block)
    past = Past(block, -(-taps // block))
    spectra = partitions(filters, block)
    found = []
    for part in signal.reshape(-1, block):
        past.take(part)
        found.append(past.through(spectra))
    np.testing.assert_allclose(np.hstack(found), whole(filters, signal), atol=1e-12)


def test_a_steady_temperature_is_one_convolution(filters):
    following = FollowingBank.of_filters(filters(KNOTS))
    signal = np.random.default_rng(1).standard_normal(20 * 64)
    found = rendered(Renderer(following, 21.3, 64), signal)
    np.testing.assert_allclose(found, whole(following.taps(21.3)[0], signal), atol=1e-12)


def test_a_fade_mixes_what_both_filters_make_of_all_the_past(filters):
    following = FollowingBank.of_filters(filters(KNOTS))
    signal = np.random.default_rng(2).standard_normal(20 * 64)
    renderer = Renderer(following, 20.0, 64)
    first = rendered(renderer, signal[: 5 * 64])
    assert renderer.follow(31.0)
    second = rendered(renderer, signal[5 * 64 :])
    old, new = (whole(following.taps(t)[0], signal) for t in (20.0, 31.0))
    share = np.zeros(len(signal))
    share[5 * 64 :] = raised_cosine(0, 15 * 64, round(FADE_TIME * 8_000.0))
    np.testing.assert_allclose(np.hstack([first, second]), old + share * (new - old), atol=1e-12)


def test_small_moves_readings_in_a_fade_and_nan_change_nothing(filters):
    renderer = Renderer(FollowingBank.of_filters(filters(KNOTS)), 20.0, 64)
    assert not renderer.follow(20.0 + 0.99 * TEMPERATURE_STEP)
    assert not renderer.follow(float("nan"))
    assert renderer.follow(20.0 + TEMPERATURE_STEP)
    assert not renderer.follow(40.0)  # the fade has begun
    rendered(renderer, np.zeros(64 * 3))
    assert renderer.follow(40.0)
    assert renderer.changes == 2


def test_beyond_the_range_the_end_holds(filters):
    renderer = Renderer(FollowingBank.of_filters(filters(KNOTS)), -30.0, 64)
    assert renderer.temperature == 0.0
    assert renderer.follow(1e9)
    assert renderer.temperature == 60.0


def test_a_step_of_five_degrees_at_150_hz_makes_no_click(filters):
    """A switched set of filters does, by 40 dB and more: the measure can tell."""
    rate = 44_100.0
    following = FollowingBank.of_filters(type(filters(KNOTS))(_section2_like(KNOTS, rate), KNOTS, rate, 256))
    signal = np.sin(2 * np.pi * 150.0 / rate * np.arange(100 * 512))
    renderer = Renderer(following, 30.0)
    faded = rendered(renderer, signal[: 50 * 512])
    assert renderer.follow(35.0)
    faded = np.hstack([faded, rendered(renderer, signal[50 * 512 :])])
    old, new = (whole(following.taps(t)[0], signal) for t in (30.0, 35.0))
    switched = np.where(np.arange(len(signal)) < 50 * 512, old, new)
    assert _residue(faded, rate) <= -80.0
    assert _residue(switched, rate) > -60.0


def _section2_like(temperature, rate):
    t = np.arange(512) / rate
    pitch = 220.0 * np.exp(-0.009 * temperature)[:, None, None]
    n = np.arange(2)[:, None]
    hann = np.sin(np.pi * np.arange(512) / 512) ** 2
    return np.sin(2 * np.pi * (1 + 0.4 * n) * pitch * t + n) * hann


def _residue(signal, rate):
    """Largest sample above 2 kHz, dB of the largest sample; the onset of the tone left out."""
    high = sosfiltfilt(butter(8, 2_000.0, "high", fs=rate, output="sos"), signal)[:, 8_000:-8_000]
    return 20.0 * np.log10(np.abs(high).max() / np.abs(signal).max())


def test_blocks_of_another_length_are_refused(filters):
    with pytest.raises(ValueError, match=r"a block of \(63,\) samples"):
        Renderer(FollowingBank.of_filters(filters(KNOTS)), 20.0, 64).process(np.zeros(63))
    with pytest.raises(ValueError, match="block 0 samples"):
        Renderer(FollowingBank.of_filters(filters(KNOTS)), 20.0, 0)
