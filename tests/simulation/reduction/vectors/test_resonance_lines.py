"""Lines on narrow resonances: the band's rms is that of the closed form, however sharp they are."""

import numpy as np
import pytest

from simulation.reduction.damped_modes import resonance_lines, root_mean_square

GRID = np.linspace(100.0, 1500.0, 200)


@pytest.mark.parametrize("loss", [2e-4, 1e-3, 1e-2])
def test_rms_of_a_resonance_is_that_of_its_area(loss: float) -> None:
    """The area under |1/((1 + j eta) - (f/f0)**2)|**2 is pi f0/(2 eta) for light damping."""
    center = 437.3
    lines = resonance_lines(np.array([center]), loss, GRID)
    h = 1.0 / (1.0 + 1j * loss - (lines / center) ** 2)
    resonant = np.pi * center / (2.0 * loss)
    assert root_mean_square(h, lines) ** 2 * 1400.0 == pytest.approx(resonant, rel=0.25)
    assert np.abs(h).max() == pytest.approx(1.0 / loss)


def test_wide_resonances_and_those_outside_add_nothing() -> None:
    assert resonance_lines(np.array([800.0]), 0.05, GRID) is GRID
    assert resonance_lines(np.array([50.0, 1600.0]), 1e-3, GRID) is GRID


def test_lines_ascend_within_the_band() -> None:
    lines = resonance_lines(np.array([100.1, 700.0, 1499.9]), 1e-3, GRID)
    assert (np.diff(lines) > 0.0).all()
    assert (lines[0], lines[-1]) == (100.0, 1500.0)
    assert {100.1, 700.0, 1499.9} <= set(lines.tolist())
