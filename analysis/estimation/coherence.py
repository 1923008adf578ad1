"""The variance of an FRF from the coherence that came with it."""

import numpy as np
from numpy.typing import NDArray

from analysis.recordings.noise_power import single_repeat_power

LEAST_COHERENCE = 1e-6
"""Coherence below which a line counts as of this coherence: it weighs nothing."""


def without_information(coherence: NDArray[np.float64]) -> bool:
    """Whether a coherence is 1 on every line: that of a single average, or a program's default."""
    return bool((coherence > 1.0 - 1e-9).all())


def coherence_variance(
    h: NDArray[np.complex128], coherence: NDArray[np.float64], averages: float | None = None
) -> NDArray[np.float64] | None:
    """E|h - H|^2 = |h|^2 (1 - c) / (n c), of H1 (Bendat and Piersol, Random Data, 2010, ch. 9).

    Parameters
    ----------
    h : (F,) complex ndarray
    coherence : (F,) ndarray
        0 to 1.
    averages : float, optional
        n; where it is not given, the level of the noise is taken from the roughness of `h` along
        frequency, and only its course from the coherence.

    Returns
    -------
    (F,) ndarray or None
        In the square of the unit of `h`, above zero; None where there is no information in the
        coherence (`without_information`), or the FRF is zero throughout.

    Raises
    ------
    ValueError
        Where the coherence leaves 0 to 1.
    """
    if not ((coherence >= -1e-6) & (coherence <= 1.0 + 1e-4)).all():
        raise ValueError(f"coherence from {coherence.min():.3g} to {coherence.max():.3g}; 0 to 1 allowed")
    power = float((np.abs(h) ** 2).mean())
    if without_information(coherence) or power == 0.0:
        return None
    known = np.clip(coherence, LEAST_COHERENCE, 1.0 - 1e-9)
    course: NDArray[np.float64] = np.abs(h) ** 2 * (1.0 - known) / known
    course = np.maximum(course, 1e-24 * power)
    largest = max(float(course.max()), power / LEAST_COHERENCE)  # whatever |h| is there
    course = np.where(coherence <= LEAST_COHERENCE, largest, course)
    if averages is not None:
        return course / averages
    level = float(np.median(single_repeat_power(h) / course) / np.log(2.0))
    return course * max(level, 1e-12)
