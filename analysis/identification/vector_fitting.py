"""Start poles by relaxed vector fitting.

Gustavsen, IEEE Trans. Power Delivery 21, 2006: a rational function sigma(s) with the present poles turns the
search for better poles into linear least squares; the zeros of sigma are the next poles. Free scaling of
sigma with a mild non-triviality condition keeps noise from dragging it. No start values are needed; noise only
reduces accuracy, which variable projection restores.
"""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lstsq
from scipy.linalg.lapack import dtrtrs

from analysis.identification.lines import Lines
from analysis.identification.normal_equations import triangular_factor
from analysis.identification.pole_residue import pole_columns
from analysis.identification.residual_terms import ResidualTerms
from analysis.identification.variable_projection import misfit_at

AT_REST = 0.02
"""Relative change of the misfit in each of two successive relocations at which the iteration stops."""


def spread_poles(low: float, high: float, count: int, damping: float = 0.01) -> NDArray[np.complex128]:
    """Pole pairs spread evenly over a band.

    Parameters
    ----------
    low, high : float
        Hz.
    count : int
    damping : float
        Damping ratio of each.

    Returns
    -------
    (count,) complex ndarray
        rad/s, upper half plane, ascending.
    """
    w = 2.0 * np.pi * np.linspace(low, high, count)
    poles: NDArray[np.complex128] = w * (-damping + 1j * np.sqrt(1.0 - damping**2))
    return poles


def relocate(lines: Lines, poles: NDArray[np.complex128], terms: ResidualTerms) -> NDArray[np.complex128]:
    """One relaxed relocation: the zeros of sigma for the present poles, reflected into the left half plane.

    Parameters
    ----------
    lines : Lines
    poles : (J,) complex ndarray
        Present poles, upper half plane, rad/s.
    terms : ResidualTerms

    Returns
    -------
    (N,) complex ndarray
        New poles, rad/s, upper half plane only; real zeros are left out.
    """
    count, fixed = len(poles), lines.term_columns(terms)
    sigma = np.concatenate([pole_columns(lines.s, poles, lines.spread), np.ones((1, len(lines.frequency)))])
    norms = np.linalg.norm(sigma, axis=1)
    model = np.concatenate([sigma[:-1], fixed])
    sigma /= norms[:, None]
    energy = (np.abs(lines.h / lines.deviation) ** 2).sum(axis=0)
    spread = (sigma * np.sqrt(energy)).view(float)
    normal = spread @ spread.T
    for group in lines.weight_groups:
        seen = model.view(float) * group.weight
        triangle, lengths = triangular_factor(seen, len(model))
        for response in group.data.view(complex):
            onto = seen @ (sigma * response).view(float).T
            onto = dtrtrs(triangle, onto / lengths[:, None], trans=1)[0]
            normal -= onto.T @ onto
    size = np.sqrt(energy.mean() / len(lines.h))
    # sum over the lines of Re sigma = number of lines: sigma is not zero, and its asymptote is free
    relaxation = size / np.sqrt(len(lines.s)) * sigma.real.sum(1)
    normal += np.outer(relaxation, relaxation)
    target = relaxation * size * np.sqrt(len(lines.s))
    rank = np.finfo(float).eps * len(normal)
    c = lstsq(normal, target, cond=rank, lapack_driver="gelsy", check_finite=False)[0] / norms
    constant = c[-1] if abs(c[-1]) > 1e-8 * np.abs(c).max() / lines.scale else 1e-8
    return _zeros(poles, c[: 2 * count], constant)


def _zeros(
    poles: NDArray[np.complex128], coefficients: NDArray[np.float64], constant: float
) -> NDArray[np.complex128]:
    """Zeros of constant + sum over pole pairs, as eigenvalues of a real matrix."""
    even = np.arange(0, 2 * len(poles), 2)
    matrix = np.zeros((2 * len(poles), 2 * len(poles)))
    matrix[even] = -2.0 / constant * coefficients
    matrix[even, even] += poles.real
    matrix[even, even + 1] += poles.imag
    matrix[even + 1, even] = -poles.imag
    matrix[even + 1, even + 1] = poles.real
    zeros = np.linalg.eigvals(matrix)
    zeros = zeros[zeros.imag > 0.0]
    mirrored: NDArray[np.complex128] = -np.abs(zeros.real) + 1j * zeros.imag
    return mirrored[np.argsort(mirrored.imag)]


def start_poles(lines: Lines, count: int, terms: ResidualTerms, *, iterations: int = 12) -> NDArray[np.complex128]:
    """Start poles: more pole pairs than the FRFs have modes.

    Parameters
    ----------
    lines : Lines
    count : int
        Pole pairs at the start of the search.
    terms : ResidualTerms
    iterations : int
        Largest number of relocations.

    Returns
    -------
    (N,) complex ndarray
        rad/s, upper half plane, sorted by frequency; N is at most `count`.
    """
    poles = spread_poles(lines.frequency[0], lines.frequency[-1], count)
    misfits = [np.inf, np.inf]
    for _ in range(iterations):
        moved = relocate(lines, poles, terms)
        if len(moved) == 0:
            break
        poles = moved
        misfits.append(misfit_at(lines, poles, terms))
        if all(abs(new - old) < AT_REST * new for old, new in pairwise(misfits[-3:])):
            break
    return poles
