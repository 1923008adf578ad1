import numpy as np
import pytest

from analysis.identification.averaging import averaged, roughness
from analysis.identification.lines import Lines
from analysis.identification.pole_residue import NONE, synthesis
from analysis.identification.pole_search import fit

FREQUENCY = np.arange(100.0, 500.0, 0.1)
NOTHING = np.zeros((1, 0), complex)


def one_peak(damping: float, rng: np.random.Generator, noise: float) -> tuple[complex, Lines]:
    pole = 2 * np.pi * 300.0 * complex(-damping, np.sqrt(1 - damping**2))
    h = synthesis(FREQUENCY, np.array([pole]), np.array([[-pole.real * 1j]]), NONE, NOTHING)
    draw = rng.normal(size=h.shape) + 1j * rng.normal(size=h.shape)
    return pole, Lines(FREQUENCY, h + noise / np.sqrt(2) * draw, np.full(h.shape, noise))


def test_a_peak_keeps_its_lines_and_slopes_lose_theirs() -> None:
    _, lines = one_peak(0.001, np.random.default_rng(0), 1e-3)
    blocks = averaged(lines)
    width = np.diff(blocks.frequency)
    assert len(blocks.frequency) < len(FREQUENCY) / 5
    assert width[np.abs(blocks.frequency[1:] - 300.0) < 0.5].max() < 0.25
    assert width[blocks.frequency[1:] < 250.0].min() > 0.5


def test_no_measured_value_is_lost_from_the_count() -> None:
    _, lines = one_peak(0.01, np.random.default_rng(0), 1e-2)
    assert averaged(lines).values == lines.values


def test_two_values_of_a_block_give_the_sums_of_its_lines_over_a_cubic() -> None:
    """The FRF is straight, so all blocks are as long as they may be; in each the second factor is a cubic."""
    rng = np.random.default_rng(4)
    frequency = np.arange(1000.0, 1000.0 + 64 * 64)
    h = (1.0 + 2.0j + (3.0 - 1.0j) * (frequency - 3000.0) / 2000.0)[None]
    draw = rng.normal(size=h.shape) + 1j * rng.normal(size=h.shape)
    lines = Lines(frequency, h + draw / np.sqrt(2), np.ones(h.shape))
    blocks = averaged(lines)
    assert len(blocks.frequency) == 128

    def sums(one: Lines, data: np.ndarray) -> np.ndarray:
        along = (one.frequency - one.frequency.mean()) / 2000.0
        weight = one.deviation[0] ** -2
        return np.array([(along**power * data * weight).sum() for power in range(4)])

    exact = averaged(Lines(frequency, h, np.ones(h.shape)))
    np.testing.assert_allclose(sums(exact, exact.h[0]), sums(lines, h[0]), rtol=1e-4)
    np.testing.assert_allclose(sums(blocks, blocks.h[0])[:2], sums(lines, lines.h[0])[:2], rtol=1e-9)


def test_errors_of_the_two_values_are_independent_and_as_large_as_stated() -> None:
    rng = np.random.default_rng(6)
    frequency = np.arange(1000.0, 1000.0 + 64 * 64)
    errors = []
    for _ in range(20):
        h = rng.normal(size=(1, len(frequency))) + 1j * rng.normal(size=(1, len(frequency)))
        blocks = averaged(Lines(frequency, 100.0 + h, np.full(h.shape, np.sqrt(2.0))))
        errors.append(((blocks.h - 100.0) / blocks.deviation)[0].reshape(-1, 2))
    error = np.concatenate(errors)
    products = (error.conj().T @ error).real / len(error)
    np.testing.assert_allclose(products, np.eye(2), atol=4.0 / np.sqrt(len(error)))


@pytest.mark.parametrize("damping", [0.0005, 0.005, 0.05])
def test_a_fit_to_blocks_is_good_enough_to_start_the_last_one(damping: float) -> None:
    """Within half a standard deviation, and with nearly all the information that the lines hold."""
    rng = np.random.default_rng(2)
    for _ in range(3):
        pole, lines = one_peak(damping, rng, 1e-2)
        on_lines = fit(lines, np.array([pole]), NONE, tolerance=1e-9)
        on_blocks = fit(averaged(lines), np.array([pole]), NONE, tolerance=1e-9)
        sigma = abs(pole) / np.sqrt(2 * on_lines.projection.hessian[0, 0])
        assert abs(on_blocks.poles[0] - on_lines.poles[0]) < 0.5 * sigma
        assert on_blocks.projection.hessian[0, 0] > 0.9 * on_lines.projection.hessian[0, 0]


def test_roughness_is_the_noise_however_sharp_a_peak() -> None:
    _, lines = one_peak(0.0002, np.random.default_rng(1), 1e-3)
    assert np.median(roughness(lines.h)) == pytest.approx(1e-3, rel=0.15)
