"""When filters are changed for another temperature, and how without a click."""

import numpy as np
from numpy.typing import NDArray

FADE_TIME = 0.02
"""Seconds over which one set of filters fades into the next."""
TEMPERATURE_STEP = 0.25
"""Kelvin by which a reading has to leave the temperature of the filters in use before they are changed."""


def raised_cosine(first: int, count: int, length: int) -> NDArray[np.float64]:
    """Share of the new filters in a fade, sample by sample.

    Its spectrum falls by 18 dB an octave, so that a fade adds little beyond the band of the filters.

    Parameters
    ----------
    first : int
        Samples of the fade already past.
    count : int
        Samples wanted.
    length : int
        Samples of the whole fade.

    Returns
    -------
    (count,) ndarray
        0 to 1.
    """
    done = np.minimum(first + np.arange(count), length)
    share: NDArray[np.float64] = 0.5 - 0.5 * np.cos(np.pi * done / length)
    return share
