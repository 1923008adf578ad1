"""Weak and strong hits: a linear structure is left in peace, one that softens is named."""

import numpy as np
import pytest

from analysis.estimation.agreement import of_hits, of_records
from analysis.estimation.spectra import SampledSignals, welch

RATE = 1024.0
LINES = np.fft.rfftfreq(2048, 1.0 / RATE)


def frf(frequency: np.ndarray) -> np.ndarray:
    return 1.0 / (frequency**2 - LINES**2 + 2j * 0.01 * frequency * LINES)


def hits(rng: np.random.Generator, levels: np.ndarray, softening: float) -> tuple[np.ndarray, np.ndarray]:
    """Blocks of an oscillator at 62 Hz whose frequency falls with the level, and of a place hit that varies."""
    pulse = np.exp(-(((np.arange(2048) / RATE - 0.02) / 1e-3) ** 2))
    drives, answers = [], []
    for level in levels:
        u = level * pulse + 1e-3 * rng.standard_normal(2048)
        h = frf(62.0 * (1.0 - softening * level)) * (1.0 + 0.01 * rng.standard_normal())
        answers.append(np.fft.irfft(h * np.fft.rfft(u)) + 1e-8 * rng.standard_normal(2048))
        drives.append(u)
    return np.array(drives)[:, None], np.array(answers)[:, None]


@pytest.mark.parametrize("count", [6, 10, 30])
def test_a_structure_that_softens_is_named(count: int) -> None:
    levels = np.linspace(2.5, 5.0, count) if count > 6 else np.repeat([2.5, 5.0], 3)
    found = of_hits(*hits(np.random.default_rng(0), levels, 1e-3), levels)
    assert found is not None
    assert (found.low, found.high) == (2.5, 5.0)
    assert "drives of 2.5 to 5 N are averaged" in found.message("N")


def test_a_linear_one_rarely_is_and_equal_levels_are_not_compared() -> None:
    """Of 200 tests with four to twelve hits one in a thousand is expected."""
    rng = np.random.default_rng(1)
    named = 0
    for count in (4, 6, 8, 12) * 50:
        levels = rng.uniform(2.5, 5.0, count)
        named += of_hits(*hits(rng, levels, 0.0), levels) is not None
    assert named <= 3
    same = np.full(8, 4.0)
    assert of_hits(*hits(rng, same, 1e-3), same) is None


@pytest.mark.parametrize(("softening", "differs"), [(0.0, False), (2e-3, True)])
def test_records_of_a_shaker_at_two_levels(softening: float, differs: bool) -> None:
    rng = np.random.default_rng(2)
    grid = np.fft.rfftfreq(32768, 1.0 / RATE)
    parts = []
    for level in (1.0, 5.0):
        u = level * rng.standard_normal(32768)
        f = 62.0 * (1.0 - softening * level)
        y = np.fft.irfft(np.fft.rfft(u) / (f**2 - grid**2 + 2j * 0.01 * f * grid))
        y += 0.01 * y.std() * rng.standard_normal(32768)
        parts.append(welch(SampledSignals(RATE, u[None], y[None]), 2.0))
    assert (of_records(parts, np.array([1.0, 5.0])) is not None) == differs


@pytest.mark.parametrize(("softening", "differs"), [(0.0, False), (2e-3, True)])
def test_records_of_one_sweep_each_are_compared_by_the_noise_between_lines(
    softening: float, differs: bool
) -> None:
    """Nothing is averaged within a record; the sweep ends at rest, its force has noise of its own."""
    count, named = 8192, 0
    time = np.arange(count) / RATE
    sweep = np.where(time < 6.0, np.sin(2 * np.pi * (20.0 + 12.0 * time) * time), 0.0)
    lines = np.fft.rfftfreq(count, 1.0 / RATE)
    for seed in range(40):
        rng = np.random.default_rng(seed)
        parts = []
        for level in (1.0, 2.0):
            f = 62.0 * (1.0 - softening * (level - 1.0))
            h = 1.0 / (f**2 - lines**2 + 2j * 0.02 * f * lines)
            u = level * sweep
            y = np.fft.irfft(h * np.fft.rfft(u))
            u = u + 1e-3 * rng.standard_normal(count)
            y = y + 3e-3 * np.sqrt(np.mean(y**2)) * rng.standard_normal(count)
            parts.append(welch(SampledSignals(RATE, u[None], y[None]), count / RATE, "rectangular", 0.0))
        named += of_records(parts, np.array([1.0, 2.0])) is not None
    assert named == 40 if differs else named <= 1


def test_lines_of_noise_alone_are_not_compared() -> None:
    """A plate that answers up to 200 Hz under a soft tip, recorded up to 512 Hz: of 100 tests none is expected.

    If the lines are chosen by their own variance, chance chooses those of noise that differ most: 9 are told.
    """
    rng = np.random.default_rng(2)
    pulse = np.exp(-(((np.arange(2048) / RATE - 0.02) / 1.8e-3) ** 2))
    low = np.where(LINES < 200.0, frf(62.0), 0.0)
    named = 0
    for _ in range(100):
        levels = rng.uniform(2.0, 5.0, 5)
        drives = levels[:, None] * pulse
        answers = np.fft.irfft(low * np.fft.rfft(drives, axis=1), axis=1)
        answers = answers + 1e-7 * rng.standard_normal(answers.shape)
        named += of_hits(drives[:, None], answers[:, None], levels) is not None
    assert named <= 1
