import numpy as np
import pytest

from analysis.identification.automatic import identify
from analysis.identification.averaging import averaged
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.missing import split
from analysis.identification.pole_residue import NONE, REAL_E_F, synthesis
from analysis.identification.pole_search import fit
from tests.synthetic_frf import pairs, r10

FREQUENCY = np.arange(100.0, 500.0, 0.25)
TWO = 2 * np.pi * np.array([-5.0 + 299.2j, -4.0 + 301.1j])
"""Less than a quarter of their half widths apart along the frequency, a fifth across."""


def two_as_one(responses: int, orientation: complex = 1.0) -> Lines:
    """Lines of two poles that look like one, turned about their middle."""
    poles = TWO.mean() + orientation * (TWO - TWO.mean())
    residues = 100.0j * np.outer(1.0 + np.arange(responses), [1.0, 0.8])
    clean = synthesis(FREQUENCY, poles, residues, NONE, np.zeros((responses, 0), complex))
    deviation = 1e-4 * np.sqrt(np.mean(np.abs(clean) ** 2, axis=1, keepdims=True))
    draw = np.random.default_rng(0).normal(size=(2, *clean.shape))
    noise = deviation / np.sqrt(2) * (draw[0] + 1j * draw[1])
    return Lines(FREQUENCY, clean + noise, np.broadcast_to(deviation, clean.shape))


@pytest.mark.parametrize("responses", [1, 2])
@pytest.mark.parametrize("orientation", [1.0, 1j, np.exp(0.25j * np.pi)])
@pytest.mark.parametrize("thinned", [False, True])
def test_a_pole_that_stands_for_two_is_split_the_way_they_lie(
    responses: int, orientation: complex, thinned: bool
) -> None:
    lines = two_as_one(responses, orientation)
    lines = averaged(lines) if thinned else lines
    found = split(lines, fit(lines, TWO[:1], NONE))
    assert found is not None
    true = TWO.mean() + orientation * (TWO - TWO.mean())
    away = np.abs(found.poles[:, None] - true)
    assert away.min(axis=0).max() < 0.2 * abs(TWO[1] - TWO[0])


def test_poles_that_stand_for_themselves_are_not_split() -> None:
    for seed in range(5):
        case = r10(np.random.default_rng(seed))
        lines = Lines(case.frequency, case.h[None], np.full((1, len(case.h)), case.deviation))
        assert split(lines, fit(lines, case.poles, REAL_E_F)) is None
    empty = fit(lines, case.poles[:0], REAL_E_F)
    assert split(lines, empty) is None


def test_no_mode_of_a_near_pair_is_lost() -> None:
    """Modes at 170.25 and 170.76 Hz, half widths of 2.6 Hz: no matched filter finds the second."""
    case = pairs(np.random.default_rng(1026))
    modes = identify(Measured(case.frequency, case.h[None]))
    assert modes.status == ("kept",) * 8
    np.testing.assert_allclose(np.abs(modes.poles), np.abs(case.poles), rtol=1e-3)
