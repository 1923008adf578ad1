"""Runs averaged as one agree by 1 where they are of one FRF, by 0 where they are not, whatever the noise."""

import numpy as np
import pytest

from analysis.estimation.agreement import agreement
from analysis.estimation.spectra import Spectra, of_blocks

RATE, COUNT = 1000.0, 2048
FREQUENCY = np.fft.rfftfreq(COUNT, 1.0 / RATE)


def resonances(at: tuple[float, ...], residues: tuple[float, ...]) -> np.ndarray:
    s = 2j * np.pi * FREQUENCY
    poles = [2 * np.pi * f * (-0.01 + 1j) for f in at]
    return np.sum([r / (s - p) + r / (s - np.conj(p)) for r, p in zip(residues, poles, strict=True)], axis=0)


def run(h: np.ndarray, hits: int, noise: float, rng: np.random.Generator, drives: int = 1) -> Spectra:
    u = rng.standard_normal((hits, drives, COUNT))
    y = np.fft.irfft(np.fft.rfft(u).sum(1) * h, COUNT)
    y += noise * y.std() * rng.standard_normal(y.shape)
    return of_blocks(u, y[:, None], RATE)


AT = (60.0, 150.0, 290.0)
ONE = resonances(AT, (1.0, -0.7, 0.5))
OTHERS = [resonances(AT, r) for r in ((0.9, 0.8, 0.6), (-0.2, 1.0, -0.9), (-1.0, 0.1, 0.4))]


@pytest.mark.parametrize("hits", [1, 3])
@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_runs_of_one_frf_agree(hits: int, noise: float) -> None:
    rng = np.random.default_rng(1)
    found = agreement([run(ONE, hits, noise, rng) for _ in range(5)])
    assert found is not None
    assert found.between[0] == pytest.approx(1.0 / (1.0 + noise**2) if hits == 1 else 1.0, abs=0.06)
    assert found.different.size == 0
    assert np.isnan(found.within[0]) == (hits == 1)


@pytest.mark.parametrize("hits", [1, 3])
def test_runs_of_other_points_do_not(hits: int) -> None:
    rng = np.random.default_rng(2)
    found = agreement([run(h, hits, 0.02, rng) for h in (ONE, *OTHERS)])
    assert found is not None
    assert found.between[0] < 0.3
    assert found.different.tolist() == [0]
    two = agreement([run(h, hits, 0.02, rng) for h in (ONE, OTHERS[1])])
    assert two is not None
    assert two.different.tolist() == [0]


def test_unrelated_responses_agree_by_nothing_on_average() -> None:
    rng = np.random.default_rng(3)
    found = []
    for _ in range(20):
        random = [rng.standard_normal(len(FREQUENCY)) + 1j * rng.standard_normal(len(FREQUENCY)) for _ in range(4)]
        found.append(agreement([run(h, 1, 0.0, rng) for h in random]).between[0])  # type: ignore[union-attr]
    assert np.mean(found) == pytest.approx(0.0, abs=0.02)


def test_noise_is_not_taken_for_another_point() -> None:
    rng = np.random.default_rng(4)
    found = agreement([run(ONE, 4, 5.0, rng) for _ in range(5)])
    assert found is not None
    assert found.within[0] < 0.5
    assert found.different.size == 0
    assert found.doubtful.tolist() == [0]


def test_a_structure_that_changed_is_doubted() -> None:
    rng = np.random.default_rng(5)
    warmer = resonances(tuple(0.993 * f for f in AT), (1.0, -0.7, 0.5))
    found = agreement([run(ONE, 3, 0.01, rng), run(warmer, 3, 0.01, rng)])
    assert found is not None
    assert 0.5 < found.between[0] < 0.95


def test_a_run_alone_and_too_few_averages_tell_nothing() -> None:
    rng = np.random.default_rng(6)
    assert agreement([run(ONE, 3, 0.0, rng)]) is None
    assert agreement([run(ONE, 1, 0.0, rng, drives=2) for _ in range(3)]) is None
    assert agreement([run(ONE, 3, 0.0, rng, drives=2) for _ in range(3)]).between[0] == pytest.approx(
        1.0, abs=1e-6
    )  # type: ignore[union-attr]
