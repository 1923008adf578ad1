import numpy as np

from analysis.identification.resolution import heights, unresolved


def at(f: float, half_width: float) -> complex:
    return 2 * np.pi * complex(-half_width, f)


def test_height_is_what_a_lone_peak_shows() -> None:
    pole, residue = at(100.0, 1.0), 3.0 - 4.0j
    on_peak = residue / (2j * np.pi * 100.0 - pole)
    assert heights(np.array([pole]), np.array([[residue]]))[0] == abs(on_peak)


def test_two_frequencies_closer_than_two_lines_are_one() -> None:
    poles = np.array([at(100.0, 0.3), at(100.15, 0.3), at(101.0, 0.3)])
    residues = np.array([[1.0, 2.0, 1.0]], complex)
    np.testing.assert_array_equal(unresolved(poles, residues, 0.1), [True, False, False])


def test_small_companions_of_a_narrow_peak_are_its_leakage() -> None:
    poles = np.array([at(100.0, 0.1), at(101.5, 0.3), at(98.0, 0.05)])
    residues = np.array([[1.0, 0.1, 0.1]], complex)  # heights 1, 1/30, 1/5 of the first; the last is a needle
    np.testing.assert_array_equal(unresolved(poles, residues, 0.1), [False, True, True])
    residues = np.array([[1.0, 1.0, 0.6]], complex)
    np.testing.assert_array_equal(unresolved(poles, residues, 0.1), [False, False, False])


def test_wide_peaks_may_have_small_neighbours() -> None:
    poles = np.array([at(100.0, 3.0), at(102.0, 3.0)])
    assert not unresolved(poles, np.array([[1.0, 0.02]], complex), 0.1).any()


def test_two_wide_modes_may_be_closer_than_two_lines() -> None:
    """Over four lines of half width the sum of two has a shape of its own: BIC decides, not this rule."""
    poles = np.array([at(100.0, 0.4), at(100.15, 0.5)])
    assert not unresolved(poles, np.array([[1.0, 2.0]], complex), 0.1).any()


def test_a_mode_whose_frequency_moves_between_responses_is_not_two() -> None:
    """Two poles describe it with residues that have no common phase; those of two close modes have one each."""
    poles = np.array([at(100.0, 1.0), at(100.2, 1.0)])
    shape = np.array([1.0, -0.5, 0.7, 0.3])
    moved = np.array([0.4, -0.3, 0.5, -0.6]) * 1j  # what one has more the other has less
    residues = np.column_stack([0.6 * shape + moved, 0.4 * shape - moved])
    np.testing.assert_array_equal(unresolved(poles, residues, 0.01).sum(), 1)
    other = np.array([0.2, 0.9, -0.4, 0.8])
    assert not unresolved(poles, np.column_stack([shape, other]).astype(complex), 0.01).any()
    apart = np.array([at(100.0, 1.0), at(101.0, 1.0)])
    assert not unresolved(apart, residues, 0.01).any()
