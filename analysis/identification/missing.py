"""Missing poles, lost by elimination or never found by vector fitting: searched in the residual of the model."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from analysis.identification.added_columns import pair_gains
from analysis.identification.bic import bic
from analysis.identification.lines import Lines
from analysis.identification.order import attempt
from analysis.identification.pole_residue import pole_columns, synthesis
from analysis.identification.pole_search import PoleFit
from analysis.identification.resolution import unresolved


def residual(lines: Lines, fitted: PoleFit) -> NDArray[np.complex128]:
    """Measured minus model, (K, F)."""
    now = fitted.projection
    left: NDArray[np.complex128] = lines.h - synthesis(
        lines.frequency, now.poles, now.residues, fitted.terms, now.coefficients
    )
    return left


def matched(lines: Lines, left: NDArray[np.complex128], shortlist: int = 8) -> NDArray[np.complex128]:
    """Poles that would explain most of a residual, from a bank of matched filters, one per half width.

    Every filter is the weighted line shape 1/(s - lambda), correlated with the residual over the whole band by
    FFT; the strongest peaks of all widths are returned.

    Parameters
    ----------
    lines : Lines
    left : (K, F) complex ndarray
        Measured minus model.
    shortlist : int
        Largest number of poles returned.

    Returns
    -------
    (N,) complex ndarray
        rad/s, upper half plane, strongest first; N is at most `shortlist`.
    """
    spacing = lines.spacing
    place = np.round((lines.frequency - lines.frequency[0]) / spacing).astype(int)
    span = place[-1] + 1
    length = int(2 ** np.ceil(np.log2(2 * span)))
    white = np.zeros((len(left), span), dtype=complex)
    weight = np.zeros((len(left), span))
    white[:, place] = left / lines.deviation**2
    weight[:, place] = lines.deviation**-2.0
    white, weight = np.fft.fft(white, length), np.fft.fft(weight, length)
    found: list[tuple[float, complex]] = []
    width = 1.5 * spacing
    while width < 0.08 * (lines.frequency[-1] - lines.frequency[0]):
        reach, reach_squared = _line_shape(length, spacing, width)
        overlap = np.fft.ifft(white * reach)[:, :span]
        energy = np.fft.ifft(weight * reach_squared).real[:, :span]
        gain = (np.abs(overlap) ** 2 / np.maximum(energy, 1e-12 * energy.max())).sum(0)
        peaks = np.flatnonzero((gain >= np.roll(gain, 1)) & (gain > np.roll(gain, -1)))
        for peak in peaks[np.argsort(gain[peaks])[::-1][:shortlist]]:
            f = lines.frequency[0] + spacing * peak
            found.append((float(gain[peak]), 2.0 * np.pi * complex(-width, f)))
        width *= 2.0
    found.sort(key=lambda pair: -pair[0])
    return np.array([pole for _, pole in found[:shortlist]], dtype=complex)


@lru_cache(maxsize=32)  # the same for all sweeps of a campaign
def _line_shape(
    length: int, spacing: float, width: float
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Conjugate spectra of 1/(j f + width), f on `length` lines, and of its squared magnitude."""
    shape = 1.0 / (1j * np.fft.fftfreq(length, 1.0 / length) * spacing + width)
    return np.fft.fft(shape).conj(), np.fft.fft(np.abs(shape) ** 2).conj()


def gains(lines: Lines, fitted: PoleFit, poles: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Fall of the misfit by adding each pole alone, all residues refitted, poles held.

    Parameters
    ----------
    lines : Lines
    fitted : PoleFit
    poles : (N,) complex ndarray
        Candidates, rad/s.

    Returns
    -------
    (N,) ndarray
    """
    s = lines.s
    model = np.concatenate([pole_columns(s, fitted.poles), lines.term_columns(fitted.terms)])
    new = pole_columns(s, poles)
    return pair_gains(lines, model, new, residual(lines, fitted))[0]


def add_missing(lines: Lines, blocks: Lines, fitted: PoleFit, *, most: int = 6) -> PoleFit:
    """Add the poles that explain most of the residual, one at a time, as long as BIC falls.

    Parameters
    ----------
    lines : Lines
        All lines; candidates come from their residual.
    blocks : Lines
        The same FRFs averaged, on which BIC is judged.
    fitted : PoleFit
        On `blocks`.
    most : int
        Largest number of poles added.

    Returns
    -------
    PoleFit
        On `blocks`.
    """
    for _ in range(most):
        candidates = matched(lines, residual(lines, fitted))
        if len(candidates) == 0:
            return fitted
        level = bic(fitted, blocks)
        trials = [
            attempt(blocks, np.append(fitted.poles, pole), fitted.terms, level)
            for pole in candidates[np.argsort(gains(blocks, fitted, candidates))[::-1][:2]]
        ]
        better = [trial for trial in trials if trial is not None]
        if not better:
            return fitted
        trial = min(better, key=lambda t: t.projection.misfit)
        if unresolved(lines, trial.poles, trial.projection.residues).any():
            return fitted
        fitted = trial
    return fitted
