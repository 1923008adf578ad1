import numpy as np
import pytest

from analysis.scatter import median_deviation


def test_normal_numbers_have_their_standard_deviation_whatever_a_few_others_are() -> None:
    values = 5.0 + 0.3 * np.random.default_rng(0).normal(size=(20_000, 2))
    values[::100] = 1e6
    assert median_deviation(values) == pytest.approx(np.full((1, 2), 0.3), rel=0.03)
    assert median_deviation(values, axis=(0, 1)).shape == (1, 1)
