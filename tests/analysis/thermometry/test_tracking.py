"""The track: against batch least squares, over wandering temperatures, and through nonsense."""

import numpy as np
import pytest

from analysis.thermometry import ThermometerReading, Track

REFUSED = ThermometerReading(np.nan, np.nan, np.nan, 0.0, "silence")


def reading(temperature, sigma=0.1):
    return ThermometerReading(temperature, sigma, 1.0, 1.0)


def test_without_wander_it_is_the_straight_line_of_least_squares():
    rng = np.random.default_rng(0)
    time = np.arange(40.0)
    values = 20.0 + 0.03 * time + 0.1 * rng.standard_normal(40)
    track = Track(wander=0.0, first_rate=1e3)
    for value in values:
        track.step(reading(value), 1.0)
    line, covariance = np.polyfit(time, values, 1, cov="unscaled")
    assert track.temperature == pytest.approx(np.polyval(line, 39.0), abs=1e-5)
    at = np.array([39.0, 1.0])
    assert track.sigma == pytest.approx(0.1 * np.sqrt(at @ covariance @ at), rel=1e-5)


def test_ninety_percent_of_its_intervals_hold_the_truth():
    rng = np.random.default_rng(1)
    inside = []
    for _ in range(40):
        track, rate, true = Track(), 0.0, 25.0
        for _ in range(60):
            rate += 0.002 * rng.standard_normal()
            true += rate
            track.step(reading(true + 0.05 * rng.standard_normal(), 0.05), 1.0)
            inside.append(abs(track.temperature - true) < 1.645 * track.sigma)
    assert 0.85 < np.mean(inside) < 0.95


def test_silence_widens_and_a_reading_narrows():
    track = Track()
    assert np.isnan(track.temperature)
    assert track.sigma == np.inf
    track.step(REFUSED, 1.0)
    assert track.sigma == np.inf
    track.step(reading(20.0), 1.0)
    assert (track.temperature, track.sigma) == (20.0, pytest.approx(0.1))
    for _ in range(20):
        track.step(REFUSED, 1.0)
    wide = track.sigma
    assert wide > 0.5
    track.step(reading(20.5), 1.0)
    assert track.sigma < 0.11


def test_one_strange_reading_is_passed_over_three_begin_anew():
    track = Track()
    for _ in range(10):
        track.step(reading(20.0), 1.0)
    track.step(reading(45.0), 1.0)
    assert track.temperature == pytest.approx(20.0, abs=0.1)
    track.step(reading(20.0), 1.0)
    for _ in range(2):
        track.step(reading(45.0), 1.0)
    assert track.temperature == pytest.approx(20.0, abs=0.2)
    track.step(reading(45.0), 1.0)
    assert track.temperature == 45.0
