"""Signals of shaker and hammer tests as their generators make them, told apart."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import butter, lfilter

from analysis.estimation.spectra import SampledSignals, is_impacts, is_swept, leaks, period

RATE = 1024
SECONDS = 48

Signal = NDArray[np.float64]


def noise(seconds: float = SECONDS, seed: int = 0) -> Signal:
    return np.random.default_rng(seed).standard_normal(round(seconds * RATE))


def chirp(seconds: float) -> Signal:
    t = np.arange(round(seconds * RATE)) / RATE
    return np.asarray(np.sin(2 * np.pi * (20 * t + 190 / seconds * t**2)))


def bursts() -> Signal:
    return np.concatenate([np.append(noise(2, seed), np.zeros(2 * RATE)) for seed in range(SECONDS // 4)])


def hits() -> Signal:
    """Of a hand: neither their heights nor the times between them repeat."""
    rng, force = np.random.default_rng(2), np.zeros(SECONDS * RATE)
    force[np.cumsum(rng.integers(2 * RATE, 4 * RATE, 12))] = rng.uniform(40.0, 80.0, 12)
    return force


def low_passed() -> Signal:
    return np.asarray(lfilter(*butter(4, 0.05), noise()))


def recording(force: Signal, seed: int = 1) -> SampledSignals:
    """With a response that decays within half a second, and 1 % of noise in both."""
    decay = np.exp(-9 * np.arange(RATE) / RATE) * np.sin(0.5 * np.arange(RATE))
    answer = np.convolve(force, decay)[: len(force)]
    rng = np.random.default_rng(seed)
    signals = [one + 0.01 * one.std() * rng.standard_normal(len(one)) for one in (force, answer)]
    return SampledSignals(RATE, signals[0][None], signals[1][None])


@pytest.mark.parametrize("force", [noise(), bursts(), low_passed(), hits(), chirp(SECONDS)])
def test_signals_that_never_repeat_have_no_period(force: Signal) -> None:
    assert period(recording(force).drives) is None


@pytest.mark.parametrize("one", [chirp(8), chirp(1), noise(4), np.append(chirp(1), np.zeros(2 * RATE))])
def test_the_period_is_found_to_the_sample(one: Signal) -> None:
    force = np.tile(one, SECONDS * RATE // len(one))
    assert period(recording(force).drives) == len(one)


@pytest.mark.parametrize("force", [noise(), bursts(), low_passed(), np.tile(chirp(1), SECONDS), hits()])
def test_only_a_single_sweep_drives_its_lines_in_turn(force: Signal) -> None:
    assert not is_swept(recording(force).drives)
    assert is_swept(recording(chirp(SECONDS)).drives)


def test_hits_are_told_from_what_a_shaker_plays() -> None:
    assert is_impacts(recording(hits()).drives[0])
    assert is_impacts(-hits() + 3.0)
    assert not any(is_impacts(recording(force).drives[0]) for force in (noise(), bursts(), chirp(SECONDS)))


def test_noise_leaks_and_whole_bursts_periods_and_sweeps_do_not() -> None:
    assert leaks(recording(noise()), 4.0, "hann")
    assert leaks(recording(noise()), 4.0, "rectangular", 0.0)
    assert leaks(recording(bursts()), 2.0, "hann")
    assert not leaks(recording(bursts()), 4.0, "rectangular", 0.0)
    assert leaks(recording(bursts()), 4.0, "rectangular", 0.5)
    assert not leaks(recording(np.tile(chirp(8), 6)), 8.0, "rectangular", 0.0)
    assert not leaks(recording(chirp(SECONDS)), SECONDS, "rectangular", 0.0)


@pytest.mark.parametrize(("force", "needed"), [(np.tile(chirp(8), 6), "8"), (chirp(SECONDS), "48")])
def test_segments_that_cut_a_period_or_a_sweep_are_refused_with_those_that_do_not(
    force: Signal, needed: str
) -> None:
    with pytest.raises(ValueError, match=rf'segments.seconds = {needed}, segments.window = "rectangular"'):
        leaks(recording(force), 2.0, "hann")
