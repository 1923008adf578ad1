"""Pairs of poles that are one mode, whatever an information criterion says.

A window smooths an FRF, and a resonance that rings longer than the record leaks into the lines around it. Both
look like further poles, within two lines or beside a narrow peak. Lines of a response that was recorded without a
window until it was at rest are exact: there two frequencies may be closer than two lines.

Two poles at a distance D with residues Q and R differ from one pole between them by QR/(Q + R) D^2/(s - lambda)^3.
A resonance that moves while it is measured, or is slightly nonlinear, differs from a steady one in the same way.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.lines import Lines
from analysis.identification.moving import one_that_moves

CLOSEST = 2.0
"""Smallest distance of two modes, in line spacings."""

NARROWEST_PAIR = 3.5
"""Half width, in line spacings, of the narrower of two modes from which they may be closer than `CLOSEST`: on so
many lines BIC distinguishes the sum of two resonances from one."""

NARROW = 6.0
"""Half width, in line spacings, below which a resonance may leak."""

NARROWEST_AT_REST = np.log(1e3) / (2.0 * np.pi)
"""Half width, in line spacings, of a resonance that falls to a thousandth within the record: 1.1. It replaces
the two above if the response was at rest at the end."""

STEADY = 0.05
"""Largest movement of a resonance over the repeats, in half widths, at which its lines count as those at rest:
beyond, the mean over the repeats has a skirt that looks like further poles."""

REACH = 30.0
"""Distance from a narrow resonance, in line spacings, within which a small pole is taken for its leakage."""

SMALL = 0.1
"""Largest height of such a pole, relative to the resonance."""

NEEDLE_SMALL = 0.5
"""The same for a pole narrower than one line spacing: noise near a tall peak is larger."""

SMALLEST_DIFFERENCE = 1e-3
"""Smallest difference between two poles and one, relative to the peak, that shows two modes: few tests are linear
to better than that, and a response counts as at rest where it has fallen to that."""

COINCIDENT = 0.5
"""Distance of two poles, in half widths of the narrower, up to which they may differ that little from one."""

MOVING = 1.0
"""The same for two that may represent one mode whose frequency differs from one FRF to the next."""


def heights(poles: NDArray[np.complex128], residues: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Height of every pole's peak, |R|/|Re lambda|, root sum of squares over responses: (J,) ndarray."""
    size: NDArray[np.float64] = np.linalg.norm(residues, axis=0) / -poles.real
    return size


def unresolved(lines: Lines, poles: NDArray[np.complex128], residues: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Poles that are leakage, or the smaller one of two that cannot be separated.

    Parameters
    ----------
    lines : Lines
    poles : (J,) complex ndarray
        rad/s.
    residues : (K, J) complex ndarray

    Returns
    -------
    (J,) ndarray of bool
    """
    height = heights(poles, residues)
    place, half = poles.imag / (2.0 * np.pi), -poles.real / (2.0 * np.pi)
    spacing = lines.spacing_at(place)
    width = half / spacing
    narrow = NARROWEST_AT_REST if lines.at_rest else NARROW
    exact = lines.at_rest & (lines.shift * np.abs(poles) < STEADY * -poles.real)
    standing = np.zeros(len(poles), dtype=bool)
    for j in np.argsort(height)[::-1]:
        others = np.flatnonzero(standing)
        apart, narrower = np.abs(place[others] - place[j]) / spacing[others], np.minimum(width[others], width[j])
        small = NEEDLE_SMALL if width[j] < 1.0 else SMALL
        leaked = (width[others] < narrow) & (apart < REACH) & (height[j] < small * height[others])
        narrowest = np.where(exact[others] & exact[j], NARROWEST_AT_REST, NARROWEST_PAIR)
        close = (apart < CLOSEST) & (narrower < narrowest)
        standing[j] = (
            not (leaked | close).any()
            and not any(
                _like_one(lines, poles[[i, j]], residues[:, [i, j]]) for i in others[apart < COINCIDENT * narrower]
            )
            and not any(
                one_that_moves(lines, poles, residues, np.flatnonzero(np.abs(place - place[i]) < MOVING * half[i]))
                for i in others[apart < MOVING * narrower]
            )
        )
    lesser: NDArray[np.bool_] = ~standing
    return lesser


def _like_one(lines: Lines, pair: NDArray[np.complex128], residues: NDArray[np.complex128]) -> bool:
    """Whether two close poles, with residues (K, 2), differ from one by less than one that is not quite steady."""
    together, product = np.abs(residues.sum(axis=1)), np.abs(residues.prod(axis=1))
    half_width = -pair.real.max()
    difference = (abs(pair[0] - pair[1]) / half_width) ** 2
    difference *= np.linalg.norm(product / np.maximum(together, np.finfo(float).tiny))
    moved = lines.shift * abs(pair[0]) / half_width  # over the repeats, and while it rings in one of 1/spacing s
    spacing = float(lines.spacing_at(pair.imag.mean() / (2.0 * np.pi)))
    least = SMALLEST_DIFFERENCE + moved**2 + 1.25 * moved * spacing / half_width
    return bool(difference < least * np.linalg.norm(together))
