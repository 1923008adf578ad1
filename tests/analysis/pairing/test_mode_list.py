"""Peaks and strong modes of FRFs whose poles and residues are known."""

import numpy as np
import pytest

from analysis.identification.modes import Modes
from analysis.identification.pole_residue import NONE
from analysis.pairing.assignment import ModeList


def pole(f: float, zeta: float) -> complex:
    return complex(2 * np.pi * f * (-zeta + 1j * np.sqrt(1 - zeta**2)))


POLES = np.array([pole(200, 0.01), pole(300, 0.02), pole(301, 0.02), pole(500, 0.01)])


def identified() -> Modes:
    covariance = np.tile(np.diag([1e-8, 1e-4]), (4, 1, 1))
    return Modes(
        POLES,
        np.array([[3.0, 2.0, 2.0, 5.0]], dtype=complex),
        covariance,
        NONE,
        np.zeros((1, 0), dtype=complex),
        ("kept", "kept", "kept", "computational"),
        ("",) * 4,
        (100.0, 600.0),
        0.01,
        1000,
        damping="viscous",
    )


def test_poles_that_are_no_modes_are_left_out_and_those_that_overlap_are_not_certain() -> None:
    found = ModeList.measured(identified(), np.array([0.1]))
    np.testing.assert_allclose(found.frequency, [200.0, 300.0, 301.0])
    assert found.certain.tolist() == [True, False, False]
    np.testing.assert_allclose(found.sigma_frequency / found.frequency, 1e-4)
    np.testing.assert_allclose(found.bandwidth, [4.0, 12.0, 12.04])


def test_a_peak_is_what_the_frf_of_one_mode_reaches() -> None:
    f, zeta, residue, rms = 200.0, 0.01, 3.0, 0.1
    s = 2j * np.pi * np.linspace(190.0, 210.0, 20001)
    alone = residue / (s - pole(f, zeta))
    found = ModeList.computed(
        np.array([pole(f, zeta)]), np.array([[residue + 0j]]), np.array([rms]), damping="viscous"
    )
    assert found.peak[0] == pytest.approx(np.abs(alone).max() / rms, rel=1e-6)
    assert found.strong[0] == (np.abs(alone).max() / rms > 0.3)


def test_arrays_that_do_not_belong_together_are_refused() -> None:
    one, two = np.ones(1), np.ones(2)
    with pytest.raises(ValueError, match="sigma_frequency has shape"):
        ModeList(one, two, one, one, np.ones((1, 1), complex), one > 0)
    with pytest.raises(ValueError, match="residues have shape"):
        ModeList(one, one, one, one, np.ones((1, 2), complex), one > 0)
    with pytest.raises(ValueError, match="must ascend"):
        ModeList(np.array([2.0, 1.0]), two, two, two, np.ones((1, 2), complex), two > 0)
