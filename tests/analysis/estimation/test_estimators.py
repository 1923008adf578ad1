"""H1, H2 and Hv against known filters and their known biases; the variance against repeated estimates."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from analysis.estimation.estimators import estimate
from analysis.estimation.spectra import SampledSignals, pooled, welch
from analysis.estimation.windows import effective_averages, segment_window

RATE = 1000.0
B, A = [0.3, 0.1], [1.0, -0.9, 0.5]
OTHER = ([0.0, 0.2, -0.1], [1.0, 0.4])


def gain(b: list[float], a: list[float], frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
    z = np.exp(-2j * np.pi * frequency / RATE)
    return np.asarray(sum(c * z**n for n, c in enumerate(b)) / sum(c * z**n for n, c in enumerate(a)))


def noisy(
    rng: np.random.Generator, samples: int, at_drive: float = 0.0, at_response: float = 0.0
) -> SampledSignals:
    u = rng.standard_normal(samples)
    y = lfilter(B, A, u)
    u = u + at_drive * rng.standard_normal(samples)
    return SampledSignals(RATE, u[None], (y + at_response * y.std() * rng.standard_normal(samples))[None])


@pytest.mark.parametrize("estimator", ["h1", "h2", "hv"])
def test_every_estimator_finds_a_filter_without_noise(estimator: str) -> None:
    found = estimate(welch(noisy(np.random.default_rng(0), 200_000), 0.5), estimator)  # type: ignore[arg-type]
    np.testing.assert_allclose(found.h[0, 0], gain(B, A, found.frequency), rtol=0.02)
    assert found.coherence.min() > 0.999


def test_noise_of_the_drive_biases_h1_not_h2_and_hv_between() -> None:
    """White noise of a tenth of the power: H1 is 1/1.1 of the truth; that of the response biases none."""
    rng = np.random.default_rng(1)
    drive = welch(noisy(rng, 400_000, at_drive=np.sqrt(0.1)), 0.2)
    true = gain(B, A, drive.frequency[1:])
    ratio = {name: np.abs(estimate(drive, name).h[0, 0] / true).mean() for name in ("h1", "h2", "hv")}  # type: ignore[arg-type]
    assert ratio["h1"] == pytest.approx(1 / 1.1, abs=0.01)
    assert ratio["h2"] == pytest.approx(1.0, abs=0.01)
    assert ratio["hv"] == pytest.approx(np.sqrt(1 / 1.1), abs=0.01)
    response = welch(noisy(rng, 400_000, at_response=0.3), 0.2)
    for name in ("h1", "h2", "hv"):
        assert np.abs(estimate(response, name).h[0, 0] / true).mean() == pytest.approx(1.0, abs=0.02)  # type: ignore[arg-type]
    both = [np.abs(estimate(response, name).h[0, 0]) for name in ("h1", "h2", "hv")]  # type: ignore[arg-type]
    np.testing.assert_allclose(both[2], np.sqrt(both[0] * both[1]), rtol=1e-9)


@pytest.mark.parametrize("estimator", ["h1", "hv"])
def test_two_drives_at_once_are_told_apart(estimator: str) -> None:
    """Correlated drives: each alone would be given part of the other's share."""
    rng = np.random.default_rng(2)
    first, own = rng.standard_normal((2, 300_000))
    u = np.stack([first, 0.6 * first + 0.8 * own])
    y = np.stack([lfilter(B, A, u[0]) + lfilter(*OTHER, u[1]), lfilter(*OTHER, u[0])])
    found = estimate(welch(SampledSignals(RATE, u, y), 0.5), estimator)  # type: ignore[arg-type]
    assert found.h.shape == (2, 2, len(found.frequency))
    direct, cross = gain(B, A, found.frequency), gain(*OTHER, found.frequency)
    np.testing.assert_allclose(found.h[0], [direct, cross], atol=0.02)
    np.testing.assert_allclose(found.h[1, 0], cross, atol=0.02)
    np.testing.assert_allclose(found.h[1, 1], 0.0, atol=0.02)


@pytest.mark.parametrize(
    ("estimator", "drives", "within"),
    [("h1", 1, 0.06), ("h1", 2, 0.06), ("h2", 1, 0.2), ("hv", 1, 0.1), ("hv", 2, 0.1)],
)
def test_stated_variance_is_that_of_repeated_estimates(estimator: str, drives: int, within: float) -> None:
    """E|h - H|^2 at a coherence above 0.3, bias included, where all noise is on the response."""
    rng = np.random.default_rng(3)
    found = []
    for _ in range(120):
        u = rng.standard_normal((drives, 40_000))
        y = lfilter(B, A, u).sum(0) + rng.standard_normal(40_000)
        found.append(estimate(welch(SampledSignals(RATE, u, y[None]), 0.2, overlap=0.5), estimator))  # type: ignore[arg-type]
    true = gain(B, A, found[0].frequency)
    real = np.mean([np.abs(one.h[0, 0] - true) ** 2 for one in found], axis=0)
    stated = np.mean([one.variance[0, 0] for one in found if one.variance is not None], axis=0)
    coherent = np.mean([one.coherence[0] for one in found], axis=0) > 0.3
    assert (real / stated)[coherent].mean() == pytest.approx(1.0, abs=within)


def test_overlapping_hann_segments_are_worth_what_welch_says() -> None:
    """Half overlap, Welch's equation 10: a Hann window's correlation there is 1/6, so n / (1 + 2/36)."""
    assert effective_averages(segment_window("hann", 4096), 2048, 10_000) / 10_000 == pytest.approx(
        1.0 / (1.0 + 2.0 / 36.0), rel=1e-3
    )
    assert effective_averages(segment_window("rectangular", 64), 64, 7) == 7.0


def test_runs_pooled_are_one_long_run() -> None:
    rng = np.random.default_rng(4)
    parts = [welch(noisy(rng, 20_000, at_response=0.5), 0.2, "rectangular", 0.0) for _ in range(5)]
    together = pooled(parts)
    assert together.averages == 500.0
    np.testing.assert_allclose(together.g_uu, np.mean([part.g_uu for part in parts], axis=0))


def test_what_cannot_be_estimated_says_what_to_do() -> None:
    rng = np.random.default_rng(5)
    u = rng.standard_normal(4000)
    with pytest.raises(ValueError, match="shorter segments"):
        welch(SampledSignals(RATE, u[None], u[None]), 5.0)
    with pytest.raises(ValueError, match=r"0 to 0\.95"):
        welch(SampledSignals(RATE, u[None], u[None]), 0.5, overlap=1.0)
    with pytest.raises(ValueError, match="silent on every line"):
        estimate(welch(SampledSignals(RATE, 0 * u[None], u[None]), 0.5))
    two = welch(SampledSignals(RATE, np.stack([u, 2 * u]), u[None]), 0.1)
    with pytest.raises(ValueError, match="the drives move as one"):
        estimate(two)
    with pytest.raises(ValueError, match="choose h1 or hv"):
        estimate(two, "h2")
    with pytest.raises(ValueError, match="as many averages as drives"):
        estimate(welch(SampledSignals(RATE, rng.standard_normal((2, 4000)), u[None]), 4.0))
