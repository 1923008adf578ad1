"""Lines of a stepped sine, dense at the resonances, of joined sweeps and of a logarithmic sweep."""

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.identification.automatic import identify
from analysis.identification.averaging import averaged
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.missing import matched
from analysis.identification.settings import Settings

FREQUENCY = np.array([52.0, 87.0, 133.0, 171.0, 260.0])
DAMPING = np.array([0.008, 0.006, 0.010, 0.005, 0.008])
STEPS = [f * (1.0 + z * np.linspace(-3.0, 3.0, 12)) for f, z in zip(FREQUENCY, DAMPING, strict=True)]
GRIDS = {
    "stepped sine on a grid": np.unique(np.concatenate([np.arange(30.0, 300.0, 2.0), *STEPS])),
    "few steps": np.unique(np.concatenate([np.arange(30.0, 300.0, 10.0), *STEPS])),
    "logarithmic": np.geomspace(30.0, 300.0, 600),
    "a short dense sweep": np.concatenate(
        [np.arange(30.0, 169.0, 0.5), np.arange(169.0, 173.0, 0.1), np.arange(173.0, 300.0, 0.5)]
    ),
    "a dense sweep, then few lines": np.concatenate([np.arange(30.0, 200.0, 0.1), np.arange(200.0, 300.0, 3.0)]),
    "two sweeps of the same lines": np.sort(np.append(GRID := np.arange(30.0, 300.0, 0.5), GRID * (1.0 + 1e-8))),
}


def measured(
    lines: NDArray[np.float64],
    seed: int,
    frequency: NDArray[np.float64] = FREQUENCY,
    damping: NDArray[np.float64] = DAMPING,
    order: int = 0,
) -> Measured:
    """Three FRFs times s^order, with errors of 1 % of every value."""
    rng = np.random.default_rng(seed)
    s, omega, count = 2j * np.pi * lines, 2 * np.pi * frequency, len(frequency)
    poles = omega * (-damping + 1j * np.sqrt(1.0 - damping**2))
    residues = rng.uniform(0.5, 1.5, (3, count)) * rng.choice([-1.0, 1.0], (3, count)) * omega / (2j * poles.imag)
    h = residues @ (1.0 / (s - poles[:, None])) + residues.conj() @ (1.0 / (s - poles.conj()[:, None]))
    noise = rng.standard_normal((2, *h.shape)) / np.sqrt(2.0)
    return Measured(lines, h * s**order * (1.0 + 0.01 * (noise[0] + 1j * noise[1])))


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


@pytest.mark.parametrize("order", [0, 2])
def test_low_modes_of_three_decades_are_found_beside_high_ones(order: int) -> None:
    for seed in range(4):
        frequency = np.random.default_rng(seed).uniform(0.93, 1.07, 10) * np.geomspace(9.0, 3800.0, 10)
        found = identify(
            measured(np.geomspace(5.0, 5000.0, 800), seed, frequency, np.full(10, 0.015), order),
            Settings(mains=None),
        )
        assert found.status == ("kept",) * 10
        assert found.reading("viscous").frequency_hz == pytest.approx(frequency, rel=2e-3)


def test_a_mode_between_two_bands_is_known_from_its_flanks() -> None:
    lines = np.arange(30.0, 300.0, 0.25)
    lines = lines[(lines < 120.0) | (lines > 150.0)]
    errors = []
    for seed in range(6):
        modes = identify(measured(lines, seed), Settings(mains=None))
        assert modes.status == ("kept", "kept", "weak", "kept", "kept")
        assert modes.reason[2] == "no line at its peak, where lines are left out: known from its flanks alone"
        found = modes.reading("viscous")
        errors.append((found.frequency_hz[2] - FREQUENCY[2]) / found.sigma_frequency_hz[2])
    assert 0.4 < np.sqrt(np.mean(np.square(errors))) < 1.7


def test_a_mode_on_few_lines_is_no_hum_unless_the_mains_is_there() -> None:
    """Half a line wide, and within a line of 400 and 480 Hz, but 0.9 and 1 % away from these."""
    lines = np.concatenate([np.arange(40.0, 250.0, 0.1), np.arange(250.0, 600.0, 8.0)])
    frequency = np.array([61.0, 117.0, 203.0, 403.5, 475.0])
    for seed in range(4):
        modes = identify(measured(lines, seed, frequency, np.array([0.006, 0.006, 0.006, 0.0075, 0.0075])))
        assert "harmonic" not in modes.status


def test_filters_find_a_needle_and_a_hump_on_lines_of_any_spacing() -> None:
    frequency = np.geomspace(5.0, 5000.0, 2500)
    for f, half_width in ((8.0, 0.08), (700.0, 10.0), (3000.0, 150.0)):
        pole = 2.0 * np.pi * complex(-half_width, f)
        left = -pole.real / (2j * np.pi * frequency[None] - pole)
        found = matched(Lines(frequency, left, np.full(left.shape, 0.1)), left)[0]
        assert abs(found.imag - pole.imag) < np.pi * half_width
        assert 0.5 < found.real / pole.real < 2.0


def test_blocks_end_where_the_spacing_changes() -> None:
    """Two values at the Gauss points of one line and of many denser ones would lie beyond these."""
    frequency = np.concatenate([np.arange(102.0, 1000.0, 2.0), np.arange(1000.0, 1080.0, 0.1)])
    h = np.ones((1, len(frequency)), dtype=complex)
    blocks = averaged(Lines(frequency, h, np.full(h.shape, 0.1)))
    assert len(blocks.frequency) < 0.3 * len(frequency)
    assert blocks.values == 2 * len(frequency)


def test_spacing_is_that_of_the_lines_around() -> None:
    def lines(frequency: NDArray[np.float64]) -> Lines:
        return Lines(frequency, np.ones((1, len(frequency)), complex), np.ones((1, len(frequency))))

    even = lines(np.delete(np.arange(10.0, 50.0, 0.5), [20, 41]))  # without two lines of hum
    assert even.spacing == 0.5
    assert (even.spacing_at(np.array([5.0, 20.0, 33.3, 60.0])) == 0.5).all()
    dense = lines(np.concatenate([np.arange(10.0, 20.0, 1.0), np.arange(20.0, 22.0, 0.1), np.arange(22.0, 40.0)]))
    assert dense.spacing_at(np.array([12.3, 21.0, 35.0])) == pytest.approx([1.0, 0.1, 1.0])
    assert dense.spacing == pytest.approx(0.1)
    few = lines(np.concatenate([np.arange(10.0, 80.0, 1.0), np.arange(80.0, 80.5, 0.1), np.arange(80.5, 150.0)]))
    assert few.spacing_at(np.array([50.0, 80.2])) == pytest.approx([1.0, 0.1])
    twice = lines(np.sort(np.append(GRID, GRID * (1.0 + 1e-8))))
    assert twice.spacing == pytest.approx(0.5)
