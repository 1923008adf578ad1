"""What a shot before a campaign tells, against signals made of known parts."""

import numpy as np
import pytest

from analysis.protocol.drive import drive_signal
from analysis.protocol.shot import heard, shot_of
from analysis.protocol.sweep import SweepSettings

RATE = 51_200.0 / 6.0
LONG = SweepSettings(
    kind="linear", band=(100.0, 1500.0), duration=60.0, taper=0.5, tail=5.0, repeats=5, levels=(0.5, 2.0)
)


def test_a_shot_is_the_campaign_s_band_at_its_highest_level_in_under_three_seconds():
    short = shot_of(LONG)
    assert (short.band, short.levels, short.repeats) == ((100.0, 1500.0), (2.0,), 2)
    assert short.repeats * short.record < 2.0
    assert short.frequency_range[1] < 1.07 * 1500.0


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
    one = heard(silence, drive, signal, inside, RATE, full=5.0)
    rms_of_hum = np.sqrt(0.01**2 + 0.5 * 0.004**2)
    assert one.mains == mains
    assert one.hum == pytest.approx(rms_of_hum, rel=0.02)
    assert one.noise == pytest.approx(np.hypot(rms_of_hum, 0.002), rel=0.02)
    assert one.peak == pytest.approx(1.0 / 5.0, rel=0.1)
    assert one.level == pytest.approx(0.5 * np.sqrt(np.mean(played**2)), rel=0.01)
    assert 0.95 < one.coherence < 1.0
    assert heard(silence, drive, 0.5 * drive, inside, RATE, full=5.0).coherence == pytest.approx(1.0)
