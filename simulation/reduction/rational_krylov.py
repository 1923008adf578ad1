"""Candidate space of a reduced model: block rational Krylov spaces at a few undamped materials.

Real shifts and real factors cost half of complex ones, and every further vector costs one
back-substitution. Damping of the plate alone is no other direction: it makes frequency and the
ratio of patch to plate stiffness complex, and the space is trained over both.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import SuperLU

from analysis.arrays import Real
from simulation.reduction.damped_modes import DampedModes, relative_error
from simulation.shell.factors import factorize
from simulation.shell.shell_model import ShellModel

STEPS = 4
"""Blocks added to every chain between two looks at the convergence."""

LONGEST = 90
"""Blocks of a chain at which a space that has not converged is given up."""


@dataclass
class Chain:
    """Orthonormal blocks spanning (K - s M)**-1 b, (K - s M)**-1 M (K - s M)**-1 b, ... of one shift s.

    Vectors stand in rows, along which their products are taken; `weighed` holds the mass times every one.
    """

    factors: SuperLU
    mass: csr_matrix
    load: Real
    vectors: Real = field(init=False)
    weighed: Real = field(init=False)

    def __post_init__(self) -> None:
        self.vectors = self.weighed = np.zeros((0, len(self.load)))

    def extend(self, steps: int) -> tuple[Real, Real]:
        """Add blocks, orthonormal to all before in the mass's inner product: (n, k), and mass times them."""
        start = len(self.vectors)
        for _ in range(steps):
            block = self.factors.solve(self.load)
            weighed = self.mass @ block
            for _ in range(2):  # once leaves what rounding kept of the vectors before
                share = self.vectors @ weighed
                block = block - self.vectors.T @ share
                weighed = weighed - self.weighed.T @ share
                values, vectors = np.linalg.eigh(block.T @ weighed)
                kept = values > 1e-14 * values[-1]
                scale = vectors[:, kept] / np.sqrt(values[kept])
                block, weighed = block @ scale, weighed @ scale
            self.vectors = np.vstack([self.vectors, block.T])
            self.weighed = np.vstack([self.weighed, weighed.T])
            self.load = weighed
        return self.vectors[start:].T, self.weighed[start:].T


@dataclass
class Galerkin:
    """Gram matrices of a growing set of vectors, one a row: nothing is multiplied twice."""

    stiffness: csr_matrix
    coupling: Real
    vectors: Real
    projected_stiffness: Real = field(default_factory=lambda: np.zeros((0, 0)))
    projected_mass: Real = field(default_factory=lambda: np.zeros((0, 0)))

    def add(self, block: Real, weighed: Real) -> None:
        """Append vectors (n, k), given the mass times them."""
        self.vectors = np.vstack([self.vectors, block.T])
        self.projected_stiffness = _bordered(self.projected_stiffness, self.vectors @ (self.stiffness @ block))
        self.projected_mass = _bordered(self.projected_mass, self.vectors @ weighed)

    def modes(self) -> DampedModes:
        """Modes of the projected plate, nearly dependent vectors left out."""
        values, basis = np.linalg.eigh(self.projected_mass)
        kept = values > 1e-12 * values[-1]
        basis = basis[:, kept] / np.sqrt(values[kept])
        force = basis.T @ (self.vectors @ self.coupling)
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
    """Vectors that hold every transfer between patches at one material.

    Chains grow until the transfers over the grid and on its resonances, lightly damped, change by less than
    `tolerance` of their rms.

    Parameters
    ----------
    model : ShellModel
        Of n unknowns.
    youngs_modulus : float
        Pa.
    poisson_ratio : float
    shifts : (S,) ndarray, Hz
        Expansion points, one chain for each.
    lines : (F,) ndarray, Hz
        Even grid over the band.
    loss_factor : float
        Of the light damping.
    tolerance : float

    Returns
    -------
    (n, N) ndarray

    Raises
    ------
    RuntimeError
        Where the longest chains do not suffice.
    """
    stiffness = model.stiffness(youngs_modulus, poisson_ratio)
    chains = [
        Chain(factorize(stiffness - (2 * np.pi * shift) ** 2 * model.mass), model.mass, model.coupling)
        for shift in shifts
    ]
    space = Galerkin(stiffness, model.coupling, np.zeros((0, model.size)))
    last: DampedModes | None = None
    for _ in range(0, LONGEST, STEPS):
        for chain in chains:
            space.add(*chain.extend(STEPS))
        now = space.modes()
        if last is not None and _change(last, now, loss_factor, now.lines(loss_factor, lines)) < tolerance:
            return space.vectors.T
        last = now
    raise RuntimeError(
        f"the Krylov space at E {youngs_modulus:.4g} Pa, nu {poisson_ratio:.3g} did not converge to {tolerance:g}"
    )


def _change(before: DampedModes, now: DampedModes, loss_factor: float, lines: Real) -> float:
    return relative_error(before.transfers(lines, loss_factor), now.transfers(lines, loss_factor), lines)


def _bordered(gram: Real, columns: Real) -> Real:
    """Symmetric matrix with the last columns (and rows) added."""
    old, new = len(gram), columns.shape[1]
    grown = np.empty((old + new, old + new))
    grown[:old, :old] = gram
    grown[:, old:] = columns
    grown[old:, :old] = columns[:old].T
    grown[old:, old:] = 0.5 * (columns[old:] + columns[old:].T)
    return grown
