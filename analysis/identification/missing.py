"""Poles found in the residual of a model: missing ones added, and one replaced by two close ones.

Missing poles were lost by elimination, or never found by vector fitting.

Poles at lambda + d and lambda - d with total residue R differ from one pole between them by R d^2/(s - lambda)^3
and higher powers; a term in 1/(s - lambda)^2 only moves the one pole. The coefficient of 1/(s - lambda)^3 in the
residual gives the complex d, so that the search starts with the separation and orientation estimated from the
data.
"""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dtrtrs

from analysis.identification.judgement.resolution import unresolved
from analysis.identification.lines import Lines
from analysis.identification.order import attempt, bic, misfit_worth
from analysis.identification.pole_residue import (
    fill_columns,
    paired,
    pole_columns,
    residues_from_columns,
    synthesis,
)
from analysis.identification.pole_search import PREDICTED_FALL_FACTOR, PoleFit, triangular_factor

WIDTHS = (1.5, 0.08)
"""Half widths of the filters: from so many lines to this share of the band, each twice the one before."""

MOST_PLACES = 1000
"""Places at which uneven lines are searched: the wider filters reach from one to the next."""

VALUES_AT_ONCE = 1_000_000
"""Number of values, lines times places, that are computed at once."""

Filtered = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.complex128], NDArray[np.float64]]
"""Places (N,) and half widths (N,), Hz; correlation with the residual (K, N) and energy (K, N) of the filter."""


def residual(lines: Lines, fitted: PoleFit) -> NDArray[np.complex128]:
    """Measured minus model, (K, F)."""
    now = fitted.projection
    left: NDArray[np.complex128] = lines.h - synthesis(
        lines.frequency, now.poles, now.residues, fitted.terms, now.coefficients
    )
    return left


def matched(lines: Lines, left: NDArray[np.complex128], shortlist: int = 8) -> NDArray[np.complex128]:
    """Poles that would explain most of a residual, from a bank of matched filters, one per half width.

    Every filter is the weighted line shape 1/(s - lambda), correlated with the residual over the whole band; the
    strongest peaks of all widths are returned.

    Parameters
    ----------
    left : (K, F) complex ndarray
        Measured minus model.
    shortlist : int
        Largest number of poles returned.

    Returns
    -------
    (N,) complex ndarray
        rad/s, upper half plane, strongest first; N is at most `shortlist`.
    """
    found: list[tuple[float, complex]] = []
    for place, width, overlap, energy in (_by_fft if lines.even else _line_by_line)(lines, left):
        gain = (np.abs(overlap) ** 2 / np.maximum(energy, 1e-12 * energy.max())).sum(0)
        peaks = np.flatnonzero((gain >= np.roll(gain, 1)) & (gain > np.roll(gain, -1)))
        highest = peaks[np.argsort(gain[peaks])[::-1][:shortlist]]
        found += [(float(gain[n]), 2.0 * np.pi * complex(-width[n], place[n])) for n in highest]
    found.sort(key=lambda pair: -pair[0])
    return np.array([pole for _, pole in found[:shortlist]], dtype=complex)


def _by_fft(lines: Lines, left: NDArray[np.complex128]) -> Iterator[Filtered]:
    """Correlate with every width, at all places of even lines."""
    spacing = lines.spacing
    line = np.round((lines.frequency - lines.frequency[0]) / spacing).astype(int)
    span = line[-1] + 1
    length = int(2 ** np.ceil(np.log2(2 * span)))
    white = np.zeros((len(left), span), dtype=complex)
    weight = np.zeros((len(left), span))
    white[:, line] = left / lines.deviation**2
    weight[:, line] = lines.deviation**-2.0
    white, weight = np.fft.fft(white, length), np.fft.fft(weight, length)
    place = lines.frequency[0] + spacing * np.arange(span)
    width = WIDTHS[0] * spacing
    while width < WIDTHS[1] * (lines.frequency[-1] - lines.frequency[0]):
        reach, reach_squared = _line_shape(length, spacing, width)
        overlap = np.fft.ifft(white * reach)[:, :span]
        energy = np.fft.ifft(weight * reach_squared).real[:, :span]
        yield place, np.full(span, width), overlap, energy
        width *= 2.0


def _line_by_line(lines: Lines, left: NDArray[np.complex128]) -> Iterator[Filtered]:
    """Correlate with every width, at uneven lines: one grid for all would be as fine as their densest."""
    f, white, weight = lines.frequency, left / lines.deviation**2, lines.deviation**-2.0
    place = f[:: -(-len(f) // MOST_PLACES)]
    width = WIDTHS[0] * lines.spacing_at(place)
    while (at := width < WIDTHS[1] * (f[-1] - f[0])).any():
        place, width = place[at], width[at]
        overlap, energy = np.empty((len(left), len(place)), complex), np.empty((len(left), len(place)))
        for part in np.array_split(np.arange(len(place)), -(-len(place) * len(f) // VALUES_AT_ONCE)):
            shape = 1.0 / (width[part] - 1j * (f[:, None] - place[part]))
            overlap[:, part], energy[:, part] = white @ shape, weight @ np.abs(shape) ** 2
        yield place, width, overlap, energy
        width = 2.0 * width


@lru_cache(maxsize=32)  # the same for all sweeps of a campaign
def _line_shape(
    length: int, spacing: float, width: float
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Conjugate spectra of 1/(j f + width), f on `length` lines, and of its squared magnitude."""
    shape = 1.0 / (1j * np.fft.fftfreq(length, 1.0 / length) * spacing + width)
    return np.fft.fft(shape).conj(), np.fft.fft(np.abs(shape) ** 2).conj()


def pair_gains(
    lines: Lines, known: NDArray[np.complex128], pairs: NDArray[np.complex128], left: NDArray[np.complex128]
) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """Fall of the misfit if one pair of columns (a pole) is added alone, with a coefficient for every response.

    Parameters
    ----------
    known : (P, F) complex ndarray
        Columns of the model.
    pairs : (2N, F) complex ndarray
        Columns multiplied by the real and the imaginary part of a complex coefficient, alternating.
    left : (K, F) complex ndarray
        Measured minus model.

    Returns
    -------
    gain : (N,) ndarray
    factor : (K, N) complex ndarray
    """
    gain = np.zeros(len(pairs) // 2)
    factor = np.zeros((len(left), len(gain)), dtype=complex)
    for group in lines.weight_groups:
        model = known.view(float) * group.weight
        fresh = np.concatenate([pairs, left[group.rows] * group.scales[:, None]]).view(float) * group.weight
        triangle, lengths = triangular_factor(model, len(model))
        onto = dtrtrs(triangle, model @ fresh.T / lengths[:, None], trans=1)[0]
        among = fresh @ fresh.T - onto.T @ onto
        for n in range(len(gain)):
            own = slice(2 * n, 2 * n + 2)
            overlap = among[own, len(pairs) :]
            solved = np.linalg.lstsq(among[own, own], overlap, rcond=1e-10)[0]
            gain[n] += (overlap * solved).sum()
            factor[group.rows, n] = residues_from_columns((solved / group.scales).T)[:, 0]
    return gain, factor


def gains(lines: Lines, fitted: PoleFit, poles: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Fall of the misfit by adding each pole alone, all residues refitted, poles held.

    Parameters
    ----------
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


LARGEST_SPLIT = 0.5
"""Largest distance from a pole to either of the two, in half widths: with a larger one there are two peaks."""

POLES_TRIED = 4
"""Number of poles that are tried, in order of predicted gain."""


def split(lines: Lines, fitted: PoleFit) -> PoleFit | None:
    """Replace a pole by two close ones where BIC falls most.

    Parameters
    ----------
    fitted : PoleFit
        Converged for its number of poles.

    Returns
    -------
    PoleFit or None
        None where BIC does not fall.
    """
    gain, apart = _thirds(lines, fitted)
    if lines.damping is not None:  # two close modes of usual damping look like one with more
        gain = gain + 0.5 * lines.redundancy * lines.damping.departure(fitted.poles)[0]
    level, now = bic(fitted, lines), fitted.projection
    target = misfit_worth(lines, level, len(fitted.poles) + 1, fitted.terms)
    for j in np.argsort(-gain)[:POLES_TRIED]:
        if now.misfit - PREDICTED_FALL_FACTOR * gain[j] > target:
            break
        pole, half_width = fitted.poles[j], -fitted.poles[j].real
        d = np.sqrt(apart[j])
        d *= min(1.0, LARGEST_SPLIT * half_width / abs(d))
        two = attempt(lines, np.append(np.delete(fitted.poles, j), [pole + d, pole - d]), fitted.terms, level)
        if two is not None:
            return two
    return None


def _thirds(lines: Lines, fitted: PoleFit) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """Fall of the misfit with a term in 1/(s - lambda)^3 for each pole, and the d^2 from it, (J,) each."""
    poles, residues, count = fitted.poles, fitted.projection.residues, len(fitted.poles)
    known = np.empty((4 * count, len(lines.s)), dtype=complex)
    fill_columns(lines.s, poles, known[: 2 * count], known[2 * count :])
    known = np.concatenate([known, lines.term_columns(fitted.terms)])
    inverse = 1.0 / (lines.s - np.concatenate([poles, poles.conj()])[:, None])
    new = np.empty((2 * count, len(lines.s)), dtype=complex)
    paired(inverse**3, new)
    gain, factor = pair_gains(lines, known, new, residual(lines, fitted))
    return gain, (residues.conj() * factor).sum(axis=0) / (np.abs(residues) ** 2).sum(axis=0)
