"""Wilson's interval against published values and against its own definition."""

import numpy as np
import pytest
from scipy.stats import binomtest

from app.blind_trial.proof import NINETY_FIVE, proportion_interval


def test_values_in_the_literature():
    """R. G. Newcombe, Statistics in Medicine 17, 1998, table I, method 3."""
    assert proportion_interval(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert proportion_interval(15, 148) == pytest.approx((0.0624, 0.1605), abs=5e-5)
    assert proportion_interval(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)
    assert proportion_interval(1, 29) == pytest.approx((0.0061, 0.1718), abs=5e-5)


@pytest.mark.parametrize(("hits", "count"), [(0, 1), (1, 1), (3, 7), (198, 200)])
def test_against_scipy(hits: int, count: int):
    other = binomtest(hits, count).proportion_ci(0.95, method="wilson")
    assert proportion_interval(hits, count) == pytest.approx((other.low, other.high), abs=1e-12)


def test_the_ends_are_where_the_normal_test_turns():
    low, high = proportion_interval(7, 40)
    for p in (low, high):
        assert abs(7 / 40 - p) / np.sqrt(p * (1 - p) / 40) == pytest.approx(NINETY_FIVE)


def test_nothing_counted_says_nothing():
    assert proportion_interval(0, 0) == (0.0, 1.0)
    with pytest.raises(ValueError, match="5 hits of 4"):
        proportion_interval(5, 4)
