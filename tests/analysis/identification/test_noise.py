import numpy as np
import pytest

from analysis.identification.judgement.status import harmonic_lines
from analysis.identification.measured import deviation_from_residual, pooled, shared_by_responses

FREQUENCY = np.arange(40.0, 840.0, 0.5)
RNG = np.random.default_rng(4)


def noise(deviation: np.ndarray) -> np.ndarray:
    draw = RNG.normal(size=(1, len(FREQUENCY))) + 1j * RNG.normal(size=(1, len(FREQUENCY)))
    return deviation / np.sqrt(2) * draw


def test_slowly_changing_deviation_is_recovered() -> None:
    truth = 0.3 + (FREQUENCY / 400.0) ** 2
    found = deviation_from_residual(noise(truth), np.ones((1, len(FREQUENCY))))
    assert np.abs(found[0] / truth - 1).max() < 0.4
    assert np.mean(found[0] / truth) == pytest.approx(1.0, abs=0.05)


def test_exact_fit_still_has_weights() -> None:
    found = deviation_from_residual(np.zeros((1, 100), complex), np.full((1, 100), 5.0 + 0j))
    assert (found > 0.0).all()
    assert found.max() < 1e-10


def test_responses_with_one_course_of_noise_share_it() -> None:
    """Four sensors of one kind at their own levels, estimated from two repeats, and one unlike them."""
    truth = np.sqrt(0.3 + (FREQUENCY / 400.0) ** 2)
    level = np.array([1.0, 3.0, 0.2, 50.0])[:, None]
    drawn = np.concatenate([noise(truth) for _ in range(4)])
    estimated = level * deviation_from_residual(drawn, np.ones_like(drawn))
    other = estimated[:1] / truth
    found = pooled(np.concatenate([estimated[:2], other, estimated[2:]]))
    assert found[2] == pytest.approx(other[0])
    shared = found[[0, 1, 3, 4]]
    ratio = shared / shared[0]
    np.testing.assert_allclose(ratio, ratio[:, :1] * np.ones(len(truth)), rtol=1e-12)
    error, before = (np.log(one / (level * truth)).std(axis=1) for one in (shared, estimated))
    assert (error < 0.8 * before).all()


def test_only_outlying_lines_at_harmonics_are_spoilt() -> None:
    left = noise(np.ones(len(FREQUENCY)))
    at = {f: int(np.argmin(np.abs(FREQUENCY - f))) for f in (100.0, 250.5, 333.0, 600.0)}
    for f in (100.0, 250.5, 333.0):
        left[0, at[f]] += 12.0
    spoilt = harmonic_lines(FREQUENCY, left, 0.5, 50.0)
    assert [f for f in at if spoilt[at[f]]] == [100.0, 250.5]
    assert spoilt.sum() == 2


@pytest.mark.parametrize(("common", "wanted"), [(0.0, 1.0), (0.5, 1.0 + 7 * 0.25), (1.0, 8.0)])
def test_responses_that_share_the_noise_of_the_force_count_as_fewer(common: float, wanted: float) -> None:
    """Eight responses of any phase; a share of their noise power is that of the measured force."""
    phase = np.exp(2j * np.pi * RNG.random((8, len(FREQUENCY))))
    own = np.concatenate([noise(np.ones(len(FREQUENCY))) for _ in range(8)])
    left = np.sqrt(common) * noise(np.ones(len(FREQUENCY))) * phase + np.sqrt(1.0 - common) * own
    assert shared_by_responses(left, 3.0 * phase, 1.0) == pytest.approx(wanted, rel=0.15)
