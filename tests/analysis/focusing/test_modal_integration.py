"""Modes integrated in time, against the steady state in closed form."""

import numpy as np
import pytest

from analysis.focusing.modal_integration import modal_motion
from analysis.focusing.panel_model import PanelModes

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
    np.testing.assert_allclose(found, steady, atol=0.005 * np.abs(steady).max())


def test_the_error_falls_with_the_square_of_the_step():
    errors = []
    for rate in (4_000.0, 8_000.0):
        found, steady = moved(150.0, resonances((200.0, 0.06), (430.0, 0.1)), rate)
        errors.append(np.abs(found - steady).max())
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)


def test_a_free_plate_as_a_whole_moves_by_its_inertia():
    found, steady = moved(150.0, np.array([0.0, (2.0 * np.pi * 200.0) ** 2 * (1.0 + 0.06j)]))
    np.testing.assert_allclose(found, steady, atol=0.005 * np.abs(steady).max())


def test_only_the_samples_asked_for_are_returned():
    modes = PanelModes(resonances((200.0, 0.06)), np.ones((1, 1)), np.ones((1, 1)))
    drive = np.exp(2j * np.pi * 150.0 * np.arange(1000) / RATE)[None]
    np.testing.assert_array_equal(modal_motion(modes, drive, RATE, 7), modal_motion(modes, drive, RATE)[::7])
