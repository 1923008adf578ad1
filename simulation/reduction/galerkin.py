"""Galerkin projection of a model onto given vectors."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from scipy.sparse import csr_matrix

from analysis.arrays import Real
from analysis.material import MaterialBox
from simulation.reduction.reduced_model import ReducedModel
from simulation.shell.shell_model import ShellModel

WORKERS = 2
"""Number of matrices projected at a time."""


def projected(
    model: ShellModel, vectors: Real, box: MaterialBox, band: tuple[float, float], dashpots: Real
) -> ReducedModel:
    """Galerkin model on given vectors; its error is not measured yet.

    Parameters
    ----------
    model : ShellModel
        Of n unknowns.
    vectors : (n, N) ndarray
        Orthonormal in the mass.
    box : MaterialBox
    band : (float, float)
        Hz.
    dashpots : (n, q) ndarray
        Columns whose product is the damping matrix, truncated to its significant part.

    Returns
    -------
    ReducedModel
        Its error is infinite.
    """

    def of(matrix: csr_matrix) -> Real:
        small = vectors.T @ (matrix @ vectors)
        return np.asarray(0.5 * (small + small.T))

    with ThreadPoolExecutor(WORKERS) as executor:
        first, second, patches = executor.map(of, (model.stiffness_1, model.stiffness_2, model.stiffness_patch))
    return ReducedModel(
        stiffness_1=first,
        stiffness_2=second,
        stiffness_patch=patches,
        coupling=vectors.T @ model.coupling,
        capacitance=model.capacitance,
        box=box,
        band=band,
        error=float("inf"),
        dashpots=vectors.T @ dashpots,
    )
