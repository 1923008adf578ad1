"""Proper orthogonal decomposition, in the energy norm, of a plate's responses over a box of materials.

Galerkin projection of a model onto given vectors, and products with many vectors.
"""

import itertools
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from analysis.arrays import Real
from analysis.material import MaterialBox
from simulation.reduction.damped_modes import DampedModes, relative_error, root_mean_square
from simulation.reduction.reduced_model import ReducedModel
from simulation.shell.shell_model import ShellModel

WORKERS = 2
"""Number of materials solved, of matrices projected, or of parts of a product computed, at a time."""
MODULI, TRAINING_MATERIALS = 6, 4
"""Number of materials along E (geometric) and nu (even) at which responses are computed."""
COMPARED_STRIDE = 2
"""A size's error is measured at one material in so many, staggered."""

BAND_MARGIN = 0.03
"""Margin of the training responses beyond the band, as a share of its ends. A resonance just above the band at the
training nu may lie inside it at other nu: without the margin errors there are 10 times as large."""

FIELD_LINES = 5
"""The field is compared at every so-many-th line."""

DEPENDENT_SHARE = 1e-6
"""Vectors are left out whose part outside the others is below this share of them. Its square, in the Gram matrix,
is a hundred times the rounding error."""

PEAK_ERROR_FACTOR = 15.0
"""Error of transfers, over the share of the responses' energy that is left out divided by the loss factor: 13 to
22 were found. The search for the size starts with it."""
AIMED_TOLERANCE_SHARE = 0.9
"""Share of the tolerance for which the next size is estimated."""

LEAST_LOSS = 1e-4
"""Smallest loss factor of training: without damping the response at resonance is infinite."""


def middle(box: MaterialBox) -> tuple[float, float]:
    """Geometric mean of E [Pa] and mean of nu."""
    return float(np.sqrt(np.prod(box.youngs_modulus))), float(np.mean(box.poisson_ratio))


def energy_shift(band: tuple[float, float]) -> float:
    """Factor on the mass, rad2/s2, so that stiffness plus mass is a norm for rigid motion of a free plate too."""
    return float((2 * np.pi * max(band[0], 0.1 * band[1])) ** 2)


def training_loss(box: MaterialBox) -> float:
    """Loss factor of training responses: the smallest of the box, for the sharpest resonances."""
    return max(box.loss_factor[0], LEAST_LOSS)


def mass_orthonormal(vectors: Real, energy: csr_matrix, mass: csr_matrix) -> Real:
    """Columns that span the same space, orthonormal in the mass; nearly dependent ones are left out.

    Parameters
    ----------
    vectors : (n, k) ndarray
    energy : (n, n) csr_matrix
        Symmetric and positive definite: the norm for near dependence.
    mass : (n, n) csr_matrix

    Returns
    -------
    (n, N) ndarray
        N is at most k.
    """
    weighed = product(energy, vectors)
    norm = np.sqrt(np.einsum("ni,ni->i", vectors, weighed))
    values, basis = np.linalg.eigh((vectors.T @ weighed) / np.outer(norm, norm))
    kept = values > DEPENDENT_SHARE**2 * values[-1]
    vectors = vectors @ (basis[:, kept] / np.outer(norm, np.sqrt(values[kept])))
    root = scipy.linalg.cholesky(vectors.T @ product(mass, vectors), lower=True)
    return np.asarray(vectors @ np.linalg.inv(root).T)


def leading(gram: Real, least: float) -> tuple[Real, Real]:
    """Leading eigenvalues (s,), eigenvectors (r, s) of a gram matrix; the others have a root sum below `least`."""
    values, vectors = np.linalg.eigh(0.5 * (gram + gram.T))
    values = np.maximum(values, 0.0)
    kept = np.sqrt(np.cumsum(values)) > least
    return values[kept], vectors[:, kept]


def decomposition(candidate: ReducedModel, lines: Real, tolerance: float) -> Real:
    """Smallest set of leading directions (N, r) of the responses over the box that keeps the tolerance.

    Parameters
    ----------
    candidate : ReducedModel
        Of N coordinates.
    lines : (F,) ndarray
        Hz, even; lines on narrow resonances are added at every material.
    tolerance : float
        Of any transfer between patches, relative to its rms, against the candidate.

    Returns
    -------
    (N, r) ndarray
        Orthonormal in the mass, as the candidate's coordinates are.
    """
    loss = training_loss(candidate.box)
    wider = np.linspace((1.0 - BAND_MARGIN) * lines[0], (1.0 + BAND_MARGIN) * lines[-1], lines.size)
    materials = list(
        itertools.product(
            np.geomspace(*candidate.box.youngs_modulus, MODULI),
            np.linspace(*candidate.box.poisson_ratio, TRAINING_MATERIALS),
        )
    )
    energy = candidate.stiffness(*middle(candidate.box), 0.0).real
    energy = energy + energy_shift(candidate.band) * np.eye(candidate.size)
    root = scipy.linalg.cholesky(energy, lower=True)
    compared = [k for k in range(len(materials)) if sum(divmod(k, TRAINING_MATERIALS)) % COMPARED_STRIDE == 0]
    references: dict[int, _Reference] = {}

    def gram(place: int) -> Real:
        modes = candidate.damped_modes(*materials[place])
        if place in compared:
            references[place] = _Reference.of(modes, modes.lines(loss, lines), candidate, loss)
        return modes.gram(modes.lines(loss, wider), loss)

    with ThreadPoolExecutor(WORKERS) as executor:
        grams = list(executor.map(gram, range(len(materials))))
        values, leading_last = np.linalg.eigh(root.T @ sum(grams[1:], grams[0]) @ root)
        directions = scipy.linalg.solve_triangular(root.T, leading_last[:, ::-1], lower=False)

        def error(size: int) -> float:
            small = candidate.restricted(np.linalg.qr(directions[:, :size])[0])

            def at(place: int) -> float:
                return float(references[place].error(small.damped_modes(*materials[place]), small, loss))

            return max(executor.map(at, compared))

        share = np.append(np.cumsum(np.maximum(values, 0.0))[::-1], 0.0)
        size = _smallest(error, share / share[0], tolerance, loss * tolerance / PEAK_ERROR_FACTOR)
    return np.asarray(np.linalg.qr(directions[:, :size])[0])


def _smallest(error: Callable[[int], float], share: Real, tolerance: float, first: float) -> int:
    """Smallest size, within 2 %, whose error is at most the tolerance.

    The error is nearly in proportion to the share (N + 1,) of the responses' energy that a size leaves out, of
    which `first` is the first trial.
    """
    low, high, step = 0, len(share) - 1, max(2, len(share) // 50)
    size = int(np.argmax(share <= first))
    while high - low > step:
        size = min(max(size, low + step), high - 1)
        wrong = error(size)
        wanted = int(np.argmax(share <= AIMED_TOLERANCE_SHARE * share[size] * tolerance / wrong))
        if wrong <= tolerance:
            high = size
            if high - wanted <= step:
                break
        else:
            low = size
        size = wanted
    return high


@dataclass(frozen=True)
class _Reference:
    """Reference transfers, and field at the points on some of the lines, for the error of a smaller model."""

    lines: Real
    transfers: NDArray[np.complex128]
    field: Real

    @classmethod
    def of(cls, modes: DampedModes, lines: Real, model: ReducedModel, loss: float) -> Self:
        some = lines[::FIELD_LINES] if len(model.points) else lines[:0]
        field = model.deflection @ modes.responses(some, loss)
        return cls(lines, modes.transfers(lines, loss), field)

    def error(self, modes: DampedModes, model: ReducedModel, loss: float) -> float:
        """Larger of the errors of transfers and field, as `ReducedModel.error` counts them."""
        transfer = relative_error(modes.transfers(self.lines, loss), self.transfers, self.lines)
        if not self.field.size:
            return transfer
        some = self.lines[::FIELD_LINES]
        wrong = np.sqrt(_power(model.deflection @ modes.responses(some, loss) - self.field, some.size))
        rms = np.sqrt(np.mean(root_mean_square(np.sqrt(_power(self.field, some.size)), some) ** 2))
        return max(transfer, float(wrong.max() / rms))


def _power(field: Real, lines: int) -> Real:
    """Mean over the points of |w|**2, (inputs, lines); columns are real, then imaginary parts of both."""
    return np.asarray(np.mean(field**2, axis=0).reshape(2, -1, lines).sum(axis=0))


ROWS_AT_ONCE = 1000
"""Rows of a part: threads keep what memory they once took."""


def projected(
    model: ShellModel,
    vectors: Real,
    box: MaterialBox,
    band: tuple[float, float],
    dashpots: Real,
    *,
    known: ReducedModel | None = None,
) -> ReducedModel:
    """Galerkin model on given vectors; its error is not measured yet.

    Parameters
    ----------
    model : ShellModel
        Of n unknowns.
    vectors : (n, N) ndarray
        Orthonormal in the mass.
    band : (float, float)
        Hz.
    dashpots : (n, q) ndarray
        Columns whose product is the damping matrix, truncated to its significant part.
    known : ReducedModel, optional
        Projection onto the first of the vectors, which is not repeated.

    Returns
    -------
    ReducedModel
        Its error is infinite.
    """

    def of(name: str) -> Real:
        before = getattr(known, name) if known else np.zeros((0, 0))
        matrix, new = getattr(model, name), vectors[:, len(before) :]
        acting = np.flatnonzero(np.diff(matrix.indptr))  # few rows of the patches' stiffness are not empty
        if len(acting) == len(vectors):
            return bordered(before, vectors.T @ (matrix @ new))
        return bordered(before, vectors[acting].T @ (matrix[acting] @ new))

    names = ("stiffness_1", "stiffness_2", "stiffness_patch")
    with ThreadPoolExecutor(WORKERS) as executor:
        stiffnesses = dict(zip(names, executor.map(of, names), strict=True))
    return ReducedModel(
        **stiffnesses,
        coupling=vectors.T @ model.coupling,
        capacitance=model.capacitance,
        box=box,
        band=band,
        error=float("inf"),
        dashpots=vectors.T @ dashpots,
    )


def bordered(gram: Real, columns: Real) -> Real:
    """Symmetric matrix (k, k) with the last columns (k + s, s), and rows, added."""
    old, new = len(gram), columns.shape[1]
    grown = np.empty((old + new, old + new))
    grown[:old, :old] = gram
    grown[:old, old:] = columns[:old]
    grown[old:, :old] = columns[:old].T
    grown[old:, old:] = 0.5 * (columns[old:] + columns[old:].T)
    return grown


def product(matrix: csr_matrix, vectors: Real) -> Real:
    """Sparse matrix (m, n) times many vectors (n, k), (m, k): SciPy's product uses one core only."""
    found = np.empty((matrix.shape[0], vectors.shape[1]))

    def part(start: int) -> None:
        rows = slice(start, start + ROWS_AT_ONCE)
        found[rows] = matrix[rows] @ vectors

    with ThreadPoolExecutor(WORKERS) as executor:
        list(executor.map(part, range(0, len(found), ROWS_AT_ONCE)))
    return found
