"""Pairs of modes whose partners are known: shuffled, missing, extra, close, and of opposite sign."""

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.pairing.assignment import ModeList, ModePairs, agreement_of, pair_modes

BAND = (50.0, 1000.0)
F = np.array([100.0, 180.0, 300.0, 460.0, 700.0])
RESIDUES = np.array([[20.0, -40.0, 60.0, 90.0, -130.0], [30.0, 10.0, -80.0, 50.0, 140.0]], dtype=complex)


def modes(
    f: NDArray[np.float64], residues: NDArray[np.complex128], zeta: float = 0.02, sigma: float = 1e-4
) -> ModeList:
    order = np.argsort(f)
    ones = np.ones(len(f))
    return ModeList(f[order], sigma * f[order], zeta * ones, 0.01 * zeta * ones, residues[:, order], ones > 0.0)


def partners(pairs: ModePairs) -> dict[float, float]:
    f, g = pairs.measured.frequency[pairs.measured_index], pairs.computed.frequency[pairs.computed_index]
    return dict(zip(f.tolist(), g.tolist(), strict=True))


def test_every_mode_finds_its_partner_whatever_the_order_and_shift() -> None:
    shifted = F * (1.0 + np.array([0.01, -0.015, 0.0, 0.02, -0.01]))
    order = np.random.default_rng(1).permutation(len(F))
    pairs = pair_modes(20.0, BAND, modes(F, RESIDUES), modes(shifted[order], 1.1 * RESIDUES[:, order]))
    assert partners(pairs) == dict(zip(F.tolist(), shifted.tolist(), strict=True))
    np.testing.assert_allclose(pairs.difference, shifted / F - 1.0)
    np.testing.assert_allclose(pairs.sigma, np.hypot(1.0, shifted / F) * 1e-4)
    np.testing.assert_allclose(pairs.damping, 1.0)
    np.testing.assert_allclose(pairs.mac, 1.0)
    np.testing.assert_allclose(pairs.agreement, 2 * 1.1 / (1 + 1.1**2))
    assert pairs.count == (5, 5)


def test_modes_beyond_the_window_stay_alone_on_both_sides() -> None:
    """The window is the bandwidth, 4 % here, on either side; a tenth is beyond it."""
    elsewhere = F.copy()
    elsewhere[2] *= 1.10
    pairs = pair_modes(20.0, BAND, modes(F, RESIDUES), modes(elsewhere, RESIDUES))
    assert pairs.unpaired_measured.tolist() == pairs.missing.tolist() == [2]
    assert pairs.share == pytest.approx(0.8)


def test_a_measured_mode_that_the_twin_lacks_and_one_that_was_not_measured() -> None:
    pairs = pair_modes(20.0, BAND, modes(F[1:], RESIDUES[:, 1:]), modes(F[:-1], RESIDUES[:, :-1]))
    assert sorted(partners(pairs)) == F[1:-1].tolist()
    assert pairs.measured.frequency[pairs.unpaired_measured].tolist() == [700.0]
    assert pairs.computed.frequency[pairs.missing].tolist() == [100.0]


def test_a_computed_mode_that_no_channel_sees_or_beyond_the_band_is_not_missing() -> None:
    hidden = RESIDUES.copy()
    hidden[:, 1] *= 1e-3
    assert pair_modes(20.0, BAND, modes(F[2:], RESIDUES[:, 2:]), modes(F, hidden)).missing.tolist() == [0]
    assert pair_modes(20.0, (150.0, 1000.0), modes(F[2:], RESIDUES[:, 2:]), modes(F, hidden)).missing.size == 0


def test_a_computed_mode_covered_by_a_larger_neighbour_is_not_missing() -> None:
    """Measured FRFs show one peak there, which the larger one takes."""
    f = np.array([300.0, 304.0])
    both = np.array([[60.0, 25.0]], dtype=complex)
    pairs = pair_modes(20.0, BAND, modes(f[:1], both[:, :1]), modes(f, both))
    assert partners(pairs) == {300.0: 300.0}
    assert pairs.missing.size == 0


def test_two_close_modes_are_not_exchanged_where_one_lies_nearer_to_the_other() -> None:
    """Shapes decide: the twin has both 1 % low, so that its upper mode lies at the lower measured one."""
    measured, computed = np.array([400.0, 404.0]), np.array([396.0, 400.0])
    shapes = np.array([[50.0, 50.0], [50.0, -50.0]], dtype=complex)
    pairs = pair_modes(20.0, BAND, modes(measured, shapes), modes(computed, shapes))
    assert partners(pairs) == {400.0: 396.0, 404.0: 400.0}
    np.testing.assert_allclose(pairs.mac, 1.0)


def test_a_strong_mode_is_not_given_to_a_weak_one_that_lies_nearer() -> None:
    pairs = pair_modes(
        20.0,
        BAND,
        modes(np.array([500.0]), np.array([[80.0 + 0j]])),
        modes(np.array([500.5, 505.0]), np.array([[0.5 + 0j, 80.0]])),
    )
    assert partners(pairs) == {500.0: 505.0}


def test_frequencies_alone_match_nothing_where_the_residues_have_the_wrong_sign() -> None:
    pairs = pair_modes(20.0, BAND, modes(F, RESIDUES), modes(F, -RESIDUES))
    assert pairs.share == 0.0
    one = pair_modes(20.0, BAND, modes(F, RESIDUES[:1]), modes(F, RESIDUES[:1]))
    assert one.mac is None  # of one channel it is 1 for any two shapes
    assert one.share == 1.0


def test_lightly_damped_modes_have_a_window_wider_than_their_bandwidth() -> None:
    shifted = F * 1.009
    pairs = pair_modes(20.0, BAND, modes(F, RESIDUES, zeta=1e-3), modes(shifted, RESIDUES, zeta=1e-3))
    assert pairs.share == 1.0
    np.testing.assert_allclose(pairs.distance, 0.45, rtol=1e-6)
    np.testing.assert_allclose(pairs.window, 0.02)


def test_agreement_is_that_of_its_formula() -> None:
    one, other = np.array([[1.0 + 0j, 1.0, 1.0, 1.0]]), np.array([[1.0, -1.0, 2.0, np.exp(1j * np.pi / 3)]])
    np.testing.assert_allclose(np.diagonal(agreement_of(one, other)), [1.0, -1.0, 0.8, 0.5])
    assert agreement_of(0.0 * one, 0.0 * other).max() == 0.0


def test_without_strong_modes_no_share_is_stated() -> None:
    assert np.isnan(pair_modes(20.0, BAND, modes(F, 1e-3 * RESIDUES), modes(F, 1e-3 * RESIDUES)).share)
