"""Pairs of poles that are one mode, whatever an information criterion says, and poles that stand for two modes.

A window smooths an FRF, and a resonance that rings longer than the record leaks into the lines around it. Both
look like further poles, within two lines or beside a narrow peak. Lines of a response that was recorded without a
window until it was at rest are exact: there two frequencies may be closer than two lines.

Two poles at a distance D with residues Q and R differ from one pole between them by QR/(Q + R) D^2/(s - lambda)^3.
A resonance that moves while it is measured, or is slightly nonlinear, differs from a steady one in the same way.
Where a fit leaves this shape, its size tells how far two modes may be apart that the lines do not separate.

Two poles may also stand for one mode whose frequency differs between FRFs measured one after the other.
A structure that warms up, dries or is touched between the hits of a roving hammer has another frequency in every
FRF. To the first order two poles describe that, with another share of either in every FRF. So does a pole of its
own in every FRF, with four parameters fewer. At the second order the two differ.
"""

import numpy as np
import scipy.special
from numpy.typing import NDArray

from analysis.identification.lines import Lines
from analysis.identification.pole_residue import COMPLEX_E_F_G, NONE, synthesis
from analysis.identification.pole_search import PoleFit, fit, project

HALF_WIDTHS_COMPARED = 10.0
"""Lines compared, in half widths on either side: beyond, both models are the same."""

FEWEST_LINES = 24
"""Lines compared at least."""

MOST_FRFS = 12
"""FRFs compared, those that show the poles best: the others tell little and take as long."""

MOST_STEPS = 8
"""Most steps of the search for the pole of one FRF, which starts between the two."""


def lines_near(lines: Lines, pole: complex, half_widths: float, fewest: int) -> NDArray[np.bool_]:
    """Tell the lines (F,) within some half widths of a pole, and the nearest ones where these are fewer."""
    away = np.abs(lines.s.imag - pole.imag)
    return np.asarray(away <= max(half_widths * -pole.real, np.sort(away)[min(fewest, len(away)) - 1]))


def one_that_moves(
    lines: Lines, poles: NDArray[np.complex128], residues: NDArray[np.complex128], group: NDArray[np.intp]
) -> bool:
    """Whether close poles represent one mode with a pole of its own in every FRF: whether that has the lower BIC.

    Parameters
    ----------
    lines : Lines
        K FRFs.
    poles : (J,) complex ndarray
        rad/s.
    residues : (K, J) complex ndarray
    group : (M,) ndarray of int
        The poles in question.
    """
    count = len(residues)
    if count < 2 or lines.together:
        return False
    shared_poles = poles[group]
    near = lines_near(lines, complex(shared_poles.mean()), HALF_WIDTHS_COMPARED, FEWEST_LINES)
    f, others = lines.frequency[near], np.delete(np.arange(len(poles)), group)
    none = np.zeros((count, 0), complex)
    h = lines.h[:, near] - synthesis(f, poles[others], residues[:, others], NONE, none)
    signal = (np.abs(residues[:, group]).sum(axis=1)[:, None] / lines.deviation[:, near]).mean(axis=1)
    strongest = np.argsort(signal)[::-1][:MOST_FRFS]
    h, count = h[strongest], len(strongest)
    shared = own = 0.0
    for row, deviation in zip(h, lines.deviation[strongest][:, near], strict=True):
        one = Lines(f, row[None], deviation[None])
        start = shared_poles.mean()[None]
        shared += project(one, shared_poles, COMPLEX_E_F_G, derivatives=False).misfit
        own += fit(one, start, COMPLEX_E_F_G, max_iterations=MOST_STEPS, tolerance=1e-4).projection.misfit
    independent = 2 * h.size / lines.redundancy
    parameters = 2 * len(group) * (1 + count) - 4 * count  # with shared poles minus with a pole in every FRF
    least = np.finfo(float).tiny
    rise = independent * np.log(max(own, least) / max(shared, least))
    return bool(rise < parameters * np.log(independent))


LEAST_MODE_DISTANCE = 2.0
"""Smallest distance of two modes, in line spacings."""

NARROWEST_PAIR = 3.5
"""Half width, in line spacings, of the narrower of two modes from which they may be closer than
`LEAST_MODE_DISTANCE`: on so many lines BIC distinguishes the sum of two resonances from one."""

LEAKING_HALF_WIDTH = 6.0
"""Half width, in line spacings, below which a resonance may leak."""

NARROWEST_AT_REST = np.log(1e3) / (2.0 * np.pi)
"""Half width, in line spacings, of a resonance that falls to a thousandth within the record: 1.1. It replaces
the two above if the response was at rest at the end."""

LARGEST_MOVEMENT = 0.05
"""Largest movement of a resonance over the repeats, in half widths, at which its lines count as those at rest:
beyond, the mean over the repeats has a skirt that looks like further poles."""

LEAKAGE_DISTANCE = 30.0
"""Distance from a narrow resonance, in line spacings, within which a small pole is taken for its leakage."""

LARGEST_LEAKAGE = 0.1
"""Largest height of such a pole, relative to the resonance."""

NEEDLE_SMALL = 0.5
"""The same for a pole narrower than one line spacing: noise near a tall peak is larger."""

SMALLEST_DIFFERENCE = 1e-3
"""Smallest difference between two poles and one, relative to the peak, that shows two modes: few tests are linear
to better than that, and a response counts as at rest where it has fallen to that."""

COINCIDENT_DISTANCE = 0.5
"""Distance of two poles, in half widths of the narrower, up to which they may differ that little from one."""

MOVING_MODE_DISTANCE = 1.0
"""The same for two that may represent one mode whose frequency differs from one FRF to the next."""


def heights(poles: NDArray[np.complex128], residues: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Height of every pole's peak, |R|/|Re lambda|, root sum of squares over responses: (J,) ndarray."""
    size: NDArray[np.float64] = np.linalg.norm(residues, axis=0) / -poles.real
    return size


def unresolved(lines: Lines, poles: NDArray[np.complex128], residues: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Poles that are leakage, or the smaller one of two that cannot be separated.

    Parameters
    ----------
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
    narrow = NARROWEST_AT_REST if lines.at_rest else LEAKING_HALF_WIDTH
    exact = lines.at_rest & (lines.shift * np.abs(poles) < LARGEST_MOVEMENT * -poles.real)
    standing = np.zeros(len(poles), dtype=bool)
    for j in np.argsort(height)[::-1]:
        others = np.flatnonzero(standing)
        apart, narrower = np.abs(place[others] - place[j]) / spacing[others], np.minimum(width[others], width[j])
        small = NEEDLE_SMALL if width[j] < 1.0 else LARGEST_LEAKAGE
        leaked = (width[others] < narrow) & (apart < LEAKAGE_DISTANCE) & (height[j] < small * height[others])
        narrowest = np.where(exact[others] & exact[j], NARROWEST_AT_REST, NARROWEST_PAIR)
        close = (apart < LEAST_MODE_DISTANCE) & (narrower < narrowest)
        standing[j] = (
            not (leaked | close).any()
            and not any(
                _like_one(lines, poles[[i, j]], residues[:, [i, j]])
                for i in others[apart < COINCIDENT_DISTANCE * narrower]
            )
            and not any(
                one_that_moves(
                    lines,
                    poles,
                    residues,
                    np.flatnonzero(np.abs(place - place[i]) < MOVING_MODE_DISTANCE * half[i]),
                )
                for i in others[apart < MOVING_MODE_DISTANCE * narrower]
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


LEAST_PEAKED = 20.0
"""Power of the shape that two modes leave, over that of what else is left there, from which it is theirs.

Errors in proportion to the response leave 1 to 5, a neighbour of two modes 5 to 13."""

LEAST_APART = 0.3
"""Distance of two modes from the pole between them, in half widths, from which they leave other shapes, too."""

BY_CHANCE = 1e-5
"""Probability with which noise leaves as much of the shape."""

FEWEST_AT_PEAK = 8
"""Lines that the shape is looked for in, at least."""


def half_distances(lines: Lines, fitted: PoleFit, left: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Distance from each pole to either of two modes that it may stand for, (J,) rad/s; 0 for a single mode.

    Two modes alike at +- D leave R D^2/(s - pole)^3, less what the residue R and the pole take up of it.

    Parameters
    ----------
    lines : Lines
        K FRFs.
    fitted : PoleFit
        Of J poles.
    left : (K, F) complex ndarray
        Residual of the fit.
    """
    residues = fitted.projection.residues.T
    found = [_half_distance(lines, *one, left) for one in zip(fitted.poles, residues, strict=True)]
    return np.array(found, dtype=float)


def _half_distance(
    lines: Lines, pole: complex, residue: NDArray[np.complex128], left: NDArray[np.complex128]
) -> float:
    near = lines_near(lines, pole, HALF_WIDTHS_COMPARED, FEWEST_AT_PEAK)
    if near.sum() < FEWEST_AT_PEAK or not residue.any():
        return 0.0
    r, weight = left[:, near] / lines.deviation[:, near], 1.0 / lines.deviation[:, near]
    powers = (lines.s[near] - pole)[:, None] ** -np.arange(1.0, 4.0)  # residue, pole, two modes
    q, upper = np.linalg.qr(weight[:, :, None] * powers)
    taken = np.einsum("kfp,kf->kp", q.conj(), r)
    explained, size = np.abs(taken[:, 2]), np.abs(q[:, :, 2]) ** 2
    power = float((explained**2).sum()) / lines.redundancy
    if power <= scipy.special.gammainccinv(len(r), BY_CHANCE):
        return 0.0
    other = np.abs(r - np.einsum("kfp,kp->kf", q, taken)) ** 2
    other /= np.maximum(1.0 - (np.abs(q) ** 2).sum(-1), 0.1)  # a line draws what is fitted to itself
    product = np.abs(residue) @ (explained / np.abs(upper[:, 2, 2]))
    apart = float(np.sqrt(product)) / float(np.linalg.norm(residue))
    peaked = (explained**2).sum() * size.sum() > LEAST_PEAKED * len(r) * (size * other).sum()
    return apart if peaked or apart > LEAST_APART * -pole.real else 0.0
