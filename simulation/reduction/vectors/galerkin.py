"""Galerkin projection of a model onto given vectors, and products with many vectors."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from scipy.sparse import csr_matrix

from analysis.arrays import Real
from analysis.material import MaterialBox
from simulation.reduction.reduced_model import ReducedModel
from simulation.shell.shell_model import ShellModel

WORKERS = 2
"""Number of matrices projected, or of parts of a product computed, at a time."""
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
