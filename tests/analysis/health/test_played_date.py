"""Sound as a date: music-like drives through the panel in closed form, independent or filtered from one signal."""

import numpy as np
import pytest
from scipy.signal import lfilter

from analysis.health.recording import played_date
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import NO_EFFECTS
from tests.analysis.health.healthy_panel import LINES, NODES, NOISE, REAL, laws, usual_watch

RATE, SECONDS = 2_560.0, 300.0
COUNT = round(RATE * SECONDS)
NO_LINES = np.zeros(LINES.size, dtype=bool)
HALF_WIDTH = 0.5 * 0.03 * LINES[0]


def pink(rng, channels):
    """Noise whose power falls with frequency, and whose level moves, as that of music."""
    coloured = lfilter([1.0], [1.0, -0.8], rng.standard_normal((channels, COUNT)))
    return coloured * (1.0 + 0.7 * np.sin(2.0 * np.pi * 0.21 * np.arange(COUNT) / RATE))


def filtered(rng):
    """One piece of sound through a filter for each actuator, with delays, as a focusing panel plays it."""
    taps = rng.standard_normal((2, 40)) * np.exp(-np.arange(40) / 8.0)
    (signal,) = pink(rng, 1)
    return np.array([np.roll(np.convolve(signal, own)[:COUNT], 9 * n) for n, own in enumerate(taps)])


def answered(drives, temperature, rng, effects=NO_EFFECTS, hum=0.0):
    """Responses of the real panel, with noise."""
    every = np.fft.rfftfreq(COUNT, 1.0 / RATE)
    inside = (every > 40.0) & (every < 1_200.0)
    law, chosen = laws().local(temperature), np.arange(40.0, 1_201.0, 0.25)
    spectra, total = np.fft.rfft(drives), np.zeros((2, every.size), dtype=complex)
    for source in range(2):
        h = REAL.frf(law, chosen, effects, SweepPoint(temperature, 0.0, 1.0, source))
        for channel in range(2):
            smooth = np.interp(every[inside], chosen, h[channel].real) + 1j * np.interp(
                every[inside], chosen, h[channel].imag
            )
            total[channel, inside] += smooth * spectra[source, inside]
    clean = np.fft.irfft(total, COUNT)
    noise = rng.standard_normal(clean.shape) * NOISE * clean.std(axis=1, keepdims=True)
    return clean + noise + hum


def date(drives, responses, name="sound"):
    return played_date(drives, responses, RATE, LINES, NO_LINES, NODES, HALF_WIDTH, name)


@pytest.mark.parametrize("of_one", [False, True])
def test_a_panel_that_plays_tells_its_temperature_and_gives_no_alarm(of_one):
    watch, rng = usual_watch(), np.random.default_rng(5)
    drives = filtered(rng) if of_one else pink(rng, 2)
    recording = date(drives, answered(drives, 24.5, rng))
    assert (recording.mix is not None) == of_one
    found = watch.take([recording])
    assert not found.alarm, found
    assert found.label is None
    assert found.temperature == pytest.approx(24.5, abs=0.3)


@pytest.mark.parametrize("of_one", [False, True])
def test_a_mass_on_a_panel_that_plays_is_named_and_placed(of_one):
    watch, rng = usual_watch(), np.random.default_rng(6)
    drives = filtered(rng) if of_one else pink(rng, 2)
    effects = {"mass_at_place": {"mass": 0.002, "x": 0.06, "y": 0.11}}
    assert watch.take([date(drives, answered(drives, 13.0, rng, effects))]).alarm
    named = watch.named()
    assert named.family == "mass"
    assert named.change is not None
    assert np.hypot(named.change.values["x"] - 0.06, named.change.values["y"] - 0.11) < 0.005
    assert named.change.values["mass"] == pytest.approx(0.002, rel=0.1)


def test_responses_to_independent_drives_are_those_of_the_panel():
    rng = np.random.default_rng(7)
    drives = pink(rng, 2)
    recording = date(drives, answered(drives, 30.0, rng))
    law = laws().local(30.0)
    for source, sweep in enumerate(recording.sweeps):
        exact = REAL.frf(law, NODES.frequency, NO_EFFECTS, SweepPoint(30.0, 0.0, 1.0, source))
        missed = NODES.at_nodes(sweep.coefficients) - exact
        assert np.linalg.norm(missed) < 0.02 * np.linalg.norm(exact)


@pytest.mark.parametrize(
    ("spoilt", "said"),
    [
        (lambda drives, _: (drives[:, :5_000], _[:, :5_000]), "s of sound; segments of"),
        (lambda drives, _: (drives[:, :200_000], _[:, :200_000]), "s or more, and the band of the baseline"),
        (lambda drives, _: (drives * [[1.0], [0.0]], _), "silent"),
        (lambda drives, _: (np.array([drives[0], drives[0] + 0.1 * drives[1]]), _), "partly one signal"),
    ],
)
def test_sound_that_says_too_little_is_refused(spoilt, said):
    rng = np.random.default_rng(8)
    drives = pink(rng, 2)
    with pytest.raises(ValueError, match=said):
        date(*spoilt(drives, 0.1 * drives))
