"""The paper's recipe (section 4.2): pick peaks, fit each locally, then refine all poles over the wide band.

Provided to reproduce the paper. A mode without a peak of its own is not found, and in a lossy plate peaks merge:
about a tenth of R10's modes is missed, where `automatic` misses none.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.finishing import finish
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.pole_residue import REAL_E, REAL_E_F, ResidualTerms
from analysis.identification.pole_search import fit
from analysis.identification.settings import Settings

LEAST_PROMINENCE = 10.0
"""Smallest prominence of a peak, in standard deviations of the noise."""


def identify_by_peaks(
    measured: Measured, settings: Settings | None = None, terms: ResidualTerms = REAL_E_F
) -> Modes:
    """Identify FRFs that share their poles by their peaks.

    Parameters
    ----------
    measured : Measured
        One drive, K responses.
    settings : Settings, optional
        Only the mains frequency is used.
    terms : ResidualTerms
        The paper's E + F/s^2 by default.

    Raises
    ------
    ValueError
        If no peak stands out of the noise.
    """
    lines = measured.lines()
    start = [local_pole(lines, place, width) for place, width in peaks(lines)]
    if not start:
        raise ValueError(
            f"no peak stands {LEAST_PROMINENCE:g} standard deviations out of the noise: nothing to pick"
        )
    found = fit(lines, np.array(start), terms, tolerance=1e-6, max_iterations=100)
    return finish(measured, lines, found, settings or Settings())[0]


def peaks(lines: Lines) -> list[tuple[int, float]]:
    """Find peaks: the index of each one's line, and its half-power width in lines.

    Amplitudes in standard deviations of the band's noise, all responses together.
    """
    from scipy.signal import find_peaks, peak_widths

    noise = np.median(lines.deviation, axis=1, keepdims=True)  # scatter over lines would add peaks
    height: NDArray[np.float64] = np.sqrt((np.abs(lines.h / noise) ** 2).mean(axis=0))
    places, _ = find_peaks(height, prominence=LEAST_PROMINENCE)
    widths = peak_widths(height, places, rel_height=1.0 - np.sqrt(0.5))[0]
    return [(int(place), float(width)) for place, width in zip(places, widths, strict=True)]


def local_pole(lines: Lines, place: int, width: float) -> complex:
    """Pole of one peak, fitted alone with a constant over one half-power width to either side.

    Parameters
    ----------
    place : int
        Line of the peak.
    width : float
        Half-power width, in lines.

    Returns
    -------
    complex
        rad/s; the half-power estimate itself where the fit leaves that window.
    """
    f = lines.frequency[place]
    half = 0.5 * max(width, 1.0) * float(lines.spacing_at(f))
    guess = 2.0 * np.pi * complex(-half, f)
    reach = max(int(np.ceil(width)), 4)
    window = slice(max(place - reach, 0), place + reach + 1)
    if window.stop - window.start < 8 or len(lines.frequency[window]) < 8:
        return guess
    near = Lines(lines.frequency[window], lines.h[:, window], lines.deviation[:, window], as_measured=lines.grid)
    pole = complex(fit(near, np.array([guess]), REAL_E, tolerance=1e-6).poles[0])
    inside = near.frequency[0] <= pole.imag / (2.0 * np.pi) <= near.frequency[-1]
    return pole if inside and -pole.real < 8.0 * np.pi * half else guess
