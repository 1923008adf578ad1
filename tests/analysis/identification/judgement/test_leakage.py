"""Leakage of segments: its closed form against a convolution, its correction over many records of known modes."""

from typing import get_args

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.estimation.estimators import Estimator, Segments, estimate
from analysis.estimation.spectra import SampledSignals, welch
from analysis.estimation.windows import Shape, segment_window
from analysis.identification.automatic import identify
from analysis.identification.judgement.leakage import seen_through, without_leakage
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.pole_residue import ResidualTerms
from analysis.identification.settings import Settings

RATE, SECONDS, BEFORE = 1024.0, 60.0, 8.0
F = np.array([52.0, 101.0, 168.0, 243.0, 310.0])
ZETA = np.array([0.006, 0.008, 0.004, 0.006, 0.005])
POLES = 2.0 * np.pi * F * (-ZETA + 1j * np.sqrt(1.0 - ZETA**2))
RESIDUES = np.array([0.9, -1.6, 1.2, 2.1, -1.4]) / (2j * POLES.imag)


def true_modes() -> Modes:
    return Modes(
        poles=POLES,
        residues=RESIDUES[None],
        covariance=np.tile(1e-6 * np.eye(2), (len(POLES), 1, 1)),
        terms=ResidualTerms("none", (), False),
        coefficients=np.zeros((1, 0), dtype=complex),
        status=("kept",) * len(POLES),
        reason=("",) * len(POLES),
        band=(20.0, 400.0),
        misfit=0.0,
        lines=1,
    )


@pytest.mark.parametrize("window", get_args(Shape))
@pytest.mark.parametrize("estimator", get_args(Estimator))
def test_what_segments_show_is_the_frf_smoothed_by_the_power_of_the_window(
    window: Shape, estimator: Estimator
) -> None:
    """Sums over a grid of 32 points per line, 400 lines to either side, with the window's transform."""
    seconds, fine, reach = 2.0, 32, 400
    frequency = np.arange(90.0, 115.0, 1.0 / seconds)
    weight = segment_window(window, 4096)
    kernel = np.abs(np.fft.fft(weight, 4096 * fine)) ** 2
    kernel = np.concatenate([kernel[-fine * reach :], kernel[: fine * reach + 1]])
    kernel /= kernel.sum()
    offsets = np.arange(-fine * reach, fine * reach + 1) / (fine * seconds)
    cross, power = np.empty((2, len(frequency)), dtype=complex)
    for line, f in enumerate(frequency):
        h = true_modes().synthesis(f - offsets)[0]
        cross[line], power[line] = (kernel * h).sum(), (kernel * np.abs(h) ** 2).sum()
    wanted = {"h1": cross, "h2": power / cross.conj(), "hv": cross * np.sqrt(power) / np.abs(cross)}[estimator]
    shown = seen_through(Segments(seconds, window, estimator), true_modes(), frequency)[0]
    np.testing.assert_allclose(shown, wanted, atol=2e-3 * np.abs(wanted).max())


def record(seed: int, noise: float) -> SampledSignals:
    rng = np.random.default_rng(seed)
    count = round((SECONDS + BEFORE) * RATE)
    force = rng.standard_normal(count)
    h = true_modes().synthesis(np.fft.rfftfreq(2 * count, 1.0 / RATE))[0]
    motion = np.fft.irfft(np.fft.rfft(force, 2 * count) * h, 2 * count)[:count]
    u, y = np.stack([force, motion])[:, round(BEFORE * RATE) :]
    y = y + noise * y.std() * rng.standard_normal(len(y))
    return SampledSignals(RATE, u[None], y[None])


def found(seed: int, segments: Segments, noise: float) -> tuple[Measured, Modes]:
    frf = estimate(welch(record(seed, noise), segments.seconds, segments.window), segments.estimator)
    band = (frf.frequency > 20.0) & (frf.frequency < 400.0)
    assert frf.variance is not None
    lines = Measured(frf.frequency[band], frf.h[:, 0, band], frf.variance[:, 0, band])
    return lines, identify(lines, Settings(mains=None))


def errors(modes: Modes) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Of log |pole| and log damping ratio of the five modes, and in their standard deviations; (5, 2) each."""
    poles, spread = modes.poles[modes.real], modes.covariance[modes.real]
    off = np.column_stack([np.abs(poles) / np.abs(POLES), -poles.real / np.abs(poles) / ZETA])
    return np.log(off), np.log(off) / np.sqrt(np.diagonal(spread, axis1=1, axis2=2))


@pytest.mark.parametrize(
    ("seconds", "window", "estimator", "rest", "most"),
    [
        (4.0, "hann", "h1", 0.1, 1.25),
        (2.0, "hann", "h1", 0.1, 1.25),
        (2.0, "rectangular", "h1", 0.1, 1.25),
        (2.0, "hann", "h2", 0.6, 1.4),
        (2.0, "hann", "hv", 0.6, 1.4),
    ],
)
def test_damping_is_within_its_deviation_without_leakage(
    seconds: float, window: Shape, estimator: Estimator, rest: float, most: float
) -> None:
    """Over twelve records; with leakage damping was 2 to 15 % too high, two to five standard deviations."""
    segments, before, after, scaled = Segments(seconds, window, estimator), [], [], []
    for seed in range(12):
        lines, modes = found(seed, segments, 0.03)
        before.append(errors(modes)[0])
        corrected = without_leakage(modes, lines.lines(), segments)
        assert corrected.corrected
        off, deviations = errors(corrected.modes)
        after.append(off)
        scaled.append(deviations)
    assert abs(np.mean(after, axis=0)[:, 1].mean()) < rest * np.mean(before, axis=0)[:, 1].mean()
    assert np.sqrt(np.square(scaled).mean(axis=(0, 1)))[1] < most
    assert np.sqrt(np.square(scaled).mean(axis=(0, 1)))[0] < 1.5


def test_leakage_that_cannot_be_corrected_is_in_the_deviation() -> None:
    """Segments of half a second: a line is wider than the modes."""
    segments = Segments(0.5, "flattop")
    lines, _ = found(0, segments, 0.03)
    wide = true_modes()
    corrected = without_leakage(wide, lines.lines(), segments)
    assert not corrected.corrected
    np.testing.assert_array_equal(corrected.modes.poles, POLES)
    assert (np.sqrt(corrected.modes.covariance[:, 1, 1]) >= np.abs(corrected.bias[:, 1])).all()
    assert (corrected.bias[:, 1] > 0.3).all()
