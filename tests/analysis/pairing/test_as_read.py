"""One pole that stands for two modes: its distance from the twin's own is within its standard deviation."""

from functools import partial

import numpy as np
import pytest

from analysis.identification.automatic import identify
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.pole_residue import COMPLEX_E_F_G
from analysis.identification.settings import Settings
from analysis.pairing.assignment import ModeList, pair_modes
from app.twins.computed_modes import poles_as_read, residues_at

LINES = np.arange(400.0, 1000.25, 0.5)
FREQUENCY = np.array([484.8, 539.4, 702.9, 717.9, 788.8, 856.3])


def pole(f, zeta):
    return 2 * np.pi * f * (-zeta + 1j * np.sqrt(1.0 - zeta**2))


def paired(zeta, noise, shift=0.0, seed=1):
    """Pair the modes identified in noisy FRFs with those of a twin whose resonances are off by a share `shift`."""
    rng = np.random.default_rng(seed)
    poles, sizes = pole(FREQUENCY, zeta), np.array([1.0, -0.8, 1.0, 0.07, 0.9, -1.1])
    sj = 2j * np.pi * LINES

    def answer(poles):
        parts = sizes[:, None] * (1.0 / (sj - poles[:, None]) + 1.0 / (sj - poles.conj()[:, None]))
        return parts.sum(axis=0)[None]

    h = answer(poles)
    level = noise * np.sqrt((np.abs(h) ** 2).mean())
    measured = h + level * np.sqrt(0.5) * (rng.standard_normal(h.shape) + 1j * rng.standard_normal(h.shape))
    deviation = np.full(h.shape, level)
    modes = identify(Measured(LINES, measured, deviation**2), Settings(terms=(COMPLEX_E_F_G,)))
    rms, theirs = np.sqrt((np.abs(measured) ** 2).mean(axis=1)), poles * (1.0 + shift)
    of_twin = Lines(LINES, answer(theirs), deviation)
    computed = ModeList.computed(theirs, residues_at(theirs, of_twin, COMPLEX_E_F_G), rms, modes.damping)
    before = pair_modes(20.0, (400.0, 1000.0), ModeList.measured(modes, rms), computed)
    return before, before.as_read(modes, theirs, partial(poles_as_read, of_twin=of_twin, terms=COMPLEX_E_F_G))


def test_a_pole_between_two_modes_is_as_uncertain_as_it_is_far_from_them():
    before, after = paired(0.05, 0.004)
    near = np.argmin(np.abs(after.measured.frequency[after.measured_index] - 702.9))
    assert abs(before.difference[near]) > 5.0 * before.sigma[near]  # one pole for both, and sure of it
    assert (np.abs(after.difference) < 3.0 * after.sigma).all()


@pytest.mark.parametrize("shift", [0.0, 0.003])
def test_modes_that_stand_alone_keep_what_they_had(shift):
    before, after = paired(0.002, 0.004, shift)
    assert len(after.measured_index) >= 5
    np.testing.assert_allclose(after.sigma, before.sigma, rtol=0.5)
    if shift:  # a twin that is off is told by as many standard deviations as before
        assert (np.abs(after.difference) > 5.0 * after.sigma).sum() >= 5
