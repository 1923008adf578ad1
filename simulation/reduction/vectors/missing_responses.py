"""Responses in other states that the space of the plate without effects does not represent.

For each state, the plain space is extended by a few Krylov vectors of that state, and the leading directions
outside the plain space are kept, scaled by their share in the responses. The directions of all states are then
decomposed once more.
"""

import numpy as np
import scipy.linalg
from scipy.sparse import csr_matrix

from analysis.arrays import Real
from simulation.reduction.vectors.energy_decomposition import leading
from simulation.reduction.vectors.galerkin import product
from simulation.reduction.vectors.rational_krylov import Chain
from simulation.shell.unknowns import factorize
from simulation.state.state_matrices import StateMatrices

SHIFTS_OVER_BAND = (0.55, 1.0)
"""Shifts, as shares of the band's upper end, at which a state's stiffness is factorized."""
KRYLOV_VECTORS = 14
"""Number of Krylov vectors for every load and shift."""
LOSS_FACTOR = 0.04
"""Light damping of the responses compared, so that every mode stands out."""
BAND_LINES = 150
"""Frequencies over the band at which these are compared."""


def missing_directions(vectors: Real, matrices: StateMatrices, band: tuple[float, float], least: float) -> Real:
    """Directions of a state's responses outside the span of vectors, leading ones first.

    Parameters
    ----------
    vectors : (n, r) ndarray
        Orthonormal in the mass.
    matrices : StateMatrices
        Of the state.
    band : (float, float)
        Hz.
    least : float
        Share below which directions are left out.

    Returns
    -------
    (n, s) ndarray
        The norm of each, in the state's energy, is its rms share in the responses.
    """
    stiffness = matrices.plate + matrices.patches
    shifts = 2 * np.pi * np.array(SHIFTS_OVER_BAND) * band[1]
    new = np.hstack(  # one chain after the other: the factors of both would be the largest arrays of the reduction
        [
            Chain(factorize(stiffness - shift**2 * matrices.mass), matrices.mass, matrices.coupling).extend(
                KRYLOV_VECTORS
            )[0]
            for shift in shifts
        ]
    )
    both = np.hstack([vectors, new])
    mass, elastic = both.T @ (matrices.mass @ both), both.T @ (stiffness @ both)
    responses = _responses(elastic, mass, both.T @ matrices.coupling, band)
    energy = elastic + (2 * np.pi * 0.3 * band[1]) ** 2 * mass
    r = vectors.shape[1]
    inner = np.linalg.solve(energy[:r, :r], energy[:r, r:])
    values, basis = np.linalg.eigh(_symmetric(energy[r:, r:] - energy[r:, :r] @ inner))
    kept = values > 1e-9 * values[-1]
    root = basis[:, kept] * np.sqrt(values[kept])
    size = np.sqrt(np.einsum("ij,ij->j", responses, energy @ responses))
    left, strength, _ = np.linalg.svd(root.T @ (responses[r:] / size), full_matrices=False)
    share = strength / np.sqrt(responses.shape[1])
    count = int((share > least).sum())
    directions = (basis[:, kept] / np.sqrt(values[kept])) @ left[:, :count] * share[:count]
    return np.asarray(new @ directions - vectors @ (inner @ directions))


def extended_basis(
    vectors: Real, missing: Real, energy: csr_matrix, mass: csr_matrix, tail: float, *, gram: Real
) -> Real:
    """Basis of vectors and the leading missing directions, orthonormal in the mass.

    Parameters
    ----------
    vectors : (n, r) ndarray
        Orthonormal in the mass.
    missing : (n, s) ndarray
        Of all states, see `missing_directions`.
    energy, mass : (n, n) sparse matrix
    tail : float
        Largest share of a state's responses left out.
    gram : (r, r) ndarray
        Energies of the vectors.

    Returns
    -------
    (n, r + k) ndarray
        The given vectors first.
    """
    weighed = product(energy, missing)
    shared = vectors.T @ weighed
    within = np.linalg.solve(gram, shared)
    values, basis = leading(missing.T @ weighed - shared.T @ within, tail)
    basis = basis / np.sqrt(values)
    rest = missing @ basis
    rest -= vectors @ (within @ basis)
    rest -= vectors @ (vectors.T @ product(mass, rest))
    root = scipy.linalg.cholesky(_symmetric(rest.T @ product(mass, rest)))
    return np.hstack([vectors, scipy.linalg.solve_triangular(root, rest.T, trans="T").T])


def _responses(stiffness: Real, mass: Real, force: Real, band: tuple[float, float]) -> Real:
    """Real and imaginary parts of the lightly damped responses over the band, (N, k)."""
    values, basis = np.linalg.eigh(_symmetric(mass))
    kept = values > 1e-11 * values[-1]
    basis = basis[:, kept] / np.sqrt(values[kept])
    squares, shapes = np.linalg.eigh(_symmetric(basis.T @ stiffness @ basis))
    terms = 1.0 / ((1.0 + 1j * LOSS_FACTOR) * squares[:, None] - (2 * np.pi * np.linspace(*band, BAND_LINES)) ** 2)
    modal = ((shapes.T @ (basis.T @ force))[:, :, None] * terms[:, None, :]).reshape(len(squares), -1)
    return np.asarray(basis @ (shapes @ np.hstack([modal.real, modal.imag])))


def _symmetric(matrix: Real) -> Real:
    return np.asarray(0.5 * (matrix + matrix.T))
