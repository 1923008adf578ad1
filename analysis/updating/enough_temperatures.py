"""At how many temperatures estimates are needed before laws can be fitted through them."""

import numpy as np
from numpy.typing import NDArray

from analysis.gap.data.groups import TemperatureGroups

FEWEST = 3
"""Temperatures that laws need: from two, the data cannot tell how smooth a law is."""


def distinct_temperatures(temperature: NDArray[np.float64]) -> int:
    """Count the set-points at which readings (T,), degrees Celsius, were taken: legs and levels repeat them."""
    return len(TemperatureGroups.of(temperature).size) if temperature.size else 0
