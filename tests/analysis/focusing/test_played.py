"""A sweep in the time domain, on the plate in closed form."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from analysis.focusing.played import play_methods, sweep

CONSTANTS = (1.6e9, 0.36, 0.08)


@pytest.fixture(scope="module")
def plain(make_plate, make_panel, six):
    settings = {"taps": 128, "sample_rate": 8_000.0, "transform_length": 4_096}
    return make_plate(make_panel(six, band=(100.0, 500.0), edges=(60.0, 560.0), **settings))


@pytest.fixture(scope="module")
def played(plain):
    return play_methods(plain, plain.panel, CONSTANTS)


def test_time_and_frequency_domain_agree(played):
    np.testing.assert_allclose(played.total, played.expected, atol=3e-4)


@dataclass(frozen=True)
class WrongModes:
    """A plate whose modes are 5 % lower than those its answers show."""

    plate: Any

    @property
    def space(self):
        return self.plate.space

    def amplitudes(self, *asked):
        return self.plate.amplitudes(*asked)

    def forms(self, *asked):
        return self.plate.forms(*asked)

    def modes(self, youngs_modulus, *others, count):
        return self.plate.modes(0.9 * youngs_modulus, *others, count=count)


def test_the_two_domains_share_no_answer_of_the_plate(plain, played):
    """The check can fail: modes that are wrong show up as a difference, in time alone."""
    found = play_methods(WrongModes(plain), plain.panel, CONSTANTS)
    stif = found.methods.index("stif")
    assert found.expected[stif] == played.expected[stif]
    assert abs(found.total[stif] - found.expected[stif]) > 0.01


def test_a_slow_sweep_passes_each_line_with_that_line_s_contrast(played):
    """Away from the ends, where it begins and where the panel rings on: within what 80 Hz/s smears."""
    stif = played.methods.index("stif")
    inside = (played.sweep_frequency > 130.0) & (played.sweep_frequency < 450.0)
    steady = np.interp(played.sweep_frequency, played.frequency, played.contrast[stif])
    off = np.abs(played.sweep_contrast[stif] - steady)[inside]
    assert off.mean() < 0.03


def test_stif_leads_and_time_reversal_waits_for_its_sound(played):
    assert np.argmax(played.total) == 0
    assert played.delay[played.methods.index("time-reversal")] > played.delay[0] == 64


def test_the_sweep_runs_over_the_band_at_constant_octaves_per_second():
    signal, frequency = sweep((100.0, 800.0), 2.0, 8_000.0)
    assert len(signal) == len(frequency) == 16_000
    assert frequency[0] == 100.0
    assert frequency[-1] == pytest.approx(800.0, rel=1e-3)
    np.testing.assert_allclose(np.diff(np.log(frequency)), np.log(8.0) / 16_000)
    crossings = np.count_nonzero(np.diff(np.sign(signal.real)))
    assert crossings == pytest.approx(2.0 * np.trapezoid(frequency, dx=1 / 8_000.0), rel=0.01)


def test_the_sweep_holds_nothing_outside_its_band():
    """Where it begins or ends at once, a filter that is loud outside the band would be judged there."""
    signal, _ = sweep((100.0, 800.0), 2.0, 8_000.0)
    energy = np.abs(np.fft.fft(signal)) ** 2
    frequency = np.fft.fftfreq(len(signal), 1.0 / 8_000.0)
    assert energy[(frequency < 80.0) | (frequency > 900.0)].sum() < 1e-4 * energy.sum()
    assert np.abs(signal).max() == pytest.approx(1.0)
