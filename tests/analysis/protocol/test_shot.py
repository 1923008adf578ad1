"""What a shot before a campaign tells, against signals made of known parts."""

import numpy as np
import pytest

from analysis.protocol.acceptance import input_levels, shot_of
from analysis.protocol.sweep import SweepSettings, drive_signal

RATE = 51_200.0 / 6.0
LONG = SweepSettings(
    kind="linear", band=(100.0, 1500.0), duration=60.0, taper=0.5, tail=5.0, repeats=5, levels=(0.5, 2.0)
)


def test_a_shot_is_the_campaign_s_band_at_its_highest_level_in_under_three_seconds():
    short = shot_of(LONG)
    assert (short.levels, short.repeats) == ((2.0,), 2)
    assert short.band[0] == 100.0
    assert 0.95 * 1500.0 < short.band[1] <= 1500.0
    assert short.repeats * short.record < 2.0
    assert short.frequency_range[1] <= LONG.frequency_range[1] * (1.0 + 1e-12)


@pytest.mark.parametrize("mains", [50.0, 60.0])
def test_level_noise_hum_and_coherence(mains):
    rng = np.random.default_rng(4)
    short = shot_of(LONG)
    played = drive_signal(short, 2.0, RATE)
    time = np.arange(round(0.4 * RATE)) / RATE
    hum = 0.01 * np.sqrt(2.0) * np.sin(2 * np.pi * mains * time) + 0.004 * np.cos(2 * np.pi * 3 * mains * time)
    silence = 0.3 + hum + 0.002 * rng.standard_normal(time.size)
    drive = np.stack([played, played]).astype(np.float32)
    signal = (0.5 * drive + 0.02 * rng.standard_normal(drive.shape)).astype(np.float32)
    grid = np.fft.rfftfreq(played.size, 1.0 / RATE)
    inside = (grid >= 100.0) & (grid <= 1500.0)
    one = input_levels(silence, drive, signal, inside, RATE, full=5.0)
    rms_of_hum = np.sqrt(0.01**2 + 0.5 * 0.004**2)
    assert one.mains == mains
    assert one.hum == pytest.approx(rms_of_hum, rel=0.02)
    assert one.noise == pytest.approx(np.hypot(rms_of_hum, 0.002), rel=0.02)
    assert one.peak == pytest.approx(1.0 / 5.0, rel=0.1)
    assert one.level == pytest.approx(0.5 * np.sqrt(np.mean(played**2)), rel=0.01)
    assert 0.95 < one.coherence < 1.0
    assert input_levels(silence, drive, 0.5 * drive, inside, RATE, full=5.0).coherence == pytest.approx(1.0)


def test_a_shot_ends_no_higher_than_the_campaign_s_sweep():
    """A wide band with a short linear fade passes below half of the rate; the shot has to, too."""
    rate = 51_200.0
    wide = SweepSettings(
        kind="linear", band=(20.0, 22_500.0), duration=20.0, taper=0.01, tail=1.0, repeats=2, levels=(1.0,)
    )
    assert drive_signal(wide, 1.0, rate).any()
    short = shot_of(wide)
    assert short.frequency_range[1] <= wide.frequency_range[1] * (1.0 + 1e-12)
    assert drive_signal(short, 1.0, rate).any()
    assert short.band[0] == 20.0
    assert 0.8 * 22_500.0 < short.band[1] < 22_500.0


def test_a_shot_of_a_narrow_band_has_a_band():
    """Its own fade takes a twentieth of what the band spans, which never closes it."""
    narrow = LONG.model_copy(update={"band": (1000.0, 1001.0), "taper": 1e-3})
    low, high = shot_of(narrow).band
    assert low < high <= 1001.0
    assert shot_of(narrow).frequency_range[1] <= narrow.frequency_range[1] * (1.0 + 1e-12)
