"""Leakage of windowed segments: what it does to poles and residues, and their correction."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.estimators import Segments
from analysis.identification.lines import Lines
from analysis.identification.modes import Modes
from analysis.identification.pole_residue import to_parameters, to_poles
from analysis.identification.pole_search import PoleFit, fit

MOST_CORRECTIONS = 12
"""Most repetitions of the correction."""

LARGEST_LAST_STEP = 1e-3
"""Largest change of log damping ratio, and of log |pole| over damping ratio, in the last step."""

MOST = np.log(2.0)
"""Largest correction of log damping ratio: modes that the window widens more are not known."""

UNSURE = {"h1": 0.1, "h2": 0.5, "hv": 0.5}
"""Standard deviation of a correction, relative to it. The force is not flat over the width of the window; leakage
that the drive does not explain is partly taken for noise of the response, which H2 and Hv are without."""


def seen_through(segments: Segments, modes: Modes, frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
    """FRFs of modes as spectra over segments show them, with a flat force.

    Parameters
    ----------
    frequency : (F,) ndarray
        Hz.

    Returns
    -------
    (K, F) complex ndarray
        Of H1: H smoothed by the power of the window's spectrum. H2 and Hv contain |H|^2 smoothed in the same way.
    """
    h = modes.synthesis(frequency)
    poles = np.concatenate([modes.poles, modes.poles.conj()])
    residues = np.concatenate([modes.residues, modes.residues.conj()], axis=1)
    change = segments.changes(np.asarray(2j * np.pi * frequency, dtype=np.complex128), poles)
    seen = np.asarray(h + residues @ change)
    if segments.estimator == "h1" or not len(poles):
        return seen
    # on the axis |H|^2 is 2 Re of a sum over the poles, with the residues R conj(H(-conj(lambda)))
    mirrored = np.array([_at(modes, -p.conjugate()) for p in poles]).T
    power = np.maximum(np.abs(h) ** 2 + 2.0 * ((residues * mirrored.conj()) @ change).real, np.abs(seen) ** 2)
    size = np.maximum(np.abs(seen), np.finfo(float).tiny)
    return np.asarray(seen * (power / size**2 if segments.estimator == "h2" else np.sqrt(power) / size))


def _at(modes: Modes, s: complex) -> NDArray[np.complex128]:
    """FRFs (K,) at a point off the axis."""
    h = (modes.residues / (s - modes.poles)).sum(1) + (modes.residues.conj() / (s - modes.poles.conj())).sum(1)
    return np.asarray(h + modes.coefficients @ np.array([s**power for power in modes.terms.powers]))


class Unleaked(NamedTuple):
    """Modes without the leakage of segments.

    Attributes
    ----------
    modes : Modes
        Corrected, with the uncertainty of the correction in the covariance; as fitted, with the leakage in the
        covariance, where the correction does not converge.
    bias : (J, 2) ndarray
        What leakage added to log |pole| and log damping ratio.
    corrected : bool
    """

    modes: Modes
    bias: NDArray[np.float64]
    corrected: bool


def without_leakage(modes: Modes, lines: Lines, segments: Segments) -> Unleaked:
    """Find the modes that look like the fitted ones through the windows of segments.

    Parameters
    ----------
    modes : Modes
        As fitted.
    lines : Lines
        To which, for their weights.
    """

    def seen(now: Modes) -> PoleFit:
        return fit(replace(lines, h=seen_through(segments, now, lines.frequency)), modes.poles, modes.terms)

    fitted = to_parameters(modes.poles)
    now, first = modes, np.zeros(fitted.shape)
    for step in range(MOST_CORRECTIONS):
        found = seen(now)
        moved = fitted - to_parameters(found.poles)
        first = first if step else -moved
        x = to_parameters(now.poles) + moved
        if not np.isfinite(x).all() or np.abs(x - fitted)[modes.real, 1].max(initial=0.0) > MOST:
            break
        residues = now.residues + modes.residues - found.projection.residues
        now = replace(now, poles=to_poles(x), residues=residues)
        if _size(moved, fitted)[modes.real].max(initial=0.0) < LARGEST_LAST_STEP:
            bias = fitted - x
            spread = _spread(modes.covariance, bias, UNSURE[segments.estimator])
            return Unleaked(replace(now, covariance=spread), bias, True)
    spread = modes.covariance + first[:, :, None] * first[:, None, :]
    return Unleaked(replace(modes, covariance=spread), first, False)


def _size(moved: NDArray[np.float64], fitted: NDArray[np.float64]) -> NDArray[np.float64]:
    """Largest of the two changes of every pole, that of the frequency in units of its half width."""
    return np.asarray(np.abs(moved / np.column_stack([np.exp(fitted[:, 1]), np.ones(len(moved))])).max(axis=1))


def _spread(covariance: NDArray[np.float64], bias: NDArray[np.float64], unsure: float) -> NDArray[np.float64]:
    """Covariance of corrected poles: the same deviation in the complex plane, and the error of the correction."""
    scale = np.column_stack([np.ones(len(bias)), np.exp(bias[:, 1])])
    known = covariance * scale[:, :, None] * scale[:, None, :]
    return np.asarray(known + unsure**2 * bias[:, :, None] * bias[:, None, :])
