"""Poles that a record is too short to tell apart.

A record of 1/spacing seconds cannot tell two frequencies closer than about two lines, and a resonance that
rings on beyond it smears into the lines around (leakage). Both are explained better by extra poles than by one,
so no information criterion refuses those: this rule does.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.shapes.assurance import mpc

CLOSEST = 2.0
"""Line spacings between two modes at least."""

NARROWEST_PAIR = 3.5
"""Half width, in line spacings, of the narrower of two modes from which they may be closer than `CLOSEST`: over
so many lines their sum has a shape of its own, and BIC tells it from that of one."""

NARROW = 6.0
"""Half width, in line spacings, below which a resonance may leak."""

REACH = 30.0
"""Line spacings beside a narrow resonance where small companions are taken for its leakage."""

SMALL = 0.1
"""Height of such a companion, relative to the resonance."""

NEEDLE_SMALL = 0.5
"""The same for a companion narrower than one line's spacing: a needle in the noise that a tall peak carries."""

COINCIDENT = 0.5
"""Distance of two poles, in half widths of the narrower, up to which they may stand for one mode whose frequency
differs from one FRF to the next: the structure changed between the measurements."""

IN_PHASE, OUT_OF_PHASE = 0.95, 0.75
"""They do if the modal phase collinearity of the sum of their residues is above the first value and that of one of
the two below the second. A measured beam, hit at nine places, gives 0.99 and 0.55; its other modes 0.98 to 1.00."""


def heights(poles: NDArray[np.complex128], residues: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Height of every pole's peak, |R|/|Re lambda|, root of the sum of squares over responses: (J,) ndarray."""
    size: NDArray[np.float64] = np.linalg.norm(residues, axis=0) / -poles.real
    return size


def unresolved(
    poles: NDArray[np.complex128], residues: NDArray[np.complex128], spacing: float
) -> NDArray[np.bool_]:
    """Which poles are the lesser of two that the lines cannot tell apart, or leakage.

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
    lesser = np.zeros(len(poles), dtype=bool)
    standing: list[int] = []
    for j in np.argsort(height)[::-1]:
        for i in standing:
            apart = abs(place[i] - place[j])
            small = NEEDLE_SMALL if width[j] < 1.0 else SMALL
            leaked = width[i] < NARROW and apart < REACH and height[j] < small * height[i]
            close = apart < CLOSEST and min(width[i], width[j]) < NARROWEST_PAIR
            if close or leaked or _one_that_moves(poles[[i, j]], residues[:, [i, j]]):
                lesser[j] = True
                break
        else:
            standing.append(int(j))
    return lesser


def _one_that_moves(pair: NDArray[np.complex128], residues: NDArray[np.complex128]) -> bool:
    """Whether two poles, with residues (K, 2), stand for one mode whose frequency differs between FRFs."""
    if len(residues) < 3 or abs(pair[0] - pair[1]) > COINCIDENT * -pair.real.max():
        return False
    together, *each = mpc(np.column_stack([residues.sum(axis=1), residues]).T)
    return bool(together > IN_PHASE and min(each) < OUT_OF_PHASE)
