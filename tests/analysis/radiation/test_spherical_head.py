"""Rigid sphere: its surface does not move, low-frequency delay between ears, far and slow limits."""

import numpy as np
import pytest
from scipy.special import eval_legendre, spherical_jn, spherical_yn

from analysis.radiation.radiator import Radiator
from analysis.radiation.spherical_head import HEAD_RADIUS, at_ears, sphere_response


def test_at_low_frequencies_the_ears_differ_by_three_halves_of_the_way():
    """Kuhn, JASA 62 (1977) 157: the interaural delay of a far source tends to 3 a/c sin θ."""
    k, angle = np.array([0.05, 0.5]), 0.6
    left, right = sphere_response(np.array([-np.sin(angle), np.sin(angle)]), 50.0, k)
    delay = np.angle(right / left) / k
    np.testing.assert_allclose(delay, 3.0 * HEAD_RADIUS * np.sin(angle), rtol=2e-3)
    np.testing.assert_allclose(np.abs(left), 1.0, atol=0.01)


def test_pressure_on_the_sphere_is_that_of_a_field_whose_radial_velocity_vanishes():
    """The incident wave expanded in spherical functions, and a scattered one that cancels its radial slope."""
    k, distance, cosine = 12.0, 0.6, np.linspace(-1.0, 1.0, 7)
    x, away = k * HEAD_RADIUS, k * distance
    total = np.zeros(len(cosine), dtype=complex)
    for m in range(20):
        source = spherical_jn(m, away) - 1j * spherical_yn(m, away)
        out, slope = (spherical_jn(m, x, d) - 1j * spherical_yn(m, x, d) for d in (False, True))
        scattered = spherical_jn(m, x) - spherical_jn(m, x, True) / slope * out
        total += -1j * k * (2 * m + 1) * source * scattered * eval_legendre(m, cosine)
    centre = np.exp(-1j * away) / distance
    np.testing.assert_allclose(sphere_response(cosine, distance, np.array([k]))[:, 0], total / centre, rtol=1e-8)


def test_the_ear_on_the_side_of_the_panel_hears_it_first_and_louder():
    panel = Radiator(np.array([[1.0, 0.0], [1.02, 0.0]]), np.full(2, 1e-4))
    frequency = np.array([300.0, 700.0, 1000.0])
    place = np.array([0.0, 0.0, 0.8])
    kernel = panel.pressure(place[None], frequency)[0]
    left, right = at_ears(kernel, panel.points, place, panel.wavenumber(frequency)).sum(axis=-1)
    assert (np.abs(right) > np.abs(left)).all()
    assert (np.angle(right / left)[:2] > 0.0).all()  # the third has turned by more than half a period
    ahead = Radiator(np.array([[-0.01, 0.0], [0.01, 0.0]]), np.full(2, 1e-4))
    kernel = ahead.pressure(place[None], frequency)[0]
    left, right = at_ears(kernel, ahead.points, place, ahead.wavenumber(frequency)).sum(axis=-1)
    np.testing.assert_allclose(left, right, rtol=1e-3)
    with pytest.raises(ValueError, match=r"a source 0.05 m from the middle of a head"):
        sphere_response(np.zeros(1), 0.05, np.ones(1))
