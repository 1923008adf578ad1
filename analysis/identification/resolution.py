"""Pairs of poles that the frequency resolution cannot separate.

A record of 1/spacing seconds cannot separate two frequencies closer than about two lines, and a resonance that
rings longer than the record leaks into the lines around it. Extra poles fit both better than one pole does, so an
information criterion accepts them; this rule rejects them.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.shapes.assurance import mpc

CLOSEST = 2.0
"""Smallest distance of two modes, in line spacings."""

NARROWEST_PAIR = 3.5
"""Half width, in line spacings, of the narrower of two modes from which they may be closer than `CLOSEST`: on so
many lines BIC distinguishes the sum of two resonances from one."""

NARROW = 6.0
"""Half width, in line spacings, below which a resonance may leak."""

REACH = 30.0
"""Distance from a narrow resonance, in line spacings, within which a small pole is taken for its leakage."""

SMALL = 0.1
"""Largest height of such a pole, relative to the resonance."""

NEEDLE_SMALL = 0.5
"""The same for a pole narrower than one line spacing: noise near a tall peak is larger."""

COINCIDENT = 0.5
"""Distance of two poles, in half widths of the narrower, up to which they may represent one mode whose frequency
differs from one FRF to the next: the structure changed between the measurements."""

IN_PHASE, OUT_OF_PHASE = 0.95, 0.75
"""They do if the modal phase collinearity of the sum of their residues is above the first value and that of one of
the two below the second. A measured beam, hit at nine places, gives 0.99 and 0.55; its other modes over 0.98."""


def heights(poles: NDArray[np.complex128], residues: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Height of every pole's peak, |R|/|Re lambda|, root sum of squares over responses: (J,) ndarray."""
    size: NDArray[np.float64] = np.linalg.norm(residues, axis=0) / -poles.real
    return size


def unresolved(
    poles: NDArray[np.complex128], residues: NDArray[np.complex128], spacing: float
) -> NDArray[np.bool_]:
    """Poles that are leakage, or the smaller one of two that the lines cannot separate.

    Parameters
    ----------
    poles : (J,) complex ndarray
        rad/s.
    residues : (K, J) complex ndarray
    spacing : float
        Of the lines, Hz.

    Returns
    -------
    (J,) ndarray of bool
    """
    height = heights(poles, residues)
    place = poles.imag / (2.0 * np.pi * spacing)
    width = -poles.real / (2.0 * np.pi * spacing)
    standing = np.zeros(len(poles), dtype=bool)
    for j in np.argsort(height)[::-1]:
        others = np.flatnonzero(standing)
        apart, narrower = np.abs(place[others] - place[j]), np.minimum(width[others], width[j])
        small = NEEDLE_SMALL if width[j] < 1.0 else SMALL
        leaked = (width[others] < NARROW) & (apart < REACH) & (height[j] < small * height[others])
        close = (apart < CLOSEST) & (narrower < NARROWEST_PAIR)
        standing[j] = not (leaked | close).any() and not any(
            _one_that_moves(poles[[i, j]], residues[:, [i, j]]) for i in others[apart < COINCIDENT * narrower]
        )
    lesser: NDArray[np.bool_] = ~standing
    return lesser


def _one_that_moves(pair: NDArray[np.complex128], residues: NDArray[np.complex128]) -> bool:
    """Whether two poles, with residues (K, 2), represent one mode whose frequency differs between FRFs."""
    if len(residues) < 3 or abs(pair[0] - pair[1]) > COINCIDENT * -pair.real.max():
        return False
    together, *each = mpc(np.column_stack([residues.sum(axis=1), residues]).T)
    return bool(together > IN_PHASE and min(each) < OUT_OF_PHASE)
