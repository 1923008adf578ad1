"""Volts in, pascals out: tones against the response, whatever the blocks are, and a panel that warms."""

import numpy as np
import pytest

from analysis.focusing.panel import Filters
from analysis.rendering.renderer import (
    RESPONSE_SAMPLES,
    SAMPLES_AT_ONCE,
    SAMPLES_BEFORE_ZERO,
    HeardRenderer,
    impulse_responses,
)

SETTINGS = Filters(band=(100.0, 800.0), edges=(60.0, 900.0))
RATE = SETTINGS.sample_rate


def panel(temperature, lines):
    """Two listeners, two actuators: resonances that move with temperature, and ways of 1 and 2 ms."""
    omega, place = (
        2.0 * np.pi * lines,
        2.0 * np.pi * np.array([180.0, 420.0]) * (1.0 - 0.004 * (temperature - 20.0)),
    )
    modes = place**2 / (place**2 * (1.0 + 0.08j) - omega[:, None] ** 2)
    delay = np.exp(-1j * omega * np.array([[1e-3], [2e-3]]))
    return delay[:, :, None] * modes


def played(signal, block, temperature=lambda _time: 20.0):
    work = HeardRenderer(panel, SETTINGS, temperature(0.0))
    parts = []
    for start in range(0, signal.shape[1], block):
        parts += work.take(signal[:, start : start + block], temperature(start / RATE))
    return np.concatenate([*parts, *work.rest()], axis=1)


def test_a_tone_is_heard_with_the_size_and_phase_of_the_response():
    time = np.arange(40_000) / RATE
    for frequency in (125.0, 430.0, 790.0):
        tone = np.array([np.cos(2.0 * np.pi * frequency * time), np.sin(2.0 * np.pi * frequency * time)])
        heard = played(tone, 512)
        assert heard.shape == (2, 40_000 + RESPONSE_SAMPLES - SAMPLES_BEFORE_ZERO)
        exact = panel(20.0, np.array([frequency]))[:, 0] @ np.array([1.0, -1.0j])
        middle = slice(20_000, 38_000)
        expected = (exact[:, None] * np.exp(2j * np.pi * frequency * time[middle])).real
        np.testing.assert_allclose(heard[:, middle], expected, atol=1e-2 * np.abs(exact).max())  # 0.1 dB


@pytest.mark.parametrize("block", [77, 512, SAMPLES_AT_ONCE, 10_001])
def test_blocks_do_not_matter_and_nothing_is_lost(block, rng):
    signal = rng.normal(size=(2, 9_000))
    impulses = impulse_responses(panel, SETTINGS, 20.0)
    exact = np.array([sum(np.convolve(signal[n], impulses[ear, n]) for n in range(2)) for ear in range(2)])
    heard = played(signal, block)
    assert heard.shape[1] == 9_000 + RESPONSE_SAMPLES - SAMPLES_BEFORE_ZERO
    np.testing.assert_allclose(heard[:, :-1], exact[:, SAMPLES_BEFORE_ZERO:], atol=1e-10)


def test_before_its_time_and_outside_its_band_a_response_is_silent():
    impulses = impulse_responses(panel, SETTINGS, 20.0)
    assert np.abs(impulses[..., : SAMPLES_BEFORE_ZERO // 2]).max() < 1e-2 * np.abs(impulses).max()
    assert np.abs(impulses[..., -RESPONSE_SAMPLES // 8 :]).max() < 3e-3 * np.abs(impulses).max()
    spectrum = np.abs(np.fft.rfft(impulses))
    every = np.fft.rfftfreq(RESPONSE_SAMPLES, 1.0 / RATE)
    assert spectrum[..., (every < 45.0) | (every > 1_180.0)].max() < 1e-9


def test_a_panel_that_warms_is_heard_as_it_is_then_without_a_click():
    count = 140_000
    time = np.arange(count) / RATE
    tone = np.array([np.cos(2.0 * np.pi * 180.0 * time), np.zeros(count)])
    heard = played(tone, 512, lambda now: 20.0 if now < 1.0 else 30.0)[0, :count]
    for middle, temperature in ((slice(30_000, 38_000), 20.0), (slice(120_000, 135_000), 30.0)):
        exact = panel(temperature, np.array([180.0]))[0, 0, 0]
        expected = (exact * np.exp(2j * np.pi * 180.0 * time[middle])).real
        np.testing.assert_allclose(heard[middle], expected, atol=1e-2 * abs(exact))
    high = np.abs(np.fft.rfft(heard[30_000:90_000] * np.hanning(60_000)))
    every = np.fft.rfftfreq(60_000, 1.0 / RATE)
    assert high[every > 2_000.0].max() < 1e-4 * high.max()
