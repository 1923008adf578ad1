"""Lines of a stepped sine, dense at the resonances, and of a logarithmic sweep."""

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.identification.automatic import identify
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.settings import Settings

FREQUENCY = np.array([52.0, 87.0, 133.0, 171.0, 260.0])
DAMPING = np.array([0.008, 0.006, 0.010, 0.005, 0.008])
STEPS = [f * (1.0 + z * np.linspace(-3.0, 3.0, 12)) for f, z in zip(FREQUENCY, DAMPING, strict=True)]
GRIDS = {
    "stepped sine on a grid": np.unique(np.concatenate([np.arange(30.0, 300.0, 2.0), *STEPS])),
    "few steps": np.unique(np.concatenate([np.arange(30.0, 300.0, 10.0), *STEPS])),
    "logarithmic": np.geomspace(30.0, 300.0, 600),
}


def measured(lines: NDArray[np.float64], seed: int) -> Measured:
    """Three FRFs of five modes with errors of 1 % of every value."""
    rng = np.random.default_rng(seed)
    s, omega = 2j * np.pi * lines, 2 * np.pi * FREQUENCY
    poles = omega * (-DAMPING + 1j * np.sqrt(1.0 - DAMPING**2))
    residues = rng.uniform(0.5, 1.5, (3, 5)) * rng.choice([-1.0, 1.0], (3, 5)) * omega / (2j * poles.imag)
    h = residues @ (1.0 / (s - poles[:, None])) + residues.conj() @ (1.0 / (s - poles.conj()[:, None]))
    noise = rng.standard_normal((2, *h.shape)) / np.sqrt(2.0)
    return Measured(lines, h * (1.0 + 0.01 * (noise[0] + 1j * noise[1])))


@pytest.mark.parametrize("grid", GRIDS)
def test_all_modes_and_no_others_are_found(grid: str) -> None:
    errors = []
    for seed in range(6):
        modes = identify(measured(GRIDS[grid], seed), Settings(mains=None))
        assert modes.status == ("kept",) * 5
        found = modes.reading("viscous")
        errors += [
            (found.frequency_hz - FREQUENCY) / found.sigma_frequency_hz,
            (found.damping_ratio - DAMPING) / found.sigma_damping_ratio,
        ]
    assert 0.6 < np.sqrt(np.mean(np.square(errors))) < 1.4


def test_spacing_is_that_of_the_lines_around() -> None:
    def lines(frequency: NDArray[np.float64]) -> Lines:
        return Lines(frequency, np.ones((1, len(frequency)), complex), np.ones((1, len(frequency))))

    even = lines(np.delete(np.arange(10.0, 50.0, 0.5), [20, 41]))  # without two lines of hum
    assert even.spacing == 0.5
    assert (even.spacing_at(np.array([5.0, 20.0, 33.3, 60.0])) == 0.5).all()
    dense = lines(np.concatenate([np.arange(10.0, 20.0, 1.0), np.arange(20.0, 22.0, 0.1), np.arange(22.0, 40.0)]))
    assert dense.spacing_at(np.array([12.3, 21.0, 35.0])) == pytest.approx([1.0, 0.1, 1.0])
    assert dense.spacing == pytest.approx(0.1)
