"""Lines taken by mains hum, at the nominal frequency and at others."""

import numpy as np
import pytest

from analysis.recordings.mains import likely_mains, mains_lines, other_fundamentals

FREQUENCY = np.arange(100.0, 1500.0, 0.5)


def noise(seed: int, sweeps: int = 20, channels: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).exponential(1.0, (sweeps, channels, FREQUENCY.size))


def with_hum(rough: np.ndarray, fundamental: float, power: float) -> np.ndarray:
    loud = rough.copy()
    harmonics = fundamental * np.arange(np.ceil(100.0 / fundamental), 1499.0 / fundamental)
    loud[..., np.round((harmonics - 100.0) / 0.5).astype(int)] += power
    return loud


def test_a_line_and_a_half_around_each_harmonic() -> None:
    assert mains_lines(np.array([119.0, 120.0, 121.0]), 60.0, 2.0).tolist() == [False, True, False]


def test_noise_is_no_hum() -> None:
    nothing = np.zeros(FREQUENCY.size, dtype=bool)
    assert all(other_fundamentals(FREQUENCY, noise(seed), nothing) == [] for seed in range(5))


def test_noise_that_channels_share_is_no_hum() -> None:
    """Eleven points divided by one measured force have its noise in common."""
    nothing = np.zeros(FREQUENCY.size, dtype=bool)
    for seed in range(8):
        shared = 0.9 * noise(seed, 5) + 0.1 * noise(seed + 100, 5, 11)
        assert other_fundamentals(FREQUENCY, shared, nothing) == []


def test_a_faint_steady_hum_and_a_loud_one_in_a_single_sweep_are_found() -> None:
    nothing = np.zeros(FREQUENCY.size, dtype=bool)
    (found,) = other_fundamentals(FREQUENCY, with_hum(noise(1), 49.87, 4.0), nothing)
    assert abs(found - 49.87) < 0.02
    once = noise(2)
    once[3] = with_hum(once[3], 60.04, 40.0)
    assert all(abs(hum - 60.04) < 0.02 for hum in other_fundamentals(FREQUENCY, once, nothing))
    assert other_fundamentals(FREQUENCY, once, nothing)


def test_a_hum_on_excluded_lines_is_none() -> None:
    excluded = mains_lines(FREQUENCY, 50.0, 2.0)
    assert other_fundamentals(FREQUENCY, with_hum(noise(3), 50.0, 50.0), excluded) == []


@pytest.mark.parametrize(("hum", "expected"), [(60.03, True), (57.0, False), (None, False)])
def test_a_grid_is_found_by_few_harmonics(hum: float | None, expected: bool) -> None:
    """Six harmonics in band: too few to be sure of any fundamental, enough for that of a grid."""
    band = FREQUENCY < 450.0
    excluded = mains_lines(FREQUENCY, 50.0, 2.0)[band]
    for seed in range(5):
        rough = noise(seed) if hum is None else with_hum(noise(seed), hum, 30.0)
        found = other_fundamentals(FREQUENCY[band], rough[..., band], excluded)
        assert bool(found) == expected
        assert all(abs(one - 60.03) < 0.1 for one in found)


@pytest.mark.parametrize("hum", [50.0, 60.0, None])
def test_the_grid_is_told_from_frfs_with_its_hum(hum: float | None) -> None:
    """Odd harmonics of a tenth, noise of a hundredth, and two sharp resonances, one of them on a harmonic."""
    rng = np.random.default_rng(8)
    f = np.arange(20.0, 1000.0, 0.5)
    h = 1e4 / (150.0**2 - f**2 + 1j * f) + 1e4 / (433.0**2 - f**2 + 2j * f)
    h = h + 0.01 * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size))
    if hum is not None:
        h[np.searchsorted(f, hum * np.arange(1, 1000 / hum, 2))] += 0.1
    assert likely_mains(f, h[None]) == hum


def test_sharp_resonances_near_harmonics_are_no_hum() -> None:
    """A short hammer record, lines 2.5 Hz apart: three resonances of a line near odd multiples of 60 Hz."""
    f = np.arange(30.0, 600.0, 2.53)
    rng = np.random.default_rng(0)
    resonances = ((61.3, 1.0), (149.0, 1.2), (298.0, 3.4), (417.0, 2.5))
    h = np.sum([f**2 / (f0**2 - f**2 + 1j * width * f) for f0, width in resonances], axis=0)
    h = h + 1e-3 * (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size))
    assert likely_mains(f, h[None]) is None
