import numpy as np

from analysis.identification.over_temperature.smooth_tracks import SmoothTracks

TEMPERATURE = np.linspace(0.0, 60.0, 13)


def curved(coefficients: np.ndarray) -> tuple[SmoothTracks, np.ndarray]:
    """Tracks and places (T, J, 2) of modes with such coefficients (P, J), besides what all have in common."""
    tracks = SmoothTracks.polynomials(TEMPERATURE, np.zeros((len(TEMPERATURE), coefficients.shape[1], 2)))
    place = np.full((*tracks.base.shape[:2], 2), np.log(0.03))
    place[:, :, 0] = 7.0 - 0.5 * np.tanh((TEMPERATURE[:, None] - 30.0) / 10.0) + tracks.basis @ coefficients
    return tracks, place


def drawn(modes: int) -> np.ndarray:
    """Coefficients that differ by 1 %, 0.5 % and 0.3 % beyond the constant."""
    size = np.array([0.3, 0.01, 0.005, 0.003])
    return size[:, None] * np.random.default_rng(0).normal(size=(4, modes))


def test_curves_are_told_by_those_of_the_plate_to_bend_as_little_as_they_do() -> None:
    """Of 60 modes, one of which leaves the others, standard deviations come out within a third."""
    coefficients = drawn(60)
    coefficients[1:, 7] = 0.4
    tracks, place = curved(coefficients)
    estimated = tracks.estimated(place, np.ones(place.shape[:2], bool))
    np.testing.assert_allclose(np.sqrt(estimated.own[:, 1:, 0]), [[0.01, 0.005, 0.003]] * 60, rtol=0.33)
    assert np.array_equal(estimated.own[:, 0], tracks.own[:, 0])
    assert np.array_equal(estimated.own[:, :, 1], tracks.own[:, :, 1])


def test_modes_that_few_sweeps_show_learn_from_the_others_and_tell_nothing() -> None:
    coefficients = drawn(12)
    coefficients[1:, 6:] = 0.2
    tracks, place = curved(coefficients)
    active = np.ones(place.shape[:2], bool)
    active[:4, 6:] = False
    estimated = tracks.estimated(place, active)
    np.testing.assert_allclose(np.sqrt(estimated.own[:, 1:, 0]).max(axis=0), [0.01, 0.005, 0.003], rtol=1.0)
    assert np.array_equal(tracks.estimated(place, active & (np.arange(12) < 4)).own, tracks.own)


def test_background_bends_as_it_likes() -> None:
    tracks, place = curved(drawn(12))
    tracks.own[3, :2, 1] = 1.0
    estimated = tracks.estimated(place, np.ones(place.shape[:2], bool))
    assert np.array_equal(estimated.own[3], tracks.own[3])
    assert (estimated.own[4, 1:, 0] < tracks.own[4, 1:, 0]).all()


def test_curves_that_are_all_alike_keep_the_scatter() -> None:
    coefficients = drawn(12)
    coefficients[1:] = 0.0
    tracks, place = curved(coefficients)
    estimated = tracks.estimated(place, np.ones(place.shape[:2], bool))
    np.testing.assert_allclose(np.sqrt(estimated.own[:, 1:, 0]), tracks.scatter[0])
