from collections.abc import Callable

import numpy as np
import pytest

from analysis.protocol.sweep import SweepSettings, drive_signal

RATE = 51_200.0 / 6.0


@pytest.mark.parametrize(("kind", "taper"), [("logarithmic", 0.1), ("linear", 0.08)])
def test_frequency_runs_through_the_band_between_the_fades(
    sweep_of: Callable[..., SweepSettings], kind: str, taper: float
) -> None:
    """Held against the frequency's own law: the angle's slope, from the analytic signal at a high rate."""
    sweep = sweep_of(kind=kind, taper=taper)
    rate = 100_000.0
    signal = drive_signal(sweep, 1.0, rate)[: round(sweep.duration * rate)]
    spectrum = np.fft.fft(signal)
    spectrum[signal.size // 2 :] = 0.0
    frequency = np.diff(np.unwrap(np.angle(np.fft.ifft(spectrum)))) * rate / (2.0 * np.pi)
    time = (np.arange(frequency.size) + 0.5) / rate
    share = (time - taper) / (sweep.duration - 2.0 * taper)
    law = 100.0 + 1400.0 * share if kind == "linear" else 100.0 * 15.0**share
    inside = (share > 0.02) & (share < 0.98)
    assert np.max(np.abs(frequency / law - 1.0)[inside]) < 0.01
    middle = np.abs(share - 0.5).argmin()
    assert frequency[middle] == pytest.approx(law[middle], rel=1e-4)


@pytest.mark.parametrize("kind", ["logarithmic", "linear"])
def test_spectrum_is_that_of_a_constant_level_over_the_band(
    sweep_of: Callable[..., SweepSettings], kind: str
) -> None:
    """Stationary phase: |U(f)| = A/2 / sqrt(df/dt); nothing to speak of outside the fades."""
    sweep = sweep_of(kind=kind, duration=10.0, taper=0.4)
    level = 1.7
    signal = drive_signal(sweep, level, RATE)
    spectrum = np.abs(np.fft.rfft(signal)) / RATE
    grid = np.fft.rfftfreq(signal.size, 1.0 / RATE)
    inner = sweep.duration - 2.0 * sweep.taper
    slope = np.full_like(grid, 1400.0 / inner) if kind == "linear" else grid * np.log(15.0) / inner
    inside = (grid > 130.0) & (grid < 1400.0)
    ripple = spectrum[inside] / (level / 2.0 / np.sqrt(slope[inside])) - 1.0
    assert np.sqrt(np.mean(ripple**2)) < 0.02
    low, high = sweep.frequency_range
    outside = (grid < 0.7 * low) | (grid > 1.2 * high)
    assert spectrum[outside].max() < 2e-3 * spectrum[inside].max()


def test_begins_and_ends_at_rest_and_is_silent_in_the_tail(sweep_of: Callable[..., SweepSettings]) -> None:
    sweep = sweep_of()
    signal = drive_signal(sweep, 2.0, RATE)
    assert signal.size == round(2.4 * RATE)
    assert signal[0] == 0.0
    assert not signal[int(np.ceil(2.0 * RATE)) :].any()
    assert 1.99 < np.abs(signal).max() <= 2.0
    steps = np.abs(np.diff(signal))
    assert steps[:20].max() < 0.01  # no click where it begins
    assert steps[round(2.0 * RATE) - 20 :].max() < 0.01


def test_level_only_scales(sweep_of: Callable[..., SweepSettings]) -> None:
    np.testing.assert_allclose(
        drive_signal(sweep_of(), 3.0, RATE), 3.0 * drive_signal(sweep_of(), 1.0, RATE), rtol=1e-12
    )


def test_beyond_half_the_sample_rate_is_refused(sweep_of: Callable[..., SweepSettings]) -> None:
    with pytest.raises(ValueError, match="below half of the sample rate"):
        drive_signal(sweep_of(), 1.0, 3000.0)


@pytest.mark.parametrize("kind", ["burst-random", "multi-sine"])
def test_many_sines_have_an_even_spectrum_in_the_band_and_the_peak_asked_for(
    sweep_of: Callable[..., SweepSettings], kind: str
) -> None:
    sweep = sweep_of(kind=kind, duration=5.0, taper=0.05)
    signal = drive_signal(sweep, 2.0, RATE)
    assert 1.9 < np.abs(signal).max() <= 2.0
    assert signal[0] == 0.0
    assert not signal[int(np.ceil(5.0 * RATE)) :].any()
    # the lines of the burst itself: what fades at both ends hardly changes them, and nothing lies outside the band
    burst = signal[: round(5.0 * RATE)]
    spectrum = np.abs(np.fft.rfft(burst))
    grid = np.fft.rfftfreq(burst.size, 1.0 / RATE)
    inside = (grid > 105.0) & (grid < 1495.0)
    assert np.std(spectrum[inside]) < 0.1 * np.mean(spectrum[inside])
    assert spectrum[(grid < 50.0) | (grid > 1550.0)].max() < 0.03 * np.mean(spectrum[inside])


@pytest.mark.parametrize("kind", ["burst-random", "multi-sine"])
def test_many_sines_are_those_of_their_formula(sweep_of: Callable[..., SweepSettings], kind: str) -> None:
    """Summed one by one at a few moments, up to the level, at a rate that no duration is a multiple of."""
    sweep = sweep_of(kind=kind, duration=1.0, taper=0.1)
    rate = 7777.7
    signal = drive_signal(sweep, 1.0, rate)
    at = np.array([1000, 2500, 4321, 6000])
    numbers = np.arange(100, 1501)
    order = np.arange(1, numbers.size + 1)
    phase = np.pi * order * (order - 1) / numbers.size
    if kind == "burst-random":
        phase = np.random.default_rng(20).uniform(0.0, 2.0 * np.pi, numbers.size)
    summed = np.array([np.sin(2.0 * np.pi * numbers * n / rate + phase).sum() for n in at])
    ratio = signal[at] / summed
    assert np.ptp(ratio) < 1e-8 * abs(ratio[0])


def test_schroeders_phases_keep_the_peak_low(sweep_of: Callable[..., SweepSettings]) -> None:
    crest = {}
    for kind in ("burst-random", "multi-sine"):
        signal = drive_signal(sweep_of(kind=kind, duration=5.0, taper=0.05), 1.0, RATE)[: round(5.0 * RATE)]
        crest[kind] = np.abs(signal).max() / signal.std()
    assert crest["multi-sine"] < 2.0
    assert crest["burst-random"] > 3.5


def test_too_many_sines_are_refused(sweep_of: Callable[..., SweepSettings]) -> None:
    with pytest.raises(ValueError, match="too many sines"):
        sweep_of(kind="multi-sine", duration=600.0)
