"""FRF, variance and coherence of one sweep, at each of its outputs."""

import numpy as np
from numpy.typing import NDArray

from analysis.recordings.campaign import Sweep
from analysis.recordings.h1 import sweep_h1

SAMPLES, DIP = 1024, slice(200, 206)


def sweep_of(drive: NDArray[np.float64], *responses: NDArray[np.float64]) -> Sweep:
    rows = np.array(responses).astype("f4")
    return Sweep(0, "up", 1.0, 20.0, 20.0, "2026-01-01T00:00:00", drive.astype("f4"), rows)


def white(rng: np.random.Generator, repeats: int, size: NDArray[np.float64]) -> NDArray[np.float64]:
    """Repeats of a drive with random phases and a given size on every line."""
    spectrum = size * np.exp(2j * np.pi * rng.random(size.size))
    return np.tile(np.fft.irfft(spectrum, SAMPLES), (repeats, 1))


def test_each_output_has_its_own_frf_and_coherence() -> None:
    """Coherence is the share of the response's power that the drive explains, here 1/2 and 1/5."""
    rng, lines = np.random.default_rng(5), slice(20, 480)
    drive = white(rng, 200, np.ones(SAMPLES // 2 + 1))
    power = 1.0 / SAMPLES  # of a sample's noise: 1 on every line, as the drive's
    noise = np.sqrt(power) * rng.standard_normal((2, *drive.shape))
    sweep = sweep_of(drive, drive + noise[0], -3.0 * drive + 6.0 * noise[1])
    found = sweep_h1(sweep, lines, np.zeros(460, dtype=bool), ("S1", "S2"))
    np.testing.assert_allclose(found.h.mean(axis=1), [1.0, -3.0], atol=0.05)
    np.testing.assert_allclose(found.coherence.mean(axis=1), [0.5, 0.2], atol=0.01)
    np.testing.assert_allclose(found.variance.mean(axis=1), [1.0 / 200, 36.0 / 200], rtol=0.05)
    assert found.repeats_dof == 2 * (200 - 2)
    assert found.notes == []


def test_noise_of_the_response_is_told_where_the_drive_dips() -> None:
    """A shaker is weak at a resonance: white noise of the response weighs a hundred times more on those lines."""
    rng, noise = np.random.default_rng(3), 1e-3
    size = np.ones(SAMPLES // 2 + 1)
    size[DIP] = 0.1
    drive = white(rng, 4, size)
    nothing, lines = np.zeros(300, dtype=bool), slice(100, 400)
    errors, stated = [], []
    for _ in range(100):
        response = drive + noise * rng.standard_normal(drive.shape)
        found = sweep_h1(sweep_of(drive, response), lines, nothing, ("S1",))
        errors.append(np.abs(found.h[0] - 1.0) ** 2)
        stated.append(found.variance[0])
    real, stated = np.mean(errors, axis=0), np.mean(stated, axis=0)
    dip = np.zeros(300, dtype=bool)
    dip[DIP.start - lines.start : DIP.stop - lines.start] = True
    for part in (dip, ~dip):
        np.testing.assert_allclose(stated[part].mean() / real[part].mean(), 1.0, atol=0.15)
    np.testing.assert_allclose(stated[dip] / np.median(stated), 100.0, rtol=0.05)


def test_no_coherence_is_above_one() -> None:
    """Without noise it is 1, and rounding puts half of the lines above."""
    rng = np.random.default_rng(7)
    drive = white(rng, 3, np.ones(SAMPLES // 2 + 1))
    found = sweep_h1(sweep_of(drive, 0.7 * drive), slice(20, 480), np.zeros(460, dtype=bool), ("S1",))
    assert found.coherence.max() <= 1.0
    np.testing.assert_allclose(found.coherence, 1.0, rtol=1e-9)
