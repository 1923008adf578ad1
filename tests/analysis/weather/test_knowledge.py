"""A plane of temperatures from readings, and from a panel's own response."""

import numpy as np
import pytest

from analysis.weather.family import Believed, OwnThermometer, plane

CORNERS = np.array([[-0.8, -0.1], [0.9, -0.7], [0.7, 0.8], [-0.5, 0.9]])


def readings(places, middle, x, y):
    return middle + 0.5 * (x * places[:, 0] + y * places[:, 1])


@pytest.mark.parametrize("count", [3, 4])
def test_three_thermometers_tell_a_plane(count):
    places = CORNERS[:count]
    found = plane(places, readings(places, 31.0, 18.0, -7.0))
    assert found.middle == pytest.approx(31.0, abs=1e-4)
    assert found.across == pytest.approx((18.0, -7.0), abs=1e-4)


def test_one_thermometer_is_the_temperature_everywhere():
    assert plane(CORNERS[1:2], np.array([44.0])) == Believed(
        pytest.approx(44.0), (pytest.approx(0.0), pytest.approx(0.0))
    )


def test_two_thermometers_tell_the_tilt_along_their_line_only():
    places = np.array([[-0.6, 0.3], [0.8, 0.3]])
    found = plane(places, readings(places, 20.0, 10.0, 0.0))
    assert found.across == pytest.approx((10.0, 0.0), abs=1e-3)
    assert found.middle == pytest.approx(20.0, abs=1e-3)


def test_the_panel_finds_the_plane_that_it_has_through_noise_and_a_gain(warm, rng):
    lines = warm.plate.panel.filters.frequency
    own = OwnThermometer.of(warm, lines, 6, (0.0, 60.0))
    charge = own.measured(warm.tilted(33.0, (9.0, -6.0)))
    noise = rng.standard_normal(len(charge)) + 1j * rng.standard_normal(len(charge))
    heard = 1.07 * charge + 0.01 * np.sqrt(0.5 * np.mean(np.abs(charge) ** 2)) * noise
    found = own.read(heard, Believed(30.0), tries=8)
    assert found.middle == pytest.approx(33.0, abs=0.1)
    assert found.across == pytest.approx((9.0, -6.0), abs=0.5)


def test_a_panel_too_noisy_to_tell_a_tilt_keeps_to_the_last_reading(warm, rng):
    own = OwnThermometer.of(warm, warm.plate.panel.filters.frequency, 6, (0.0, 60.0))
    charge = own.measured(warm.tilted(33.0, (0.0, 0.0)))
    noise = 1e4 * np.abs(charge).max() * (rng.standard_normal(len(charge)) + 1j * rng.standard_normal(len(charge)))
    found = own.read(noise, Believed(30.0), tries=3)
    assert abs(found.middle - 30.0) < 20.0
    assert np.abs(found.across).max() < 40.0
