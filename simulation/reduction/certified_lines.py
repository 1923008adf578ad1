"""Check that frequencies are within the band of a reduced plate."""

import numpy as np
from numpy.typing import ArrayLike

from analysis.arrays import Real


def certified_lines(frequency: ArrayLike, band: tuple[float, float]) -> Real:
    """Return frequencies, Hz, as an array of one axis or more; ValueError for one outside the band, Hz."""
    lines = np.atleast_1d(np.asarray(frequency, float))
    low, high = band
    outside = lines[~((lines >= low * (1 - 1e-9)) & (lines <= high * (1 + 1e-9)))]
    if outside.size:
        raise ValueError(f"frequency {outside[0]:.6g} Hz is outside the twin's band, {low:g} to {high:g} Hz")
    return lines
