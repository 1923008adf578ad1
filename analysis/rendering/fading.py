"""When filters are changed for another temperature, and how without a click."""

import numpy as np
from numpy.typing import NDArray

FADE = 0.02
"""Seconds over which one set of filters fades into the next."""
STEP = 0.25
"""Kelvin by which a reading has to leave the temperature of the filters in use before they are changed."""


def raised_cosine(first: int, count: int, length: int) -> NDArray[np.float64]:
    """Share (count,) of the new filters from sample `first` of a fade of `length` samples on: 0 to 1.

    Its spectrum falls by 18 dB an octave, so that little of a fade is heard beyond the band of the filters.
    """
    done = np.minimum(first + np.arange(count), length)
    share: NDArray[np.float64] = 0.5 - 0.5 * np.cos(np.pi * done / length)
    return share
