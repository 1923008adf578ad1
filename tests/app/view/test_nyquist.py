"""Which part of an FRF is shown in the Nyquist plane."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("PySide6.QtSvg", reason="Qt cannot be loaded here", exc_type=ImportError)

from analysis.identification.modes import Modes
from app.view.frf_plots import LEAST_LINES_AROUND, WIDTHS_AROUND_CURSOR, around
from tests.app.view.conftest import FREQUENCY, modes_at


def place(hertz: float) -> int:
    return int(np.abs(FREQUENCY - hertz).argmin())


def test_six_half_power_widths_of_the_nearest_mode_are_shown() -> None:
    modes = modes_at(0.0)
    light = replace(modes, poles=modes.poles.real / 10 + 1j * modes.poles.imag)
    shown = FREQUENCY[around(FREQUENCY, place(610.0), light)]
    reach = WIDTHS_AROUND_CURSOR * 2 * 0.003 * 610.0
    assert shown[[0, -1]] == pytest.approx([610.0 - reach, 610.0 + reach], abs=2.0)


def test_no_further_than_the_next_mode() -> None:
    """The half-power width at 180 Hz is 11 Hz; six of them would reach 65 Hz."""
    both = modes_at(0.0)
    crowded = replace(both, poles=both.poles * np.array([1.0, 210.0 / 320.0, 1.0]))
    shown = FREQUENCY[around(FREQUENCY, place(180.0), crowded)]
    assert shown[[0, -1]] == pytest.approx([150.0, 210.0], abs=2.0)


@pytest.mark.parametrize("modes", [None, replace(modes_at(0.0), status=("computational",) * 3)])
def test_without_modes_a_share_of_the_frequency_is_shown(modes: Modes | None) -> None:
    shown = FREQUENCY[around(FREQUENCY, place(500.0), modes)]
    assert shown[[0, -1]] == pytest.approx([470.0, 530.0], abs=2.0)


@pytest.mark.parametrize("here", [0, len(FREQUENCY) - 1])
def test_some_lines_are_shown_however_narrow_a_mode_is(here: int) -> None:
    modes = modes_at(0.0)
    narrow = replace(modes, poles=modes.poles.real / 1e4 + 1j * modes.poles.imag)
    assert around(FREQUENCY, here, narrow).sum() == LEAST_LINES_AROUND + 1
