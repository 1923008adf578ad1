"""Candidate space of a reduced model: block rational Krylov spaces at a few undamped materials.

Real shifts and real factors cost half as much as complex ones, and every further vector costs one
back-substitution. Damping of the plate needs no further vectors: it makes frequency and the ratio of patch to
plate stiffness complex, and the space is trained over both.

Responses in other states that the space of the plate without effects does not represent.

For each state, the plain space is extended by a few Krylov vectors of that state, and the leading directions
outside the plain space are kept, scaled by their share in the responses. The directions of all states are then
decomposed once more.
"""

from dataclasses import dataclass, field

import numpy as np
import scipy.linalg
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import SuperLU

from analysis.arrays import Real
from simulation.reduction.damped_modes import DampedModes, relative_error
from simulation.reduction.vectors.energy_decomposition import bordered, leading, product
from simulation.shell.shell_model import ShellModel
from simulation.shell.unknowns import factorize
from simulation.state.state_matrices import StateMatrices

BLOCKS_PER_CHECK = 4
"""Number of blocks added to every chain between two checks of convergence: two may add nothing to the transfers
between the loads although modes are still missing."""

CONVERGED_CHANGE = 10.0
"""Chains are long enough at a change of the transfers by this many times the tolerance: the blocks that cause
it leave a far smaller error, because convergence accelerates once the band's modes are resolved (at most a
hundredth of the change was measured)."""

MOST_BLOCKS = 90
"""Largest number of blocks of a chain; without convergence an error is raised."""


class GrowingRows:
    """A growing set of vectors, one per row, so that products run along rows.

    They are stored in an array with spare rows, so that adding a few does not copy all.
    """

    def __init__(self, size: int) -> None:
        self._store = np.empty((64, size))
        self._count = 0

    @property
    def all(self) -> Real:
        """Return the vectors, (k, n)."""
        return self._store[: self._count]

    def add(self, columns: Real) -> None:
        """Append the columns of an (n, s) array."""
        count = self._count + columns.shape[1]
        if count > len(self._store):
            grown = np.empty((2 * count, self._store.shape[1]))
            grown[: self._count] = self.all
            self._store = grown
        self._store[self._count : count] = columns.T
        self._count = count


@dataclass
class Chain:
    """Orthonormal blocks spanning (K - s M)**-1 b, (K - s M)**-1 M (K - s M)**-1 b, ... of one shift s.

    `weighed` holds the mass times every vector.
    """

    factors: SuperLU
    mass: csr_matrix
    load: Real
    vectors: GrowingRows = field(init=False)
    weighed: GrowingRows = field(init=False)

    def __post_init__(self) -> None:
        self.vectors, self.weighed = GrowingRows(len(self.load)), GrowingRows(len(self.load))
        self._recent = 0

    def extend(self, steps: int) -> tuple[Real, Real]:
        """Add blocks, orthonormal to all before in the mass's inner product: (n, k), and mass times them.

        The operator is symmetric in this product: except for rounding, the image of a block has components only
        along the last two blocks (Lanczos). These are removed first, then the remainders by rounding along all.
        """
        start = len(self.vectors.all)
        for _ in range(steps):
            count = len(self.vectors.all)
            block = self.factors.solve(self.load)
            weighed = self.mass @ block
            for first in (self._recent, 0):
                vectors, products = self.vectors.all[first:], self.weighed.all[first:]
                share = vectors @ weighed
                block = block - vectors.T @ share
                weighed = weighed - products.T @ share
                values, directions = np.linalg.eigh(block.T @ weighed)
                kept = values > 1e-14 * values[-1]
                scale = directions[:, kept] / np.sqrt(values[kept])
                block, weighed = block @ scale, weighed @ scale
            self._recent = max(count - self.load.shape[1], 0)
            self.vectors.add(block)
            self.weighed.add(weighed)
            self.load = weighed
        return self.vectors.all[start:].T, self.weighed.all[start:].T


class Galerkin:
    """Gram matrices of a growing set of vectors, without repeated products."""

    def __init__(self, stiffness: csr_matrix, coupling: Real) -> None:
        self.stiffness, self.coupling = stiffness, coupling
        self.vectors = GrowingRows(len(coupling))
        self.projected_stiffness = self.projected_mass = np.zeros((0, 0))

    def add(self, block: Real, weighed: Real) -> None:
        """Append vectors (n, k), given the mass times them."""
        self.vectors.add(block)
        of_all = self.vectors.all
        self.projected_stiffness = bordered(self.projected_stiffness, of_all @ (self.stiffness @ block))
        self.projected_mass = bordered(self.projected_mass, of_all @ weighed)

    def modes(self) -> DampedModes:
        """Modes of the projected plate, without nearly dependent vectors."""
        values, basis = np.linalg.eigh(self.projected_mass)
        kept = values > 1e-12 * values[-1]
        basis = basis[:, kept] / np.sqrt(values[kept])
        force = basis.T @ (self.vectors.all @ self.coupling)
        return DampedModes.of(basis.T @ self.projected_stiffness @ basis, force)


def material_space(
    model: ShellModel,
    youngs_modulus: float,
    poisson_ratio: float,
    *,
    shifts: Real,
    lines: Real,
    loss_factor: float,
    tolerance: float,
) -> Real:
    """Vectors that represent every transfer between patches at one material.

    Chains grow until the transfers over the grid and on its resonances, lightly damped, change by less than
    `CONVERGED_CHANGE` times `tolerance` of their rms.

    Parameters
    ----------
    model : ShellModel
        Of n unknowns.
    youngs_modulus : float
        Pa.
    shifts : (S,) ndarray, Hz
        Expansion points, one chain for each.
    lines : (F,) ndarray, Hz
        Even grid over the band.
    loss_factor : float
        Of the light damping.

    Returns
    -------
    (n, N) ndarray

    Raises
    ------
    RuntimeError
        If the longest chains are not sufficient.
    """
    stiffness = model.stiffness(youngs_modulus, poisson_ratio)
    chains = [
        Chain(factorize(stiffness - (2 * np.pi * shift) ** 2 * model.mass), model.mass, model.coupling)
        for shift in shifts
    ]
    space = Galerkin(stiffness, model.coupling)
    last: DampedModes | None = None
    for _ in range(0, MOST_BLOCKS, BLOCKS_PER_CHECK):
        for chain in chains:
            space.add(*chain.extend(BLOCKS_PER_CHECK))
        now = space.modes()
        if (
            last is not None
            and _change(last, now, loss_factor, now.lines(loss_factor, lines)) < CONVERGED_CHANGE * tolerance
        ):
            return space.vectors.all.T
        last = now
    raise RuntimeError(
        f"the Krylov space at E {youngs_modulus:.4g} Pa, nu {poisson_ratio:.3g} did not converge to {tolerance:g}"
    )


def _change(before: DampedModes, now: DampedModes, loss_factor: float, lines: Real) -> float:
    return relative_error(before.transfers(lines, loss_factor), now.transfers(lines, loss_factor), lines)


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
