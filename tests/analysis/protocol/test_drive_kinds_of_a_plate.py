"""A simulated plate driven by each kind of drive: H1 is its transfer within the noise, and nothing leaks."""

from collections.abc import Callable

import numpy as np
import pytest

from analysis.arrays import Real
from analysis.protocol.sweep import SweepSettings, drive_signal
from analysis.recordings.h1 import h1

RATE = 51_200.0 / 6.0
MODES = np.array([140.0, 310.0, 620.0, 990.0, 1330.0])
"""Hz; each with a damping ratio of 2 %, and a residue of its own sign."""
ZETA = 0.02


def transfer(frequency: Real) -> Real:
    """Mobility of a plate with five modes, in closed form."""
    omega, natural = 2.0 * np.pi * frequency[:, None], 2.0 * np.pi * MODES
    sign = np.array([1.0, -1.0, 1.0, 1.0, -1.0])
    each = 1j * omega * sign * 100.0 / (natural**2 - omega**2 + 2j * ZETA * natural * omega)
    return np.asarray(each.sum(axis=1))


def answered(drive: Real, noise: float, rng: np.random.Generator) -> Real:
    """Return the response, computed over four times the record, so that what rings on is cut off, not wrapped."""
    size = 4 * drive.size
    h = transfer(np.fft.rfftfreq(size, 1.0 / RATE))
    whole = np.fft.irfft(h * np.fft.rfft(drive, size), size)
    return np.asarray(whole[: drive.size] + noise * rng.standard_normal(drive.size))


@pytest.mark.parametrize("kind", ["burst-random", "multi-sine", "logarithmic"])
def test_h1_is_the_transfer_within_the_noise(sweep_of: Callable[..., SweepSettings], kind: str) -> None:
    sweep = sweep_of(kind=kind, duration=2.0, taper=0.1, tail=1.0)
    rng = np.random.default_rng(1)
    drive = drive_signal(sweep, 1.0, RATE)
    repeats, noise = 40, 0.02
    drives = np.tile(drive, (repeats, 1)).astype(np.float32)
    responses = np.array([answered(drive, noise, rng) for _ in range(repeats)]).astype(np.float32)
    h, variance, _ = h1(drives, responses)
    grid = np.fft.rfftfreq(drive.size, 1.0 / RATE)
    inside = (grid > 105.0) & (grid < 1490.0)
    spread = repeats * np.abs(h - transfer(grid))[inside] ** 2 / variance[inside]  # that of a single repeat
    # of complex noise |error|^2 over its variance has the mean 1, its scatter over these lines 1 / sqrt(lines)
    assert np.mean(spread) == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("kind", ["burst-random", "multi-sine"])
def test_without_noise_what_is_left_is_what_rings_beyond_the_record(
    sweep_of: Callable[..., SweepSettings], kind: str
) -> None:
    sweep = sweep_of(kind=kind, duration=2.0, taper=0.1, tail=1.0)
    drive = drive_signal(sweep, 1.0, RATE)
    response = answered(drive, 0.0, np.random.default_rng(0))
    h, _, _ = h1(drive[None], response[None])
    grid = np.fft.rfftfreq(drive.size, 1.0 / RATE)
    inside = (grid > 105.0) & (grid < 1490.0)
    true = transfer(grid)[inside]
    assert np.median(np.abs(h[inside] - true)) < 1e-4 * np.abs(true).max()
