"""The simulated response against one long transform, and its noise."""

import numpy as np
import pytest

from analysis.rendering.following import TemperatureProgramme
from analysis.thermometry import simulated_response

RATE, BAND = 1_000.0, (40.0, 380.0)


def long_transform(panel, drive, temperature):
    count = 2 * drive.shape[1]
    lines = np.fft.rfftfreq(count, 1.0 / RATE)
    inside = (lines >= BAND[0]) & (lines <= BAND[1])
    spectrum = np.zeros(len(lines), dtype=complex)
    spectrum[inside] = np.sum(
        panel.transfer(temperature, lines[inside]) * np.fft.rfft(drive, count)[:, inside], axis=0
    )
    return np.fft.irfft(spectrum, count)[: drive.shape[1]]


def test_a_steady_panel_is_one_convolution(panel, drives):
    drive = drives(7.3)
    steady = TemperatureProgramme(np.zeros(1), np.array([31.0]))
    found = simulated_response(panel(), drive, RATE, BAND, steady, 300.0, np.random.default_rng(0))
    expected = long_transform(panel(), drive, 31.0)
    middle = slice(500, -500)  # a band cut off sharply rings before its time, and so across the ends
    error = np.sum((found - expected)[middle] ** 2) / np.sum(expected[middle] ** 2)
    assert error < 1e-4


def test_noise_lies_as_far_below_as_was_said(panel, drives):
    drive = drives(8.0)
    steady = TemperatureProgramme(np.zeros(1), np.array([20.0]))
    clean, noisy = (
        simulated_response(panel(), drive, RATE, BAND, steady, snr, np.random.default_rng(0))
        for snr in (300.0, 14.0)
    )
    assert 10.0 * np.log10(np.mean(clean**2) / np.mean((noisy - clean) ** 2)) == pytest.approx(14.0, abs=0.2)


def test_a_panel_that_warms_ends_as_a_warm_one(panel, drives):
    drive = drives(10.0)
    warming = TemperatureProgramme(np.array([2.0, 4.0]), np.array([20.0, 30.0]))
    found = simulated_response(panel(), drive, RATE, BAND, warming, 300.0, np.random.default_rng(0))
    for part, temperature in ((slice(500, 1_000), 20.0), (slice(6_000, 9_000), 30.0)):
        expected = long_transform(panel(), drive, temperature)[part]
        assert np.sum((found[part] - expected) ** 2) < 1e-3 * np.sum(expected**2)
