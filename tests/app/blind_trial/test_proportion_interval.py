"""Wilson's interval against published values and against its own definition."""

import numpy as np
import pytest
from scipy.stats import binomtest

from app.blind_trial.proportion_interval import NINETY_FIVE, wilson


def test_values_in_the_literature():
    """R. G. Newcombe, Statistics in Medicine 17, 1998, table I, method 3."""
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert wilson(15, 148) == pytest.approx((0.0624, 0.1605), abs=5e-5)
    assert wilson(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)
    assert wilson(1, 29) == pytest.approx((0.0061, 0.1718), abs=5e-5)


@pytest.mark.parametrize(("hits", "count"), [(0, 1), (1, 1), (3, 7), (198, 200)])
def test_against_scipy(hits: int, count: int):
    other = binomtest(hits, count).proportion_ci(0.95, method="wilson")
    assert wilson(hits, count) == pytest.approx((other.low, other.high), abs=1e-12)


def test_the_ends_are_where_the_normal_test_turns():
    low, high = wilson(7, 40)
    for p in (low, high):
        assert abs(7 / 40 - p) / np.sqrt(p * (1 - p) / 40) == pytest.approx(NINETY_FIVE)


def test_nothing_counted_says_nothing():
    assert wilson(0, 0) == (0.0, 1.0)
    with pytest.raises(ValueError, match="5 hits of 4"):
        wilson(5, 4)
