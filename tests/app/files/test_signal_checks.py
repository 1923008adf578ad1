import numpy as np
import pytest
from numpy.typing import NDArray

from app.files.campaigns.tdms_sweep import faults, flat_topped
from drivers.ni.modules import NI_9234

RATE = 51_200.0 / 6


def sweep(amplitude: float, noise: float = 0.0) -> NDArray[np.float64]:
    time = np.arange(int(2.0 * RATE)) / RATE
    phase = 2 * np.pi * 100.0 * 2.0 / np.log(15.0) * (15.0 ** (time / 2.0) - 1.0)
    return amplitude * np.sin(phase) + noise * np.random.default_rng(3).standard_normal(time.size)


def quantised(samples: NDArray[np.float64], quantum: float) -> NDArray[np.float32]:
    return (quantum * np.round(samples / quantum)).astype(np.float32)


@pytest.mark.parametrize("bits", [12, 16, 24])
@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_whole_peaks_pass_at_any_resolution(bits: int, noise: float) -> None:
    assert flat_topped(quantised(sweep(1.0, noise), 10.0 / 2**bits)) == 0


def test_slow_peaks_held_by_a_coarse_converter_pass() -> None:
    slow = quantised(np.sin(2 * np.pi * 5.0 * np.arange(20_000) / 51_200.0), 10.0 / 2**12)
    longest = np.diff(np.flatnonzero(np.diff(slow) != 0)).max()
    assert longest > 20  # the tops are flat indeed, and yet whole
    assert flat_topped(slow) == 0


@pytest.mark.parametrize("level", [0.2, 0.9, 0.99])
@pytest.mark.parametrize("sides", ["both", "above"])
def test_cut_peaks_are_found_below_full_scale(level: float, sides: str) -> None:
    cut = np.clip(quantised(sweep(1.0, 1e-4), 6e-7), -level if sides == "both" else -2.0, np.float32(level))
    held = np.count_nonzero(np.abs(cut) == np.float32(level))
    found = flat_topped(cut)
    assert 0.3 * held < found <= held


def told(samples: NDArray[np.floating], module: object = NI_9234) -> str:
    return "; ".join(f"{seen} / {allowed}" for seen, allowed in faults(samples, module))  # type: ignore[arg-type]


def test_good_channel_has_no_fault() -> None:
    assert told(quantised(sweep(1.0, 1e-3), NI_9234.quantum)) == ""
    assert told(sweep(100.0), None) == ""  # nothing known of the module: no range to be outside of


def test_full_scale_is_the_modules() -> None:
    assert "9234" in told(np.clip(sweep(7.0), -5.0, 5.0))
    assert "clipped" in told(sweep(5.2))
    assert told(sweep(4.9)) == ""


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_samples_that_are_no_numbers_are_counted_and_placed(value: float) -> None:
    samples = sweep(1.0)
    samples[[517, 900]] = value
    assert f"{value} at sample 517 (2 of" in told(samples)


def test_silence_is_told() -> None:
    assert "connected" in told(np.zeros(1000))
    assert "connected" in told(np.full(1000, 0.3))
    assert "connected" in told(np.zeros(1000), None)
    assert "connected" in told(NI_9234.quantum * np.random.default_rng(1).integers(-3, 4, 1000).astype(float))
