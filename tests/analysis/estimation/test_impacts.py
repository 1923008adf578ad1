"""Hammer tests of a plate with known poles: windows and their correction, rejected blows, tails too short."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import butter, lfilter

from analysis.estimation.estimators import estimate
from analysis.estimation.impacts import HammerTest, find_blows
from analysis.estimation.ringing import ringing
from analysis.estimation.spectra import SampledSignals, clipped, signal_faults
from analysis.estimation.windows import without_window
from analysis.identification.automatic import identify
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.settings import Settings

RATE = 8192.0
F = np.array([180.0, 410.0, 890.0])
ZETA = np.array([0.004, 0.003, 0.005])
POLES = 2 * np.pi * F * (-ZETA + 1j * np.sqrt(1 - ZETA**2))
RESIDUES = np.array([0.9, -0.7, 0.5]) / (2j * POLES.imag)
SECONDS = 1.0


def ring(force: NDArray[np.float64]) -> NDArray[np.float64]:
    """Displacement of a structure with three modes: its impulse response sampled, folded with the force."""
    t = np.arange(round(3.0 * RATE)) / RATE
    impulse = 2.0 * (RESIDUES[:, None] * np.exp(np.outer(POLES, t))).real.sum(0)
    impulse[0] *= 0.5
    return np.asarray(np.convolve(force, impulse)[: len(force)] / RATE)


def blow(samples: int, at: float, height: float = 50.0, width: float = 4e-4) -> NDArray[np.float64]:
    t = np.arange(samples) / RATE
    return height * np.exp(-(((t - at) / width) ** 2))


def session(blows: list[tuple[float, float]], seconds: float, noise: float = 0.0, seed: int = 0) -> SampledSignals:
    rng = np.random.default_rng(seed)
    samples = round(seconds * RATE)
    force = sum((blow(samples, at, height) for at, height in blows), np.zeros(samples))
    response = ring(force)
    response = response + noise * np.abs(response).max() * rng.standard_normal(samples)
    return SampledSignals(RATE, (force + 0.01 * rng.standard_normal(samples))[None], response[None])


def identified(recording: SampledSignals, test: HammerTest) -> tuple[Modes, float]:
    blows = find_blows(recording, test)
    found = estimate(blows.spectra())
    band = (found.frequency > 60.0) & (found.frequency < 1200.0)
    variance = None if found.variance is None else found.variance[:, 0, band]
    measured = Measured(found.frequency[band], found.h[:, 0, band], variance)
    return identify(measured, Settings(mains=None)), blows.window.rate


def test_hits_are_found_and_three_modes_with_their_damping() -> None:
    recording = session([(0.5 + 3.0 * n, 50.0 + 5 * n) for n in range(4)], 12.5, noise=1e-4)
    test = HammerTest(trigger=5.0, pretrigger=0.02)
    blows = find_blows(recording, test)
    assert [hit.rejected for hit in blows.hits] == ["", "", "", ""]
    np.testing.assert_allclose([hit.peak for hit in blows.hits], [50, 55, 60, 65], rtol=0.02)
    modes, rate = identified(recording, test)
    assert rate == 0.0
    kept = modes.poles[modes.real]
    np.testing.assert_allclose(kept.imag, POLES.imag, rtol=2e-5)
    np.testing.assert_allclose(kept.real, POLES.real, rtol=0.01)


@pytest.mark.parametrize("seed", range(3))
def test_one_blow_alone_is_identified_as_exactly_as_its_noise_allows(seed: int) -> None:
    """Roughness along frequency, which peaks two lines wide have without noise, must not be taken for noise."""
    modes, _ = identified(session([(0.5, 50.0)], 3.0, noise=1e-4, seed=seed), HammerTest(trigger=5.0))
    kept = modes.poles[modes.real]
    assert (np.abs(kept.imag / POLES.imag - 1.0) < [2e-7, 1e-6, 1e-5]).all()
    assert (np.abs(kept.real / POLES.real - 1.0) < [1e-4, 2e-4, 5e-3]).all()


def test_the_damping_of_an_exponential_window_is_taken_out_of_the_poles() -> None:
    """Blocks of a second, in which the lowest mode falls to a hundredth only: the window leaves no leakage."""
    recording = session([(0.5 + 3.0 * n, 50.0) for n in range(4)], 12.5, noise=1e-5)
    test = HammerTest(trigger=5.0, pretrigger=0.02, duration=SECONDS, exponential=1e-4)
    modes, rate = identified(recording, test)
    assert rate == pytest.approx(np.log(1e4) / SECONDS)
    raw = modes.poles[modes.real]
    np.testing.assert_allclose(raw.real, POLES.real - rate, rtol=5e-3)
    poles, covariance = without_window(raw, modes.covariance[modes.real], rate)
    np.testing.assert_allclose(poles.imag, POLES.imag, rtol=1e-5)
    np.testing.assert_allclose(poles.real, POLES.real, rtol=0.02)
    assert (covariance[:, 1, 1] > modes.covariance[modes.real, 1, 1]).all()


def test_the_deviation_of_a_corrected_pole_is_that_of_the_pole_in_the_plane() -> None:
    rng = np.random.default_rng(3)
    pole, rate, sigma = np.array([-8.0 + 900j]), 5.0, 0.02
    scattered = pole + sigma * (rng.standard_normal(20000) + 1j * rng.standard_normal(20000))

    def logs(poles: NDArray[np.complex128]) -> NDArray[np.float64]:
        return np.array([np.log(np.abs(poles)), np.log(-poles.real / np.abs(poles))])

    _, after = without_window(pole, np.cov(logs(scattered))[None], rate)
    np.testing.assert_allclose(after[0], np.cov(logs(scattered + rate)), rtol=0.05, atol=1e-9)


def test_a_mode_whose_damping_the_window_drowned_is_unknown_and_not_unstable() -> None:
    poles, covariance = without_window(np.array([-5.0 + 900j]), 1e-4 * np.eye(2)[None], 5.5)
    assert poles[0].real < 0.0
    assert covariance[0, 1, 1] > 1.0


def test_a_double_hit_whose_second_blow_is_the_harder_is_left_out() -> None:
    """The force window would drop the first blow, which the response has felt."""
    blows = find_blows(session([(0.5, 30.0), (0.506, 50.0)], 2.0), HammerTest(trigger=5.0, duration=1.0))
    (hit,) = blows.hits
    assert hit.rejected == "double hit: 60 % of the force 6.0 ms earlier"


def test_a_record_that_begins_at_its_trigger_says_what_to_shorten() -> None:
    assert find_blows(session([(0.002, 50.0)], 1.0), HammerTest(trigger=5.0)).spectra().averages == 1
    blows = find_blows(session([(0.002, 50.0)], 1.0), HammerTest(trigger=5.0, pretrigger=0.005))
    with pytest.raises(ValueError, match=r"pretrigger of 0.005\S* s, and 0.001\S* s are rec.*hammer.pretrigger"):
        blows.spectra()


def test_double_hits_overloads_and_blows_cut_short_are_left_out_and_named() -> None:
    recording = session([(0.5, 50), (3.5, 50), (3.5625, 20), (6.5, 80), (9.5, 50), (11.9, 50)], 12.0)
    response = recording.responses.copy()
    after = slice(round(9.4 * RATE), round(10.5 * RATE))
    response[0, after] = np.clip(response[0, after], -0.2 * response.max(), 0.2 * response.max())
    blows = find_blows(
        SampledSignals(RATE, recording.drives, response),
        HammerTest(trigger=5.0, duration=SECONDS),
        [79.0, None],
    )
    words = [hit.rejected.partition(":")[0] for hit in blows.hits]
    assert words == ["", "double hit", "overload", "overload", "cut short"]
    assert "40 % of the force again 62.5 ms later" in blows.hits[1].rejected
    assert "force was cut off" in blows.hits[2].rejected
    assert "response 1 was cut off" in blows.hits[3].rejected
    assert blows.spectra().averages == 1.0


def test_no_blow_at_all_says_what_to_do() -> None:
    recording = session([(0.5, 50.0)], 2.0)
    with pytest.raises(ValueError, match="lower the trigger"):
        find_blows(recording, HammerTest(trigger=500.0))
    doubled = find_blows(session([(0.5, 50.0), (0.52, 40.0)], 2.0), HammerTest(trigger=5.0, duration=1.0))
    with pytest.raises(ValueError, match=r"double hit.*record this point again"):
        doubled.spectra()
    with pytest.raises(ValueError, match="a hammer test has one"):
        find_blows(SampledSignals(RATE, np.vstack([recording.drives] * 2), recording.responses), HammerTest())


def test_a_short_tail_is_told_with_the_length_it_needs() -> None:
    """Loss factor 0.8 % at 180 Hz: a thousandth after ln 1000 / (pi 180 0.008) = 1.53 s."""
    recording = session([(0.1, 50.0)], 0.6, noise=1e-4)
    force = recording.drives[0]
    seen = ringing(np.array([ring(force) for _ in range(3)]), RATE, 0.45)
    assert seen is not None
    assert seen.frequency == pytest.approx(180.0, abs=3.0)
    assert seen.loss_factor == pytest.approx(0.008, rel=0.1)
    assert seen.needed == pytest.approx(1.53, rel=0.1)
    assert "needs a tail of 1." in seen.message(0.45, "lengthen duration")
    assert "it is 0.45 s: lengthen duration" in seen.message(0.45, "lengthen duration")


def test_noise_and_hum_at_the_end_are_no_ringing() -> None:
    rng = np.random.default_rng(4)
    samples = round(3.0 * RATE)
    response = ring(blow(samples, 0.1))
    t = np.arange(samples) / RATE
    hum = 0.02 * np.abs(response).max() * np.sin(2 * np.pi * 50 * t + rng.uniform(0, 6, (4, 1)))
    assert ringing(response + hum, RATE, 2.0) is None
    assert ringing(np.array([response]), RATE, 2.0) is None


@pytest.mark.parametrize("seed", range(8))
def test_noise_after_a_single_blow_is_no_ringing(seed: int) -> None:
    """A tail of 2.8 s holds the decay of 1.53 s of the slowest mode; 0.7 % of noise was taken for ringing."""
    noisy = session([(0.1, 50.0)], 3.0, noise=7e-3, seed=seed).responses
    assert ringing(noisy, RATE, 2.8) is None


def test_signals_that_are_no_measurement() -> None:
    signal = np.sin(np.arange(100.0) / 4.0)
    spoilt = np.where(np.arange(100) == 7, np.nan, signal)
    said = signal_faults(["a", "b", "c", "d"], [signal, 0 * signal, 0 * signal + 3.0, spoilt])
    assert len(said) == 3
    assert "'b': zero throughout" in said[0]
    assert "constant at 3" in said[1]
    assert "sample 8 of 100 is not a finite number" in said[2]
    assert all("unused" in one or "export" in one for one in said)
    assert clipped(np.clip(signal, -0.7, 0.7))
    assert not clipped(signal)
    assert clipped(signal, 0.9)


@pytest.mark.parametrize("levels", [12, 100, 2**15, None])
def test_single_samples_that_were_cut_off_are_an_overload(levels: int | None) -> None:
    """A fifth of the sample rate: no peak is flat for four samples. A few levels alone are no overload."""
    t = np.arange(2000)
    signal = np.exp(-t / 400.0) * np.sin(2.0 * np.pi * 0.2013 * t)

    def read(analogue: NDArray[np.float64]) -> NDArray[np.float64]:
        return analogue if levels is None else np.round(levels * analogue) / levels

    assert clipped(read(np.clip(signal, -0.6, 0.6))) is (levels != 12)
    assert not clipped(read(signal))
    assert not clipped(read(signal * np.exp(t / 400.0)))


@pytest.mark.parametrize("width", [3.0, 10.0])
def test_the_force_window_keeps_a_smooth_pulse_whole(width: float) -> None:
    """Against the spectrum of the pulse itself: raised cosines between samples, of every offset."""
    samples, rate = 2000, 5000.0
    for offset in np.linspace(0.0, 1.0, 5):
        x = (np.arange(samples) - 300.0 - offset) / width
        force = np.where(np.abs(x) < np.pi, 0.5 * (1.0 + np.cos(x)), 0.0)
        recording = SampledSignals(rate, 40.0 * force[None], force[None])
        blows = find_blows(recording, HammerTest(trigger=4.0, pretrigger=0.04, duration=0.3))
        found = np.sqrt(blows.spectra().g_uu[:10, 0, 0].real)
        true = np.abs(np.fft.rfft(40.0 * force[blows.hits[0].start :][: blows.samples]))[:10]
        assert np.abs(found / true - 1.0).max() < 1e-3


def test_the_force_window_knows_of_ac_coupling() -> None:
    """A system that hands the force on, both behind a capacitor: H1 is 1; else its phase is corner / frequency."""
    rate, corner = 8533.0, 0.5
    time = np.arange(round(2.0 * rate)) / rate
    force = 30.0 * np.exp(-(((time - 0.2) / 4e-4) ** 2))
    coupled = lfilter(*butter(1, corner, btype="highpass", fs=rate), force)
    recording = SampledSignals(rate, coupled[None], coupled[None].copy())
    test = HammerTest(trigger=4.0, pretrigger=0.05, duration=1.5)
    found = estimate(find_blows(recording, replace(test, coupling=corner)).spectra())
    inside = (found.frequency > 50.0) & (found.frequency < 600.0)
    assert np.abs(found.h[0, 0, inside] - 1.0).max() < 3e-4  # 1e-2 without
    uncorrected = estimate(find_blows(recording, test).spectra())
    low = (found.frequency > 50.0) & (found.frequency < 100.0)
    turned = np.angle(uncorrected.h[0, 0, low])
    ratio = turned * found.frequency[low] / corner  # 1 of a pulse whose tails the window keeps whole
    assert 0.4 < ratio.min() < ratio.max() < 1.0
