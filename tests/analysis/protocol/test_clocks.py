"""Two clocks that differ: found from the drive as recorded, and no reason to refuse a sweep."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.protocol.sweep import SweepSettings, clock_difference, compare_drive, drive_signal, stretched

RATE = 51_200.0 / 6.0
MINUTE = {"band": (100.0, 2000.0), "duration": 60.0}
SEEN = 0.1
"""Samples at a record's end."""
SWEEPS: list[dict[str, Any]] = [
    {},
    MINUTE,
    {**MINUTE, "kind": "linear"},
    {**MINUTE, "band": (1000.0, 1100.0)},
    {"kind": "burst-random", "duration": 10.0},
    {"kind": "multi-sine", "duration": 10.0},
]


def recorded(sweep: SweepSettings, difference: float, noise: float = 0.0) -> NDArray[np.float32]:
    """(2, M) the sweep in closed form at the moments another clock records it, 38.4 and 38.7 samples late."""
    rng = np.random.default_rng(3)
    played = drive_signal(sweep, 1.0, RATE / (1.0 + difference))
    size = round(sweep.record * RATE)
    cut = np.pad(played, (0, size))[:size]
    grid = np.fft.rfftfreq(size)
    late = [np.fft.irfft(np.fft.rfft(cut) * np.exp(-2j * np.pi * grid * delay), size) for delay in (38.4, 38.7)]
    return (np.stack(late) + noise * rng.standard_normal((2, size))).astype(np.float32)


@pytest.mark.parametrize("settings", SWEEPS, ids=["2 s", "60 s", "linear", "narrow", "burst", "multi-sine"])
@pytest.mark.parametrize("difference", [1e-4, -1e-4, 5e-6, 2.9e-4])
def test_the_difference_is_found_and_taken_out(
    sweep_of: Callable[..., SweepSettings], settings: dict[str, Any], difference: float
) -> None:
    sweep = sweep_of(**settings)
    played = drive_signal(sweep, 1.0, RATE)
    drives = recorded(sweep, difference, noise=0.01)
    found = clock_difference(drives, played, RATE, sweep)
    assert abs(found - difference) * played.size < SEEN
    reference = stretched(played, found, RATE, sweep, 1.0) if found else played
    for drive, delay in zip(drives, (38.4, 38.7), strict=True):
        gain, late, correlation = compare_drive(drive, reference, RATE, sweep.frequency_range)
        assert gain == pytest.approx(1.0, abs=2e-3)
        assert late == pytest.approx(delay, abs=0.1)
        assert correlation > (0.9996 if sweep.kind == "burst-random" else 0.9998)  # its rms is a fifth of its peak


@pytest.mark.parametrize("settings", SWEEPS, ids=["2 s", "60 s", "linear", "narrow", "burst", "multi-sine"])
def test_one_clock_shows_no_difference(sweep_of: Callable[..., SweepSettings], settings: dict[str, Any]) -> None:
    sweep = sweep_of(**settings)
    assert clock_difference(recorded(sweep, 0.0, 5e-4), drive_signal(sweep, 1.0, RATE), RATE, sweep) == 0.0


def test_what_is_no_copy_of_the_drive_has_no_clock_beyond_that_of_crystals(
    sweep_of: Callable[..., SweepSettings],
) -> None:
    sweep = sweep_of()
    played = drive_signal(sweep, 1.0, RATE)
    noise = np.random.default_rng(5).standard_normal((3, played.size))
    assert abs(clock_difference(noise, played, RATE, sweep)) <= 3e-4
    assert clock_difference(np.zeros((2, played.size)), played, RATE, sweep) == 0.0


@pytest.mark.parametrize("kind", ["logarithmic", "linear"])
def test_the_moment_at_which_a_sweep_passes_a_frequency(sweep_of: Callable[..., SweepSettings], kind: str) -> None:
    """Zero crossings: between two of them lies half a period of the frequency passed there."""
    sweep = sweep_of(kind=kind, duration=20.0)
    rate = 200_000.0
    played = drive_signal(sweep, 1.0, rate)[: round(20.0 * rate)]
    index = np.flatnonzero(np.diff(np.sign(played)) != 0)[50:-50]
    crossing = (index + played[index] / (played[index] - played[index + 1])) / rate
    frequency = 0.5 / np.diff(crossing)
    middle = 0.5 * (crossing[1:] + crossing[:-1])
    assert sweep.timing.passed_at(frequency) == pytest.approx(middle, abs=2e-3)
