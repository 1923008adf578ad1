from itertools import combinations

import numpy as np
import pytest

from analysis.focusing.energy import EnergyForms
from analysis.focusing.methods import invert
from analysis.focusing.performance import contrast
from analysis.focusing.placement import clearance, exchange, refined


def test_exchange_finds_the_best_set_of_all(make_plate, make_panel, rng):
    """Three of twenty positions: 1140 sets, all of them tried."""
    centers = np.array([(x, y) for x in (0.03, 0.075, 0.12, 0.165, 0.21) for y in (0.03, 0.07, 0.12, 0.16)])
    plate = make_plate(make_panel(tuple(map(tuple, centers))))
    frequency = np.linspace(100.0, 500.0, 9)
    forms = plate.space.forms([plate.amplitudes(2.2e9, 0.33, 0.06, frequency)])

    def contrast_of(subset):
        part = EnergyForms(
            forms.plate[:, :, subset[:, None], subset],
            forms.target[:, :, subset[:, None], subset],
            forms.aim[:, :, subset],
        )
        return contrast(part, invert(part).filters).mean()

    def score(subsets):
        return np.array([contrast_of(subset) for subset in subsets])

    sets = np.array(list(combinations(range(len(centers)), 3)))
    scores = score(sets)
    found = exchange(score, ~np.eye(len(centers), dtype=bool), 3, rng, starts=6)
    assert found.score == pytest.approx(scores.max())
    np.testing.assert_array_equal(found.chosen, sets[np.argmax(scores)])
    assert found.scores.max() == found.score


def test_patches_keep_their_distance(rng):
    centers = np.array([(0.0, 0.0), (0.01, 0.01), (0.02, 0.0), (0.0, 0.03)])
    free = clearance(centers, 0.02)
    np.testing.assert_array_equal(free[0], [False, False, True, True])
    np.testing.assert_array_equal(free, free.T)
    found = exchange(lambda sets: -sets.sum(axis=1).astype(float), free, 2, rng)
    assert free[tuple(found.chosen)]
    np.testing.assert_array_equal(found.chosen, [0, 2])


def test_too_many_for_the_plate_is_refused(rng):
    with pytest.raises(ValueError, match="no 3 of the 4 candidates"):
        exchange(lambda sets: np.zeros(len(sets)), np.zeros((4, 4), dtype=bool), 3, rng)


def test_small_moves_end_where_no_neighbour_is_better():
    hill = np.array([(0.031, 0.052), (0.1, 0.06)])

    def score(layouts):
        return -np.abs(layouts - hill).sum(axis=(1, 2))

    start = np.array([(0.02, 0.02), (0.13, 0.1)])
    found, value = refined(score, start, lambda layout: True, [0.01, 0.001])
    np.testing.assert_allclose(found, hill, atol=1e-9)
    assert value == pytest.approx(0.0, abs=1e-9)
    walled, _ = refined(
        score, start, lambda layout: bool((layout[:, 0] >= 0.015).all() and layout[1, 1] > 0.085), [0.01]
    )
    assert walled[1, 1] == pytest.approx(0.09)
