"""Start poles by relaxed vector fitting.

Gustavsen, IEEE Trans. Power Delivery 21, 2006: a rational function sigma(s) with the present poles turns the
search for better poles into linear least squares; the zeros of sigma are the next poles. Free scaling of
sigma with a mild non-triviality condition keeps noise from dragging it. No start values are needed; noise only
reduces accuracy, which variable projection restores.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lstsq
from scipy.linalg.lapack import dtrtrs

from analysis.identification.lines import Lines, WeightedLines
from analysis.identification.pole_residue import ResidualTerms
from analysis.identification.pole_search import factor_of_gram, misfit_at

SETTLED_MISFIT = 0.02
"""Relative change of the misfit in each of two successive relocations at which the iteration stops."""


def spread_poles(lines: Lines, count: int, damping: float = 0.01) -> NDArray[np.complex128]:
    """Pole pairs spread evenly over the band, or like its lines where these are uneven.

    Parameters
    ----------
    damping : float
        Damping ratio of each.

    Returns
    -------
    (count,) complex ndarray
        rad/s, upper half plane, ascending.
    """
    if lines.even:
        f = np.linspace(lines.frequency[0], lines.frequency[-1], count)
    else:
        f = np.quantile(lines.grid, np.linspace(0.0, 1.0, count))
    poles: NDArray[np.complex128] = 2.0 * np.pi * f * (-damping + 1j * np.sqrt(1.0 - damping**2))
    return poles


@dataclass(frozen=True)
class Relocation:
    """Lines prepared for relaxed relocations of poles.

    Attributes
    ----------
    unit, energy : WeightedLines
        Without weights, and with the root of the responses' summed energy in units of their deviations; the
        constant of sigma is their row.
    groups : list of WeightedLines
        For responses of common weights; their rows are residual terms, data, and every term times every response.
    responses : list of int
        Of each group.
    terms : int
        Number of columns of residual terms.
    """

    unit: WeightedLines
    energy: WeightedLines
    groups: list[WeightedLines]
    responses: list[int]
    terms: int

    @classmethod
    def of(cls, lines: Lines, terms: ResidualTerms) -> "Relocation":
        """Prepare lines, with residual terms."""
        w, fixed, groups = lines.s.imag, lines.term_columns(terms), []
        for group in lines.weight_groups:
            weight, data = group.weight[::2], group.data.view(complex)
            times = (fixed * data.conj()[:, None]).reshape(-1, len(w))
            rows = np.concatenate([fixed * weight, data, times])
            groups.append(WeightedLines.of(w, weight, rows, len(fixed)))
        size = np.sqrt((np.abs(lines.h / lines.deviation) ** 2).sum(axis=0))
        unit, energy = (WeightedLines.of(w, one, one[None].astype(complex)) for one in (np.ones(len(w)), size))
        return cls(unit, energy, groups, [len(group.rows) for group in lines.weight_groups], len(fixed))

    def relocated(self, poles: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Zeros of sigma for the present poles, reflected into the left half plane.

        Parameters
        ----------
        poles : (J,) complex ndarray
            Present poles, upper half plane, rad/s.

        Returns
        -------
        (N,) complex ndarray
            New poles, rad/s, upper half plane only; real zeros are left out.
        """
        lines, unit = len(self.unit.w), self.unit.at(poles)
        norms = np.sqrt(np.append(unit.squares, lines))
        normal = np.tril(self.energy.at(poles).gram(1))
        normal += np.tril(normal, -1).T
        for weighted, responses in zip(self.groups, self.responses, strict=True):
            normal -= self._explained(weighted, poles, responses)
        normal /= norms * norms[:, None]
        size = np.sqrt(self.energy.products[0, 0] / lines / sum(self.responses))
        # sum over the lines of Re sigma = number of lines: sigma is not zero, and its asymptote is free
        relaxation = size / np.sqrt(lines) * np.append(unit.onto[:, 0], lines) / norms
        normal += np.outer(relaxation, relaxation)
        target = relaxation * size * np.sqrt(lines)
        rank = np.finfo(float).eps * len(normal)
        c = lstsq(normal, target, cond=rank, lapack_driver="gelsy", check_finite=False)[0] / norms
        least = 1e-8 * np.abs(c).max() / np.sqrt(self.unit.w[0] * self.unit.w[-1])
        return _zeros(poles, c[:-1], c[-1] if abs(c[-1]) > least else 1e-8)

    def _explained(
        self, weighted: WeightedLines, poles: NDArray[np.complex128], responses: int
    ) -> NDArray[np.float64]:
        """Products of sigma times the responses, (2J + 1, 2J + 1), as far as poles and terms explain them."""
        products, own, terms = weighted.at(poles), 2 * len(poles), self.terms
        model = slice(own + terms)
        triangle, lengths = factor_of_gram(
            products.gram(terms),
            own + terms,
            lambda: weighted.line_by_line(poles, terms, derivatives=False)[model],
        )
        explained = np.zeros((own + 1, own + 1))
        onto = np.empty((own + terms, own + 1))
        for response in range(responses):
            row, first = terms + response, terms + responses + response * terms
            onto[:own, :-1], onto[:own, -1] = products.times_row(row), products.onto[:, row]
            onto[own:, :-1] = products.onto[:, first : first + terms].T
            onto[own:, -1] = weighted.products[:terms, row]
            solved = dtrtrs(triangle, onto / lengths[:, None], trans=1)[0]
            explained += solved.T @ solved
        return explained


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
    count : int
        Pole pairs at the start of the search.
    iterations : int
        Largest number of relocations.

    Returns
    -------
    (N,) complex ndarray
        rad/s, upper half plane, sorted by frequency; N is at most `count`.
    """
    poles, relocation = spread_poles(lines, count), Relocation.of(lines, terms)
    misfits = [np.inf, np.inf]
    for _ in range(iterations):
        moved = relocation.relocated(poles)
        if len(moved) == 0:
            break
        poles = moved
        misfits.append(misfit_at(lines, poles, terms))
        if all(abs(new - old) < SETTLED_MISFIT * new for old, new in pairwise(misfits[-3:])):
            break
    return poles
