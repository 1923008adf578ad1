"""Contrast weighted with the sound, and the sound's spectrum."""

import numpy as np
import pytest

from analysis.focusing.energy import EnergyForms
from analysis.rendering.following import TemperatureProgramme
from analysis.rendering.renderer import field_contrast, power_spectrum

LINES = np.arange(100.0, 301.0, 10.0)


def test_the_power_of_a_tone_stands_at_its_line():
    time = np.arange(8_000) / 4_000.0
    found = power_spectrum(2.0 * np.sin(2 * np.pi * 152.0 * time), 4_000.0, LINES)
    assert found.argmax() == 5
    assert found[5] == pytest.approx(1.0)  # a quarter of the squared amplitude: half of the power, one side
    assert found.sum() == pytest.approx(1.0)


def test_lines_beyond_the_band_do_not_count():
    time = np.arange(8_000) / 4_000.0
    assert power_spectrum(np.sin(2 * np.pi * 50.0 * time), 4_000.0, LINES).sum() < 1e-20


def test_a_tone_s_contrast_is_that_of_its_line():
    rng = np.random.default_rng(0)
    root = rng.standard_normal((2, 3, len(LINES), 4, 4)) + 1j * rng.standard_normal((2, 3, len(LINES), 4, 4))
    target, rest = np.einsum("xtfkn,xtfkm->xtfnm", root.conj(), root)[:, :1]
    forms = EnergyForms(target + rest, target, np.zeros((1, len(LINES), 4), complex))
    filters = rng.standard_normal((len(LINES), 4)) + 0j
    tone = np.zeros(len(LINES))
    tone[7] = 3.0
    found = field_contrast(forms, filters, tone)
    r = filters[7]
    assert found.sound == pytest.approx((r @ target[0, 7] @ r / (r @ (target + rest)[0, 7] @ r)).real)
    assert found.worst <= found.sound <= 1.0
    assert np.isnan(field_contrast(forms, filters, np.zeros(len(LINES))).sound)


@pytest.mark.parametrize(
    ("time", "temperature", "said"),
    [
        ([], [], "moments for"),
        ([0.0, 1.0], [20.0], "moments for"),
        ([1.0, 0.0], [20.0, 21.0], "must ascend"),
        ([0.0], [np.nan], "finite"),
    ],
)
def test_a_programme_that_is_none_is_refused(time, temperature, said):
    with pytest.raises(ValueError, match=said):
        TemperatureProgramme(np.array(time), np.array(temperature))
