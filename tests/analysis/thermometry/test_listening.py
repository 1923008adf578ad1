"""Temperature from simulated music: accuracy, intervals, gain, a wrong law, refusals."""

import numpy as np
import pytest

from analysis.rendering.following import TemperatureProgramme
from analysis.thermometry import Listener, Track, simulated_response

RATE, BAND = 1_000.0, (40.0, 380.0)
GRID = np.linspace(0.0, 60.0, 121)


@pytest.fixture(scope="module")
def listener(panel):
    return Listener.of(panel(), GRID, RATE, BAND)


def stretches(listener, drive, response):
    """Yield the reading and the middle of every stretch."""
    for first in range(listener.before, drive.shape[1] - listener.whole + listener.before, listener.frame):
        begin = first - listener.before
        part = drive[:, begin : begin + listener.whole]
        yield listener.read(part, response[first : first + listener.frame]), (first + 0.5 * listener.frame) / RATE


def played(panel, drive, programme, snr=20.0, seed=0):
    return simulated_response(panel, drive, RATE, BAND, programme, snr, np.random.default_rng(seed))


def steady(temperature):
    return TemperatureProgramme(np.zeros(1), np.array([temperature]))


def test_a_minute_of_music_at_20_db_is_told_to_a_tenth_of_a_kelvin_and_the_intervals_hold(panel, listener, drives):
    z, error, tracked = [], [], []
    for seed in range(3):
        drive = drives(60.0, seed)
        warming = TemperatureProgramme(np.array([0.0, 60.0]), np.array([20.0, 21.0]) + 13.0 * seed)
        track = Track()
        for reading, time in stretches(listener, drive, played(panel(), drive, warming, seed=seed)):
            true = warming.at(time)
            track.step(reading, 1.0)
            assert not reading.refused
            z.append((reading.temperature - true) / reading.sigma)
            error.append(reading.temperature - true)
            tracked.append(abs(track.temperature - true) / track.sigma)
    assert np.sqrt(np.mean(np.square(error))) < 0.1
    assert 0.85 <= np.mean(np.abs(z) < 1.645) <= 0.95
    assert np.mean(np.array(tracked) < 1.645) >= 0.85
    assert abs(np.mean(z)) < 0.3


def test_without_noise_only_the_grid_s_interpolation_is_left(panel, listener, drives):
    drive = drives(5.0)
    for reading, _ in stretches(listener, drive, played(panel(), drive, steady(33.3), 300.0)):
        assert reading.temperature == pytest.approx(33.3, abs=2e-3)


def test_sigma_is_the_bound_of_cramer_and_rao(panel, listener, drives):
    """White noise of known power, gain unknown: the least variance any estimator has, from the answer's slope."""
    drive = drives(3.0)
    low, mid, high = (
        simulated_response(panel(), drive, RATE, BAND, steady(t), 300.0, np.random.default_rng(0))
        for t in (29.9, 30.0, 30.1)
    )
    noise = 0.1 * np.sqrt(np.mean(mid**2))
    found = []
    for seed in range(12):
        noisy = mid + noise * np.random.default_rng(seed).standard_normal(len(mid))
        found.append(next(iter(stretches(listener, drive, noisy)))[0].sigma)
    part = slice(listener.before, listener.before + listener.frame)
    slope, value = (high - low)[part] / 0.2, mid[part]
    across = slope - value * (slope @ value) / (value @ value)
    bound = noise / np.linalg.norm(across)
    assert bound < np.mean(found) < 1.5 * bound


@pytest.mark.parametrize("gain", [1e-9, 250.0, -3.0])
def test_the_gain_may_be_any_and_is_estimated(panel, listener, drives, gain):
    drive = drives(4.0)
    for reading, _ in stretches(listener, drive, gain * played(panel(), drive, steady(41.0))):
        assert reading.temperature == pytest.approx(41.0, abs=0.4)
        assert reading.gain == pytest.approx(gain, rel=0.05)


def test_a_gain_that_moves_meanwhile_costs_little(panel, listener, drives):
    drive = drives(20.0)
    gain = 1.0 + 0.5 * np.sin(2 * np.pi * np.arange(drive.shape[1]) / RATE / 15.0)
    error = [
        reading.temperature - 28.0
        for reading, _ in stretches(listener, drive, gain * played(panel(), drive, steady(28.0)))
    ]
    assert np.sqrt(np.mean(np.square(error))) < 0.3


def test_a_law_that_is_wrong_moves_the_reading_to_where_the_panel_is_as_soft(panel, listener, drives):
    """Filters are looked up by that reading, and so are right all the same: 2 % of E are 1 % of pitch, 1.25 K."""
    drive = drives(10.0)
    found = [
        reading.temperature
        for reading, _ in stretches(listener, drive, played(panel(softness=0.98), drive, steady(30.0)))
    ]
    assert np.mean(found) == pytest.approx(30.0 + 0.5 * np.log(1.0 / 0.98) / 0.008, abs=0.1)


def test_a_wrong_damping_hardly_moves_the_reading_and_widens_its_sigma(panel, listener, drives):
    drive = drives(10.0)
    right, wrong = (
        [r for r, _ in stretches(listener, drive, played(panel(loss_factor=loss), drive, steady(30.0)))]
        for loss in (0.06, 0.075)
    )
    assert np.mean([r.temperature for r in wrong]) == pytest.approx(30.0, abs=0.3)
    assert np.mean([r.sigma for r in wrong]) > np.mean([r.sigma for r in right])
    assert all(r.explained < s.explained for r, s in zip(wrong, right, strict=True))


def test_what_says_nothing_is_refused(panel, listener, drives):
    drive, rng = drives(3.0), np.random.default_rng(0)
    answer = played(panel(), drive, steady(30.0))
    silent = listener.read(0.0 * drive[:, : listener.whole], answer[: listener.frame])
    assert silent.refused == "silence in the band"
    noise = rng.standard_normal(listener.frame)
    assert "explains" in listener.read(drive[:, : listener.whole], noise).refused
    time = np.arange(drive.shape[1]) / RATE
    hum = np.tile(
        np.sin(2 * np.pi * 42.0 * time), (3, 1)
    )  # below every mode: stiffness alone, which the gain takes
    sent = played(panel(), hum, steady(30.0))
    reading = listener.read(hum[:, : listener.whole], sent[listener.before : listener.before + listener.frame])
    assert "too little energy where the response moves" in reading.refused
    assert np.isnan(reading.temperature)


def test_a_temperature_beyond_the_range_is_refused(panel, drives):
    drive = drives(3.0)
    short = Listener.of(panel(), np.linspace(10.0, 20.0, 21), RATE, BAND)
    answer = played(panel(), drive, steady(24.0))
    reading = listener_read(short, drive, answer)
    assert reading.refused


def listener_read(listener, drive, answer):
    part = slice(listener.before, listener.before + listener.frame)
    return listener.read(drive[:, : listener.whole], answer[part])
