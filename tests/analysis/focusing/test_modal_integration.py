"""Modes integrated in time, against the steady state in closed form."""

import numpy as np
import pytest

from analysis.focusing.panel_model import PanelModes
from analysis.focusing.played import modal_motion

RATE, SECONDS = 8_000.0, 1.5


def moved(frequency, eigenvalues, rate=RATE):
    """Motion half way through a tone, and the steady state there: q = b f / (ω²(1 + jη) - w²)."""
    shapes = np.array([[1.0, 0.4], [-0.3, 0.8]])
    coupling = np.array([[2.0, 1.0], [-1.0, 3.0]])
    time = np.arange(int(SECONDS * rate)) / rate
    swelling = np.sin(0.5 * np.pi * np.clip(5.0 * np.minimum(time, SECONDS - time) / SECONDS, 0.0, 1.0)) ** 2
    drive = np.array([[1.0], [0.5j]]) * swelling * np.exp(2j * np.pi * frequency * time)
    found = modal_motion(PanelModes(np.asarray(eigenvalues), shapes, coupling), drive, rate)
    steady = shapes @ ((coupling @ drive) / (eigenvalues - (2.0 * np.pi * frequency) ** 2)[:, None])
    middle = slice(len(time) // 3, 2 * len(time) // 3)
    return found[middle], steady.real.T[middle]


def resonances(*pairs):
    return np.array([(2.0 * np.pi * f) ** 2 * (1.0 + 1j * eta) for f, eta in pairs])


@pytest.mark.parametrize("frequency", [60.0, 200.0, 310.0])
def test_a_long_tone_ends_in_the_steady_state_of_hysteretic_damping(frequency):
    found, steady = moved(frequency, resonances((200.0, 0.06), (9_000.0, 0.1)))
    np.testing.assert_allclose(found, steady, atol=1e-4 * np.abs(steady).max())


def test_modes_far_above_the_rate_follow_as_springs():
    """Reduced plates have some, at up to thirty times the rate; with 32 points one at 21 went ten times as far."""
    found, steady = moved(200.0, resonances((14.0 * RATE, 0.06), (30.0 * RATE, 0.1)))
    np.testing.assert_allclose(found, steady, atol=1e-4 * np.abs(steady).max())


def burst(time, frequency, length, pole):
    """Motion by y' = pole · y + sin²(πt/length) exp(jwt), 0 < t < length, from rest: three exponentials."""
    total = np.zeros(len(time), dtype=complex)
    for share, turn in ((0.5, 0.0), (-0.25, 1.0), (-0.25, -1.0)):
        rate = 2j * np.pi * (frequency + turn / length)
        within = np.clip(time, 0.0, length)
        driven = (np.exp(rate * within) - np.exp(pole * within)) / (rate - pole)
        total += share * driven * np.exp(pole * np.maximum(time - length, 0.0))
    return total


def test_a_burst_moves_one_mode_as_in_closed_form():
    """300 Hz at 4 kHz, half an amplitude's rise in ten samples: a drive straight between them misses by 2 %."""
    eigenvalue, rate, length, late = resonances((200.0, 0.06))[0], 4_000.0, 0.02, 0.05
    time = np.arange(int(0.3 * rate)) / rate
    pole = 1j * np.sqrt(eigenvalue)
    within = (time >= late) & (time <= late + length)
    envelope = np.where(within, np.sin(np.pi * (time - late) / length) ** 2, 0.0)
    drive = envelope * np.exp(2j * np.pi * 300.0 * (time - late))
    found = modal_motion(PanelModes(np.array([eigenvalue]), np.ones((1, 1)), np.ones((1, 1))), drive[None], rate)
    past = burst(time - late, 300.0, length, pole)
    # the other half follows its future: the burst, and time, turned about
    future = burst(late + length - time, -300.0, length, pole) * np.exp(2j * np.pi * 300.0 * length)
    exact = ((past + future) / (2.0 * pole)).real
    np.testing.assert_allclose(found[:, 0], exact, atol=3e-4 * np.abs(exact).max())


def test_the_error_falls_with_the_fourth_power_of_the_step():
    errors = []
    for rate in (4_000.0, 8_000.0):
        found, steady = moved(400.0, resonances((200.0, 0.06), (430.0, 0.1)), rate)
        errors.append(np.abs(found - steady).max())
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.1)


def test_a_free_plate_as_a_whole_moves_by_its_inertia():
    found, steady = moved(150.0, np.array([0.0, (2.0 * np.pi * 200.0) ** 2 * (1.0 + 0.06j)]))
    np.testing.assert_allclose(found, steady, atol=2e-3 * np.abs(steady).max())


def test_only_the_samples_asked_for_are_returned():
    modes = PanelModes(resonances((200.0, 0.06)), np.ones((1, 1)), np.ones((1, 1)))
    drive = np.exp(2j * np.pi * 150.0 * np.arange(1000) / RATE)[None]
    np.testing.assert_array_equal(modal_motion(modes, drive, RATE, 7), modal_motion(modes, drive, RATE)[::7])
