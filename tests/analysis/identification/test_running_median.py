from typing import Literal

import numpy as np
import pytest
from scipy.ndimage import median_filter

from analysis.identification.lines import running_median


@pytest.mark.parametrize("mode", ["nearest", "reflect"])
@pytest.mark.parametrize("window", [40, 41])
def test_it_is_the_median_of_every_window(mode: Literal["nearest", "reflect"], window: int) -> None:
    values = np.random.default_rng(0).normal(size=(3, 200))
    every = median_filter(values, (1, window), mode=mode)
    np.testing.assert_array_equal(running_median(values, window, mode), every)
