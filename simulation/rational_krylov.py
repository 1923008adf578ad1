"""Candidate space of a reduced model: block rational Krylov spaces at a few undamped materials.

Real shifts and real factors cost a quarter of complex ones, and every further vector costs one
back-substitution. Damping of the plate alone is no other direction: it makes frequency and the
ratio of patch to plate stiffness complex, and the space is trained over both.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import SuperLU

from simulation.shell_model import ShellModel, factorize

Real = NDArray[np.float64]

STEPS = 4
"""Blocks added to every chain between two looks at the convergence."""

LONGEST = 60
"""Blocks of a chain at which a space that has not converged is given up."""


@dataclass
class Chain:
    """Orthonormal blocks (K - s M)**-1 b, (K - s M)**-1 M (K - s M)**-1 b, ... of one shift."""

    factors: SuperLU
    mass: csr_matrix
    load: Real
    blocks: list[Real] = field(default_factory=list)

    def extend(self, steps: int) -> None:
        """Add blocks, each made orthonormal to all before in the mass's inner product."""
        for _ in range(steps):
            block = self.factors.solve(self.load)
            for _ in range(2):  # twice is enough
                weighed = self.mass @ block
                for before in self.blocks:
                    block = block - before @ (before.T @ weighed)
                values, vectors = np.linalg.eigh(block.T @ (self.mass @ block))
                kept = values > 1e-14 * values[-1]
                block = block @ (vectors[:, kept] / np.sqrt(values[kept]))
            self.blocks.append(block)
            self.load = self.mass @ block


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
    """Vectors (n, N) that hold every transfer between patches at one material.

    Chains grow until the transfers over `lines` Hz, lightly damped, change by less than `tolerance`
    of their rms; RuntimeError if they do not.
    """
    stiffness = model.stiffness(youngs_modulus, poisson_ratio)
    chains = [
        Chain(factorize(stiffness - (2 * np.pi * shift) ** 2 * model.mass), model.mass, model.coupling)
        for shift in shifts
    ]
    last: NDArray[np.complex128] | None = None
    while len(chains[0].blocks) < LONGEST:
        for chain in chains:
            chain.extend(STEPS)
        vectors = np.hstack([block for chain in chains for block in chain.blocks])
        now = _transfers(vectors, stiffness, model, lines, loss_factor)
        if last is not None and relative_error(now, last) < tolerance:
            return vectors
        last = now
    raise RuntimeError(
        f"the Krylov space at E {youngs_modulus:.4g} Pa, nu {poisson_ratio:.3g} did not converge to {tolerance:g}"
    )


def relative_error(value: NDArray[np.complex128], reference: NDArray[np.complex128]) -> float:
    """Largest deviation of any transfer (..., F) over its reference's rms along the lines."""
    rms = np.sqrt(np.mean(np.abs(reference) ** 2, axis=-1))
    return float((np.abs(value - reference).max(axis=-1) / rms).max())


def orthonormal(vectors: Real, apply: Callable[[Real], Real], cutoff: float) -> Real:
    """Orthonormal columns for the inner product x' W y, directions below `cutoff` left out."""
    vectors = vectors / np.sqrt(np.einsum("ni,ni->i", vectors, apply(vectors)))
    for _ in range(2):  # the second pass repairs what the Gram matrix's rounding cost
        gram = vectors.T @ apply(vectors)
        values, basis = np.linalg.eigh(0.5 * (gram + gram.T))
        kept = values > cutoff**2 * values[-1]
        vectors = vectors @ (basis[:, kept] / np.sqrt(values[kept]))
    return vectors


def _transfers(
    vectors: Real, stiffness: csr_matrix, model: ShellModel, lines: Real, loss_factor: float
) -> NDArray[np.complex128]:
    """Transfers of one material's Galerkin model, its whole stiffness damped: (P, P, F)."""
    gram = vectors.T @ (model.mass @ vectors)
    values, basis = np.linalg.eigh(gram)
    kept = values > 1e-12 * values[-1]
    basis = basis[:, kept] / np.sqrt(values[kept])
    projected = basis.T @ (vectors.T @ (stiffness @ vectors)) @ basis
    squares, shapes = scipy.linalg.eigh(0.5 * (projected + projected.T))
    force = shapes.T @ (basis.T @ (vectors.T @ model.coupling))
    terms = 1.0 / ((1.0 + 1j * loss_factor) * squares[:, None] - (2 * np.pi * lines) ** 2)
    return np.asarray(np.einsum("ri,rk,rf->ikf", force, force, terms, optimize=True))
